//! Vertex smoothing for the mean: a step along the gradient of the sum of the cells' smallest sines.

use super::super::solid::Solid;
use super::freedom::Freedom;
use super::rest_of;
use super::smooth::least_piece;
use crate::mesh::quality;
use glam::DVec3;

/// First step, times the squared length of the shortest edge, along the mean gradient.
const STEP: f64 = 1.0;

/// Shorter steps tried after the first, and by how much shorter.
const RETRIES: usize = 2;
const SHORTER: f64 = 0.4;

/// Steps that promise the mean sine less than this are not worth a visit.
const WORTH: f64 = 2e-3;

/// The share of the gain promised by the gradient that a step must keep (Armijo's rule).
const KEEP: f64 = 0.2;

/// A position within the freedom of `v` that raises the sum of the smallest sines of its cells, none of them below both
/// `floor` and the worst of them now; `None` if there is none or the gain is small.
pub(super) fn better(solid: &Solid, v: u32, freedom: Freedom, floor: f64) -> Option<DVec3> {
    let p = solid.point(v);
    let cells = solid.cells_at(v);
    let (mut gradient, mut sum, mut scale) = (DVec3::ZERO, 0.0, f64::INFINITY);
    for &t in cells {
        let rest = rest_of(solid.tet(t), v).map(|w| solid.point(w));
        gradient += least_piece(p, rest).gradient;
        sum += solid.sine(t);
        scale = rest.iter().map(|q| (*q - p).length_squared()).fold(scale, f64::min);
    }
    let count = cells.len() as f64;
    let floor = floor.min(solid.worst_sine(cells));
    let direction = freedom.project(gradient) / count;
    let slope = direction.length_squared();
    let mut t = STEP * scale;
    for _ in 0..=RETRIES {
        if slope * t < WORTH {
            return None;
        }
        let q = p + t * direction;
        if sum_with(solid, v, q, floor) > sum + KEEP * slope * t * count {
            return Some(q);
        }
        t *= SHORTER;
    }
    None
}

/// Sum of the smallest sines of the cells at `v` if it were at `q`; minus infinity if one falls below the floor.
fn sum_with(solid: &Solid, v: u32, q: DVec3, floor: f64) -> f64 {
    let mut sum = 0.0;
    for &t in solid.cells_at(v) {
        let sine = quality::min_sine(solid.tet(t).map(|w| if w == v { q } else { solid.point(w) }));
        if sine < floor {
            return f64::NEG_INFINITY;
        }
        sum += sine;
    }
    sum
}
