//! The error of four-node cells where they do not show the solution at all, by a solution with ten-node cells on the same mesh.
//!
//! As those of four nodes are among their displacements, the error is the difference of both and that of the ten-node cells,
//! which are orthogonal (where what supports prescribe is linear): the squared error of a cell is `a(u10 - u4, u10 - u4)` on it, and
//! what is estimated of u10.

use super::analyse::{Analysed, solved};
use super::quantities;
use super::resolve::Resolved;
use super::simulate::{Plan, timed};
use crate::error::Error;
use crate::fem::options::Element;
use crate::fem::{Space, Stress};
use crate::output::report::PhaseSeconds;

/// Most cells that are solved with ten nodes too, which takes six times the memory. Of more the error stays unknown.
const MOST: usize = 50_000;

/// What ten-node cells say of a solution.
pub(super) struct Richer {
    /// Value of the quantity aimed at; NaN if there is none.
    goal: f64,
    /// Their squared error over that of four-node cells.
    rest: f64,
}

impl Richer {
    /// What the error of the quantity aimed at may be beyond that of the value `found`: the difference, and the share of it that
    /// ten-node cells miss themselves, twice as goals are.
    pub(super) fn beyond(&self, found: f64) -> f64 {
        (self.goal - found).abs() * (1.0 + 2.0 * self.rest)
    }
}

/// Solves with ten-node cells, and takes the errors of cells from there where they are larger; if there are too many cells,
/// or no such solution, nothing, and errors that are not known.
///
/// # Errors
/// As those of the analysis itself, but for the solver's.
pub(super) fn compare(
    analysed: &mut Analysed<'_>,
    name: &str,
    problem: &Resolved,
    plan: &Plan<'_>,
    seconds: &mut PhaseSeconds,
) -> Result<Option<Richer>, Error> {
    let mesh = analysed.space.mesh();
    let richer = if mesh.tets().len() > MOST {
        None
    } else {
        let space = Space::new(mesh, Element::Tet10, &[]);
        // That it cannot be solved is no reason to end the run: thin cells are harder with ten nodes.
        match solved((space, None), &format!("{name}, ten-node cells"), problem, plan, None, seconds) {
            Ok((richer, ..)) => Some(richer),
            Err(Error::Fem(_)) => None,
            Err(other) => return Err(other),
        }
    };
    let Some(richer) = richer else {
        let errors = &mut analysed.errors;
        errors.unestimated.extend(&errors.unresolved);
        errors.unestimated.sort_unstable();
        errors.unestimated.dedup();
        return Ok(None);
    };
    Ok(Some(timed(&mut seconds.estimate, || {
        let (fine, coarse) = (&richer.solution.displacement, &analysed.solution.displacement);
        let between = richer.space.midside().iter().map(|e| e.map(|v| coarse[v as usize])).map(|[p, q]| p.midpoint(q));
        let difference: Vec<_> = fine.iter().zip(coarse.iter().copied().chain(between)).map(|(u, v)| *u - v).collect();
        let stress = Stress::of(&richer.space, &problem.model, &difference);
        let energies = stress.energies(&richer.space, &problem.model, &difference);
        let missed: f64 = richer.errors.squared.iter().sum();
        let found = energies.iter().zip(&richer.errors.squared).map(|(energy, rest)| 2.0 * energy + rest);
        analysed.errors.squared.iter_mut().zip(found).for_each(|(squared, found)| *squared = squared.max(found));
        let goal = problem.goal.map_or(f64::NAN, |goal| quantities::value(problem, &richer, goal));
        Richer { goal, rest: missed / (missed + 2.0 * energies.iter().sum::<f64>()) }
    })))
}
