//! Scenarios on hexahedra: resolved, solved, estimated, refined globally and written, as those on tetrahedra are.

mod analyse;
mod check;
mod compare;
pub(super) mod describe;
mod resolve;
mod results;
mod simulate;
mod subdivide;

pub(super) use check::check_hexes;
pub use compare::compare_elements;
pub use describe::HexReport;
pub use subdivide::{HexSubdivision, subdivide_hexes};

use super::leftovers;
use super::load::find;
use super::run::{announce, conclude, write_page};
use super::{ResumeError, RunOptions};
use crate::error::Error;
use crate::mesh::hex::curved::{Round, arcs};
use crate::mesh::hex::read::read_with;
use crate::mesh::hex::{HexMesh, generate};
use crate::output::atomic::ensure_writable_dir;
use crate::output::progress::Progress;
use crate::output::report::Report;
use crate::scenario::{Hexes, MeshSource, Scenario, Shape};
use resolve::{ResolvedHexes, resolve};
use results::HexResults;
use simulate::{Loop, simulate};

/// Runs a scenario on hexahedra and writes its results, whatever it expects of them.
pub(super) fn execute(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<Report, Error> {
    if options.resume {
        return Err(ResumeError::Hexahedra.into());
    }
    let problem = prepare(scenario, hexes, options)?;
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_run(&folder, scenario)?;
    let mut results = HexResults::begin(folder, scenario, &problem)?;
    let progress = Progress::new(options.quiet);
    let plan = Loop { scenario, memory: options.memory, progress, measure: false };
    let report = simulate(&problem, &plan, &mut |step| results.step(step))?;
    let steps = results.finish(&report)?;
    write_page(scenario, options, &report, steps.as_ref())?;
    conclude(scenario, options, &report, &problem.warnings)?;
    Ok(report)
}

/// Reads the mesh, resolves the scenario on it and checks that the supports hold it, before anything is written.
fn prepare(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<ResolvedHexes, Error> {
    options.check_targets(scenario)?;
    let (mesh, notes) = load(scenario, hexes)?;
    let problem = resolve(scenario, hexes, mesh)?;
    resolve::check_supports(scenario, &problem)?;
    announce(scenario, options, &notes, &problem.warnings)?;
    Ok(problem)
}

/// What a generated body is round about.
fn round(shape: &Shape) -> Option<Round> {
    match *shape {
        // Inside, an O-grid is not round.
        Shape::Cylinder { radius, .. } => Some(Round::Axis(Some(radius))),
        Shape::Tube { .. } => Some(Round::Axis(None)),
        Shape::SphereShell { .. } => Some(Round::Origin),
        _ => None,
    }
}

/// Reads or generates the mesh of a scenario, and what a user should know of it.
fn load(scenario: &Scenario, hexes: Hexes) -> Result<(HexMesh, Vec<String>), Error> {
    let (mut midsides, mut notes) = (Vec::new(), Vec::new());
    let mesh = match &scenario.mesh {
        MeshSource::Box { size, cells } => generate::box_hexes(*size, *cells)?,
        MeshSource::File(file) => {
            let file = read_with(&find(file, &scenario.directory)?, scenario.merge)?;
            notes = file.notes;
            if !file.midsides.is_empty() && !hexes.curved {
                notes.push(format!(
                    "{} edges of the mesh are curved: these elements take corners only",
                    file.midsides.len()
                ));
            }
            midsides = file.midsides;
            file.mesh
        }
        MeshSource::Shape(shape) => match *shape {
            Shape::Cylinder { radius, length, cells: [rings, layers] } => {
                generate::cylinder(radius, length, [rings, rings, layers])?
            }
            Shape::Tube { radii, length, cells, is_quarter } => generate::tube(radii, length, cells, is_quarter)?,
            Shape::SphereShell { radii, cells } => generate::sphere_shell(radii, cells, true)?,
            Shape::Prism { sides, radius, length, cells } => generate::prism(sides, radius, length, cells)?,
            other => return Err(Error::NotHexahedra { body: other.key() }),
        },
    };
    if let (MeshSource::Shape(shape), true) = (&scenario.mesh, hexes.curved) {
        midsides = round(shape).map(|round| arcs(&mesh, round)).unwrap_or_default();
    }
    Ok((if hexes.curved { mesh.with_midsides(&midsides) } else { mesh }, notes))
}
