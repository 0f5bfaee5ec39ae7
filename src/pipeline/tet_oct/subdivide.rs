//! `subsolid subdivide --scheme tet-oct`: smooth a mesh of tetrahedra and write it.

use super::super::choice::with_features;
use super::super::forecast::free_bytes;
use super::super::{load, print};
use crate::error::Error;
use crate::fem::Space;
use crate::mesh::MeshError;
use crate::mesh::read;
use crate::mesh::tet_oct::{OctSplit, TetOctMesh};
use crate::output::options::{Compression, Units};
use crate::output::progress::Progress;
use crate::output::report::{MeshReport, write_json};
use crate::output::vtk::{Fields, Values, write_vtu};
use crate::subdiv::tet_oct::{EmbedError, refine};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Most cells that are made.
const MAX_CELLS: usize = 50_000_000;

/// Bytes that a cell takes at least.
const BYTES: usize = 100;

/// What the command line says about a smooth subdivision of tetrahedra.
#[derive(Debug, Clone)]
pub struct TetOctSubdivision {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Refinement steps.
    pub steps: usize,
    /// Feature angle in degrees.
    pub feature_angle: f64,
    /// File of further creases.
    pub edges: Option<PathBuf>,
    /// File of vertices that stay where they are.
    pub corners: Option<PathBuf>,
    /// The file to write.
    pub output: PathBuf,
    /// Print errors only.
    pub quiet: bool,
    /// File for the figures of the final mesh.
    pub json: Option<PathBuf>,
}

/// What is reported of the final mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TetOctReport {
    /// Tetrahedra of the scheme.
    pub tetrahedra: usize,
    /// Octahedra of the scheme.
    pub octahedra: usize,
    /// The mesh that is written, octahedra cut into four.
    #[serde(flatten)]
    pub written: MeshReport,
}

/// Refines a mesh `steps` times and writes it as VTK: each octahedron as four tetrahedra around its shortest diagonal, with the cell
/// data `octahedron`, its number, or -1 for cells that are tetrahedra.
///
/// # Errors
/// [`Error::Mesh`] if the mesh or a list cannot be read, [`Error::Embed`] if a cell of the result is inverted, [`Error::Output`] if
/// the result cannot be written.
pub fn subdivide_tet_oct(command: &TetOctSubdivision) -> Result<TetOctReport, Error> {
    if !command.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("vtu")) {
        return Err(Error::NotVtu { path: command.output.clone() });
    }
    let file = read::read(&load::find(&command.mesh, Path::new(""))?)?;
    if !command.quiet {
        file.notes.iter().try_for_each(|note| print(&format!("note: {note}\n")))?;
    }
    let (edges, corners) = (command.edges.as_deref(), command.corners.as_deref());
    let start = with_features(file.mesh, command.feature_angle, edges, corners)?;
    check_count(start.tets().len(), command.steps, BYTES)?;
    let before = start.volume();
    let mut mesh = TetOctMesh::from(&start);
    let progress = Progress::new(command.quiet);
    let mut seconds = 0.0;
    for step in 1..=command.steps {
        let _phase = progress.phase(format!("step {step}: refine {} cells", mesh.cell_count()));
        let clock = Instant::now();
        mesh = refine(&mesh);
        seconds += clock.elapsed().as_secs_f64();
    }
    let cut = mesh.tetrahedra(OctSplit::Diagonal).map_err(EmbedError::Folded)?;
    let numbers: Vec<f64> = cut.octs.iter().map(|oct| oct.map_or(-1.0, f64::from)).collect();
    let report = TetOctReport {
        tetrahedra: mesh.tets().len(),
        octahedra: mesh.octs().len(),
        written: MeshReport::of(&cut.mesh, seconds),
    };
    let cells = vec![("octahedron", Values::Scalars(&numbers))];
    let fields = Fields { time: 0.0, units: Units::default(), points: Vec::new(), cells };
    write_vtu(&command.output, &Space::linear(&cut.mesh), &fields, Compression::default())?;
    if let Some(path) = &command.json {
        write_json(path, &report)?;
    }
    if !command.quiet {
        print(&describe(&report, (before, cut.mesh.volume()), &command.output))?;
    }
    Ok(report)
}

/// Refuses steps that would make too many cells, or more than fit into the memory that is free at so many bytes a cell: T' = 4 T + 8 O and
/// O' = T + 6 O.
pub(in super::super) fn check_count(tets: usize, steps: usize, bytes: usize) -> Result<(), MeshError> {
    let (mut now, mut octs) = (tets, 0_usize);
    for _ in 0..steps {
        (now, octs) = (4 * now + 8 * octs, now + 6 * octs);
        let free = free_bytes().map_or(usize::MAX, |all| all as usize / bytes);
        if now + octs > MAX_CELLS.min(free) {
            let message = format!(
                "{tets} tetrahedra smoothed {steps} times are more than {} cells{}; ask for fewer steps",
                MAX_CELLS.min(free),
                if free < MAX_CELLS { ", all that fits into the memory that is free" } else { "" }
            );
            return Err(MeshError::Generator(message));
        }
    }
    Ok(())
}

fn describe(report: &TetOctReport, (before, after): (f64, f64), output: &Path) -> String {
    let TetOctReport { tetrahedra, octahedra, written } = report;
    let (nodes, features, seconds) = (written.mesh.nodes, written.mesh.feature_edges, written.seconds);
    format!(
        "{tetrahedra} tetrahedra and {octahedra} octahedra, {nodes} nodes, {features} feature edges\nwith octahedra cut in four: {} \
         cells, minimum dihedral angle: worst {:.2}, average {:.2} degrees\nvolume {before:.6e}, now {after:.6e}\nmade in \
         {seconds:.3} s, written to {}\n",
        written.mesh.cells,
        written.quality.worst,
        written.quality.average,
        output.display()
    )
}
