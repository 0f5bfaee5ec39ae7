//! Scenarios: TOML text in, a checked [`Scenario`] out. Sees the plain choices of the other rooms, no numerics.
//!
//! Three stages: the document (text, overrides, spans), the keys as written (names and types), the checked values.

mod actions;
mod check;
mod deform;
mod document;
mod elements;
mod error;
mod fields;
mod numbers;
mod raw;
mod selector;
mod shapes;
mod spanned;
pub mod suggest;
mod translate;
mod wanted;

pub use actions::{Load, LoadKind, Support};
pub use check::MAX_STEPS;
pub use deform::{ControlPoints, Deformation, Move, Pose};
pub use error::{Invalid, ScenarioError};
pub use selector::Selector;
pub use shapes::Shape;
pub use wanted::{Bound, Cells, Exact, Expectation, Extent, Figure, Probe, Quantity, QuantityKind, Subject, Tolerance};

use crate::adapt::options::{Estimator, Marking};
use crate::fem::options::{Element, HexElement, HexOptions, SolverOptions};
use crate::output::options::{Compression, FieldName, HexCells, Published, Units};
use crate::subdiv::options::{Options, Smooth};
use document::Setting;
use serde::Deserialize as _;
use std::path::{Path, PathBuf};

/// What to compute, checked as far as that is possible without the mesh.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// The file it was read from.
    pub path: PathBuf,
    /// The folder of that file, where mesh files are looked for first.
    pub directory: PathBuf,
    /// What the file says, with the overrides applied, to be written beside the results.
    pub document: toml::Table,
    /// Overrides `key.path=value` that were applied to the text.
    pub overrides: Vec<String>,
    /// `title`; the file's name without `.toml` if absent.
    pub title: String,
    /// `description`; empty if absent.
    pub description: String,
    /// `[mesh]`.
    pub mesh: MeshSource,
    /// `[features]`.
    pub features: Features,
    /// `[materials.<name>]`, sorted by name.
    pub materials: Vec<Material>,
    /// `[supports.<name>]`, sorted by name.
    pub supports: Vec<Support>,
    /// `[loads.<name>]`, sorted by name.
    pub loads: Vec<Load>,
    /// `[quantities.<name>]`, sorted by name.
    pub quantities: Vec<Quantity>,
    /// `[probes.<name>]`, sorted by name.
    pub probes: Vec<Probe>,
    /// `[exact]`.
    pub exact: Option<Exact>,
    /// `[expect.<name>]`, sorted by name.
    pub expectations: Vec<Expectation>,
    /// `[refine]`.
    pub refine: Refine,
    /// `mesh.midside`.
    pub midside: Midside,
    /// `mesh.merge`: whether nodes at the same place are made one.
    pub merge: bool,
    /// `analysis.element`, if it is one of tetrahedra.
    pub element: Element,
    /// `analysis.smooth`.
    pub smooth: Option<Smooth>,
    /// `analysis.element`, if it is one of hexahedra.
    pub hexes: Option<Hexes>,
    /// `[adapt]`.
    pub adapt: Adapt,
    /// `[solver]`.
    pub solver: SolverOptions,
    /// `[output]`.
    pub output: Output,
    /// `[published]`.
    pub published: Option<Published>,
    /// `[units]`.
    pub units: Units,
    /// What is allowed but deserves a word.
    pub warnings: Vec<String>,
}

/// What becomes of the mid-side nodes of a second-order mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Midside {
    /// They are dropped: edges are straight.
    #[default]
    Straight,
    /// They are kept: edges are curved until the mesh is refined.
    Curved,
}

/// The element of a hexahedral mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hexes {
    /// The element.
    pub element: HexElement,
    /// How it is made and integrated.
    pub options: HexOptions,
    /// Whether its edges are curved where the mesh's are.
    pub curved: bool,
    /// `analysis.interpolate`: whether a Catmull-Clark solid goes through the mesh's vertices; else they are control points.
    pub interpolate: bool,
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSource {
    /// A file, as written in the scenario.
    File(PathBuf),
    /// A box with one corner at the origin.
    Box {
        /// Edge lengths.
        size: [f64; 3],
        /// Cells along each edge, before each is cut into tetrahedra.
        cells: [usize; 3],
    },
    /// Another body that is generated.
    Shape(Shape),
}

/// Edges and corners that subdivision keeps.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    /// An edge of the boundary or of an interface is a feature if its faces' normals differ by more than this angle, in degrees;
    /// 40 if not given.
    pub angle: Option<f64>,
    /// Further feature edges. Vertices are numbered from 0 in the order of the mesh the run starts from (the point ids
    /// of `step_000.vtu`).
    pub edges: Vec<[u32; 2]>,
    /// Vertices that never move, numbered likewise.
    pub corners: Vec<u32>,
}

impl Features {
    /// The angle from which on edges are features.
    #[must_use]
    pub fn sharp_angle(&self) -> f64 {
        self.angle.unwrap_or(40.0)
    }
}

/// A linear-elastic material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name of its table.
    pub name: String,
    /// Where it is written: `file:line:column`, or the override.
    pub place: String,
    /// Young's modulus, force per area.
    pub youngs_modulus: f64,
    /// Poisson's ratio, in (-1, 1/2).
    pub poissons_ratio: f64,
    /// Mass per volume, needed for gravity.
    pub density: Option<f64>,
    /// The region it fills; all regions that no other material names if absent.
    pub group: Option<String>,
}

/// Which cells are refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Those the error estimate asks for.
    Adaptive,
    /// All.
    Global,
    /// None: the input mesh is solved and that is all.
    None,
}

/// How refinement proceeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Refine {
    /// Which cells.
    pub strategy: Strategy,
    /// Refinement steps at most; not looked at under [`Strategy::None`].
    pub steps: usize,
    /// Scheme, boundary rule, passes.
    pub options: Options,
    /// When to stop before the last step.
    pub stop: Stop,
}

/// Rules that end a run early; each may be absent. Where both errors are given, both are to be reached.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stop {
    /// Estimated relative error to reach, in (0, 1).
    pub relative_error: Option<f64>,
    /// Bound of the error of the quantity of `adapt.goal` to reach.
    pub quantity_error: Option<Tolerance>,
    /// No refinement of a mesh with this many cells or more.
    pub max_cells: Option<usize>,
    /// Bytes.
    pub max_memory: Option<u64>,
    /// Seconds since the run began.
    pub seconds: Option<f64>,
}

/// How cells are chosen for refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct Adapt {
    /// How the error is estimated.
    pub estimator: Estimator,
    /// Which cells are marked.
    pub marking: Marking,
    /// Rings of neighbours added to the marked cells.
    pub grow: usize,
    /// The quantity that refinement aims at, which exists and has a dual problem; the energy if absent.
    pub goal: Option<String>,
}

/// What a run writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// VTK files of each step.
    pub vtk: bool,
    /// `report.json`.
    pub report: bool,
    /// The fields of the solution in the VTK files.
    pub fields: Vec<FieldName>,
    /// Compression of the VTK files.
    pub compression: Compression,
    /// The cells that show hexahedral elements.
    pub hexahedra: HexCells,
}

impl Scenario {
    /// Reads a file and applies overrides `key.path=value` (the value is TOML, else a bare string).
    ///
    /// # Errors
    /// [`ScenarioError::Unreadable`], or the first fault with its place, key and remedy.
    pub fn from_file(path: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        Self::from_text(&read(path)?, path, overrides)
    }

    /// Reads the file anew, with the overrides of a variant behind those that it had; faults in them name the variant.
    ///
    /// # Errors
    /// As [`Scenario::from_file`].
    pub fn variant(&self, name: &str, overrides: &[String]) -> Result<Self, ScenarioError> {
        let own = Setting::all(&format!("--variant {name}:"), overrides);
        Self::from_settings(&read(&self.path)?, &self.path, &[Setting::all(SET, &self.overrides), own].concat())
    }

    /// As [`Scenario::from_file`] with the text at hand; `path` is the file it counts as.
    ///
    /// # Errors
    /// As [`Scenario::from_file`].
    pub fn from_text(text: &str, path: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        Self::from_settings(text, path, &Setting::all(SET, overrides))
    }

    fn from_settings(text: &str, path: &Path, settings: &[Setting]) -> Result<Self, ScenarioError> {
        if let Some(format) = mesh_format(text) {
            return Err(ScenarioError::Mesh { path: path.to_owned(), format });
        }
        let sources =
            document::Sources::new(&path.display().to_string(), text, settings).map_err(ScenarioError::Invalid)?;
        let document = sources.parse().map_err(ScenarioError::Invalid)?;
        let invalid = |fault| ScenarioError::Invalid(document.explain(fault));
        let deserializer = || toml::Deserializer::from(document.root().clone());
        let raw =
            raw::RawScenario::deserialize(deserializer()).map_err(|e| invalid(translate::fault(&e, &document)))?;
        let mut scenario = check::scenario(raw, &document).map_err(invalid)?;
        scenario.path = path.to_owned();
        scenario.directory = path.parent().map(Path::to_owned).unwrap_or_default();
        scenario.document =
            toml::Table::deserialize(deserializer()).map_err(|e| invalid(translate::fault(&e, &document)))?;
        scenario.overrides = settings.iter().map(|s| s.text.clone()).collect();
        if scenario.title.is_empty() {
            scenario.title = scenario.name();
        }
        Ok(scenario)
    }

    /// A scenario file that runs this again from another folder: the text with the overrides applied, without comments;
    /// `strategy` is the one that was run, `mesh` the path of the mesh file from that folder.
    ///
    /// # Errors
    /// None with a scenario read from TOML, which can be written as TOML.
    pub fn to_run_again(&self, strategy: Strategy, mesh: Option<&Path>) -> Result<String, toml::ser::Error> {
        let mut document = self.document.clone();
        document.insert("title".to_owned(), self.title.clone().into());
        set(&mut document, "refine", "strategy", toml::Value::try_from(strategy)?);
        if let Some(mesh) = mesh {
            set(&mut document, "mesh", "file", mesh.to_string_lossy().into_owned().into());
        }
        let mut head = format!("# {} as it was run", self.path.display());
        self.overrides.iter().for_each(|o| head += &format!(", --set {o}"));
        // A comment ends with its line.
        let head = head.replace(|c: char| c.is_control(), " ");
        Ok(format!("{head}\n\n{}", toml::to_string(&document)?))
    }

    /// The file's name without its extension; names the folder of the results.
    #[must_use]
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(|| "scenario".to_owned(), |s| s.to_string_lossy().into_owned())
    }
}

/// The option that overrides come by.
const SET: &str = "--set";

/// The text of a scenario's file.
fn read(path: &Path) -> Result<String, ScenarioError> {
    std::fs::read_to_string(path).map_err(|source| {
        let help = match source.kind() {
            std::io::ErrorKind::InvalidData => "a scenario is a TOML file in UTF-8".to_owned(),
            _ => "give the path of a scenario, such as scenarios/bracket.toml".to_owned(),
        };
        ScenarioError::Unreadable { path: path.to_owned(), source, help }
    })
}

/// The JSON schema of scenarios: keys, types and words, for editors. Ranges, and what goes together, only reading tells.
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(raw::RawScenario).to_value()
}

/// Sets `key` in the table `name`, which is made if it is not there.
fn set(document: &mut toml::Table, name: &str, key: &str, value: toml::Value) {
    let entry = document.entry(name).or_insert_with(|| toml::Table::new().into());
    if let Some(table) = entry.as_table_mut() {
        table.insert(key.to_owned(), value);
    }
}

/// The format of a text that is a mesh, not a scenario.
fn mesh_format(text: &str) -> Option<&'static str> {
    let start = text.trim_start();
    // A scenario may begin with `mesh = { ... }` or `mesh .file = ...`.
    let is_key = |rest: &str| rest.trim_start().starts_with(['=', '.']);
    let is_gid =
        || start.split_at_checked(5).is_some_and(|(word, rest)| word.eq_ignore_ascii_case("mesh ") && !is_key(rest));
    if start.starts_with("$MeshFormat") { Some("Gmsh") } else { is_gid().then_some("GiD") }
}
