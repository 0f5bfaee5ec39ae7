//! The commands; the only room that sees every stage.

pub mod again;
mod analyse;
pub mod check;
mod checkpoint;
pub mod choice;
pub mod compare;
mod describe;
mod doubts;
mod forecast;
pub mod hexes;
mod hints;
pub mod inspect;
pub mod interrupt;
mod leftovers;
pub mod load;
mod loading;
mod look_ahead;
mod model_error;
mod page;
mod passes;
mod quantities;
pub mod resolve;
mod results;
mod richer;
pub mod run;
pub mod select;
mod simulate;
mod smooth;
mod straight;
pub mod subdivide;
mod subspace;
pub mod tet_oct;
mod tolerance;
pub mod variants;
pub mod verify;

pub use checkpoint::ResumeError;
pub use model_error::ModelError;

use crate::error::Error;
use crate::mesh::Tagged;
use crate::output::atomic::ensure_target;
use crate::output::table::{COLUMNS, short};
use crate::scenario::{MeshSource, Scenario};
use glam::DVec3;
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;

/// Reads the memory counter of the program that calls the library.
#[derive(Debug, Clone, Copy)]
pub struct MemoryProbe {
    /// Lets the peak start again from what is in use.
    pub reset: fn(),
    /// Largest number of bytes in use since the last reset.
    pub peak: fn() -> usize,
}

/// What the command line says about a run.
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Folder of the results; `results/<name of the scenario>` if absent.
    pub output: Option<PathBuf>,
    /// Print errors only.
    pub quiet: bool,
    /// Further file for the report.
    pub json: Option<PathBuf>,
    /// Go on from the checkpoint that an interrupted run left.
    pub resume: bool,
    /// The memory counter.
    pub memory: MemoryProbe,
}

impl RunOptions {
    /// The folder of a scenario's results.
    #[must_use]
    pub fn folder(&self, scenario: &Scenario) -> PathBuf {
        self.output.clone().unwrap_or_else(|| PathBuf::from("results").join(scenario.name()))
    }

    /// Checks that the further file for the report can be written, and is none that the scenario reads.
    fn check_targets(&self, scenario: &Scenario) -> Result<(), Error> {
        let mesh = match &scenario.mesh {
            MeshSource::File(file) => Some(load::find(file, &scenario.directory)?),
            MeshSource::Box { .. } | MeshSource::Shape(_) => None,
        };
        let inputs = || mesh.as_deref().into_iter().chain([&*scenario.path]);
        Ok(self.json.iter().try_for_each(|path| ensure_target(path, inputs()))?)
    }
}

/// Prints to standard output. A reader that has gone away (`subsolid ... | head`) is no error: files are still written.
///
/// # Errors
/// [`Error::Print`] for other failures.
pub fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::Print(e)),
        _ => Ok(()),
    }
}

/// A coordinate below this part of a mesh's diagonal is rounding.
const ROUNDING: f64 = 1e-12;

/// The corners of a mesh's bounding box, to six figures; coordinates that are rounding beside its diagonal are 0.
fn span(mesh: &impl Tagged) -> String {
    let (lo, hi) = mesh.limits();
    let diagonal = lo.distance(hi);
    let corner = |p: DVec3| {
        let [x, y, z] = p.to_array().map(|x| if x.abs() < ROUNDING * diagonal { "0".to_owned() } else { short(x, 6) });
        format!("[{x}, {y}, {z}]")
    };
    format!("{} to {}", corner(lo), corner(hi))
}

/// A paragraph broken into lines that fit, with a newline at the end.
fn wrapped(paragraph: &str) -> String {
    textwrap::fill(paragraph, usize::from(COLUMNS)) + "\n"
}
