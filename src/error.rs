//! What a command can end with, and its exit code.

use crate::adapt::AdaptError;
use crate::fem::FemError;
use crate::mesh::MeshError;
use crate::mesh::hex::HexError;
use crate::output::OutputError;
use crate::pipeline::tet_oct::DeformError;
use crate::pipeline::{ModelError, ResumeError};
use crate::scenario::ScenarioError;
use crate::subdiv::tet_oct::EmbedError;

/// Why a command failed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum Error {
    /// The scenario cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scenario(#[from] ScenarioError),
    /// The mesh cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mesh(#[from] MeshError),
    /// The hexahedral mesh cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Hex(#[from] HexError),
    /// The mesh of a scenario cannot be had in hexahedra.
    #[error("`mesh.{body}` is generated of tetrahedra only, and analysis.element is one of hexahedra")]
    #[diagnostic(help(
        "take mesh.box, cylinder, tube, sphere-shell, prism or a file; or an element such as \"tet10\""
    ))]
    NotHexahedra {
        /// The key of the body asked for.
        body: &'static str,
    },
    /// Elements of hexahedra are compared with others.
    #[error(
        "{element:?} is no element of hexahedra: compare --elements takes hex8, hex20, hex27, catmull-clark and catmull-clark+"
    )]
    #[diagnostic(help("leave it out; `compare --variant` compares tetrahedral elements"))]
    ElementsOfHexahedra {
        /// The element asked for.
        element: String,
    },
    /// A comparison of refinements of tetrahedra is asked for on hexahedra.
    #[error("hexahedra are refined globally: there is nothing adaptive to compare with")]
    #[diagnostic(help("compare elements instead: subsolid compare SCENARIO --elements hex27,catmull-clark"))]
    NothingAdaptive,
    /// Points cannot be embedded in a control mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Embed(#[from] EmbedError),
    /// Control points cannot be moved so.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Deform(#[from] DeformError),
    /// A run cannot be resumed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Resume(#[from] ResumeError),
    /// Supports, loads and materials do not fit the mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    /// The model cannot be solved, or the solver failed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fem(#[from] FemError),
    /// The error estimate cannot be marked.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Adapt(#[from] AdaptError),
    /// A file or folder cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Output(#[from] OutputError),
    /// Standard output cannot be written.
    #[error("cannot write to standard output")]
    Print(#[source] std::io::Error),
    /// A mesh is written in one format.
    #[error("cannot write {path} as a mesh: its name does not end in .vtu", path = path.display())]
    #[diagnostic(help("meshes are written as VTK unstructured grids: give a name such as refined.vtu"))]
    NotVtu {
        /// The file asked for.
        path: std::path::PathBuf,
    },
    /// A comparison with adaptive refinement needs a scheme that can refine some of the cells.
    #[error("scheme \"red\" refines all cells or none, so there is nothing adaptive to compare with")]
    #[diagnostic(help("set refine.scheme = \"sqrt3\" or \"longest-edge\"; or use `run` for global red refinement"))]
    NothingToCompare,
    /// Schemes are compared without a rule that ends all runs at a like size.
    #[error(
        "the scenario has no stop rule, and steps of different schemes differ in size: eightfold cells or half as many more"
    )]
    #[diagnostic(help("say where the runs end, such as --set refine.stop.max_cells=20000"))]
    NoStopRule,
    /// Two variants of a comparison would share a folder.
    #[error("variants `{first}` and `{second}` would share a folder")]
    #[diagnostic(help(
        "give each --variant a name of its own, whatever the case of its letters, and none that --schemes has"
    ))]
    Variants {
        /// The name of the first.
        first: String,
        /// And of the second.
        second: String,
    },
    /// Variants of a comparison are not as the scenario expects, or miss the error that it asks for.
    #[error("{sentences}")]
    #[diagnostic(help(
        "the results are complete; what holds for some variants only is no fault of the comparison: leave it out of the scenario"
    ))]
    VariantsFail {
        /// One for each of them, with its name.
        sentences: String,
        /// The exit code.
        code: u8,
    },
    /// Quantities of the last step are not what the scenario expects.
    #[error("not as expected: {sentences}")]
    #[diagnostic(help("refine more if the mesh is too coarse, or look at [expect] and what it is compared with"))]
    Unexpected {
        /// One for each quantity.
        sentences: String,
    },
    /// A folder without scenarios to verify.
    #[error("no scenarios in {folder}", folder = folder.display())]
    #[diagnostic(help("give a folder that holds scenarios (.toml): subsolid verify DIR"))]
    NoScenarios {
        /// The folder asked for.
        folder: std::path::PathBuf,
        /// Why it cannot be read.
        source: Option<std::io::Error>,
    },
    /// A scenario that is to be verified says nothing of its result.
    #[error("the scenario expects nothing")]
    #[diagnostic(help(
        "add a table, for example\n[expect.strain-energy]\nvalue = 1.0\ntolerance = {{ relative = 0.01 }}"
    ))]
    NothingExpected,
    /// Scenarios are not as they expect, or could not be run.
    #[error("not as expected: {failed}{faults}")]
    #[diagnostic(help("the table tells what was expected; where it is from, the scenarios tell"))]
    Unverified {
        /// The names of those that failed.
        failed: String,
        /// What is wrong with each, where it is not printed otherwise.
        faults: String,
    },
    /// The user ended the run.
    #[error("{ending}")]
    #[diagnostic(help("the results up to this step are complete; `subsolid run` with --resume goes on from there"))]
    Interrupted {
        /// After which step.
        ending: String,
    },
    /// The run would need more memory than there is.
    #[error("{what} {needs} of memory, and {most} can be had")]
    #[diagnostic(help("{help}; nothing was computed or written"))]
    TooLarge {
        /// What needs it: "step 4 of this run needs about".
        what: String,
        /// How much, in words.
        needs: String,
        /// How much there is, in words.
        most: String,
        /// What to do.
        help: String,
    },
    /// The run ended before the errors that the scenario asks for were reached.
    #[error("{reached} ({ending})")]
    #[diagnostic(help("{help}; the results are complete"))]
    ToleranceNotReached {
        /// What was reached and what was asked for.
        reached: String,
        /// Why the run ended.
        ending: String,
        /// What to do.
        help: &'static str,
    },
}

impl Error {
    /// The exit code of a command that ends with this error: 1 not as expected, 3 scenario, 4 mesh, 5 ill-posed model, 6 solver, memory or
    /// output, 7 asked tolerance not reached, 130 interrupted. (0 is success, 2 wrong usage.)
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Unexpected { .. } | Self::Unverified { .. } => 1,
            Self::VariantsFail { code, .. } => *code,
            Self::NotVtu { .. } | Self::Variants { .. } => 2,
            Self::Scenario(_)
            | Self::NothingToCompare
            | Self::NothingAdaptive
            | Self::ElementsOfHexahedra { .. }
            | Self::NoStopRule
            | Self::NoScenarios { .. }
            | Self::NothingExpected => 3,
            Self::Hex(_) | Self::NotHexahedra { .. } | Self::Mesh(_) | Self::Embed(EmbedError::Folded(_)) => 4,
            Self::Model(_) | Self::Embed(_) | Self::Deform(_) => 5,
            Self::Fem(error) if error.is_model() => 5,
            Self::Fem(_)
            | Self::Adapt(_)
            | Self::Output(_)
            | Self::Print(_)
            | Self::TooLarge { .. }
            | Self::Resume(_) => 6,
            Self::Interrupted { .. } => 130,
            Self::ToleranceNotReached { .. } => 7,
        }
    }
}
