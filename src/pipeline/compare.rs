//! `subsolid compare`: the same scenario refined globally and adaptively, and what adaptivity saved.

use super::doubts::ending;
use super::leftovers;
use super::results::{Results, write_text};
use super::run::{failure, plot_curves, prepare, quantity_tables, warnings};
use super::simulate::{Plan, simulate};
use super::{RunOptions, print, resolve::Resolved};
use crate::error::Error;
use crate::output::atomic::ensure_writable_dir;
use crate::output::compare::{Comparison, ratios};
use crate::output::progress::Progress;
use crate::output::report::{PhaseSeconds, Report, write_json};
use crate::output::table;
use crate::scenario::{Scenario, Strategy};
use crate::subdiv::options::Scheme;

/// A pass over both strategies that takes longer than this is not repeated.
const SHORT_SECONDS: f64 = 10.0;

/// Below this mean of a step's computing seconds, three passes are not enough against the noise of the clock.
const VERY_SHORT_STEP: f64 = 0.05;

/// Passes over runs of such steps.
const MANY_PASSES: usize = 9;

/// What is said where a comparison shows little.
const NOTHING_REFINED: &str = "warning: the scenario refines nothing (refine.strategy = \"none\", or steps = 0 or absent); \
                               compare sets the strategies itself and takes refine.steps: try --set refine.steps=3\n";

/// Runs a scenario globally and adaptively from the same input mesh under the same stop rules, and writes both results
/// and the comparison. Where the whole is short, the phases are medians over `repeat` passes, or over nine if
/// steps are very short and `repeat` is not 1.
///
/// # Errors
/// [`Error`] with its exit code, as [`super::run::run`]; the tolerance and what is expected is asked of the adaptive run.
pub fn compare(scenario: &Scenario, options: &RunOptions, repeat: usize) -> Result<(), Error> {
    if scenario.refine.options.scheme == Scheme::Red {
        return Err(Error::NothingToCompare);
    }
    let problem = prepare(scenario, options)?;
    if !options.quiet && (scenario.refine.strategy == Strategy::None || scenario.refine.steps == 0) {
        print(NOTHING_REFINED)?;
    }
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_comparison(&folder, scenario)?;
    let mut global = first_pass(scenario, options, &problem, Strategy::Global, "global")?;
    let mut adaptive = first_pass(scenario, options, &problem, Strategy::Adaptive, "adaptive")?;
    if global.seconds_total + adaptive.seconds_total < SHORT_SECONDS {
        for (report, strategy) in [(&mut global, Strategy::Global), (&mut adaptive, Strategy::Adaptive)] {
            let count = pass_count(report, repeat);
            take_medians(report, &passes(scenario, options, &problem, strategy, count)?);
        }
    }
    let ratios = ratios(&global, &adaptive);
    let text =
        table::units(&scenario.units) + &table::comparison(&global, &adaptive, &ratios, scenario.published.as_ref());
    let comparison = Comparison { global: &global, adaptive: &adaptive, ratios: &ratios };
    write_json(&folder.join("compare.json"), &comparison)?;
    write_text(&folder.join("compare.txt"), &text)?;
    plot_curves(&folder, scenario.element, &[("global", &global), ("adaptive", &adaptive)])?;
    if let Some(path) = &options.json {
        write_json(path, &comparison)?;
    }
    if !options.quiet {
        let mut doubts = warnings("global, ", &global) + &warnings("adaptive, ", &adaptive);
        for (name, strategy, report) in
            [("global", Strategy::Global, &global), ("adaptive", Strategy::Adaptive, &adaptive)]
        {
            doubts += &format!("{name}: {}\n{}", ending(scenario, strategy, report), quantity_tables(report));
        }
        print(&format!("{text}\n{doubts}results in {}\n", folder.display()))?;
    }
    failure(scenario, Strategy::Adaptive, &adaptive).map_or(Ok(()), Err)
}

/// The pass whose results are written, into a folder of the strategy's name.
fn first_pass(
    scenario: &Scenario,
    options: &RunOptions,
    problem: &Resolved,
    strategy: Strategy,
    name: &str,
) -> Result<Report, Error> {
    let mut results = Results::begin(options.folder(scenario).join(name), scenario, problem, strategy)?;
    let report = simulate(problem, &plan(scenario, options, strategy), &mut |step| results.step(step))?;
    results.finish(&report)?;
    Ok(report)
}

/// How often a run is made, from its first pass.
fn pass_count(first: &Report, asked: usize) -> usize {
    let spent: f64 = first.steps.iter().map(|s| s.seconds.computing()).sum();
    let very_short = spent < VERY_SHORT_STEP * first.steps.len() as f64;
    if asked > 1 && very_short { asked.max(MANY_PASSES) } else { asked }
}

/// The other passes, which only take the time.
fn passes(
    scenario: &Scenario,
    options: &RunOptions,
    problem: &Resolved,
    strategy: Strategy,
    repeat: usize,
) -> Result<Vec<Report>, Error> {
    (1..repeat).map(|_| simulate(problem, &plan(scenario, options, strategy), &mut |_| Ok(()))).collect()
}

fn plan<'a>(scenario: &'a Scenario, options: &RunOptions, strategy: Strategy) -> Plan<'a> {
    Plan { scenario, strategy, memory: options.memory, progress: Progress::new(options.quiet) }
}

/// Replaces the seconds of each phase that computes by the median over the report and the further passes.
fn take_medians(report: &mut Report, others: &[Report]) {
    let phases: [fn(&mut PhaseSeconds) -> &mut f64; 5] =
        [|s| &mut s.refine, |s| &mut s.assemble, |s| &mut s.solve, |s| &mut s.estimate, |s| &mut s.mark];
    for (i, step) in report.steps.iter_mut().enumerate() {
        for phase in phases {
            let mut values: Vec<f64> =
                others.iter().filter_map(|o| o.steps.get(i)).map(|s| *phase(&mut s.seconds.clone())).collect();
            values.push(*phase(&mut step.seconds));
            values.sort_by(f64::total_cmp);
            *phase(&mut step.seconds) = values[values.len() / 2];
        }
        let s = &mut step.seconds;
        s.total = s.computing() + s.write;
    }
}
