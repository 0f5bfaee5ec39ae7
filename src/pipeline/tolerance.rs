//! The errors that a scenario asks for: whether they are reached, and what to say if they are not.

use super::doubts::ending;
use crate::error::Error;
use crate::output::report::{Report, StopReason};
use crate::output::table::{percent, short};
use crate::scenario::{Scenario, Stop, Strategy, Tolerance};

/// The quantity aimed at, as a step has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub value: f64,
    pub bar: f64,
    /// What its value is at most, by Cauchy and Schwarz: the energy norm of the solution times that of the dual solution.
    pub scale: f64,
}

/// Share of the error asked for, as a fraction of its scale, below which the bar of a quantity that is zero within it says that
/// it is zero: it is a thousandth of its scale where 1 % is asked for.
const ZERO: f64 = 0.1;

/// Whether the quantity aimed at is zero as far as anyone may want to know, while a fraction of it is asked for: refinement would
/// never end.
pub(super) fn is_zero(stop: &Stop, goal: Aim) -> bool {
    let Some(Tolerance::Relative(asked)) = stop.quantity_error else { return false };
    goal.value.abs() <= goal.bar && goal.bar <= ZERO * asked * goal.scale
}

/// The stop rule that is met if all errors asked for are reached; `goal` is the quantity aimed at.
pub(super) fn reached(stop: &Stop, relative: f64, goal: Option<Aim>) -> Option<StopReason> {
    let energy = stop.relative_error.map(|asked| relative <= asked);
    let quantity = stop.quantity_error.zip(goal).map(|(asked, goal)| goal.bar <= asked.distance(goal.value));
    match (energy, quantity) {
        (Some(true), None) => Some(StopReason::RelativeError),
        (None | Some(true), Some(true)) => Some(StopReason::Quantity),
        _ => None,
    }
}

/// The error to end with if the scenario asks for an error and the run ended without it.
pub(super) fn missed(scenario: &Scenario, strategy: Strategy, report: &Report) -> Option<Error> {
    if matches!(report.stop_reason, StopReason::RelativeError | StopReason::Quantity) {
        return None;
    }
    let last = report.steps.last()?;
    let mut sentences = Vec::new();
    if let Some(asked) = scenario.refine.stop.relative_error
        && (last.error.relative > asked || last.error.relative.is_nan())
    {
        let reached = match last.error.relative {
            r if r.is_nan() => "the relative error cannot be estimated".to_owned(),
            r => format!("the estimated relative error is {} %", percent(r)),
        };
        sentences.push(format!("{reached}, {} % was asked for", percent(asked)));
    }
    sentences.extend(missed_quantity(scenario, report));
    if sentences.is_empty() {
        return None;
    }
    let reached = sentences.join("; ");
    let (ending, help) = (ending(scenario, strategy, report), help(strategy, report.stop_reason));
    Some(Error::ToleranceNotReached { reached, ending, help })
}

/// What is said of a quantity whose error bar is too large.
fn missed_quantity(scenario: &Scenario, report: &Report) -> Option<String> {
    let (asked, name) = (scenario.refine.stop.quantity_error?, scenario.adapt.goal.as_ref()?);
    let (_, found) = report.steps.last()?.quantities.iter().find(|(quantity, _)| quantity == name)?;
    let bar = found.error.unwrap_or(f64::NAN);
    if bar <= asked.distance(found.value) {
        return None;
    }
    if bar.is_nan() {
        return Some(format!("the error of {name} cannot be estimated"));
    }
    let asked = match asked {
        Tolerance::Relative(fraction) if found.value.abs() <= bar => {
            return Some(format!(
                "{name} is {} +- {}: zero within its error bar, of which {} % cannot be reached; if it is zero, ask for \
                 refine.stop.quantity_error = {{ absolute = ... }}",
                short(found.value, 3),
                short(bar, 3),
                percent(fraction)
            ));
        }
        Tolerance::Relative(fraction) => format!("{} % was", percent(fraction)),
        Tolerance::Absolute(distance) => format!("{} was", short(distance, 3)),
    };
    let share = percent(bar / found.value.abs());
    Some(format!("{name} is {} +- {} ({share} %), {asked} asked for", short(found.value, 6), short(bar, 3)))
}

/// What to do after a run that ended for this reason.
fn help(strategy: Strategy, reason: StopReason) -> &'static str {
    match reason {
        StopReason::Steps if strategy == Strategy::None => "let refine.strategy be \"adaptive\"",
        StopReason::Steps => "allow more: refine.steps",
        StopReason::MaxCells => "allow more: refine.stop.max_cells",
        StopReason::MaxMemory => "allow more: refine.stop.max_memory",
        StopReason::Seconds => "allow more: refine.stop.seconds",
        StopReason::Exact => "nothing is left to refine for: ask for more than rounding, or lower solver.tolerance",
        StopReason::StraightEdges => {
            "start from a finer mesh with curved edges, with refine.strategy = \"none\"; or ask for less"
        }
        StopReason::Zero => "ask for refine.stop.quantity_error = { absolute = ... }, in the units of the quantity",
        StopReason::RelativeError | StopReason::Quantity | StopReason::Interrupted => "run it again",
    }
}
