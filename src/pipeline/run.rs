//! `subsolid run`: one scenario from its file to its results.

use super::doubts::ending;
use super::leftovers;
use super::quantities::failed_expectations;
use super::resolve::{Resolved, check_supports, resolve_curved};
use super::results::Results;
use super::simulate::{Plan, simulate};
use super::{RunOptions, load::load, print, tolerance, wrapped};
use crate::error::Error;
use crate::fem::options::Element;
use crate::output::atomic::ensure_writable_dir;
use crate::output::plot::{Axis, error_curves};
use crate::output::progress::Progress;
use crate::output::report::{Report, write_json};
use crate::output::table;
use crate::scenario::{Scenario, Strategy};
use std::path::Path;

/// Runs a scenario and writes its results.
///
/// # Errors
/// [`Error`] with its exit code; after everything is written, [`Error::Unexpected`] if a quantity is not what the scenario
/// expects, and [`Error::ToleranceNotReached`] if it asks for an error that was not reached.
pub fn run(scenario: &Scenario, options: &RunOptions) -> Result<Report, Error> {
    let problem = prepare(scenario, options)?;
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_run(&folder, scenario)?;
    let mut results = Results::begin(folder, scenario, &problem, scenario.refine.strategy)?;
    let plan = Plan {
        scenario,
        strategy: scenario.refine.strategy,
        memory: options.memory,
        progress: Progress::new(options.quiet),
    };
    let report = simulate(&problem, &plan, &mut |step| results.step(step))?;
    if scenario.output.report {
        plot_curves(&options.folder(scenario), scenario.element, &[("this run", &report)])?;
    }
    results.finish(&report)?;
    if let Some(path) = &options.json {
        write_json(path, &report)?;
    }
    if !options.quiet {
        let folder = options.folder(scenario);
        let reactions = report.steps.last().map(table::reactions).unwrap_or_default();
        let (units, steps) = (table::units(&report.units), table::steps(&report.steps));
        let text = format!("{units}{steps}\n{reactions}{}", quantity_tables(&report));
        let ending = ending(scenario, plan.strategy, &report);
        print(&format!("{text}\n{}{ending}\nresults in {}\n", warnings("", &report), folder.display()))?;
    }
    match failure(scenario, plan.strategy, &report) {
        Some(error) => Err(error),
        None => Ok(report),
    }
}

/// The warning of a run that refines a mesh with curved edges.
const STRAIGHTENED: &str = "refined meshes have straight edges: from step 1 on the body is another than at step 0, energies do \
                            not compare, and stresses at curved surfaces get worse; start from a finer mesh, with \
                            refine.strategy = \"none\"";

/// Reads the mesh, resolves the scenario on it and checks that the supports hold it, before anything is written.
pub(super) fn prepare(scenario: &Scenario, options: &RunOptions) -> Result<Resolved, Error> {
    let file = load(scenario)?;
    let problem = resolve_curved(scenario, file.mesh, file.midsides);
    let mut problem = problem.map_err(|e| e.with_inner(&file.inner_groups))?;
    if !problem.midsides.is_empty() && scenario.refine.strategy != Strategy::None && scenario.refine.steps > 0 {
        problem.warnings.push(STRAIGHTENED.to_owned());
    }
    check_supports(scenario, &problem)?;
    if !options.quiet {
        let remarks = file.notes.iter().map(|n| wrapped(&format!("note: {n}")));
        let warnings = scenario.warnings.iter().chain(&problem.warnings).map(|w| wrapped(&format!("warning: {w}")));
        print(&format!("{}\n{}", scenario.title, remarks.chain(warnings).collect::<String>()))?;
    }
    Ok(problem)
}

/// The tables of true errors, of quantities and of what was expected of them.
pub(super) fn quantity_tables(report: &Report) -> String {
    let tables = [table::true_errors(&report.steps), table::quantities(&report.steps), table::expectations(report)];
    tables.into_iter().filter(|t| !t.is_empty()).map(|t| format!("\n{t}")).collect()
}

/// The error to end with after everything is written: an expectation that failed, or a tolerance that was not reached.
pub(super) fn failure(scenario: &Scenario, strategy: Strategy, report: &Report) -> Option<Error> {
    failed_expectations(report).or_else(|| tolerance::missed(scenario, strategy, report))
}

/// The warnings of a run; `run` names it where there are several.
pub(super) fn warnings(run: &str, report: &Report) -> String {
    report.warnings.iter().map(|w| wrapped(&format!("warning: {run}{w}"))).collect()
}

/// Plots the relative error against dofs and against seconds.
pub(super) fn plot_curves(folder: &Path, element: Element, runs: &[(&str, &Report)]) -> Result<(), Error> {
    let degree = match element {
        Element::Tet4 => 1,
        Element::Tet10 => 2,
    };
    let curve = |(name, report): &(&str, &Report), axis: Axis| {
        let mut spent = 0.0;
        let points = report.steps.iter().map(|s| {
            spent += s.seconds.computing();
            (if axis == Axis::Dofs(degree) { s.free_dofs as f64 } else { spent }, s.error.relative)
        });
        ((*name).to_owned(), points.collect())
    };
    for (axis, file) in [(Axis::Dofs(degree), "error_dofs.svg"), (Axis::Seconds, "error_seconds.svg")] {
        let curves: Vec<(String, Vec<(f64, f64)>)> = runs.iter().map(|run| curve(run, axis)).collect();
        error_curves(&folder.join(file), axis, &curves)?;
    }
    Ok(())
}
