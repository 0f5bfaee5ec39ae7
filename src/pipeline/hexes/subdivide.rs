//! `subsolid subdivide --scheme catmull-clark`: refine a mesh of hexahedra and write it.

use super::super::choice::{tagged_corners, tagged_edges};
use super::super::{load, print};
use super::describe::HexReport;
use crate::error::Error;
use crate::mesh::Crease;
use crate::mesh::hex::{HexError, HexMesh, read};
use crate::mesh::topology::sorted2;
use crate::output::atomic::ensure_target;
use crate::output::hex_mesh::write_hex_mesh;
use crate::output::options::Compression;
use crate::output::progress::Progress;
use crate::output::report::write_json;
use crate::subdiv::catmull_clark::{interpolated, refine};
use crate::subdiv::options::CatmullClark;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Most cells that are made.
const MAX_CELLS: usize = 50_000_000;

/// What the command line says about a subdivision of hexahedra.
#[derive(Debug, Clone)]
pub struct HexSubdivision {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Refinement steps.
    pub steps: usize,
    /// The masks.
    pub variant: CatmullClark,
    /// Whether the limit passes through the vertices of the mesh, which are its control points otherwise.
    pub interpolate: bool,
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

/// Refines a mesh `steps` times and writes it as VTK.
///
/// # Errors
/// [`Error::Hex`] if the mesh cannot be read or not be refined, [`Error::Mesh`] if a list cannot be read, [`Error::Output`] if
/// the result cannot be written.
pub fn subdivide_hexes(command: &HexSubdivision) -> Result<HexReport, Error> {
    if !command.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("vtu")) {
        return Err(Error::NotVtu { path: command.output.clone() });
    }
    let path = load::find(&command.mesh, Path::new(""))?;
    [Some(&command.output), command.json.as_ref()]
        .into_iter()
        .flatten()
        .try_for_each(|to| ensure_target(to, [&*path]))?;
    let file = read::read(&path)?;
    if !command.quiet {
        file.notes.iter().try_for_each(|note| print(&format!("note: {note}\n")))?;
    }
    let mut mesh = with_features(file.mesh, command)?;
    let factor = u32::try_from(command.steps).ok().and_then(|steps| 8_usize.checked_pow(steps));
    if factor.and_then(|factor| factor.checked_mul(mesh.cells().len())).is_none_or(|count| count > MAX_CELLS) {
        let (cells, steps) = (mesh.cells().len(), command.steps);
        return Err(HexError::TooManyCells { cells, steps, most: MAX_CELLS }.into());
    }
    let (progress, clock, before) = (Progress::new(command.quiet), Instant::now(), mesh.volume());
    if command.interpolate {
        let _phase = progress.phase("control points through which the limit passes".to_owned());
        mesh = interpolated(mesh, command.variant)?;
    }
    for step in 1..=command.steps {
        let _phase = progress.phase(format!("step {step}: refine {} cells", mesh.cells().len()));
        mesh = refine(&mesh, command.variant)?.mesh;
    }
    let seconds = clock.elapsed().as_secs_f64();
    let report = HexReport::of(&mesh, seconds);
    write_hex_mesh(&command.output, &mesh, Compression::default())?;
    if let Some(path) = &command.json {
        write_json(path, &report)?;
    }
    if !command.quiet {
        let (after, output) = (mesh.volume(), command.output.display());
        let text = format!("volume {before:.6e}, now {after:.6e}\nmade in {seconds:.3} s, written to {output}\n");
        print(&(report.lines() + &text))?;
    }
    Ok(report)
}

/// The mesh with its creases found, and with those and the corners that the files list.
fn with_features(mesh: HexMesh, command: &HexSubdivision) -> Result<HexMesh, Error> {
    let edges = command.edges.as_deref().map(|path| tagged_edges(mesh.topology().edges(), path)).transpose()?;
    let corners = command.corners.as_deref().map(|path| tagged_corners(mesh.points().len(), path)).transpose()?;
    let mut parts = mesh.with_creases(command.feature_angle, &[]).into_parts();
    let crease = |ends| Crease { vertices: sorted2(ends), feature: true };
    parts.creases.extend(edges.into_iter().flatten().map(crease));
    parts.corners.extend(corners.into_iter().flatten());
    Ok(HexMesh::new(parts)?)
}
