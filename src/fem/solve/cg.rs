//! Conjugate gradients, preconditioned by multigrid.

use super::amg::{Hierarchy, Real};
use super::{Kept, Problem, Solved, SolverInfo, at_the_limit, not_converged, residual};
use crate::fem::FemError;
use crate::fem::block_matrix::{CHUNK, dot, norm};
use glam::DVec3;
use rayon::prelude::*;

/// Iterations before giving up for good: hundreds of times what well-shaped meshes need.
pub(super) const MAX_ITERATIONS: usize = 20_000;

/// Iterations after which the single precision of the preconditioner is doubted.
const FEW_ITERATIONS: usize = 100;

/// Restarts from the true residual, when it is larger than the one that the recurrence carries along.
const MAX_RESTARTS: usize = 3;

/// What to do where the iterations do not suffice.
const HELP: &str = "use method \"direct\"; else check the supports, nearly flat cells and Poisson's ratio near 1/2, or \
                    accept a larger tolerance";

/// Solves from a guess or from zero (Hestenes and Stiefel 1952), until the true residual is below the tolerance, in at most
/// `limit` iterations. The preconditioner is kept in single precision, and made anew in double where that fails.
///
/// # Errors
/// [`FemError::NotConverged`], [`FemError::NotPositiveDefinite`]; those of the coarsest problem's factorisation.
pub(super) fn solve(
    problem: &Problem,
    guess: Option<&[DVec3]>,
    reason: String,
    limit: usize,
    kept: &mut Kept,
) -> Result<Solved, FemError> {
    let (displacement, remainder) = problem.start(guess);
    let mut state = State { displacement, remainder, iterations: 0, numbers: 0, relative: 1.0 };
    state.relative = norm(&state.remainder) / problem.scale;
    let found = |state: State, reason| {
        let State { displacement, iterations, relative, numbers, .. } = state;
        let info = SolverInfo { method: "amg-cg", reason, iterations, residual: relative, nonzeros: numbers };
        Ok(Solved { displacement, info })
    };
    match state.advance(problem, limit.min(FEW_ITERATIONS), &mut kept.hierarchy) {
        Ok(()) | Err(FemError::NotPositiveDefinite { .. }) => {}
        Err(error) => return Err(error),
    }
    let mut reason = reason;
    if !problem.accepts(state.relative) && !problem.is_rounding(state.relative, &state.displacement) {
        reason += &format!("; preconditioner in double precision after {} iterations", state.iterations);
        state.advance::<f64>(problem, limit, &mut None)?;
    }
    if problem.accepts(state.relative) {
        return found(state, reason);
    }
    if problem.is_rounding(state.relative, &state.displacement) {
        let reason = at_the_limit(&reason, state.relative);
        return found(state, reason);
    }
    Err(not_converged(problem, "conjugate gradients", state.iterations, state.relative, HELP))
}

/// How far the solution is.
struct State {
    displacement: Vec<DVec3>,
    /// `f - K u` at the unknowns.
    remainder: Vec<DVec3>,
    /// Its norm, relative to that of the right-hand side.
    relative: f64,
    iterations: usize,
    /// Numbers stored in the preconditioner.
    numbers: usize,
}

impl State {
    /// Iterates until the true residual is accepted, restarts are used up, or `limit` iterations are done in all.
    /// The preconditioner is the one that is kept, or made to be kept.
    fn advance<T: Real>(
        &mut self,
        problem: &Problem,
        limit: usize,
        kept: &mut Option<Hierarchy<T>>,
    ) -> Result<(), FemError> {
        if problem.accepts(self.relative) {
            return Ok(());
        }
        let system = problem.system;
        let mask = system.numbering.mask();
        let hierarchy = match kept {
            Some(hierarchy) => hierarchy,
            None => kept.insert(Hierarchy::new(&system.stiffness, system.linear.as_ref(), &system.points, mask)?),
        };
        self.numbers = hierarchy.numbers();
        for _ in 0..=MAX_RESTARTS {
            let rest = std::mem::take(&mut self.remainder);
            let done = iterate(problem, hierarchy, rest, &mut self.displacement, limit - self.iterations);
            self.remainder = residual(system, &self.displacement);
            self.relative = norm(&self.remainder) / problem.scale;
            self.iterations += done?;
            if problem.accepts(self.relative) || self.iterations >= limit {
                break;
            }
        }
        Ok(())
    }
}

/// Adds the solution of `K d = r` to `u`, `K` and `r` restricted to the unknowns; returns the number of iterations. It
/// ends when the residual of the recurrence is below the tolerance, or at the limit.
fn iterate<T: Real>(
    problem: &Problem,
    preconditioner: &mut Hierarchy<T>,
    mut r: Vec<DVec3>,
    u: &mut [DVec3],
    limit: usize,
) -> Result<usize, FemError> {
    // The recurrence drifts from the true residual by some rounding: aim a little lower.
    let goal = (0.9 * problem.tolerance * problem.scale).powi(2);
    let mut z = vec![DVec3::ZERO; r.len()];
    let mut kp = z.clone();
    preconditioner.apply(&r, norm(&r), &mut z)?;
    let mut p = z.clone();
    let mut rho = dot(&r, &z);
    for iteration in 0..limit {
        let curvature = masked_product(problem, &p, &mut kp);
        // Also refuses NaN.
        if !(curvature > 0.0 && rho > 0.0) {
            if !(curvature.is_finite() && rho.is_finite()) {
                return Err(FemError::OutOfRange { what: "solution" });
            }
            let detail = format!("p.K p = {curvature:.3e}, r.M r = {rho:.3e} in iteration {iteration}");
            return Err(FemError::NotPositiveDefinite { detail });
        }
        let alpha = rho / curvature;
        let squared = step(alpha, &p, &kp, u, &mut r);
        // With a tolerance of NaN too the true residual decides.
        if squared <= goal || goal.is_nan() {
            return Ok(iteration + 1);
        }
        preconditioner.apply(&r, squared.sqrt(), &mut z)?;
        // Rounding makes the preconditioner a little unsymmetric, which this form of beta forgives (Notay 2000).
        let beta = -alpha * dot(&z, &kp) / rho;
        rho = dot(&r, &z);
        p.par_iter_mut().with_min_len(CHUNK).zip(&z).for_each(|(p, z)| *p = *z + beta * *p);
    }
    Ok(limit)
}

/// `kp = K p` at the unknowns; returns `p . K p`.
fn masked_product(problem: &Problem, p: &[DVec3], kp: &mut [DVec3]) -> f64 {
    let (stiffness, mask) = (&problem.system.stiffness, problem.system.numbering.mask());
    let partials: Vec<f64> = kp
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, kp)| {
            let first = chunk * CHUNK;
            let mut sum = 0.0;
            for (i, kp) in kp.iter_mut().enumerate().map(|(k, kp)| (first + k, kp)) {
                *kp = mask[i] * stiffness.row_times(i, p);
                sum += kp.dot(p[i]);
            }
            sum
        })
        .collect();
    partials.iter().sum()
}

/// `u += alpha p`, `r -= alpha kp`; returns `r . r`.
fn step(alpha: f64, p: &[DVec3], kp: &[DVec3], u: &mut [DVec3], r: &mut [DVec3]) -> f64 {
    let partials: Vec<f64> = u
        .par_chunks_mut(CHUNK)
        .zip(r.par_chunks_mut(CHUNK))
        .zip(p.par_chunks(CHUNK))
        .zip(kp.par_chunks(CHUNK))
        .map(|(((u, r), p), kp)| {
            let mut sum = 0.0;
            for i in 0..u.len() {
                u[i] += alpha * p[i];
                r[i] -= alpha * kp[i];
                sum += r[i].length_squared();
            }
            sum
        })
        .collect();
    partials.iter().sum()
}
