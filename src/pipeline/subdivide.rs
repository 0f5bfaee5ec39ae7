//! `subsolid subdivide`: refine all cells of a mesh and write it.

use super::print;
use crate::error::Error;
use crate::mesh::{features, read};
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
    /// Refinement steps of all cells.
    pub steps: usize,
    /// Feature angle in degrees.
    pub feature_angle: f64,
    /// The file to write.
    pub output: PathBuf,
    /// Print errors only.
    pub quiet: bool,
    /// File for the counts and the quality of the final mesh.
    pub json: Option<PathBuf>,
}

/// Refines all cells `steps` times and writes the mesh as VTK.
///
/// # Errors
/// [`Error::Mesh`] if the mesh cannot be read or refined, [`Error::Output`] if the result cannot be written.
pub fn subdivide(command: &Subdivision) -> Result<MeshReport, Error> {
    let file = read::read(&command.mesh)?;
    let mut mesh = features::with_creases(file.mesh, command.feature_angle, &[]);
    let mut history = History::default();
    let progress = Progress::new(command.quiet);
    let clock = Instant::now();
    for step in 1..=command.steps {
        let _phase = progress.phase(format!("step {step}: refine {} cells", mesh.tets().len()));
        let all = vec![true; mesh.tets().len()];
        let refined = subdiv::refine(&mesh, &history, &all, &command.options)?;
        (mesh, history) = (refined.mesh, refined.history);
    }
    let report = MeshReport::of(&mesh, clock.elapsed().as_secs_f64());
    write_vtu(&command.output, &mesh, &Fields::default(), Compression::default())?;
    if let Some(path) = &command.json {
        write_json(path, &report)?;
    }
    if !command.quiet {
        print(&describe(&report, &command.output))?;
    }
    Ok(report)
}

fn describe(report: &MeshReport, output: &Path) -> String {
    let MeshReport { mesh, quality: q, seconds } = report;
    format!(
        "{} cells, {} nodes, {} feature edges\nminimum dihedral angle: worst {:.2}, average {:.2} degrees; largest valence \
         {}\nrefined in {seconds:.3} s, written to {}\n",
        mesh.cells,
        mesh.nodes,
        mesh.feature_edges,
        q.worst,
        q.average,
        q.max_valence,
        output.display()
    )
}
