//! The error of functions of control points, by a solution with all nodes of the subdivided mesh.
//!
//! Stresses of smooth functions hardly jump between cells, so that recovery does not see what these functions miss. But they are
//! combinations of the nodes' functions, so that the error is the difference of both solutions and the error of the
//! nodes', which are orthogonal (where what supports prescribe is linear): the squared error of a cell is `a(un - uc, un - uc)` on it, and what
//! is estimated of un.

use super::analyse::Analysed;
use super::resolve::Resolved;
use super::simulate::{Plan, timed};
use crate::adapt;
use crate::error::Error;
use crate::fem::options::SolverOptions;
use crate::fem::{self, Data, Stress, System};
use crate::output::report::PhaseSeconds;

/// Residual that the nodes' solution needs: the estimate has one or two digits.
const TOLERANCE: f64 = 1e-5;

/// Solves the nodes' system from the solution of the control points, and takes the errors of the cells from there.
///
/// # Errors
/// Those of the solver.
pub(super) fn compare(
    analysed: &mut Analysed<'_>,
    system: &System,
    problem: &Resolved,
    plan: &Plan<'_>,
    seconds: &mut PhaseSeconds,
) -> Result<(), Error> {
    let options = &plan.scenario.solver;
    let options = SolverOptions { tolerance: options.tolerance.max(TOLERANCE), ..*options };
    let own = &analysed.solution.displacement;
    let nodes = timed(&mut seconds.solve, || fem::solve(system, &options, Some(own)))?.displacement;
    timed(&mut seconds.estimate, || {
        let (space, model) = (&analysed.space, &problem.model);
        let data = Data::new(space, model, problem.exact.as_ref());
        let stress = Stress::of(space, model, &nodes);
        let found = adapt::estimate_solved(&data, &nodes, &stress, plan.scenario.adapt.estimator);
        let difference: Vec<_> = nodes.iter().zip(own).map(|(u, v)| *u - v).collect();
        let energies = Stress::of(space, model, &difference).energies(space, model, &difference);
        let errors = &mut analysed.errors;
        errors.squared = energies.iter().zip(&found.squared).map(|(energy, rest)| 2.0 * energy + rest).collect();
        (errors.unseen, errors.raised, errors.unresolved) = (found.unseen, found.raised, found.unresolved);
    });
    Ok(())
}
