//! What a run needs to go on from a step: written before each step is solved, read by `run --resume`, removed when the run is complete.
//!
//! The file holds a line that names it, two hashes and the state. The first hash is of the run: the scenario as it is run, its input mesh
//! and the program's version; the second one is of the state, whatever became of the file.

use super::resolve::Resolved;
use super::results::Kept;
use super::simulate::State;
use super::straight::Straight;
use crate::mesh::{Crease, Face, GroupId, PatchId, RegionId, TetMesh, TetMeshParts};
use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::report::{PROGRAM, StepRecord};
use crate::scenario::Scenario;
use crate::subdiv::History;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// The name of the file.
pub(super) const FILE: &str = "checkpoint.bin";

/// What it begins with.
const HEAD: &[u8] = b"subsolid checkpoint 1\n";

/// Bytes of a hash.
const HASH: usize = blake3::OUT_LEN;

/// Why a run cannot be resumed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ResumeError {
    /// There is no checkpoint.
    #[error("there is nothing to resume: cannot read {path}", path = path.display())]
    #[diagnostic(help(
        "a run leaves a checkpoint in its folder (--output) if it is interrupted or killed; run it without --resume"
    ))]
    Missing {
        /// The checkpoint.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// It is of another run.
    #[error("{path} is of another run: its scenario, its mesh or the program was changed since", path = path.display())]
    #[diagnostic(help(
        "scenario.toml beside it is the scenario as it was run: resume that, or run without --resume, which begins anew; \
         nothing was computed or written"
    ))]
    Stale {
        /// The checkpoint.
        path: PathBuf,
    },
    /// It is not what was written.
    #[error("{path} is damaged: {problem}", path = path.display())]
    #[diagnostic(help("run without --resume, which begins anew; nothing was computed or written"))]
    Corrupt {
        /// The checkpoint.
        path: PathBuf,
        /// What shows it.
        problem: &'static str,
    },
    /// Such runs have none.
    #[error("runs on hexahedra have no checkpoints")]
    #[diagnostic(help("run without --resume"))]
    Hexahedra,
}

/// The state before a step, and what was kept for pictures of the whole run.
#[derive(Serialize, Deserialize)]
struct Saved<'a> {
    mesh: SavedMesh<'a>,
    history: Cow<'a, History>,
    steps: Cow<'a, [StepRecord]>,
    warnings: Cow<'a, [String]>,
    refine_seconds: f64,
    largest_error: Option<f64>,
    guess: Option<Vec<[f64; 3]>>,
    straight: Option<Straight>,
    seconds: f64,
    peak: usize,
    kept: Cow<'a, Kept>,
}

/// The fields of a mesh in plain numbers.
#[derive(Serialize, Deserialize)]
struct SavedMesh<'a> {
    points: Vec<[f64; 3]>,
    tets: Cow<'a, [[u32; 4]]>,
    regions: Vec<u16>,
    levels: Cow<'a, [u8]>,
    faces: Vec<([u32; 3], u32)>,
    creases: Vec<([u32; 2], bool)>,
    corners: Cow<'a, [u32]>,
    region_names: Cow<'a, [String]>,
    groups: Cow<'a, [String]>,
    patches: Vec<Vec<u32>>,
}

impl<'a> SavedMesh<'a> {
    fn of(mesh: &'a TetMesh) -> Self {
        Self {
            points: plain(mesh.points()),
            tets: mesh.tets().into(),
            regions: mesh.regions().iter().map(|r| r.0).collect(),
            levels: mesh.levels().into(),
            faces: mesh.faces().iter().map(|f| (f.vertices, f.patch.0)).collect(),
            creases: mesh.creases().iter().map(|c| (c.vertices, c.feature)).collect(),
            corners: mesh.corners().into(),
            region_names: mesh.region_names().into(),
            groups: mesh.groups().into(),
            patches: mesh.patch_groups().iter().map(|groups| groups.iter().map(|g| g.0).collect()).collect(),
        }
    }

    fn parts(self) -> TetMeshParts {
        TetMeshParts {
            points: self.points.into_iter().map(DVec3::from_array).collect(),
            tets: self.tets.into_owned(),
            regions: self.regions.into_iter().map(RegionId).collect(),
            levels: self.levels.into_owned(),
            faces: self.faces.into_iter().map(|(vertices, p)| Face { vertices, patch: PatchId(p) }).collect(),
            creases: self.creases.into_iter().map(|(vertices, feature)| Crease { vertices, feature }).collect(),
            corners: self.corners.into_owned(),
            region_names: self.region_names.into_owned(),
            groups: self.groups.into_owned(),
            patches: self.patches.into_iter().map(|groups| groups.into_iter().map(GroupId).collect()).collect(),
        }
    }
}

fn plain(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(DVec3::to_array).collect()
}

/// What makes a run this one: the scenario but for its title and where its mesh lies, the mesh, and the program.
pub(super) fn identity(scenario: &Scenario, problem: &Resolved) -> [u8; HASH] {
    let mut document = scenario.document.clone();
    for key in ["title", "description"] {
        document.remove(key);
    }
    if let Some(mesh) = document.get_mut("mesh").and_then(toml::Value::as_table_mut) {
        mesh.remove("file");
    }
    if let Some(refine) = document.get_mut("refine").and_then(toml::Value::as_table_mut) {
        refine.remove("strategy");
    }
    let mut hash = blake3::Hasher::new();
    hash.update(format!("{PROGRAM}\n{:?}\n{document}\n", scenario.refine.strategy).as_bytes());
    for x in problem.mesh.points().iter().flat_map(DVec3::to_array) {
        hash.update(&x.to_le_bytes());
    }
    for v in problem.mesh.tets().iter().flatten() {
        hash.update(&v.to_le_bytes());
    }
    *hash.finalize().as_bytes()
}

/// Writes the state before a step.
///
/// # Errors
/// [`OutputError::Write`].
pub(super) fn write(path: &Path, identity: &[u8; HASH], state: &State, kept: &Kept) -> Result<(), OutputError> {
    let saved = Saved {
        mesh: SavedMesh::of(&state.mesh),
        history: Cow::Borrowed(&state.history),
        steps: Cow::Borrowed(&state.steps),
        warnings: Cow::Borrowed(&state.warnings),
        refine_seconds: state.refine_seconds,
        largest_error: state.largest_error,
        guess: state.guess.as_deref().map(plain),
        straight: state.straight,
        seconds: state.spent(),
        peak: state.peak,
        kept: Cow::Borrowed(kept),
    };
    let mut bytes = Vec::new();
    ciborium::into_writer(&saved, &mut bytes).map_err(|e| OutputError::write(path, io::Error::other(e.to_string())))?;
    write_atomic(path, |w| {
        w.write_all(HEAD)?;
        w.write_all(identity)?;
        w.write_all(blake3::hash(&bytes).as_bytes())?;
        w.write_all(&bytes)
    })
}

/// Reads the state of a run.
///
/// # Errors
/// [`ResumeError`]: the file is missing, damaged, or of another run.
pub(super) fn read(path: &Path, identity: &[u8; HASH]) -> Result<(State, Kept), ResumeError> {
    let bytes = std::fs::read(path).map_err(|source| ResumeError::Missing { path: path.to_owned(), source })?;
    let corrupt = |problem| ResumeError::Corrupt { path: path.to_owned(), problem };
    let rest =
        bytes.strip_prefix(HEAD).ok_or_else(|| corrupt("it does not begin as checkpoints of this version do"))?;
    let (of, rest) = rest.split_first_chunk::<HASH>().ok_or_else(|| corrupt("it is cut off"))?;
    let (sum, rest) = rest.split_first_chunk::<HASH>().ok_or_else(|| corrupt("it is cut off"))?;
    if blake3::hash(rest).as_bytes() != sum {
        return Err(corrupt("its checksum is wrong"));
    }
    if of != identity {
        return Err(ResumeError::Stale { path: path.to_owned() });
    }
    let saved: Saved<'_> = ciborium::from_reader(rest).map_err(|_| corrupt("its content cannot be read"))?;
    let mesh = TetMesh::new(saved.mesh.parts()).map_err(|_| corrupt("its mesh is not sound"))?;
    let state = State {
        history: saved.history.into_owned(),
        steps: saved.steps.into_owned(),
        warnings: saved.warnings.into_owned(),
        refine_seconds: saved.refine_seconds,
        largest_error: saved.largest_error,
        guess: saved.guess.map(|guess| guess.into_iter().map(DVec3::from_array).collect()),
        straight: saved.straight,
        peak: saved.peak,
        ..State::of(mesh, saved.seconds)
    };
    Ok((state, saved.kept.into_owned()))
}
