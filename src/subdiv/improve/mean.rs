//! Vertex smoothing for the mean: a step along the gradient of the sum of the cells' smallest sines.

use super::super::solid::Solid;
use super::fan::Fan;
use super::freedom::Freedom;
use super::rest_of;
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
pub(super) fn better(fan: &mut Fan, solid: &Solid, v: u32, freedom: Freedom, floor: f64) -> Option<DVec3> {
    let p = solid.point(v);
    let cells = solid.cells_at(v);
    let (mut sum, mut scale) = (0.0, f64::INFINITY);
    for &t in cells {
        sum += solid.sine(t);
        let lengths = rest_of(solid.tet(t), v).map(|w| (solid.point(w) - p).length_squared());
        scale = lengths.into_iter().fold(scale, f64::min);
    }
    fan.gather(solid, v);
    let count = cells.len() as f64;
    let floor = floor.min(solid.worst_sine(cells));
    let direction = freedom.project(fan.gradient_of_sum(p)) / count;
    let slope = direction.length_squared();
    let mut t = STEP * scale;
    for _ in 0..=RETRIES {
        if slope * t < WORTH {
            return None;
        }
        let q = p + t * direction;
        if fan.sum_above(q, floor) > sum + KEEP * slope * t * count {
            return Some(q);
        }
        t *= SHORTER;
    }
    None
}
