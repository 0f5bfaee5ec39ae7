//! What a user should doubt about a step, and why a run ended.

use super::simulate::Step;
use crate::output::report::{Report, StepRecord, StopReason};
use crate::output::table::{count, percent, short};
use crate::scenario::{Scenario, Strategy};
use glam::DVec3;

/// Displacement over the model's size from which small strains are in doubt.
const LARGE_DISPLACEMENT: f64 = 0.1;

/// Error bar of a quantity over its value from which it is in doubt itself.
const COARSE: f64 = 0.5;

/// By how much an estimate is raised above what recovery finds from which it is worth a word.
const RAISED: f64 = 1.2;

/// The warning of a run that ends because there is nothing to refine, though there is an error.
pub(super) const NOTHING_MARKED: &str =
    "marking selected no cell, so the run ends here: `adapt.marking` asks for a larger error than any cell has";

/// Warnings about a step; `before` is the record of the step before.
pub(super) fn about(step: &Step<'_>, before: Option<&StepRecord>, record: &StepRecord) -> Vec<String> {
    let index = step.index;
    let errors = &step.analysed.errors;
    // Of those that are not resolved something else is said.
    let lock = |t: &u32| errors.unresolved.binary_search(t).is_ok();
    let isolated = errors.unestimated.iter().filter(|t| !lock(t)).count();
    let isolated = (isolated > 0).then(|| {
        format!(
            "step {index}: the error of {} cannot be estimated: isolated, they share no vertex with another cell of \
             their region",
            cells(isolated)
        )
    });
    let locking = locking(step);
    let info = &step.analysed.solution.info;
    let rounding = info.reason.contains("limit of double precision").then(|| {
        format!("step {index}: the solver's residual {:.1e} is at the limit of double precision", info.residual)
    });
    // Of the same body only: straight edges add their own error.
    let same = before.filter(|before| before.error.straight_edges == record.error.straight_edges);
    let grew = same.and_then(|before| growth(index, before.error.relative, record.error.relative));
    let diagonal = step.mesh.diagonal();
    let largest = step.analysed.solution.displacement.iter().copied().map(DVec3::length).fold(0.0, f64::max);
    // A known solution is one of the linear theory, whatever its size.
    let known = record.error.true_energy.is_some();
    let large = (index == 0 && !known && largest > LARGE_DISPLACEMENT * diagonal).then(|| {
        format!(
            "the largest displacement is {} % of the model's diagonal: check units and loads; the theory holds for \
             small strains and rotations",
            percent(largest / diagonal)
        )
    });
    let coarse =
        step.analysed.goal.as_ref().zip(goal_of(record)).filter(|(goal, value)| goal.bar > COARSE * value.abs());
    let coarse = coarse.map(|(goal, value)| {
        format!(
            "step {index}: the error bar {} of the quantity aimed at is no small part of its value {}: such meshes are too \
             coarse for the bar to be trusted",
            short(goal.bar, 3),
            short(value, 6)
        )
    });
    let idle = index == 0 && step.idle;
    let idle = idle.then(|| {
        "nothing is strained, though there are loads: they are zero at all points that the mesh looks at; check their \
         expressions, or use a finer mesh where they act"
            .to_owned()
    });
    [isolated, rounding, grew, large, coarse, idle].into_iter().flatten().chain(locking).collect()
}

/// What is said of four-node cells that lock.
fn locking(step: &Step<'_>) -> Vec<String> {
    let (errors, mesh) = (&step.analysed.errors, step.mesh);
    let (index, unresolved) = (step.index, errors.unresolved.len());
    let bar = step.analysed.goal.as_ref().is_some_and(|goal| goal.bar.is_nan());
    let how = if bar || step.analysed.relative_error().is_nan() {
        "their error is not known"
    } else {
        "the estimated error is that of ten-node cells on the same mesh"
    };
    let dual = step.analysed.dual.unresolved;
    let thin = (unresolved > 0 || dual).then(|| {
        let (who, what) = if unresolved > 0 {
            (cells(unresolved), "the solution")
        } else {
            ("cells".to_owned(), "what the quantity aimed at depends on")
        };
        format!(
            "step {index}: {who} of four nodes do not show {what}, as they lock or are far too coarse: the body is much too \
             stiff; {how}. Use analysis.element = \"tet10\", or more cells through the thickness"
        )
    });
    let region = |(name, factor): (&String, &f64)| {
        (*factor > RAISED).then(|| {
            format!(
                "step {index}: four-node cells of region `{name}` lock, as its Poisson's ratio is near 1/2: their estimated \
                 error, {}-fold what the stresses say, is a rough bound. Use analysis.element = \"tet10\"",
                short(*factor, 2)
            )
        })
    };
    thin.into_iter().chain(mesh.region_names().iter().zip(&errors.raised).filter_map(region)).collect()
}

/// The value of the quantity that has an error bar.
fn goal_of(record: &StepRecord) -> Option<f64> {
    record.quantities.iter().find(|(_, q)| q.error.is_some()).map(|(_, q)| q.value)
}

/// The warning of an estimate that did not fall.
fn growth(index: usize, before: f64, now: f64) -> Option<String> {
    (now >= before && now > 0.0).then(|| {
        format!(
            "step {index}: the estimated relative error grew from {} to {} %: it is not reliable yet, the meshes are too \
             coarse",
            percent(before),
            percent(now)
        )
    })
}

/// Why a run ended, in a sentence without full stop.
pub(super) fn ending(scenario: &Scenario, strategy: Strategy, report: &Report) -> String {
    let Some(last) = report.steps.last() else { return "nothing was solved".to_owned() };
    let stop = &scenario.refine.stop;
    let asked = |rule: &str, value: Option<String>| format!("{rule} = {} reached", value.unwrap_or_default());
    let why = match report.stop_reason {
        StopReason::Steps if report.warnings.iter().any(|w| w == NOTHING_MARKED) => {
            "marking selected no cell".to_owned()
        }
        StopReason::Steps if strategy == Strategy::None => "refine.strategy = \"none\"".to_owned(),
        StopReason::Steps => asked("steps", Some(scenario.refine.steps.to_string())),
        StopReason::RelativeError => format!(
            "relative error {} %, {} % asked for",
            percent(last.error.relative),
            percent(stop.relative_error.unwrap_or_default())
        ),
        StopReason::Quantity => {
            let goal = scenario.adapt.goal.as_deref().unwrap_or_default();
            let found = last.quantities.iter().find(|(name, _)| name == goal).map(|(_, q)| *q);
            let (value, bar) = found.map_or((f64::NAN, f64::NAN), |q| (q.value, q.error.unwrap_or(f64::NAN)));
            format!("{goal} is {} +- {}, exact enough", short(value, 6), short(bar, 3))
        }
        StopReason::MaxCells => asked("max_cells", stop.max_cells.map(|n| n.to_string())),
        StopReason::MaxMemory => match stop.max_memory {
            Some(most) => format!("the next step would need more than max_memory = {most} bytes"),
            None => "the next step would need more memory than is free".to_owned(),
        },
        StopReason::Seconds => asked("seconds", stop.seconds.map(|s| s.to_string())),
        StopReason::Exact => "the estimated error is rounding".to_owned(),
        StopReason::StraightEdges => {
            "refined meshes have straight edges, which alone exceed the error asked for".to_owned()
        }
        StopReason::Zero => "the quantity aimed at is zero within its error bar".to_owned(),
        StopReason::Interrupted => "interrupted".to_owned(),
    };
    format!("stopped after step {}: {}, {why}", last.step, cells(last.mesh.cells))
}

fn cells(n: usize) -> String {
    format!("{} cell{}", count(n), if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn class_59_an_estimate_that_does_not_fall_is_doubted() {
        assert!(growth(2, 0.3, 0.31).unwrap().contains("grew from 30.0 to 31.0 %"));
        assert!(growth(1, 0.3, 0.3).is_some());
        for (before, now) in [(0.3, 0.29), (0.0, 0.0), (f64::NAN, 0.3), (0.3, f64::NAN)] {
            assert_eq!(growth(1, before, now), None);
        }
    }
}
