//! The cells around a vertex laid out for the vector units of the processor, to try positions of the vertex quickly.
//!
//! Sines are those of [`crate::mesh::quality::min_sine`] up to rounding; of cells that are not positive only the sign is
//! right.

use super::super::solid::Solid;
use super::lanes::{Block, Blocks, LANES, Lanes, least};
use super::rest_of;
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use smallvec::SmallVec;

/// The cells (v, p, q, r), positive, around a vertex v.
#[derive(Default)]
pub(super) struct Fan {
    blocks: Blocks,
    arch: Arch,
}

impl Fan {
    /// Takes the cells at `v`.
    pub(super) fn gather(&mut self, solid: &Solid, v: u32) {
        self.blocks.clear();
        for &t in solid.cells_at(v) {
            self.blocks.push(rest_of(solid.tet(t), v).map(|w| solid.point(w)));
        }
    }

    /// The corners p, q, r of cell `i`.
    pub(super) fn corners(&self, i: usize) -> [DVec3; 3] {
        self.blocks.corners(i)
    }

    /// Minimum sines of the cells, in the order of [`Solid::cells_at`], with the vertex at `x`.
    pub(super) fn sines(&self, x: DVec3) -> SmallVec<[f64; 32]> {
        self.sines_above(x, f64::NEG_INFINITY)
    }

    /// Smallest minimum sine of the cells with the vertex at `x`; stops early below `enough`.
    pub(super) fn worst_sine(&self, x: DVec3, enough: f64) -> f64 {
        self.sines_above(x, enough).into_iter().fold(f64::INFINITY, least)
    }

    /// Sum of the minimum sines with the vertex at `x`; minus infinity if one of them is below `floor`.
    pub(super) fn sum_above(&self, x: DVec3, floor: f64) -> f64 {
        let sines = self.sines_above(x, floor);
        if sines.iter().any(|sine| *sine < floor) { f64::NEG_INFINITY } else { sines.into_iter().sum() }
    }

    /// Gradient, with respect to the position `x` of the vertex, of the sum of the minimum sines.
    pub(super) fn gradient_of_sum(&self, x: DVec3) -> DVec3 {
        self.arch.dispatch(Gradients { fan: self, x })
    }

    /// Minimum sines as far as the first cells with one below `floor`.
    fn sines_above(&self, x: DVec3, floor: f64) -> SmallVec<[f64; 32]> {
        let mut sines = self.arch.dispatch(Sines { fan: self, x, floor });
        sines.truncate(self.blocks.len());
        sines
    }
}

/// [`Fan::sines_above`] for the processor at hand.
struct Sines<'a> {
    fan: &'a Fan,
    x: DVec3,
    floor: f64,
}

impl WithSimd for Sines<'_> {
    type Output = SmallVec<[f64; 32]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut all = SmallVec::new();
        for block in self.fan.blocks.iter() {
            let some = sines(block, self.x);
            all.extend_from_slice(&some);
            if some.into_iter().fold(f64::INFINITY, least) < self.floor {
                break;
            }
        }
        all
    }
}

/// [`Fan::gradient_of_sum`] for the processor at hand.
struct Gradients<'a> {
    fan: &'a Fan,
    x: DVec3,
}

impl WithSimd for Gradients<'_> {
    type Output = DVec3;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> DVec3 {
        let mut sums = [DVec3::ZERO; LANES];
        for (i, block) in self.fan.blocks.iter().enumerate() {
            let gradients = gradients(block, self.x);
            for (sum, gradient) in sums.iter_mut().zip(gradients).take(self.fan.blocks.len() - i * LANES) {
                *sum += gradient;
            }
        }
        sums.into_iter().sum()
    }
}

#[inline(always)]
fn sines(block: &Block, x: DVec3) -> Lanes {
    let mut sines = [0.0; LANES];
    for (lane, sine) in sines.iter_mut().enumerate() {
        let [p, q, r] = block.corners(lane);
        let (ep, eq, er, pq, pr, qr) = (p - x, q - x, r - x, q - p, r - p, r - q);
        let base = pq.cross(pr);
        let six_volumes = base.dot(ep);
        // The faces opposite to x, p, q, r.
        let [nx, np, nq, nr] = [base, eq.cross(er), ep.cross(er), ep.cross(eq)].map(DVec3::length_squared);
        let most = least(
            least(
                least(ep.length_squared() * (nx * np), eq.length_squared() * (nx * nq)),
                least(er.length_squared() * (nx * nr), pq.length_squared() * (np * nq)),
            ),
            least(pr.length_squared() * (np * nr), qr.length_squared() * (nq * nr)),
        );
        *sine = six_volumes * (most / (nx * np) / (nq * nr)).sqrt();
    }
    sines
}

/// Gradients of the minimum sines: from s = 6 V |e| / (|M| |N|) by logarithmic differentiation, with
/// `d ln |N| = N x (w - u) / |N|^2` for N = (u - x) x (w - x).
#[inline(always)]
fn gradients(block: &Block, x: DVec3) -> [DVec3; LANES] {
    let mut gradients = [DVec3::ZERO; LANES];
    for (lane, gradient) in gradients.iter_mut().enumerate() {
        let [p, q, r] = block.corners(lane);
        let (ep, eq, er, pq, pr, qr) = (p - x, q - x, r - x, q - p, r - p, r - q);
        let base = pq.cross(pr);
        let six_volumes = base.dot(ep);
        let (fp, fq, fr) = (er.cross(eq), ep.cross(er), eq.cross(ep));
        let [ix, ip, iq, ir] = [base, fp, fq, fr].map(|n| 1.0 / n.length_squared());
        let (lp, lq, lr) = (fp.cross(-qr) * ip, fq.cross(pr) * iq, fr.cross(-pq) * ir);
        let (sp, sq, sr) = (ep.length_squared(), eq.length_squared(), er.length_squared());
        // The square of |e| / (|M| |N|), and the gradient of its logarithm.
        let mut smallest = (sp * (iq * ir), -ep / sp - lq - lr);
        let others = [
            (sq * (ip * ir), -eq / sq - lp - lr),
            (sr * (ip * iq), -er / sr - lp - lq),
            (pq.length_squared() * (ix * ir), -lr),
            (pr.length_squared() * (ix * iq), -lq),
            (qr.length_squared() * (ix * ip), -lp),
        ];
        for (ratio, log) in others {
            let smaller = ratio < smallest.0;
            let choose = |new: f64, old: f64| if smaller { new } else { old };
            smallest = (
                choose(ratio, smallest.0),
                DVec3::new(choose(log.x, smallest.1.x), choose(log.y, smallest.1.y), choose(log.z, smallest.1.z)),
            );
        }
        *gradient = smallest.0.sqrt() * (six_volumes * smallest.1 - base);
    }
    gradients
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{generate, quality};

    #[test]
    fn sines_and_gradients_are_those_of_the_measure_and_its_finite_differences() {
        let mesh = generate::box_tets([1.0, 0.8, 1.3], [2; 3]).unwrap();
        let solid = Solid::new(&mesh);
        let v = (0..mesh.points().len() as u32).find(|&v| solid.is_interior(v)).unwrap();
        let mut fan = Fan::default();
        fan.gather(&solid, v);
        let x = solid.point(v) + DVec3::new(0.03, -0.05, 0.02);
        let sines = |x: DVec3| -> Vec<f64> {
            let corner = |w| if w == v { x } else { solid.point(w) };
            solid.cells_at(v).iter().map(|&t| quality::min_sine(solid.tet(t).map(corner))).collect()
        };
        let worst = sines(x).into_iter().fold(f64::INFINITY, f64::min);
        assert!((fan.worst_sine(x, 0.0) - worst).abs() < 1e-14);
        assert!((fan.sum_above(x, 0.0) - sines(x).into_iter().sum::<f64>()).abs() < 1e-13);
        assert_eq!(fan.sum_above(x, worst + 1e-3), f64::NEG_INFINITY);
        let (gradient, h) = (fan.gradient_of_sum(x), 1e-6);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let sum = |x: DVec3| sines(x).into_iter().sum::<f64>();
            let slope = (sum(x + h * axis) - sum(x - h * axis)) / (2.0 * h);
            assert!((slope - gradient.dot(axis)).abs() < 1e-6, "{slope} {gradient} along {axis}");
        }
        assert!(fan.worst_sine(x + DVec3::splat(10.0), 0.0) < 0.0, "an inverted cell is seen");
    }
}
