//! What straight edges make of a body with curved ones, which refinement keeps no longer.
//!
//! The mesh that was read is solved a second time, with straight edges. What changes is the body's: errors of the elements nearly
//! cancel, as the cells are the same. From step 1 on the change of the quantity aimed at is part of its error bar; and the error
//! in the energy norm, the root of twice the error of the strain energy, has that of its change.

use super::analyse::{Analysed, solved};
use super::quantities;
use super::resolve::Resolved;
use super::simulate::Plan;
use crate::error::Error;
use crate::fem::Space;
use crate::output::report::PhaseSeconds;
use crate::scenario::{Stop, Strategy};
use serde::{Deserialize, Serialize};

/// Share of the change that may be missed of it on a coarse mesh, which is added.
const MISSED: f64 = 0.5;

/// The errors that straight edges make.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Straight {
    /// Squared error in the energy norm.
    pub squared: f64,
    /// Error of the quantity aimed at; zero without one.
    pub goal: f64,
}

/// The errors that refinement will make by straight edges; nothing where it makes none.
///
/// # Errors
/// As those of the analysis itself.
pub(super) fn compare(
    analysed: &Analysed<'_>,
    problem: &Resolved,
    plan: &Plan<'_>,
    seconds: &mut PhaseSeconds,
) -> Result<Option<Straight>, Error> {
    let refines = plan.strategy != Strategy::None && plan.scenario.refine.steps > 0;
    if problem.midsides.is_empty() || !refines {
        return Ok(None);
    }
    let space = Space::new(analysed.space.mesh(), plan.scenario.element, &[]);
    let (straight, ..) = solved((space, None), "step 0, straight edges", problem, plan, None, seconds)?;
    let changed = |a: f64, b: f64| (1.0 + MISSED) * (a - b).abs();
    // Without their corrections: the recovery of stresses that turn is worse than they are.
    let computed = |on: &Analysed<'_>| problem.goal.map_or(0.0, |goal| quantities::value(problem, on, goal));
    let goal = changed(computed(analysed), computed(&straight));
    let squared = 2.0 * changed(analysed.solution.strain_energy, straight.solution.strain_energy);
    Ok(Some(Straight { squared, goal }))
}

impl Straight {
    /// Whether it alone exceeds an error that is asked for, so that no refinement of `analysed` will reach it.
    pub(super) fn exceeds(&self, stop: &Stop, analysed: &Analysed<'_>, problem: &Resolved) -> bool {
        let relative = (self.squared / (2.0 * analysed.solution.strain_energy + self.squared)).sqrt();
        let value = analysed.aim(problem).map(|aim| aim.value);
        stop.relative_error.is_some_and(|asked| relative > asked)
            || stop.quantity_error.zip(value).is_some_and(|(asked, value)| self.goal > asked.distance(value))
    }
}
