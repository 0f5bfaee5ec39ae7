//! Smoothing on one level: what oscillates from node to node.

use super::operator::Operator;
use super::real::Real;
use super::rows::minus;
use super::spectrum::{largest_eigenvalue, relaxed};
use rayon::prelude::*;

/// Largest eigenvalue of `D^-1 A` above which nodes are coupled too tightly for Gauss-Seidel sweeps to smooth well: about
/// 2.2 on well-shaped cells of one compressible material, 2.5 and more near incompressibility, where stiff and soft cells
/// alternate, and on flattened cells.
const TIGHT: f64 = 2.35;

/// Mean size of aggregates below which strong couplings run in some directions only, as on flattened cells: about 18 in
/// well-shaped ones.
const FLAT: f64 = 11.0;

/// Degree of the polynomial for tight couplings.
const DEGREE: usize = 5;

/// The interval of eigenvalues on which the polynomial is small, relative to the estimate of the largest, which is one from
/// below.
const INTERVAL: [f64; 2] = [0.03, 1.2];

/// How a hierarchy smooths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Kind {
    /// A sweep of Gauss-Seidel by nodes, forward before the coarse correction, backward after.
    Sweeps,
    /// Chebyshev's polynomials in `D^-1 A`.
    Chebyshev,
}

/// Whether nodes are coupled tightly, given the largest eigenvalue of `D^-1 A`.
pub(super) fn is_tight(largest: f64) -> bool {
    largest > TIGHT
}

impl Kind {
    /// The choice for a matrix whose `D^-1 A` has this largest eigenvalue, and whose aggregates have this mean size.
    pub fn choose(largest: f64, size: f64) -> Self {
        if is_tight(largest) || size < FLAT { Self::Chebyshev } else { Self::Sweeps }
    }
}

/// A level's matrix with the vectors of a cycle.
pub(super) struct Smoother<T, const N: usize, const W: usize> {
    pub a: Operator<T, N, W>,
    /// The right-hand side.
    pub r: Vec<[T; W]>,
    /// The solution.
    pub z: Vec<[T; W]>,
    /// After [`Smoother::before`] the residual.
    pub rest: Vec<[T; W]>,
    chebyshev: Option<Chebyshev<T, W>>,
}

/// The polynomial's interval, and its vectors.
struct Chebyshev<T, const W: usize> {
    low: f64,
    high: f64,
    step: Vec<[T; W]>,
    next: Vec<[T; W]>,
}

impl<T: Real, const N: usize, const W: usize> Smoother<T, N, W> {
    /// `largest` is an estimate of the largest eigenvalue of `D^-1 A`.
    pub fn new(a: Operator<T, N, W>, kind: Kind, largest: f64) -> Self {
        let zero = || vec![[T::default(); W]; a.len()];
        let [low, high] = INTERVAL.map(|part| part * largest);
        let chebyshev = (kind == Kind::Chebyshev).then(|| Chebyshev { low, high, step: zero(), next: zero() });
        Self { r: zero(), z: zero(), rest: zero(), a, chebyshev }
    }

    /// The same with an eigenvalue estimated here.
    pub fn estimated(a: Operator<T, N, W>, kind: Kind) -> Self {
        let largest = if kind == Kind::Chebyshev { largest_eigenvalue(&a) } else { 1.0 };
        Self::new(a, kind, largest)
    }

    /// Smooths the solution of `A z = r` from zero, and leaves the residual in `rest`.
    pub fn before(&mut self) {
        if let Some(chebyshev) = &mut self.chebyshev {
            chebyshev.smooth(&self.a, &self.r, &mut self.rest, &mut self.z, true);
            chebyshev.last_residual(&self.a, &mut self.rest);
        } else {
            // The sweep solves (D + L) z = r, so that the residual is -U z.
            self.a.solve_lower(&self.r, &mut self.z);
            self.a.minus_upper(&self.z, &mut self.rest);
        }
    }

    /// Smooths the solution of `A z = r` from `z`: the adjoint of [`Smoother::before`].
    pub fn after(&mut self) {
        if let Some(chebyshev) = &mut self.chebyshev {
            chebyshev.smooth(&self.a, &self.r, &mut self.rest, &mut self.z, false);
        } else {
            self.a.without_lower(&self.r, &self.z, &mut self.rest);
            self.a.solve_upper(&self.rest, &mut self.z);
        }
    }
}

impl<T: Real, const W: usize> Chebyshev<T, W> {
    /// Adds a polynomial in `D^-1 A` of `D^-1 (r - A z)` to `z` (Saad 2003, algorithm 12.1), which counts as zero if
    /// `from_zero`. What becomes of the residual is in `rest`, but for the last step.
    fn smooth<const N: usize>(
        &mut self,
        a: &Operator<T, N, W>,
        r: &[[T; W]],
        rest: &mut [[T; W]],
        z: &mut [[T; W]],
        from_zero: bool,
    ) {
        let (centre, half) = (0.5 * (self.high + self.low), 0.5 * (self.high - self.low));
        let first = T::new(1.0 / centre);
        if from_zero {
            rest.copy_from_slice(r);
            relaxed(a, r, &mut self.step);
            self.step.par_iter_mut().with_min_len(1024).for_each(|step| *step = step.map(|s| first * s));
        } else {
            a.times(z, [rest, &mut self.step], |i, product, [rest, step]| {
                *rest = minus(&r[i], &product);
                *step = a.relax(i, rest).map(|s| first * s);
            });
        }
        let ratio = centre / half;
        let mut damping = 1.0 / ratio;
        for degree in 1..DEGREE {
            let next = 1.0 / (2.0 * ratio - damping);
            let (keep, take) = (T::new(next * damping), T::new(2.0 * next / half));
            damping = next;
            let step = &self.step;
            a.times(step, [rest, &mut self.next, z], |i, product, [rest, next, z]| {
                *rest = minus(rest, &product);
                let new = a.relax(i, rest);
                *next = std::array::from_fn(|c| keep * step[i][c] + take * new[c]);
                if degree == 1 {
                    // The first step was not added yet: while it was made, z was read.
                    *z = if from_zero { step[i] } else { plus(z, &step[i]) };
                }
                *z = plus(z, next);
            });
            std::mem::swap(&mut self.step, &mut self.next);
        }
    }

    /// Completes the residual.
    fn last_residual<const N: usize>(&mut self, a: &Operator<T, N, W>, rest: &mut [[T; W]]) {
        a.times(&self.step, [rest], |_, product, [rest]| *rest = minus(rest, &product));
    }
}

/// `x + y`.
#[inline(always)]
fn plus<T: Real, const W: usize>(x: &[T; W], y: &[T; W]) -> [T; W] {
    std::array::from_fn(|c| x[c] + y[c])
}
