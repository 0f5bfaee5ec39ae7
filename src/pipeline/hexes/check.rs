//! `subsolid check` on hexahedra: what a run would do, without solving.

use super::super::{RunOptions, print, wrapped};
use super::describe::{HexReport, parts};
use super::resolve::{check_supports, resolve};
use super::{Hexes, load};
use crate::error::Error;
use crate::output::report::write_json;
use crate::output::table::{count, figures, table, text, units};
use crate::scenario::{Scenario, Strategy};
use std::time::Instant;

/// Reads a scenario's mesh, resolves its selectors and prints what a run would do.
///
/// # Errors
/// All that a run would report before it solves.
pub(in super::super) fn check(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<(), Error> {
    let start = Instant::now();
    let (mesh, notes) = load(scenario)?;
    let problem = resolve(scenario, hexes, mesh)?;
    check_supports(scenario, &problem)?;
    let report = HexReport::of(&problem.mesh, start.elapsed().as_secs_f64());
    if let Some(path) = &options.json {
        write_json(path, &report)?;
    }
    if options.quiet {
        return Ok(());
    }
    let mut told = format!("{}\n\n{}", scenario.title, report.table(&problem.mesh, hexes.element.name()));
    notes.iter().for_each(|note| told += &wrapped(&format!("note: {note}")));
    told += &units(&scenario.units);
    told += &parts(&problem.mesh);
    let mut chosen = table("selector|of|faces|area");
    for s in &problem.selections {
        chosen.add_row([s.name.clone(), s.what.to_owned(), count(s.faces), figures(s.area, 5)]);
    }
    told += &format!("\n{}\n", text(chosen));
    let space = problem.space(&problem.mesh);
    let (dofs, cells) = (3 * space.points().len(), problem.mesh.cells().len());
    told += &format!("\nelements: {}, {} unknowns or prescribed on this mesh\n", hexes.element.name(), count(dofs));
    if scenario.refine.strategy == Strategy::Global && scenario.refine.steps > 0 {
        let steps = scenario.refine.steps;
        let last = (0..steps).fold(cells, |cells, _| cells.saturating_mul(8));
        told += &format!("{steps} refinement steps at most, to {} cells\n", count(last));
    }
    told += &format!("results would go to {}\n", options.folder(scenario).display());
    for warning in scenario.warnings.iter().chain(&problem.warnings) {
        told += &wrapped(&format!("warning: {warning}"));
    }
    print(&told)
}
