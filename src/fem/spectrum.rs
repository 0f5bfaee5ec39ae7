//! How hard a system is for conjugate gradients: condition numbers and iterations, without and with its diagonal as
//! preconditioner.

use super::assembly::System;
use super::block_matrix::{dot, norm};
use glam::DVec3;
use nalgebra::{DMatrix, SymmetricEigen};

/// Relative residual at which iterations are counted.
const TOLERANCE: f64 = 1e-8;

/// Relative residual up to which the extreme eigenvalues are followed.
const FOLLOWED: f64 = 1e-13;

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
    let iterations = descend(&product, scale, &start, TOLERANCE).0;
    // Loads may be orthogonal to extreme eigenvectors, for symmetry; these are not.
    let noise = |i: usize, c: usize| ((1 + 3 * i + c) as f64 * 12.9898).sin() * 43758.5453;
    let rough = (0..mask.len()).map(|i| mask[i] * DVec3::from_array([0, 1, 2].map(|c| noise(i, c).fract())));
    let (_, tridiagonal) = descend(&product, scale, &rough.collect::<Vec<_>>(), FOLLOWED);
    let eigenvalues = SymmetricEigen::new(tridiagonal).eigenvalues;
    (eigenvalues.max() / eigenvalues.min(), iterations)
}

/// Conjugate gradients: iterations, and Lanczos' tridiagonal matrix.
fn descend(
    product: &impl Fn(&[DVec3]) -> Vec<DVec3>,
    scale: &[DVec3],
    b: &[DVec3],
    tolerance: f64,
) -> (usize, DMatrix<f64>) {
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
    let n = steps.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i == 0 => 1.0 / steps[0],
        0 => 1.0 / steps[i] + betas[i - 1] / steps[i - 1],
        1 => betas[i.min(j)].sqrt() / steps[i.min(j)],
        _ => 0.0,
    });
    (n, matrix)
}
