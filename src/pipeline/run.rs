//! `subsolid run`: one scenario from its file to its results.

use super::doubts::ending;
use super::forecast;
use super::leftovers;
use super::page;
use super::quantities::failed_expectations;
use super::resolve::{Resolved, check_supports, resolve_curved};
use super::results::Results;
use super::simulate::{Plan, State, simulate_from};
use super::{RunOptions, hexes, load::load, print, tolerance, wrapped};
use crate::error::Error;
use crate::fem::options::Element;
use crate::output::atomic::ensure_writable_dir;
use crate::output::compare::{TRUE, error_source};
use crate::output::page::Steps;
use crate::output::plot::{Axis, error_curves};
use crate::output::progress::Progress;
use crate::output::report::{Report, StopReason, write_json};
use crate::output::table;
use crate::scenario::{Scenario, Strategy};
use std::path::Path;

/// Runs a scenario and writes its results.
///
/// # Errors
/// [`Error`] with its exit code; after everything is written, [`Error::Unexpected`] if a quantity is not what the scenario
/// expects, and [`Error::ToleranceNotReached`] if it asks for an error that was not reached.
pub fn run(scenario: &Scenario, options: &RunOptions) -> Result<Report, Error> {
    let report = execute(scenario, options)?;
    match failure(scenario, scenario.refine.strategy, &report) {
        Some(error) => Err(error),
        None => Ok(report),
    }
}

/// Runs a scenario and writes its results, whatever it expects of them.
pub(super) fn execute(scenario: &Scenario, options: &RunOptions) -> Result<Report, Error> {
    if let Some(hexes) = scenario.hexes {
        return hexes::execute(scenario, hexes, options);
    }
    let problem = prepare(scenario, options)?;
    forecast::refuse_too_large(scenario, scenario.refine.strategy, &problem)?;
    let (mut results, state) = begin(scenario, options, &problem)?;
    let plan = Plan {
        scenario,
        strategy: scenario.refine.strategy,
        memory: options.memory,
        progress: Progress::new(options.quiet),
    };
    let report = simulate_from(state, &problem, &plan, &mut results)?;
    if scenario.output.report {
        plot_curves(&options.folder(scenario), scenario.element, &[("this run", &report)])?;
    }
    let steps = results.finish(&report)?;
    write_page(scenario, options, &report, steps.as_ref())?;
    conclude(scenario, options, &report, &problem.warnings)?;
    Ok(report)
}

/// Makes room for the results of a run, or goes on with those there are; with the state to begin from.
fn begin<'a>(
    scenario: &'a Scenario,
    options: &RunOptions,
    problem: &'a Resolved,
) -> Result<(Results<'a>, State), Error> {
    let folder = options.folder(scenario);
    if options.resume {
        return Results::resume(folder, scenario, problem);
    }
    ensure_writable_dir(&folder)?;
    leftovers::for_run(&folder, scenario)?;
    Ok((Results::begin_resumable(folder, scenario, problem)?, State::first(problem)))
}

/// Writes the page of a run.
pub(super) fn write_page(
    scenario: &Scenario,
    options: &RunOptions,
    report: &Report,
    steps: Option<&Steps>,
) -> Result<(), Error> {
    let run = page::Run { name: "", scenario, strategy: scenario.refine.strategy, report, steps };
    page::write(&options.folder(scenario), &scenario.title, &[run], &())
}

/// Writes the further file for the report, and prints tables, warnings and how the run ended; `said` are warnings of the problem
/// that were printed before.
pub(super) fn conclude(
    scenario: &Scenario,
    options: &RunOptions,
    report: &Report,
    said: &[String],
) -> Result<(), Error> {
    if let Some(path) = &options.json {
        write_json(path, report)?;
    }
    if options.quiet {
        return Ok(());
    }
    let folder = options.folder(scenario);
    let reactions = report.steps.last().map(table::reactions).unwrap_or_default();
    let (units, steps) = (table::units(&report.units), table::steps(&report.steps));
    let text = format!("{units}{steps}\n{reactions}{}", quantity_tables(report));
    let ending = ending(scenario, scenario.refine.strategy, report);
    let warnings = new_warnings("", report, scenario, said);
    print(&format!("{text}\n{warnings}{ending}\nresults in {}\n", folder.display()))
}

/// The warning of a run that refines a mesh with curved edges.
const STRAIGHTENED: &str = "refined meshes have straight edges: from step 1 on the body is another than at step 0, energies do \
                            not compare, and stresses at curved surfaces get worse. Errors from then on contain \
                            what this changes, by the mesh that was read; to avoid it start from a finer mesh, with \
                            refine.strategy = \"none\"";

/// Reads the mesh, resolves the scenario on it and checks that the supports hold it, before anything is written.
pub(super) fn prepare(scenario: &Scenario, options: &RunOptions) -> Result<Resolved, Error> {
    options.check_targets(scenario)?;
    let file = load(scenario)?;
    let problem = resolve_curved(scenario, file.mesh, file.midsides);
    let mut problem = problem.map_err(|e| e.with_inner(&file.inner_groups))?;
    if !problem.midsides.is_empty() && scenario.refine.strategy != Strategy::None && scenario.refine.steps > 0 {
        problem.warnings.push(STRAIGHTENED.to_owned());
    }
    check_supports(scenario, &problem)?;
    announce(scenario, options, &file.notes, &problem.warnings)?;
    Ok(problem)
}

/// Prints the title, remarks on the mesh, and warnings of the scenario and of the problem.
pub(super) fn announce(
    scenario: &Scenario,
    options: &RunOptions,
    notes: &[String],
    warnings: &[String],
) -> Result<(), Error> {
    if options.quiet {
        return Ok(());
    }
    let remarks = notes.iter().map(|n| wrapped(&format!("note: {n}")));
    let warnings = scenario.warnings.iter().chain(warnings).map(|w| wrapped(&format!("warning: {w}")));
    print(&format!("{}\n{}", scenario.title, remarks.chain(warnings).collect::<String>()))
}

/// The tables of true errors, of quantities and of what was expected of them.
pub(super) fn quantity_tables(report: &Report) -> String {
    let tables = [table::true_errors(&report.steps), table::quantities(&report.steps), table::expectations(report)];
    tables.into_iter().filter(|t| !t.is_empty()).map(|t| format!("\n{t}")).collect()
}

/// The error to end with after everything is written: that the user ended the run, an expectation that failed, which tells of a tolerance that was not
/// reached too, or such a tolerance.
pub(super) fn failure(scenario: &Scenario, strategy: Strategy, report: &Report) -> Option<Error> {
    if report.stop_reason == StopReason::Interrupted {
        return Some(Error::Interrupted { ending: ending(scenario, strategy, report) });
    }
    match (failed_expectations(report), tolerance::missed(scenario, strategy, report)) {
        (Some(Error::Unexpected { sentences }), Some(missed)) => {
            Some(Error::Unexpected { sentences: format!("{sentences}; {missed}") })
        }
        (failed, missed) => failed.or(missed),
    }
}

/// The warnings of a run but for those that were said before it.
pub(super) fn new_warnings(run: &str, report: &Report, scenario: &Scenario, said: &[String]) -> String {
    let new = report.warnings.iter().filter(|w| !said.contains(w) && !scenario.warnings.contains(w));
    new.map(|w| wrapped(&format!("warning: {run}{w}"))).collect()
}

/// All warnings of a run; `run` names it where there are several.
pub(super) fn warnings(run: &str, report: &Report) -> String {
    report.warnings.iter().map(|w| wrapped(&format!("warning: {run}{w}"))).collect()
}

/// Plots the relative error, the true one where it is known of all runs, against unknowns and seconds, and that of several runs
/// against memory too.
pub(super) fn plot_curves(folder: &Path, element: Element, runs: &[(&str, &Report)]) -> Result<(), Error> {
    let degree = match element {
        Element::Tet4 => 1,
        Element::Tet10 => 2,
    };
    let source = error_source(runs.iter().map(|(_, report)| *report));
    let curve = |(name, report): &(&str, &Report), axis: Axis| {
        let mut spent = 0.0;
        let points = report.steps.iter().map(|s| {
            spent += s.seconds.computing();
            let paid = match axis {
                Axis::Unknowns(_) => s.free_dofs as f64,
                Axis::Seconds => spent,
                Axis::Memory => s.peak_memory_bytes as f64 / 1e6,
            };
            (paid, s.error.true_relative.filter(|_| source == TRUE).unwrap_or(s.error.relative))
        });
        ((*name).to_owned(), points.collect())
    };
    let plots = [
        (Axis::Unknowns(degree), "error_dofs.svg"),
        (Axis::Seconds, "error_seconds.svg"),
        (Axis::Memory, "error_memory.svg"),
    ];
    let wanted = if runs.len() > 1 { plots.len() } else { 2 };
    for (axis, file) in plots.into_iter().take(wanted) {
        let curves: Vec<(String, Vec<(f64, f64)>)> = runs.iter().map(|run| curve(run, axis)).collect();
        error_curves(&folder.join(file), axis, source, &curves)?;
    }
    Ok(())
}
