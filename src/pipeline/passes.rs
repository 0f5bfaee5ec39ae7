//! Runs that are compared: each once with its results, and short ones again for the sake of their times.

use super::doubts::ending;
use super::results::Results;
use super::simulate::{Plan, simulate};
use super::{RunOptions, interrupt, resolve::Resolved};
use crate::error::Error;
use crate::output::page::Steps;
use crate::output::progress::Progress;
use crate::output::report::{PhaseSeconds, Report, StopReason};
use crate::scenario::{Scenario, Strategy};

/// A pass over all runs that takes longer than this is not repeated.
const SHORT_SECONDS: f64 = 10.0;

/// Below this mean of a step's computing seconds, three passes are not enough against the noise of the clock.
const VERY_SHORT_STEP: f64 = 0.05;

/// Passes over runs of such steps.
const MANY_PASSES: usize = 9;

/// A run that is compared with others.
pub(super) struct Contestant<'a> {
    /// Names its folder.
    pub name: &'a str,
    pub scenario: &'a Scenario,
    pub problem: &'a Resolved,
    pub strategy: Strategy,
}

/// Makes the runs, each into a folder of its name in `options.folder(of)`. Where all are short, the seconds of the phases
/// are medians over `repeat` passes, or over nine if steps are very short and `repeat` is not 1. With each report goes what a
/// page shows of the run.
///
/// # Errors
/// As [`super::run::run`].
pub(super) fn reports(
    of: &Scenario,
    runs: &[Contestant<'_>],
    options: &RunOptions,
    repeat: usize,
) -> Result<Vec<(Report, Option<Steps>)>, Error> {
    let folder = options.folder(of);
    let first = |run: &Contestant<'_>| {
        let mut results = Results::begin(folder.join(run.name), run.scenario, run.problem, run.strategy)?;
        let report = simulate(run.problem, &run.plan(options), &mut |step| results.write(step))?;
        let steps = results.finish(&report)?;
        match report.stop_reason {
            StopReason::Interrupted => Err(interrupted(run, &report)),
            _ => Ok((report, steps)),
        }
    };
    let mut reports = runs.iter().map(first).collect::<Result<Vec<_>, Error>>()?;
    if !interrupt::is_asked() && reports.iter().map(|(r, _)| r.seconds_total).sum::<f64>() < SHORT_SECONDS {
        for (run, (report, _)) in runs.iter().zip(&mut reports) {
            let again = |_| simulate(run.problem, &run.plan(options), &mut |_| Ok(()));
            let others = (1..pass_count(report, repeat)).map(again).collect::<Result<Vec<Report>, Error>>()?;
            take_medians(report, &others);
        }
    }
    Ok(reports)
}

/// The error of a comparison that the user ended.
fn interrupted(run: &Contestant<'_>, report: &Report) -> Error {
    Error::Interrupted { ending: format!("{}: {}", run.name, ending(run.scenario, run.strategy, report)) }
}

impl Contestant<'_> {
    fn plan(&self, options: &RunOptions) -> Plan<'_> {
        let progress = Progress::new(options.quiet);
        Plan { scenario: self.scenario, strategy: self.strategy, memory: options.memory, progress }
    }
}

/// How often a run is made, from its first pass.
fn pass_count(first: &Report, asked: usize) -> usize {
    let spent: f64 = first.steps.iter().map(|s| s.seconds.computing()).sum();
    let very_short = spent < VERY_SHORT_STEP * first.steps.len() as f64;
    if asked > 1 && very_short { asked.max(MANY_PASSES) } else { asked }
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
