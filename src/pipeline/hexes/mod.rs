//! Scenarios on hexahedra: resolved, solved, estimated, refined globally and written, as those on tetrahedra are.

mod analyse;
mod compare;
mod resolve;
mod results;
mod simulate;

pub use compare::compare_elements;

use super::RunOptions;
use super::leftovers;
use super::run::{announce, conclude};
use crate::error::Error;
use crate::mesh::hex::{HexMesh, generate};
use crate::output::atomic::ensure_writable_dir;
use crate::output::progress::Progress;
use crate::output::report::Report;
use crate::scenario::{Hexes, MeshSource, Scenario};
use resolve::{ResolvedHexes, resolve};
use results::HexResults;
use simulate::{Loop, simulate};

/// Runs a scenario on hexahedra and writes its results, whatever it expects of them.
pub(super) fn execute(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<Report, Error> {
    let problem = prepare(scenario, hexes, options)?;
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_run(&folder, scenario)?;
    let mut results = HexResults::begin(folder, scenario, &problem)?;
    let progress = Progress::new(options.quiet);
    let plan = Loop { scenario, memory: options.memory, progress, measure: false };
    let report = simulate(&problem, &plan, &mut |step| results.step(step))?;
    results.finish(&report)?;
    conclude(scenario, options, &report, &problem.warnings)?;
    Ok(report)
}

/// Reads the mesh, resolves the scenario on it and checks that the supports hold it, before anything is written.
fn prepare(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<ResolvedHexes, Error> {
    let problem = resolve(scenario, hexes, load(scenario, hexes)?)?;
    resolve::check_supports(scenario, &problem)?;
    announce(scenario, options, &[], &problem.warnings)?;
    Ok(problem)
}

/// Reads or generates the mesh of a scenario.
fn load(scenario: &Scenario, hexes: Hexes) -> Result<HexMesh, Error> {
    match &scenario.mesh {
        MeshSource::Box { size, cells } => Ok(generate::box_hexes(*size, *cells)?),
        MeshSource::File(_) | MeshSource::Shape(_) => Err(Error::NotHexahedra { element: hexes.element.name() }),
    }
}
