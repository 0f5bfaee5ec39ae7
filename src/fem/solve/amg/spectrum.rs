//! The largest eigenvalue of a level's matrix, relative to its diagonal blocks.

use super::operator::Operator;
use super::real::Real;
use crate::fem::block_matrix::CHUNK;
use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

/// Steps of Lanczos's method: enough for a tenth.
const STEPS: usize = 8;

/// An estimate, from below, of the largest eigenvalue of `D^-1 A`: that of the tridiagonal matrix of conjugate gradients
/// from a random start (Lanczos 1950). The power method would fall much shorter.
pub(super) fn largest_eigenvalue<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>) -> f64 {
    let mut r: Vec<[T; W]> = (0..a.len()).map(noise::<T, N, W>).collect();
    let mut z = vec![[T::default(); W]; a.len()];
    relaxed(a, &r, &mut z);
    let (mut p, mut q) = (z.clone(), z.clone());
    let mut rho = dot::<T, N, W>(&r, &z);
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let (mut last_alpha, mut beta) = (1.0, 0.0);
    for _ in 0..STEPS {
        a.times(&p, [&mut q], |_, product, [q]| *q = product);
        let curvature = dot::<T, N, W>(&p, &q);
        if !(curvature > 0.0 && rho > 0.0) {
            break;
        }
        let alpha = rho / curvature;
        diagonal.push(1.0 / alpha + beta / last_alpha);
        let next = step(a, T::new(alpha), &q, &mut r, &mut z);
        (beta, rho, last_alpha) = (next / rho, next, alpha);
        beside.push(beta.max(0.0).sqrt() / alpha);
        let factor = T::new(beta);
        p.par_iter_mut().zip(&z).with_min_len(1024).for_each(|(p, z)| (0..N).for_each(|c| p[c] = z[c] + factor * p[c]));
    }
    let n = diagonal.len();
    let tridiagonal = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    if n == 0 { 1.0 } else { SymmetricEigen::new(tridiagonal).eigenvalues.max() }
}

/// `r -= alpha q`, `z = D^-1 r`; returns `r . z`.
fn step<T: Real, const N: usize, const W: usize>(
    a: &Operator<T, N, W>,
    alpha: T,
    q: &[[T; W]],
    r: &mut [[T; W]],
    z: &mut [[T; W]],
) -> f64 {
    let part = |chunk: usize, r: &mut [[T; W]], z: &mut [[T; W]], q: &[[T; W]]| {
        for (k, q) in q.iter().enumerate() {
            (0..N).for_each(|c| r[k][c] -= alpha * q[c]);
            z[k] = a.relax(chunk * CHUNK + k, &r[k]);
        }
        part_dot::<T, N, W>(r, z)
    };
    let vectors = r.par_chunks_mut(CHUNK).zip(z.par_chunks_mut(CHUNK)).zip(q.par_chunks(CHUNK)).enumerate();
    vectors.map(|(chunk, ((r, z), q))| part(chunk, r, z, q)).collect::<Vec<f64>>().iter().sum()
}

/// `z = D^-1 r`.
pub(super) fn relaxed<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>, r: &[[T; W]], z: &mut [[T; W]]) {
    z.par_iter_mut().zip(r).with_min_len(1024).enumerate().for_each(|(i, (z, r))| *z = a.relax(i, r));
}

/// A vector in [-1, 1] that has a bit of everything (splitmix64 of the node's number).
fn noise<T: Real, const N: usize, const W: usize>(i: usize) -> [T; W] {
    let random = |k: usize| {
        let mut x = ((i * N + k) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    std::array::from_fn(|k| if k < N { T::new(random(k)) } else { T::default() })
}

/// `x . y`, summed in chunks of fixed size.
fn dot<T: Real, const N: usize, const W: usize>(x: &[[T; W]], y: &[[T; W]]) -> f64 {
    let parts = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK));
    parts.map(|(x, y)| part_dot::<T, N, W>(x, y)).collect::<Vec<f64>>().iter().sum()
}

fn part_dot<T: Real, const N: usize, const W: usize>(x: &[[T; W]], y: &[[T; W]]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (0..N).map(|c| x[c].get() * y[c].get()).sum::<f64>()).sum()
}
