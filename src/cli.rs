//! The words of the command line.

use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use std::path::PathBuf;
use subsolid::pipeline::variants::Variant;
use subsolid::subdiv::options::{Boundary, CatmullClark, Mode, QualityMeasure, Scheme};

/// Finite-element simulation of linear-elastic solids represented by adaptive subdivision meshes.
#[derive(Debug, Parser)]
#[command(name = "subsolid", version, about, arg_required_else_help = true, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 ok; 1 a check failed; 2 usage; 3 scenario; 4 mesh; 5 ill-posed model; \
                          6 solver, memory or output; 7 asked tolerance not reached; 130 interrupted.\n\
                          Meshes are looked for beside the scenario, then in the folder named by SUBSOLID_DATA.";

const FORMATS: &str = "Formats, found from the content: Gmsh MSH 2.2 and 4.1 (text, binary), Abaqus and CalculiX .inp, \
                       MEDIT .mesh, VTK legacy .vtk and XML .vtu, GiD .msh. docs/formats.md tells what is read of each.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Solve scenarios: solve, estimate, refine, repeat; write VTK files, report.json and report.html
    Run {
        /// Scenario files (TOML)
        #[arg(required = true, value_name = "SCENARIO")]
        scenarios: Vec<PathBuf>,
        /// Go on where an interrupted or killed run of the same scenario stopped; ends with the same files
        #[arg(long)]
        resume: bool,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Run a scenario adaptively and globally, or under other choices; print and write what each paid for its error
    Compare {
        /// Scenario file (TOML)
        scenario: PathBuf,
        /// Compare subdivision schemes instead: sqrt(3), longest-edge bisection and red refinement, each with and without
        /// the error-driven optimiser, with the same elements, solver, estimator and marking. The scenario needs a rule in
        /// [refine.stop] that ends all runs, such as max_cells
        #[arg(long)]
        schemes: bool,
        /// Compare the scenario under overrides of your choice instead, such as "fine: mesh.box.cells=[4,4,4];
        /// refine.steps=2" (repeatable)
        #[arg(long = "variant", value_name = "NAME: KEY=VALUE; ...")]
        variants: Vec<Variant>,
        /// Compare elements of hexahedra instead, refined globally, such as hex8,hex27,catmull-clark: largest displacement,
        /// compliance, condition number and iterations against what they cost
        #[arg(long, value_name = "ELEMENT,...", value_delimiter = ',', conflicts_with_all = ["schemes", "variants"])]
        elements: Vec<String>,
        /// Repetitions of short runs; times are medians over them. Steps below 50 ms are repeated at least nine times,
        /// unless this is 1
        #[arg(long, value_name = "N", default_value_t = 3, value_parser = value_parser!(u16).range(1..))]
        repeat: u16,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Run all scenarios of a folder and print what they expect beside what came out; fails if one is not as expected
    Verify {
        /// Folder of scenarios (TOML)
        #[arg(default_value = "scenarios/verification", value_name = "DIR")]
        folder: PathBuf,
        /// Write the table, the problems and the sources of their references to this file, as Markdown
        #[arg(long, value_name = "FILE")]
        markdown: Option<PathBuf>,
        /// Write the results of each scenario into a folder in this one [default: they are not written]
        #[arg(long, value_name = "DIR")]
        output: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Write the page of results that are there, report.html, again
    Report {
        /// Folder that `run` or `compare` has written
        folder: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Say what a run would do, and solve nothing
    Check {
        /// Scenario file (TOML)
        scenario: PathBuf,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Refine a mesh, all of it or chosen cells, and write it
    #[command(after_help = FORMATS)]
    Subdivide(Subdivide),
    /// Print counts, groups, regions and quality of a mesh
    #[command(after_help = FORMATS)]
    Inspect {
        /// Mesh file
        mesh: PathBuf,
        /// Boundary edges with a larger angle between the normals of their faces are features, in degrees
        #[arg(long, value_name = "DEG", default_value = "40", value_parser = angle)]
        feature_angle: f64,
        #[command(flatten)]
        common: Common,
    },
    /// Move what is embedded in a solid with its control points, from pose to pose; write the frames as VTK
    Deform {
        /// Scenario file (TOML) with [mesh], [embed] and [[pose]]
        scenario: PathBuf,
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        scenario_options: ScenarioOptions,
    },
    /// Analyse how smooth tetrahedral/octahedral subdivision is: across faces, along edges, at vertices; write the characteristic
    /// maps as VTK
    Smoothness {
        /// Folder of the maps
        #[arg(long, value_name = "DIR", default_value = "results/smoothness")]
        output: PathBuf,
        /// Write all tables to this file, as Markdown, and pictures into a folder of its name beside it
        #[arg(long, value_name = "FILE")]
        markdown: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Print the JSON schema of scenarios, for editors
    Schema,
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// What `subdivide` is told.
#[derive(Debug, Args)]
pub struct Subdivide {
    /// Mesh file
    pub mesh: PathBuf,
    /// Subdivision scheme
    #[arg(long, value_enum, default_value_t = SchemeName::Sqrt3)]
    pub scheme: SchemeName,
    /// Refinement steps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u8).range(0..=20))]
    pub steps: u8,
    /// Cells to refine in each step: boundary (those with a boundary face), curvature (those where the boundary turns), or
    /// a file of cell numbers from 0, one a line; later steps refine what those before refined [default: all]
    #[arg(long, value_name = "CELLS", value_parser = cells)]
    pub select: Option<CellsName>,
    /// With --select curvature: edges that turn less are flat, in degrees [default: 5]
    #[arg(long, value_name = "DEG", value_parser = angle)]
    pub curvature_angle: Option<f64>,
    /// Boundary edges with a larger angle between the normals of their faces are features, in degrees
    #[arg(long, visible_alias = "crease-angle", value_name = "DEG", default_value = "40", value_parser = angle)]
    pub feature_angle: f64,
    /// The masks of scheme catmull-clark where other than four cells meet at an edge [default: bajaj]
    #[arg(long, value_enum)]
    pub variant: Option<VariantName>,
    /// With scheme catmull-clark: find control points so that the smooth solid passes through the vertices of the mesh
    #[arg(long)]
    pub interpolate: bool,
    /// Further feature edges: a file of two vertices (numbers from 0) a line
    #[arg(long, value_name = "FILE")]
    pub edges: Option<PathBuf>,
    /// Vertices that stay where they are: a file of one number (from 0) a line
    #[arg(long, value_name = "FILE")]
    pub corners: Option<PathBuf>,
    /// What scheme sqrt3 does to the boundary surface; red and longest-edge keep it [default: approximating]
    #[arg(long, value_enum)]
    pub boundary: Option<BoundaryName>,
    /// How each refined mesh of tetrahedra is optimised for its dihedral angles [default: best]
    #[arg(long, value_enum)]
    pub optimise: Option<ModeName>,
    /// What a good cell is to the published operations [default: min-sine]
    #[arg(long, value_enum)]
    pub measure: Option<MeasureName>,
    /// The .vtu file to write
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Write the mesh after each elementary stage into this folder too; open its frames.pvd in ParaView
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// What all commands have
    #[command(flatten)]
    pub common: Common,
}

/// Names of the optimiser's modes.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ModeName {
    /// With the operations of the published scheme
    Paper,
    /// With all operations: larger angles, fewer cells at a vertex
    Best,
}

impl From<ModeName> for Mode {
    fn from(name: ModeName) -> Self {
        match name {
            ModeName::Paper => Self::Paper,
            ModeName::Best => Self::Best,
        }
    }
}

/// Names of the measures of a cell.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum MeasureName {
    /// The smallest sine of its dihedral angles
    MinSine,
    /// The smallest dihedral angle
    MinDihedral,
    /// The smallest solid angle
    MinSolidAngle,
    /// The shortest over the longest edge
    EdgeRatio,
}

impl From<MeasureName> for QualityMeasure {
    fn from(name: MeasureName) -> Self {
        match name {
            MeasureName::MinSine => Self::MinSine,
            MeasureName::MinDihedral => Self::MinDihedral,
            MeasureName::MinSolidAngle => Self::MinSolidAngle,
            MeasureName::EdgeRatio => Self::EdgeRatio,
        }
    }
}

/// Cells to refine, as named on the command line.
#[derive(Debug, Clone)]
pub enum CellsName {
    /// Those with a boundary face.
    Boundary,
    /// Those where the boundary turns.
    Curvature,
    /// Those in a file.
    File(PathBuf),
    /// All of them.
    All,
}

/// Options of all commands that compute.
#[derive(Debug, Args)]
pub struct Common {
    /// Threads to compute with [default: all cores]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print errors only
    #[arg(long, short)]
    pub quiet: bool,
    /// Write the figures to this file too; `-` is standard output, where nothing else is printed then
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of the commands that read scenarios.
#[derive(Debug, Args)]
pub struct ScenarioOptions {
    /// Folder of the results [default: results/<scenario's name>]; of several scenarios of one `run` each has its own in it
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Override a key of the scenario, such as refine.steps=3 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Names of subdivision schemes.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum SchemeName {
    /// Tetrahedral sqrt(3) subdivision
    Sqrt3,
    /// One cell into eight
    Red,
    /// One cell into two at its longest edge
    LongestEdge,
    /// Smooth subdivision of solids of hexahedra, one cell into eight
    CatmullClark,
    /// Smooth subdivision of tetrahedra into tetrahedra and octahedra
    TetOct,
}

impl SchemeName {
    /// The scheme, if it is one of tetrahedra.
    pub fn of_tetrahedra(self) -> Option<Scheme> {
        match self {
            Self::Sqrt3 => Some(Scheme::Sqrt3),
            Self::Red => Some(Scheme::Red),
            Self::LongestEdge => Some(Scheme::LongestEdge),
            Self::CatmullClark | Self::TetOct => None,
        }
    }
}

/// Names of the masks of Catmull-Clark solids.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum VariantName {
    /// Multilinear splitting and averaging
    Bajaj,
    /// As printed in the paper of 2011
    Printed,
}

impl From<VariantName> for CatmullClark {
    fn from(name: VariantName) -> Self {
        match name {
            VariantName::Bajaj => Self::Bajaj,
            VariantName::Printed => Self::Printed,
        }
    }
}

/// Names of boundary rules.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum BoundaryName {
    /// The surface is kept
    Fixed,
    /// The surface is smoothed between features
    Approximating,
    /// The surface is rounded between features, through all its vertices
    Interpolating,
}

impl From<BoundaryName> for Boundary {
    fn from(name: BoundaryName) -> Self {
        match name {
            BoundaryName::Fixed => Self::Fixed,
            BoundaryName::Approximating => Self::Approximating,
            BoundaryName::Interpolating => Self::Interpolating,
        }
    }
}

fn angle(text: &str) -> Result<f64, String> {
    let angle: f64 = text.parse().map_err(|_| "expected a number of degrees".to_owned())?;
    if (0.0..=180.0).contains(&angle) { Ok(angle) } else { Err("expected an angle from 0 to 180 degrees".to_owned()) }
}

fn cells(text: &str) -> Result<CellsName, String> {
    Ok(match text {
        "" => return Err("expected boundary, curvature or a file".to_owned()),
        "all" => CellsName::All,
        "boundary" => CellsName::Boundary,
        "curvature" => CellsName::Curvature,
        path => CellsName::File(path.into()),
    })
}
