//! Conjugate gradients, preconditioned by multigrid.

use super::amg::{Hierarchy, Kind, Real};
use super::{Kept, Problem, ROUNDING_UNITS, Solved, SolverInfo, at_the_limit, not_converged, residual};
use crate::fem::FemError;
use crate::fem::block_matrix::{CHUNK, dot, norm};
use glam::DVec3;
use rayon::prelude::*;

/// Iterations before giving up for good: hundreds of times what well-shaped meshes need.
pub(super) const MAX_ITERATIONS: usize = 20_000;

/// Iterations after which the single precision of the preconditioner is doubted: four times as many as well-shaped meshes need.
const FEW_ITERATIONS: usize = 100;

/// Where a restart leaves more than this part of the true residual, more of them would gain nothing.
const STAGNANT: f64 = 0.5;

/// What to do where the iterations do not suffice.
const HELP: &str = "use method \"direct\"; else check the supports, nearly flat cells and Poisson's ratio near 1/2, or \
                    accept a larger tolerance";

/// Conjugate gradients (Hestenes and Stiefel 1952) on their way from a guess, or from zero, to a true residual below the tolerance.
pub(super) struct Run<'a> {
    problem: &'a Problem<'a>,
    displacement: Vec<DVec3>,
    /// `f - K u` at the unknowns.
    remainder: Vec<DVec3>,
    /// Its norm, relative to that of the right-hand side.
    pub relative: f64,
    pub iterations: usize,
    /// Whether a restart gained nothing.
    stagnant: bool,
    /// Numbers stored in the preconditioner.
    numbers: usize,
}

impl<'a> Run<'a> {
    /// Nothing done yet.
    pub fn new(problem: &'a Problem<'a>, guess: Option<&[DVec3]>) -> Self {
        let (displacement, remainder) = problem.start(guess);
        let relative = norm(&remainder) / problem.scale;
        Self { problem, displacement, remainder, relative, iterations: 0, stagnant: false, numbers: 0 }
    }

    /// Iterates with the preconditioner in single precision, which is kept, and if that is not enough in double precision, until the
    /// true residual is accepted or stagnates, but not for long.
    ///
    /// # Errors
    /// [`FemError::Multigrid`], [`FemError::NotPositiveDefinite`], [`FemError::OutOfRange`]; those of the coarsest problem's
    /// factorisation.
    pub fn for_a_while(&mut self, reason: &mut String, kept: &mut Kept) -> Result<(), FemError> {
        self.iterate_up_to(2 * FEW_ITERATIONS, reason, kept)
    }

    /// Iterates to the end, and gives the solution.
    ///
    /// # Errors
    /// As [`Run::for_a_while`] and [`Run::finish`].
    pub fn solve(mut self, mut reason: String, kept: &mut Kept) -> Result<Solved, FemError> {
        let done = self.iterate_up_to(MAX_ITERATIONS, &mut reason, kept);
        // What breaks down at the limit of double precision has got there.
        if !self.is_rounding(ROUNDING_UNITS) {
            done?;
        }
        self.finish(reason)
    }

    fn iterate_up_to(&mut self, limit: usize, reason: &mut String, kept: &mut Kept) -> Result<(), FemError> {
        match self.advance(FEW_ITERATIONS, None, &mut kept.hierarchy) {
            // The last may be rounding too: double precision will tell.
            Ok(()) | Err(FemError::Multigrid { .. } | FemError::NotPositiveDefinite { .. }) => {}
            Err(error) => return Err(error),
        }
        if self.is_done(ROUNDING_UNITS) {
            return Ok(());
        }
        // What failed need not take memory.
        kept.hierarchy = None;
        *reason += &format!("; preconditioner in double precision after {} iterations", self.iterations);
        match self.advance::<f64>(limit, None, &mut None) {
            // Sweeps need no eigenvalues: their cycle is positive.
            Err(FemError::Multigrid { .. }) => self.advance::<f64>(limit, Some(Kind::Sweeps), &mut None),
            done => done,
        }
    }

    /// Whether the residual is below the tolerance, or has come to rest within so many units of rounding.
    pub fn is_done(&self, units: f64) -> bool {
        self.problem.accepts(self.relative) || (self.stagnant && self.is_rounding(units))
    }

    fn is_rounding(&self, units: f64) -> bool {
        self.problem.is_rounding(self.relative, &self.displacement, units)
    }

    /// The solution.
    ///
    /// # Errors
    /// [`FemError::NotConverged`] if the residual is above the tolerance and above what rounding explains.
    pub fn finish(self, mut reason: String) -> Result<Solved, FemError> {
        if !self.problem.accepts(self.relative) {
            if !self.is_rounding(ROUNDING_UNITS) {
                return Err(not_converged(self.problem, "conjugate gradients", self.iterations, self.relative, HELP));
            }
            reason = at_the_limit(&reason, self.relative);
        }
        let Self { displacement, iterations, relative: residual, numbers: nonzeros, .. } = self;
        let info = SolverInfo { method: "amg-cg", reason, iterations, residual, nonzeros };
        Ok(Solved { displacement, info })
    }

    /// Iterates until the true residual is accepted or stagnates, or `limit` iterations are done in all. The preconditioner is the
    /// one that is kept, or made to be kept.
    fn advance<T: Real>(
        &mut self,
        limit: usize,
        smoother: Option<Kind>,
        kept: &mut Option<Hierarchy<T>>,
    ) -> Result<(), FemError> {
        let problem = self.problem;
        if problem.accepts(self.relative) || self.iterations >= limit {
            return Ok(());
        }
        let system = problem.system;
        let hierarchy = match kept {
            Some(hierarchy) => hierarchy,
            None => kept.insert(Hierarchy::of(system, smoother)?),
        };
        self.numbers = hierarchy.numbers();
        self.stagnant = false;
        while self.iterations < limit && !problem.accepts(self.relative) && !self.stagnant {
            let before = self.relative;
            let rest = std::mem::take(&mut self.remainder);
            let done = iterate(problem, hierarchy, rest, &mut self.displacement, limit - self.iterations);
            self.remainder = residual(system, &self.displacement);
            self.relative = norm(&self.remainder) / problem.scale;
            self.iterations += done?;
            // What ends at the limit has not come to rest; NaN has.
            let gained = self.relative < STAGNANT * before;
            self.stagnant = self.iterations < limit && !gained;
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
                return Err(FemError::out_of_range("solution"));
            }
            let detail = format!("p.K p = {curvature:.3e}, r.M r = {rho:.3e} in iteration {iteration}");
            return Err(if curvature > 0.0 {
                FemError::Multigrid { detail }
            } else {
                FemError::NotPositiveDefinite { detail }
            });
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
