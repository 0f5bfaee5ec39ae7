//! How hard a system is for conjugate gradients: condition numbers and iterations, without and with its diagonal as
//! preconditioner.

use super::assembly::System;
use super::block_matrix::{dot, norm};
use faer::{Mat, Side};
use glam::DVec3;

/// Relative residual at which iterations are counted.
const TOLERANCE: f64 = 1e-8;

/// Relative residual up to which the extreme eigenvalues are followed.
const FOLLOWED: f64 = 1e-13;

/// Unknowns up to which all eigenvalues are computed where iterations do not converge.
const DENSE: usize = 4000;

/// Iterations at most.
const MOST: usize = 3000;

/// What conjugate gradients meet in a system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// Largest over smallest eigenvalue of the matrix of the unknowns.
    pub condition: f64,
    /// Iterations from zero to a relative residual of 1e-8.
    pub iterations: usize,
    /// As `condition`, of the matrix scaled to a unit diagonal.
    pub scaled_condition: f64,
    /// As `iterations`, with the diagonal as preconditioner.
    pub scaled_iterations: usize,
    /// Numbers in the matrix of the unknowns that are stored.
    pub nonzeros: usize,
}

impl Spectrum {
    /// That of a system, by Lanczos' method: conjugate gradients compute a tridiagonal matrix, whose extreme eigenvalues are
    /// near those of the system once they have converged.
    #[must_use]
    pub fn of(system: &System) -> Self {
        let mask = system.numbering.mask();
        let ones = vec![DVec3::ONE; mask.len()];
        let inverse = |i: usize| {
            let k = system.stiffness.diagonal(i);
            let d = DVec3::new(k.x_axis.x, k.y_axis.y, k.z_axis.z);
            DVec3::select(d.cmpgt(DVec3::ZERO), d.recip(), DVec3::ZERO)
        };
        let diagonal: Vec<DVec3> = (0..mask.len()).map(inverse).collect();
        let (condition, iterations) = lanczos(system, &ones);
        let (scaled_condition, scaled_iterations) = lanczos(system, &diagonal);
        let used = |i: usize| mask[i] != DVec3::ZERO;
        let stored = |i: usize| system.stiffness.row(i).filter(|(j, _)| used(*j)).count();
        let nonzeros = 9 * (0..mask.len()).filter(|i| used(*i)).map(stored).sum::<usize>();
        Self { condition, iterations, scaled_condition, scaled_iterations, nonzeros }
    }
}

/// Condition number, and iterations of conjugate gradients with this diagonal preconditioner under the system's own loads.
fn lanczos(system: &System, scale: &[DVec3]) -> (f64, usize) {
    let mask = system.numbering.mask();
    let product =
        |p: &[DVec3]| -> Vec<DVec3> { system.stiffness.times(p).into_iter().zip(mask).map(|(x, m)| x * *m).collect() };
    let start = system.unbalanced(&system.numbering.lifting());
    let iterations = descend(&product, scale, &start, TOLERANCE).diagonal.len();
    // Loads may be orthogonal to extreme eigenvectors, for symmetry; these are not.
    let noise = |i: usize, c: usize| ((1 + 3 * i + c) as f64 * 12.9898).sin() * 43758.5453;
    let rough = (0..mask.len()).map(|i| mask[i] * DVec3::from_array([0, 1, 2].map(|c| noise(i, c).fract())));
    let tridiagonal = descend(&product, scale, &rough.collect::<Vec<_>>(), FOLLOWED);
    if tridiagonal.diagonal.len() < MOST {
        return (tridiagonal.condition(), iterations);
    }
    (dense_condition(system, scale).unwrap_or(f64::NAN), iterations)
}

/// The condition number from all eigenvalues, of matrices small enough for that.
fn dense_condition(system: &System, scale: &[DVec3]) -> Option<f64> {
    let unknowns: Vec<(usize, usize)> = system.numbering.unknowns().collect();
    if unknowns.len() > DENSE {
        return None;
    }
    let mut place = vec![[usize::MAX; 3]; scale.len()];
    unknowns.iter().enumerate().for_each(|(k, &(i, c))| place[i][c] = k);
    let mut matrix = Mat::<f64>::zeros(unknowns.len(), unknowns.len());
    for (k, &(i, c)) in unknowns.iter().enumerate() {
        for (j, block) in system.stiffness.row(i) {
            for d in (0..3).filter(|d| place[j][*d] != usize::MAX) {
                matrix[(k, place[j][d])] = block.col(d)[c] * (scale[i][c] * scale[j][d]).sqrt();
            }
        }
    }
    let eigenvalues = matrix.self_adjoint_eigenvalues(Side::Lower).ok()?;
    Some(eigenvalues.last()? / eigenvalues.first()?)
}

/// Lanczos' matrix.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Squares of the entries beside the diagonal.
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// Largest over smallest eigenvalue, by bisection.
    fn condition(&self) -> f64 {
        let n = self.diagonal.len();
        let bound = |i: usize| {
            let near = |k: usize| self.beside.get(k).map_or(0.0, |b| b.sqrt());
            self.diagonal[i] + near(i) + if i > 0 { near(i - 1) } else { 0.0 }
        };
        let high = (0..n).map(bound).fold(0.0, f64::max);
        self.eigenvalue(n - 1, high) / self.eigenvalue(0, high)
    }

    /// Eigenvalue number `k` of a positive definite matrix whose eigenvalues are below `high`.
    fn eigenvalue(&self, k: usize, high: f64) -> f64 {
        let (mut low, mut high) = (high * 1e-18, high);
        while high / low > 1.0 + 1e-12 {
            let middle = (low * high).sqrt();
            if self.below(middle) > k { high = middle } else { low = middle }
        }
        high
    }

    /// How many eigenvalues are below `x`: negative pivots of the shifted matrix (Sturm).
    fn below(&self, x: f64) -> usize {
        let (mut pivot, mut count) = (1.0, 0);
        for (i, d) in self.diagonal.iter().enumerate() {
            let left = if i == 0 { 0.0 } else { self.beside[i - 1] / pivot };
            pivot = d - x - left;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    }
}

/// Conjugate gradients, as Lanczos' tridiagonal matrix: a row an iteration.
fn descend(product: &impl Fn(&[DVec3]) -> Vec<DVec3>, scale: &[DVec3], b: &[DVec3], tolerance: f64) -> Tridiagonal {
    let scaled = |r: &[DVec3]| -> Vec<DVec3> { r.iter().zip(scale).map(|(r, s)| *r * *s).collect() };
    let (mut r, size) = (b.to_vec(), norm(b));
    let mut z = scaled(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let (mut steps, mut betas) = (Vec::new(), Vec::new());
    while steps.len() < MOST && norm(&r) > tolerance * size {
        let kp = product(&p);
        let step = rz / dot(&p, &kp);
        r.iter_mut().zip(&kp).for_each(|(r, kp)| *r -= step * *kp);
        z = scaled(&r);
        let next = dot(&r, &z);
        let beta = next / rz;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = *z + beta * *p);
        rz = next;
        steps.push(step);
        betas.push(beta);
    }
    let own = |i: usize| 1.0 / steps[i] + if i > 0 { betas[i - 1] / steps[i - 1] } else { 0.0 };
    let diagonal: Vec<f64> = (0..steps.len()).map(own).collect();
    let beside = (1..steps.len()).map(|i| betas[i - 1] / (steps[i - 1] * steps[i - 1])).collect();
    Tridiagonal { diagonal, beside }
}
