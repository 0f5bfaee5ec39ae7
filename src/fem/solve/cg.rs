//! Conjugate gradients with a two-level preconditioner: block Jacobi sweeps around a coarse correction.

use super::coarse::Coarse;
use super::{Problem, Solved, SolverInfo, at_the_limit, not_converged, residual};
use crate::fem::FemError;
use crate::fem::block_matrix::{CHUNK, dot, norm};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Iterations before giving up for good: hundreds of times what well-shaped meshes need.
pub(super) const MAX_ITERATIONS: usize = 20_000;

/// Restarts from the true residual, when it is larger than the one that the recurrence carries along.
const MAX_RESTARTS: usize = 3;

/// What to do where the iterations do not suffice.
const HELP: &str = "use method \"direct\"; else check the supports, nearly flat cells and Poisson's ratio near 1/2, or \
                    accept a larger tolerance";

/// Weight of a block Jacobi sweep. For four-node cells `x.K x <= 4 x.D x`, since the element energy of a sum of four
/// nodal displacements is at most four times the sum of theirs: any weight below 1/2 makes the sweep a contraction and
/// the preconditioner positive definite.
const DAMPING: f64 = 0.499;

/// Solves from zero (Hestenes and Stiefel 1952), until the true residual is below the tolerance, in at most `limit`
/// iterations.
///
/// # Errors
/// [`FemError::NotConverged`], [`FemError::NotPositiveDefinite`]; those of the coarse problem's factorisation.
pub(super) fn solve(problem: &Problem, reason: String, limit: usize) -> Result<Solved, FemError> {
    let preconditioner = Preconditioner::new(problem)?;
    let mut displacement = problem.lifting.clone();
    let (mut iterations, mut relative, mut remainder) = (0, 1.0, problem.rhs.clone());
    let nonzeros = 9 * problem.system.stiffness.blocks.len();
    let found = |displacement, reason, iterations, residual| {
        let info = SolverInfo { method: "cg", reason, iterations, residual, nonzeros };
        Ok(Solved { displacement, info })
    };
    for _ in 0..=MAX_RESTARTS {
        iterations += iterate(&preconditioner, remainder, &mut displacement, limit - iterations)?;
        remainder = residual(problem.system, &displacement);
        relative = norm(&remainder) / problem.scale;
        if problem.accepts(relative) {
            return found(displacement, reason, iterations, relative);
        }
    }
    if problem.is_rounding(relative, &displacement) {
        return found(displacement, at_the_limit(&reason, relative), iterations, relative);
    }
    Err(not_converged(problem, "conjugate gradients", iterations, relative, HELP))
}

/// Adds the solution of `K d = r` to `u`, `K` and `r` restricted to the unknowns; returns the number of iterations. It
/// ends when the residual of the recurrence is below the tolerance, or at the limit.
fn iterate(
    preconditioner: &Preconditioner,
    mut r: Vec<DVec3>,
    u: &mut [DVec3],
    limit: usize,
) -> Result<usize, FemError> {
    let problem = preconditioner.problem;
    // The recurrence drifts from the true residual by some rounding: aim a little lower.
    let goal = (0.9 * problem.tolerance * problem.scale).powi(2);
    let mut p = preconditioner.apply(&r)?;
    let mut kp = vec![DVec3::ZERO; p.len()];
    let mut rho = dot(&r, &p);
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
        let squared = step(rho / curvature, &p, &kp, u, &mut r);
        // With a tolerance of NaN too the true residual decides.
        if squared <= goal || goal.is_nan() {
            return Ok(iteration + 1);
        }
        let z = preconditioner.apply(&r)?;
        let next_rho = dot(&r, &z);
        let beta = next_rho / rho;
        rho = next_rho;
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

/// A symmetric two-level cycle: a sweep of block Jacobi, the coarse correction, another sweep.
struct Preconditioner<'a> {
    problem: &'a Problem<'a>,
    /// Damped inverses of the diagonal blocks.
    inverses: Vec<DMat3>,
    coarse: Coarse,
}

impl<'a> Preconditioner<'a> {
    fn new(problem: &'a Problem) -> Result<Self, FemError> {
        let coarse = Coarse::new(problem.system)?;
        Ok(Self { problem, inverses: diagonal_inverses(problem), coarse })
    }

    /// An approximation of `K^-1 r`, symmetric and positive definite in the unknowns.
    fn apply(&self, r: &[DVec3]) -> Result<Vec<DVec3>, FemError> {
        let (stiffness, mask) = (&self.problem.system.stiffness, self.problem.system.numbering.mask());
        let rows = || (0..r.len()).into_par_iter().with_min_len(CHUNK);
        let mut z: Vec<DVec3> = rows().map(|i| self.inverses[i] * r[i]).collect();
        let left: Vec<DVec3> = rows().map(|i| r[i] - mask[i] * stiffness.row_times(i, &z)).collect();
        self.coarse.correct(mask, &left, &mut z)?;
        Ok(rows().map(|i| z[i] + self.inverses[i] * (r[i] - stiffness.row_times(i, &z))).collect())
    }
}

/// The damped inverse of each node's diagonal block; rows and columns of prescribed components are zero.
fn diagonal_inverses(problem: &Problem) -> Vec<DMat3> {
    let mask = problem.system.numbering.mask();
    let inverse = |i: usize| {
        let project = DMat3::from_diagonal(mask[i]);
        let fixed = DMat3::from_diagonal(DVec3::ONE - mask[i]);
        // Unit entries stand in for the prescribed components, so that the block can be inverted.
        let block = project * problem.system.stiffness.diagonal(i) * project + fixed;
        project * block.inverse() * project * DAMPING
    };
    (0..mask.len()).into_par_iter().with_min_len(CHUNK).map(inverse).collect()
}
