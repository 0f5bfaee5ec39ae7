//! Vertex moves that lower the weighted cost of the cells around.

use super::super::super::solid::Solid;
use super::super::freedom::Freedom;
use super::cost::{cost_and_gradient, cost_and_sine};
use glam::{DMat3, DVec3};

/// A move must lower the cost of the cells around by this share.
const GAIN: f64 = 1e-3;

/// Cells at a vertex: the vertex itself first, the others in an order that keeps the cell positive, and a weight.
struct Fan {
    cells: Vec<([DVec3; 3], f64)>,
}

impl Fan {
    fn new(solid: &Solid, weights: &[f64], v: u32) -> Self {
        let cells = solid.cells_at(v).iter().map(|&t| {
            let tet = solid.tet(t);
            let rest = super::super::rest_of(tet, v);
            (rest.map(|w| solid.point(w)), super::weight(weights, tet))
        });
        Self { cells: cells.collect() }
    }

    /// Weighted cost and gradient with the vertex at `p`; `None` if a cell is not positive.
    fn evaluate(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let mut sum = (0.0, DVec3::ZERO);
        for &([a, b, c], weight) in &self.cells {
            let (value, gradient) = cost_and_gradient([p, a, b, c])?;
            sum = (sum.0 + weight * value, sum.1 + weight * gradient);
        }
        Some(sum)
    }

    /// True if with the vertex at `p` the weighted cost is below `bound` and no sine below `floor`.
    fn is_better(&self, p: DVec3, bound: f64, floor: f64) -> bool {
        let mut sum = 0.0;
        for &([a, b, c], weight) in &self.cells {
            match cost_and_sine([p, a, b, c]) {
                Some((cost, sine)) if sine >= floor => sum += weight * cost,
                _ => return false,
            }
            if sum >= bound {
                return false;
            }
        }
        true
    }
}

/// Where vertex `v` should move: one damped Newton step within its freedom, if that lowers the cost and leaves no cell
/// below `floor` that was not.
pub(super) fn better(solid: &Solid, weights: &[f64], v: u32, freedom: Freedom, floor: f64) -> Option<DVec3> {
    let fan = Fan::new(solid, weights, v);
    let start = solid.point(v);
    let (cost, gradient) = fan.evaluate(start)?;
    let gradient = freedom.project(gradient);
    let scale = fan.cells.iter().map(|(c, _)| (c[0] - start).length_squared()).fold(f64::INFINITY, f64::min).sqrt();
    let step = newton_step(&fan, start, gradient, scale, freedom);
    // A quadratic falls by half the slope along its Newton step.
    if -0.5 * gradient.dot(step) < GAIN * cost {
        return None;
    }
    let floor = floor.min(solid.worst_sine(solid.cells_at(v)));
    let steps = [1.0, 0.5, 0.25].map(|factor| start + factor * step);
    steps.into_iter().find(|p| fan.is_better(*p, (1.0 - GAIN) * cost, floor))
}

/// The Newton step with the Hessian from differences of the gradient, shifted until it is positive; at most `scale` long.
fn newton_step(fan: &Fan, start: DVec3, gradient: DVec3, scale: f64, freedom: Freedom) -> DVec3 {
    let h = 1e-4 * scale;
    let column = |axis: DVec3| {
        let direction = freedom.project(axis);
        fan.evaluate(start + h * direction).map(|(_, g)| (freedom.project(g) - gradient) / h)
    };
    let steepest = -gradient.normalize_or_zero() * (0.1 * scale);
    let (Some(a), Some(b), Some(c)) = (column(DVec3::X), column(DVec3::Y), column(DVec3::Z)) else { return steepest };
    let hessian = DMat3::from_cols(a, b, c);
    let hessian = (hessian + hessian.transpose()) * 0.5;
    let trace = hessian.col(0).x + hessian.col(1).y + hessian.col(2).z;
    // Directions that are not free have no curvature: any positive one will do, for the gradient has no part in them.
    let fixed = freedom.complement() * trace.abs();
    for shift in [0.0, 0.1, 0.5, 2.0] {
        let shifted = hessian + fixed + DMat3::from_diagonal(DVec3::splat(shift * trace.abs()));
        if is_positive(shifted) {
            let step = freedom.project(-(shifted.inverse() * gradient));
            return step.clamp_length_max(scale);
        }
    }
    steepest
}

/// Sylvester's criterion.
fn is_positive(m: DMat3) -> bool {
    let minor = m.col(0).x * m.col(1).y - m.col(0).y * m.col(1).x;
    m.col(0).x > 0.0 && minor > 0.0 && m.determinant() > 0.0
}
