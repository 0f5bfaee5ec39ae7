//! `subsolid check` on hexahedra: what a run would do, without solving.

use super::super::check::describe_materials;
use super::super::{RunOptions, print, wrapped};
use super::describe::{HexReport, parts};
use super::{load, resolve};
use crate::error::Error;
use crate::fem::hexes::check_hex_shapes;
use crate::output::report::{Selection, write_json};
use crate::output::table::{count, figures, table, text, units};
use crate::scenario::{Hexes, Scenario, Strategy};
use serde::Serialize;
use std::time::Instant;

/// What `--json` holds.
#[derive(Serialize)]
struct Details {
    #[serde(flatten)]
    mesh: HexReport,
    selections: Vec<Selection>,
    /// Three for each node, vertex or bubble, held or not.
    dofs: usize,
}

/// Reads a scenario's mesh, resolves its selectors and prints what a run would do.
///
/// # Errors
/// All that a run would report before it solves.
pub(in super::super) fn check_hexes(scenario: &Scenario, hexes: Hexes, options: &RunOptions) -> Result<(), Error> {
    let start = Instant::now();
    let (mesh, notes) = load(scenario, hexes)?;
    let problem = resolve::resolve(scenario, hexes, mesh)?;
    resolve::check_supports(scenario, &problem)?;
    let space = problem.space(&problem.mesh);
    check_hex_shapes(&space)?;
    let dofs = 3 * space.points().len();
    let report = HexReport::of(&problem.mesh, start.elapsed().as_secs_f64());
    let mut told = format!("{}\n\n{}", scenario.title, report.table(&problem.mesh, "of hexahedra"));
    notes.iter().for_each(|note| told += &wrapped(&format!("note: {note}")));
    told += &units(&scenario.units);
    told += &parts(&problem.mesh);
    told += &describe_materials(scenario, &problem.mesh)?;
    let mut rows = table("support or load|is|faces|area");
    for s in &problem.selections {
        rows.add_row([s.name.clone(), s.what.to_owned(), s.faces.to_string(), figures(s.area, 5)]);
    }
    told += &format!("\n{}\n", text(rows));
    let steps = match scenario.refine.strategy {
        Strategy::None => 0,
        _ => scenario.refine.steps,
    };
    let last =
        8_usize.saturating_pow(u32::try_from(steps).unwrap_or(u32::MAX)).saturating_mul(problem.mesh.cells().len());
    told += &wrapped(&format!(
        "elements: {}, {} dofs at first; all cells are refined at most {steps} times, to {} cells",
        hexes.element.name(),
        count(dofs),
        count(last)
    ));
    told += &format!("results would go to {}\n", options.folder(scenario).display());
    for warning in scenario.warnings.iter().chain(&problem.warnings) {
        told += &wrapped(&format!("warning: {warning}"));
    }
    if let Some(path) = &options.json {
        write_json(path, &Details { mesh: report, selections: problem.selections, dofs })?;
    }
    if options.quiet { Ok(()) } else { print(&told) }
}
