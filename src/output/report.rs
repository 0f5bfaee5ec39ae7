//! What a run did, in numbers: the records behind `report.json` and the tables.
//!
//! Numbers that are not finite become `null` in JSON.

use super::OutputError;
use super::atomic::write_atomic;
use super::options::Units;
use crate::mesh::hex::{self, HexMesh};
use crate::mesh::{Crease, TetMesh, features, quality, topology};
use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::io::{self, Write as _};
use std::marker::PhantomData;
use std::path::Path;

/// A whole run: `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version of this layout, [`SCHEMA`].
    pub schema: u32,
    /// Name and version of the program, [`PROGRAM`].
    pub program: String,
    /// The scenario's file.
    pub scenario: String,
    /// The units that the scenario declares.
    #[serde(skip_serializing_if = "Units::is_empty")]
    pub units: Units,
    /// What the selectors of the scenario match on the input mesh.
    pub selections: Vec<Selection>,
    /// Threads used.
    pub threads: usize,
    /// Why the run ended.
    pub stop_reason: StopReason,
    /// What in the results deserves doubt, in whole sentences.
    pub warnings: Vec<String>,
    /// One record a solve; step 0 is the input mesh.
    pub steps: Vec<StepRecord>,
    /// Quantities of the last step beside what the scenario expects of them.
    #[serde(serialize_with = "as_map")]
    pub expectations: Vec<(String, ExpectationRecord)>,
    /// Wall time of the run, writing included; within a comparison that of the first pass, though the seconds of the steps
    /// are medians over all.
    pub seconds_total: f64,
    /// Most memory held at a time since the run began.
    pub peak_memory_bytes: u64,
}

/// What the selector of a support or load matches on the input mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Selection {
    /// Name of the support or load.
    pub name: String,
    /// `support` or `load`.
    pub what: &'static str,
    /// Number of boundary faces.
    pub faces: usize,
    /// Their area.
    pub area: f64,
}

/// Version of the layout of `report.json`.
pub const SCHEMA: u32 = 1;

/// Name and version of the program.
pub const PROGRAM: &str = concat!("subsolid ", env!("CARGO_PKG_VERSION"));

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All steps asked for were made; or marking selected no cell, as a warning says.
    Steps,
    /// The estimated relative error is small enough.
    RelativeError,
    /// The error bar of the quantity aimed at is small enough.
    Quantity,
    /// The next mesh would have too many cells.
    MaxCells,
    /// The next solve would need too much memory.
    MaxMemory,
    /// The time is up.
    Seconds,
    /// The estimated error is rounding: there is nothing to refine for.
    Exact,
    /// Refinement makes curved edges straight, and that alone exceeds an error asked for.
    StraightEdges,
    /// The quantity aimed at is zero within its error bar, of which no fraction can be reached.
    Zero,
    /// The user interrupted.
    Interrupted,
}

/// One pass of the loop: a mesh, its solution, its error, and what they cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    /// Index from 0.
    pub step: usize,
    /// The mesh.
    #[serde(flatten)]
    pub mesh: MeshCounts,
    /// Degrees of freedom, three a node.
    pub dofs: usize,
    /// Those not prescribed by supports.
    pub free_dofs: usize,
    /// Cells selected on this mesh for the next step.
    pub selected: usize,
    /// Strain energy u.K.u / 2.
    pub strain_energy: f64,
    /// Largest length of the displacement of a node.
    pub max_displacement: f64,
    /// Estimated error.
    pub error: ErrorRecord,
    /// Shape of the cells.
    pub quality: QualityRecord,
    /// What the linear solver did.
    pub solver: SolverRecord,
    /// Wall time of each phase.
    pub seconds: PhaseSeconds,
    /// Most memory held at a time since the run began.
    pub peak_memory_bytes: u64,
    /// Total force (x, y, z) that each support exerts, in the scenario's order.
    #[serde(serialize_with = "as_map", deserialize_with = "of_map")]
    pub reactions: Vec<(String, [f64; 3])>,
    /// Named quantities, in the scenario's order.
    #[serde(serialize_with = "as_map", deserialize_with = "of_map")]
    pub quantities: Vec<(String, QuantityRecord)>,
}

/// Counts and measures of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshCounts {
    /// Cells.
    pub cells: usize,
    /// Vertices.
    pub nodes: usize,
    /// Edges.
    pub edges: usize,
    /// Boundary faces.
    pub boundary_faces: usize,
    /// Edges above the feature angle or tagged by the user.
    pub feature_edges: usize,
    /// Their total length.
    pub feature_length: f64,
    /// Volume.
    pub volume: f64,
}

/// Estimated error of a solution. With eta_K the estimated energy norm of the error in cell K (eta_K^2 stands for a(e, e)
/// on K, without the factor 1/2) and M = max eta_K at step 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// eta = sqrt(sum eta_K^2).
    pub energy: f64,
    /// eta / sqrt(2 * strain energy + eta^2).
    pub relative: f64,
    /// The part of eta that bounds what data make which the elements do not see.
    pub data: f64,
    /// The part of eta that straight edges make where those that were read are curved.
    pub straight_edges: f64,
    /// mean(eta_K) / M.
    pub normalised_mean: f64,
    /// mean(eta_K^2) / M^2.
    pub normalised_mean_square: f64,
    /// The energy norm of the true error, where an exact solution is given.
    pub true_energy: Option<f64>,
    /// That over the energy norm of the exact solution.
    pub true_relative: Option<f64>,
    /// eta over the true error, where an exact solution is given.
    pub effectivity: Option<f64>,
}

/// Shape of the cells of a mesh: minimum dihedral angles in degrees, and valences (cells at a vertex).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QualityRecord {
    /// Smallest over the cells.
    pub worst: f64,
    /// Mean over the cells.
    pub average: f64,
    /// Largest over the cells.
    pub best: f64,
    /// Most cells at a vertex.
    pub max_valence: usize,
    /// Mean number of cells at a vertex.
    pub average_valence: f64,
    /// Share of the vertices with more than 50 cells.
    pub valence_above_50: f64,
    /// Cells whose volume is not positive.
    pub inverted: usize,
}

/// What the linear solver did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverRecord {
    /// Its name.
    pub method: String,
    /// Why this one.
    pub reason: String,
    /// Iterations; 0 for a direct solver without refinement of the solution.
    pub iterations: usize,
    /// |b - K u| / |b|.
    pub residual: f64,
    /// Entries stored of the matrix or of its factor.
    pub nonzeros: usize,
}

/// Wall time of the phases of a step, in seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseSeconds {
    /// Making this step's mesh from the one before; 0 at step 0.
    pub refine: f64,
    /// Stiffness matrix and load vector.
    pub assemble: f64,
    /// The linear system.
    pub solve: f64,
    /// Stress recovery and error indicators.
    pub estimate: f64,
    /// Selection of cells.
    pub mark: f64,
    /// Result files.
    pub write: f64,
    /// The whole step.
    pub total: f64,
}

impl PhaseSeconds {
    /// The phases that compute: all but writing.
    #[must_use]
    pub fn computing(&self) -> f64 {
        self.refine + self.assemble + self.solve + self.estimate + self.mark
    }
}

/// A named quantity and its estimated error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QuantityRecord {
    /// Its value; of the quantity aimed at corrected by its estimated error.
    pub value: f64,
    /// The error bar of that, of the quantity aimed at: the estimated bound of the distance to the exact value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Its value without correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub computed: Option<f64>,
}

/// A quantity of the last step beside what the scenario expects.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExpectationRecord {
    /// Its value.
    pub value: f64,
    /// What it should be; of a range the nearest value that is allowed.
    pub expected: f64,
    /// `value - expected`.
    pub deviation: f64,
    /// The largest deviation allowed.
    pub allowed: f64,
    /// The range, if one is expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[f64; 2]>,
    /// Whether it is allowed.
    pub passed: bool,
    /// Where the expected value is from.
    pub source: Option<String>,
}

/// A mesh without a solution: what `inspect` and `subdivide` report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshReport {
    /// The mesh.
    #[serde(flatten)]
    pub mesh: MeshCounts,
    /// Shape of the cells.
    pub quality: QualityRecord,
    /// Numbers of cells by their minimum dihedral angle, in bins of two degrees from 0.
    pub dihedral_counts: Vec<usize>,
    /// Wall time of what made it.
    pub seconds: f64,
}

impl MeshReport {
    /// Describes a mesh that took `seconds` to make.
    #[must_use]
    pub fn of(mesh: &TetMesh, seconds: f64) -> Self {
        let dihedral_counts = quality::dihedral_counts(mesh);
        Self { mesh: MeshCounts::of(mesh), quality: quality::quality(mesh).into(), dihedral_counts, seconds }
    }
}

impl MeshCounts {
    /// Counts and measures a mesh.
    #[must_use]
    pub fn of(mesh: &TetMesh) -> Self {
        let (feature_edges, feature_length) = features::feature_count_and_length(mesh);
        Self {
            cells: mesh.tets().len(),
            nodes: mesh.points().len(),
            edges: topology::edges(mesh.tets()).len(),
            boundary_faces: mesh.faces().len(),
            feature_edges,
            feature_length,
            volume: mesh.volume(),
        }
    }
}

impl ErrorRecord {
    /// `normalised_mean` and `normalised_mean_square` of the squared errors of cells, with the unit M. Where nothing has an error,
    /// they are zero too.
    #[must_use]
    pub fn normalised(squared: &[f64], unit: f64) -> [f64; 2] {
        let mean = |sum: f64, unit: f64| if unit == 0.0 { 0.0 } else { sum / squared.len() as f64 / unit };
        [mean(squared.iter().map(|e| e.sqrt()).sum(), unit), mean(squared.iter().sum(), unit * unit)]
    }
}

impl MeshCounts {
    /// Counts and measures a hexahedral mesh, by its straight edges.
    #[must_use]
    pub fn of_hexes(mesh: &HexMesh) -> Self {
        let features = mesh.creases().iter().filter(|c| c.feature);
        let length = |c: &Crease| {
            let [a, b] = c.vertices.map(|v| mesh.points()[v as usize]);
            a.distance(b)
        };
        Self {
            cells: mesh.cells().len(),
            nodes: mesh.points().len(),
            edges: mesh.topology().edges().len(),
            boundary_faces: mesh.faces().len(),
            feature_edges: features.clone().count(),
            feature_length: features.map(length).sum(),
            volume: mesh.volume(),
        }
    }
}

impl QualityRecord {
    /// Angles between faces at the corners of hexahedra, and valences.
    #[must_use]
    pub fn of_hexes(mesh: &HexMesh) -> Self {
        let angles: Vec<f64> = (0..mesh.cells().len()).map(|t| hex::min_dihedral(&mesh.cell_points(t))).collect();
        let used = |v: &u32| !mesh.topology().vertex_cells(*v).is_empty();
        let valences: Vec<usize> =
            (0..mesh.points().len() as u32).filter(used).map(|v| mesh.topology().vertex_cells(v).len()).collect();
        let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
        Self {
            worst: angles.iter().copied().fold(f64::INFINITY, f64::min),
            average: mean(angles.iter().sum(), angles.len()),
            best: angles.iter().copied().fold(0.0, f64::max),
            max_valence: valences.iter().copied().max().unwrap_or(0),
            average_valence: mean(valences.iter().sum::<usize>() as f64, valences.len()),
            valence_above_50: mean(valences.iter().filter(|v| **v > 50).count() as f64, valences.len()),
            inverted: 0,
        }
    }
}

impl From<quality::Quality> for QualityRecord {
    fn from(q: quality::Quality) -> Self {
        let quality::Quality { worst, average, best, max_valence, average_valence, valence_above_50, inverted } = q;
        Self { worst, average, best, max_valence, average_valence, valence_above_50, inverted }
    }
}

/// Writes a record as indented JSON with a newline at the end; to standard output if `path` is `-`.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn write_json(path: &Path, record: &impl Serialize) -> Result<(), OutputError> {
    if path == Path::new("-") {
        let mut text = serde_json::to_string_pretty(record).map_err(|e| OutputError::write(path, e.into()))?;
        text.push('\n');
        return match io::stdout().write_all(text.as_bytes()) {
            // The reader has gone away: that is its right.
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(OutputError::write(path, e)),
            _ => Ok(()),
        };
    }
    write_atomic(path, |w| {
        serde_json::to_writer_pretty(&mut *w, record).map_err(io::Error::from)?;
        writeln!(w)
    })
}

/// Named values as a JSON object that keeps their order.
pub(super) fn as_map<T: Serialize, S: Serializer>(entries: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(entries.len()))?;
    for (name, value) in entries {
        map.serialize_entry(name, value)?;
    }
    map.end()
}

/// What [`as_map`] wrote, in its order.
fn of_map<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<(String, T)>, D::Error> {
    struct Entries<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
        type Value = Vec<(String, T)>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a table")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = Vec::new();
            while let Some(entry) = map.next_entry()? {
                entries.push(entry);
            }
            Ok(entries)
        }
    }
    deserializer.deserialize_map(Entries(PhantomData))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::output) fn step(step: usize) -> StepRecord {
        StepRecord {
            step,
            mesh: MeshCounts {
                cells: 2799,
                nodes: 967,
                edges: 4400,
                boundary_faces: 1270,
                feature_edges: 294,
                feature_length: 123.5,
                volume: 1000.0,
            },
            dofs: 2901,
            free_dofs: 2800,
            selected: 100,
            strain_energy: 6.382_330_187_8,
            max_displacement: 0.126_521_862,
            error: ErrorRecord {
                energy: 1.5,
                relative: 0.4,
                straight_edges: 0.0,
                data: 0.0,
                normalised_mean: 0.209,
                normalised_mean_square: 0.06,
                true_energy: None,
                true_relative: None,
                effectivity: None,
            },
            quality: QualityRecord {
                worst: 13.2,
                average: 45.0,
                best: 69.0,
                max_valence: 40,
                average_valence: 11.6,
                valence_above_50: 0.0,
                inverted: 0,
            },
            solver: SolverRecord {
                method: "direct".to_owned(),
                reason: "asked for".to_owned(),
                iterations: 0,
                residual: 1e-13,
                nonzeros: 100_000,
            },
            seconds: PhaseSeconds {
                assemble: 0.01,
                solve: 0.02,
                estimate: 0.005,
                total: 0.04,
                ..PhaseSeconds::default()
            },
            peak_memory_bytes: 1 << 23,
            reactions: vec![("zebra".to_owned(), [0.0, 1.0, f64::NAN]), ("ant".to_owned(), [1.0, 2.0, 3.0])],
            quantities: Vec::new(),
        }
    }

    pub(in crate::output) fn report(steps: Vec<StepRecord>) -> Report {
        Report {
            schema: SCHEMA,
            program: PROGRAM.to_owned(),
            scenario: "tripod.toml".to_owned(),
            units: Units::default(),
            selections: Vec::new(),
            threads: 2,
            stop_reason: StopReason::RelativeError,
            warnings: Vec::new(),
            steps,
            expectations: Vec::new(),
            seconds_total: 1.0,
            peak_memory_bytes: 1 << 24,
        }
    }

    /// The names under `path`, sorted.
    fn keys(json: &serde_json::Value, path: &str) -> Vec<String> {
        json.pointer(path).unwrap().as_object().unwrap().keys().cloned().collect()
    }

    fn sorted(names: &str) -> Vec<String> {
        let mut names: Vec<String> = names.split_whitespace().map(str::to_owned).collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn the_report_has_the_promised_keys_and_no_other() {
        let mut record = step(0);
        record
            .quantities
            .push(("tip".to_owned(), QuantityRecord { value: 1.0, error: Some(0.1), computed: Some(1.1) }));
        let json = serde_json::to_value(report(vec![record])).unwrap();
        let promised = [
            (
                "",
                "schema program scenario selections threads stop_reason warnings steps expectations seconds_total \
                 peak_memory_bytes",
            ),
            (
                "/steps/0",
                "step cells nodes edges boundary_faces dofs free_dofs feature_edges feature_length volume selected \
                 strain_energy max_displacement error quality solver seconds peak_memory_bytes reactions quantities",
            ),
            (
                "/steps/0/error",
                "energy relative data straight_edges normalised_mean normalised_mean_square true_energy true_relative \
                 effectivity",
            ),
            ("/steps/0/quality", "worst average best max_valence average_valence valence_above_50 inverted"),
            ("/steps/0/solver", "method reason iterations residual nonzeros"),
            ("/steps/0/seconds", "refine assemble solve estimate mark write total"),
            ("/steps/0/quantities/tip", "value error computed"),
        ];
        for (path, names) in promised {
            assert_eq!(keys(&json, path), sorted(names), "at {path:?}");
        }
        assert_eq!(json["stop_reason"], "relative_error");
        assert!(json["steps"][0]["error"]["effectivity"].is_null());
        assert_eq!(json["steps"][0]["reactions"]["ant"], serde_json::json!([1.0, 2.0, 3.0]));
    }

    #[test]
    fn reactions_keep_the_scenarios_order_and_nan_is_null() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        write_json(&path, &report(vec![step(0)])).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.find("zebra").unwrap() < text.find("ant").unwrap());
        assert!(text.ends_with("}\n") && !text.contains("NaN"));
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(json["steps"][0]["reactions"]["zebra"][2].is_null());
    }

    #[test]
    fn declared_units_stand_in_the_report_and_above_the_table() {
        let units = Units { length: Some("mm".to_owned()), stress: Some("MPa".to_owned()), ..Units::default() };
        let json = serde_json::to_value(Report { units: units.clone(), ..report(vec![step(0)]) }).unwrap();
        assert_eq!(json["units"], serde_json::json!({ "length": "mm", "stress": "MPa" }));
        assert_eq!(crate::output::table::units(&units), "units: length mm, stress MPa\n");
    }

    #[test]
    fn a_mesh_report_has_the_promised_keys() {
        let mesh = TetMesh::from_cells(
            vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z],
            vec![[0, 1, 2, 3]],
            "solid",
        );
        let mesh = mesh.unwrap();
        let counts = MeshCounts::of(&mesh);
        assert_eq!((counts.cells, counts.nodes, counts.edges, counts.boundary_faces), (1, 4, 6, 4));
        assert!((counts.volume - 1.0 / 6.0).abs() < 1e-15);
        let record = MeshReport::of(&mesh, 0.0);
        assert_eq!(record.mesh, counts);
        assert_eq!(record.dihedral_counts.iter().sum::<usize>(), counts.cells);
        let json = serde_json::to_value(record).unwrap();
        let names =
            "cells nodes edges boundary_faces feature_edges feature_length volume quality dihedral_counts seconds";
        assert_eq!(keys(&json, ""), sorted(names));
    }
}
