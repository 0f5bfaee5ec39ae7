//! `subsolid subdivide`: refine a mesh, all of it or chosen cells, and write it.

use super::choice::{Cells, with_features};
use super::{load, print};
use crate::error::Error;
use crate::fem::Space;
use crate::mesh::read;
use crate::output::atomic::ensure_target;
use crate::output::frames::FrameWriter;
use crate::output::options::Compression;
use crate::output::progress::Progress;
use crate::output::report::{MeshReport, write_json};
use crate::output::vtk::{Fields, write_vtu};
use crate::subdiv::options::Options;
use crate::subdiv::{self, History};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the command line says about a subdivision.
#[derive(Debug, Clone)]
pub struct Subdivision {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Scheme, boundary rule, passes.
    pub options: Options,
    /// Refinement steps.
    pub steps: usize,
    /// Which cells are refined.
    pub cells: Cells,
    /// Feature angle in degrees.
    pub feature_angle: f64,
    /// File of further feature edges.
    pub edges: Option<PathBuf>,
    /// File of vertices that stay where they are.
    pub corners: Option<PathBuf>,
    /// The file to write.
    pub output: PathBuf,
    /// Folder for the mesh after each elementary stage of each step.
    pub frames: Option<PathBuf>,
    /// Print errors only.
    pub quiet: bool,
    /// File for the counts and the quality of the final mesh.
    pub json: Option<PathBuf>,
}

/// Refines the chosen cells `steps` times and writes the mesh as VTK.
///
/// # Errors
/// [`Error::Mesh`] if the mesh or a list cannot be read or the mesh not be refined, [`Error::Output`] if the result cannot
/// be written.
pub fn subdivide(command: &Subdivision) -> Result<MeshReport, Error> {
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
    let (edges, corners) = (command.edges.as_deref(), command.corners.as_deref());
    let mut mesh = with_features(file.mesh, command.feature_angle, edges, corners)?;
    let (mut history, volume) = (History::default(), mesh.volume());
    let progress = Progress::new(command.quiet);
    let mut frames = command.frames.as_deref().map(FrameWriter::new).transpose()?;
    if let Some(frames) = &mut frames {
        frames.write("input", &mesh)?;
    }
    let options = Options { frames: frames.is_some(), ..command.options };
    let (mut seconds, mut split) = (0.0, 0);
    for step in 1..=command.steps {
        let chosen = command.cells.choose(&mesh, step)?;
        let count = chosen.iter().filter(|c| **c).count();
        let _phase = progress.phase(format!("step {step}: refine {count} of {} cells", chosen.len()));
        let clock = Instant::now();
        let refined = subdiv::refine(&mesh, &history, &chosen, &options)?;
        seconds += clock.elapsed().as_secs_f64();
        split += refined.info.split;
        if let Some(writer) = &mut frames {
            for frame in &refined.frames {
                writer.write(&format!("step {step} {}", frame.stage), &frame.mesh)?;
            }
        }
        (mesh, history) = (refined.mesh, refined.history);
    }
    let volumes = (volume, mesh.volume());
    let report = MeshReport::of(&mesh, seconds);
    write_vtu(&command.output, &Space::linear(&mesh), &Fields::default(), Compression::default())?;
    if let Some(path) = &command.json {
        write_json(path, &report)?;
    }
    if !command.quiet {
        print(&describe(&report, split, volumes, &command.output))?;
    }
    Ok(report)
}

fn describe(report: &MeshReport, split: usize, (before, after): (f64, f64), output: &Path) -> String {
    let MeshReport { mesh, quality: q, seconds, .. } = report;
    format!(
        "{} cells, {} nodes, {} feature edges\nminimum dihedral angle: worst {:.2}, average {:.2} degrees; largest valence \
         {}\nvolume {before:.6e}, now {after:.6e}\n{split} cells refined in {seconds:.3} s, written to {}\n",
        mesh.cells,
        mesh.nodes,
        mesh.feature_edges,
        q.worst,
        q.average,
        q.max_valence,
        output.display()
    )
}
