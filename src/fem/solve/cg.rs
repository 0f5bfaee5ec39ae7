//! Conjugate gradients, preconditioned by the inverses of the 3x3 diagonal blocks.

use super::{Problem, Solved, SolverInfo, residual};
use crate::fem::FemError;
use crate::fem::block_matrix::{CHUNK, dot, norm};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Iterations before giving up.
const MAX_ITERATIONS: usize = 20_000;

/// Restarts from the true residual, when it is larger than the one that the recurrence carries along.
const MAX_RESTARTS: usize = 3;

/// Solves from zero (Hestenes and Stiefel 1952), until the true residual is below the tolerance.
///
/// # Errors
/// [`FemError::NotConverged`], [`FemError::NotPositiveDefinite`].
pub(super) fn solve(problem: &Problem, reason: String) -> Result<Solved, FemError> {
    let inverses = diagonal_inverses(problem);
    let mut displacement = problem.lifting.clone();
    let (mut iterations, mut relative, mut remainder) = (0, 1.0, problem.rhs.clone());
    for _ in 0..=MAX_RESTARTS {
        iterations += iterate(problem, &inverses, remainder, &mut displacement, MAX_ITERATIONS - iterations)?;
        remainder = residual(problem.system, &displacement);
        relative = norm(&remainder) / problem.scale;
        if problem.accepts(relative) {
            let nonzeros = 9 * problem.system.stiffness.blocks.len();
            let info = SolverInfo { method: "cg", reason, iterations, residual: relative, nonzeros };
            return Ok(Solved { displacement, info });
        }
    }
    Err(FemError::NotConverged {
        method: "conjugate gradients",
        iterations,
        residual: relative,
        tolerance: problem.tolerance,
        help: "use method \"direct\"; else check the supports, nearly flat cells and Poisson's ratio near 1/2, or \
               accept a larger tolerance",
    })
}

/// The inverse of each node's diagonal block; rows and columns of prescribed components are zero.
fn diagonal_inverses(problem: &Problem) -> Vec<DMat3> {
    let mask = problem.system.numbering.mask();
    let inverse = |i: usize| {
        let project = DMat3::from_diagonal(mask[i]);
        let fixed = DMat3::from_diagonal(DVec3::ONE - mask[i]);
        // Unit entries stand in for the prescribed components, so that the block can be inverted.
        let block = project * problem.system.stiffness.diagonal(i) * project + fixed;
        project * block.inverse() * project
    };
    (0..mask.len()).into_par_iter().with_min_len(CHUNK).map(inverse).collect()
}

/// Adds the solution of `K d = r` to `u`, `K` and `r` restricted to the unknowns; returns the number of iterations. It
/// ends when the residual of the recurrence is below the tolerance, or at the limit.
fn iterate(
    problem: &Problem,
    inverses: &[DMat3],
    mut r: Vec<DVec3>,
    u: &mut [DVec3],
    limit: usize,
) -> Result<usize, FemError> {
    // The recurrence drifts from the true residual by some rounding: aim a little lower.
    let goal = (0.9 * problem.tolerance * problem.scale).powi(2);
    let mut p: Vec<DVec3> = r.iter().zip(inverses).map(|(r, inverse)| *inverse * *r).collect();
    let mut kp = vec![DVec3::ZERO; p.len()];
    let mut rho = dot(&r, &p);
    for iteration in 0..limit {
        let curvature = masked_product(problem, &p, &mut kp);
        // Also refuses NaN.
        if !(curvature > 0.0 && rho > 0.0) {
            let detail = format!("p.K p = {curvature:.3e}, r.M r = {rho:.3e} in iteration {iteration}");
            return Err(FemError::NotPositiveDefinite { detail });
        }
        let [next_rho, squared] = step(rho / curvature, inverses, &p, &mut kp, u, &mut r);
        // With a tolerance of NaN too the true residual decides.
        if squared <= goal || goal.is_nan() {
            return Ok(iteration + 1);
        }
        let beta = next_rho / rho;
        rho = next_rho;
        p.par_iter_mut().with_min_len(CHUNK).zip(&kp).for_each(|(p, z)| *p = *z + beta * *p);
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

/// `u += alpha p`, `r -= alpha kp`, and `M r` in the place of `kp`; returns `r . M r` and `r . r`.
fn step(alpha: f64, inverses: &[DMat3], p: &[DVec3], kp: &mut [DVec3], u: &mut [DVec3], r: &mut [DVec3]) -> [f64; 2] {
    let partials: Vec<[f64; 2]> = kp
        .par_chunks_mut(CHUNK)
        .zip(u.par_chunks_mut(CHUNK))
        .zip(r.par_chunks_mut(CHUNK))
        .zip(p.par_chunks(CHUNK))
        .zip(inverses.par_chunks(CHUNK))
        .map(|((((kp, u), r), p), inverses)| {
            let mut sums = [0.0; 2];
            for i in 0..kp.len() {
                u[i] += alpha * p[i];
                r[i] -= alpha * kp[i];
                let z = inverses[i] * r[i];
                sums[0] += r[i].dot(z);
                sums[1] += r[i].dot(r[i]);
                kp[i] = z;
            }
            sums
        })
        .collect();
    partials.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
}
