//! Vertex moves that lower the weighted cost of the cells around.

use super::super::super::solid::Solid;
use super::super::freedom::Freedom;
use super::super::rest_of;
use super::mean;
use super::weight::Weight;
use super::weighted::Fan;
use glam::{DMat3, DVec3};

/// A move must lower the cost of the cells around by this share.
const GAIN: f64 = 1e-3;

/// Collects the cells at `v`.
fn gather<W: Weight>(fan: &mut Fan<W>, solid: &Solid, weights: &[W], v: u32) {
    fan.clear();
    for &t in solid.cells_at(v) {
        let tet = solid.tet(t);
        fan.push(rest_of(tet, v).map(|w| solid.point(w)), mean(weights, tet));
    }
}

/// Where vertex `v` should move: one damped Newton step within its freedom, if that lowers the cost and leaves no cell
/// below `floor` that was not.
pub(super) fn better<W: Weight>(
    fan: &mut Fan<W>,
    solid: &Solid,
    weights: &[W],
    v: u32,
    freedom: Freedom,
    floor: f64,
) -> Option<DVec3> {
    gather(fan, solid, weights, v);
    let start = solid.point(v);
    let scale = shortest_edge(solid, v);
    let (cost, gradient, hessian) = model(fan, start, 1e-4 * scale);
    let gradient = freedom.project(gradient);
    let step = newton_step(hessian, gradient, scale, freedom);
    // A quadratic falls by half the slope along its Newton step.
    if -0.5 * gradient.dot(step) < GAIN * cost {
        return None;
    }
    let floor = floor.min(solid.worst_sine(solid.cells_at(v)));
    let steps = [1.0, 0.5, 0.25].map(|factor| start + factor * step);
    steps.into_iter().find(|p| {
        let (new, sine) = fan.cost_and_sine(*p);
        new < (1.0 - GAIN) * cost && sine >= floor
    })
}

fn shortest_edge(solid: &Solid, v: u32) -> f64 {
    let p = solid.point(v);
    let lengths = solid.cells_at(v).iter().flat_map(|&t| solid.tet(t)).filter(|&w| w != v);
    lengths.map(|w| (solid.point(w) - p).length_squared()).fold(f64::INFINITY, f64::min).sqrt()
}

/// The cost at `start`, its gradient, and its Hessian from differences of the gradient over the distance `h`.
fn model<W: Weight>(fan: &Fan<W>, start: DVec3, h: f64) -> (f64, DVec3, DMat3) {
    let [(cost, gradient), x, y, z] =
        fan.gradients([start, start + h * DVec3::X, start + h * DVec3::Y, start + h * DVec3::Z]);
    let hessian = DMat3::from_cols((x.1 - gradient) / h, (y.1 - gradient) / h, (z.1 - gradient) / h);
    (cost, gradient, (hessian + hessian.transpose()) * 0.5)
}

/// The Newton step within the freedom, the Hessian shifted until it is positive; at most `scale` long.
fn newton_step(hessian: DMat3, gradient: DVec3, scale: f64, freedom: Freedom) -> DVec3 {
    let blocked = freedom.complement();
    let free = DMat3::IDENTITY - blocked;
    let hessian = free * hessian * free;
    let trace = hessian.col(0).x + hessian.col(1).y + hessian.col(2).z;
    // Directions that are not free have no curvature: any positive one will do, for the gradient has no part in them.
    let fixed = blocked * trace.abs();
    for shift in [0.0, 0.1, 0.5, 2.0] {
        let shifted = hessian + fixed + DMat3::from_diagonal(DVec3::splat(shift * trace.abs()));
        if is_positive(shifted) {
            let step = freedom.project(-(shifted.inverse() * gradient));
            return step.clamp_length_max(scale);
        }
    }
    -gradient.normalize_or_zero() * (0.1 * scale)
}

/// Sylvester's criterion.
fn is_positive(m: DMat3) -> bool {
    let minor = m.col(0).x * m.col(1).y - m.col(0).y * m.col(1).x;
    m.col(0).x > 0.0 && minor > 0.0 && m.determinant() > 0.0
}
