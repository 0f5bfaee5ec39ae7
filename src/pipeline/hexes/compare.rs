//! `subsolid compare --elements`: one problem with several elements of hexahedra, refined globally.

use super::super::results::write_text;
use super::super::{RunOptions, page, print};
use super::simulate::{Loop, simulate};
use super::{HexResults, prepare};
use crate::error::Error;
use crate::output::atomic::ensure_writable_dir;
use crate::output::elements::{self, COSTS, ElementRow, Elements, RESULTS};
use crate::output::plot::{Panel, panels};
use crate::output::progress::Progress;
use crate::output::report::{StopReason, write_json};
use crate::output::table::{table, text};
use crate::pipeline::leftovers;
use crate::scenario::{Hexes, Scenario};
use std::path::Path;

/// Runs a scenario with each element and writes the results, and beside each other what the elements give for what they
/// cost: largest displacement, compliance, condition number and iterations of conjugate gradients.
///
/// # Errors
/// [`Error`] with its exit code, as [`super::super::run::run`].
pub fn compare_elements(scenario: &Scenario, names: &[String], options: &RunOptions) -> Result<(), Error> {
    let variants = names.iter().map(|name| variant(scenario, name)).collect::<Result<Vec<_>, Error>>()?;
    options.check_targets(scenario)?;
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    let folders: Vec<&str> = names.iter().map(String::as_str).collect();
    leftovers::for_comparison(&folder, &folders, scenario)?;
    let (mut rows, mut runs) = (Vec::new(), Vec::new());
    for (name, (scenario, hexes)) in names.iter().zip(&variants) {
        let problem =
            prepare(scenario, *hexes, &RunOptions { quiet: !rows.is_empty() || options.quiet, ..options.clone() })?;
        let mut results = HexResults::begin(folder.join(name), scenario, &problem)?;
        let plan = Loop { scenario, memory: options.memory, progress: Progress::new(options.quiet), measure: true };
        let mut measured = Vec::new();
        let report = simulate(&problem, &plan, &mut |step| {
            measured.push(step.analysed.measured());
            results.step(step)
        })?;
        let steps = results.finish(&report)?;
        if report.stop_reason == StopReason::Interrupted {
            return Err(Error::Interrupted {
                ending: format!("{name}: interrupted after step {}", measured.len() - 1),
            });
        }
        let row = |(step, measured)| ElementRow { element: name.clone(), ..super::simulate::row(step, measured) };
        rows.extend(report.steps.iter().zip(measured).map(row));
        runs.push((name, scenario, report, steps));
    }
    let pages: Vec<page::Run<'_>> = runs
        .iter()
        .map(|(name, scenario, report, steps)| {
            let strategy = scenario.refine.strategy;
            page::Run { name, scenario, strategy, report, steps: steps.as_ref() }
        })
        .collect();
    page::write(&folder, &scenario.title, &pages, &())?;
    let result = Elements { rows };
    let (heads, cells) = elements::table(&result.rows);
    let mut rows = table(&heads.join("|"));
    for row in cells {
        rows.add_row(row);
    }
    let text = text(rows) + "\n";
    write_json(&folder.join("compare.json"), &result)?;
    write_text(&folder.join("compare.txt"), &text)?;
    draw(&folder, names, &result.rows)?;
    if let Some(path) = &options.json {
        write_json(path, &result)?;
    }
    if options.quiet { Ok(()) } else { print(&format!("{text}\nresults in {}\n", folder.display())) }
}

/// The scenario with another element.
fn variant(scenario: &Scenario, name: &str) -> Result<(Scenario, Hexes), Error> {
    let mut set = scenario.overrides.clone();
    set.push(format!("analysis.element=\"{name}\""));
    let scenario = Scenario::from_file(&scenario.path, &set)?;
    match scenario.hexes {
        Some(hexes) => Ok((scenario, hexes)),
        None => Err(Error::ElementsOfHexahedra { element: name.to_owned() }),
    }
}

fn draw(folder: &Path, names: &[String], rows: &[ElementRow]) -> Result<(), Error> {
    for (label, cost) in COSTS {
        let curve = |name: &String, of: fn(&ElementRow) -> f64| {
            let own = rows.iter().filter(|r| r.element == *name);
            (name.clone(), own.map(|r| (cost(r), of(r))).collect())
        };
        let panel = |(title, of): (&'static str, fn(&ElementRow) -> f64)| Panel {
            title,
            curves: names.iter().map(|name| curve(name, of)).collect(),
        };
        panels(&folder.join(format!("elements_{label}.svg")), label, &RESULTS.map(panel))?;
    }
    Ok(())
}
