//! What a cell costs: the expected interpolation error of a random quadratic on it, and its gradient.
//!
//! Let q be a quadratic with a random Hessian H whose entries satisfy `E[H_ij H_kl] = d_ik d_jl + d_il d_jk` (no
//! direction is preferred), and I q its linear interpolant at the vertices. On a tetrahedron with centroid c, volume V,
//! edges e, barycentric gradients g_k and y_k = x_k - c,
//!
//! `E int |grad(q - I q)|^2 = V/20 sum_e |e|^2 + V/2 sum_kl (g_k . g_l) (y_k . y_l)^2`:
//!
//! the first term is the part that varies linearly in the cell, the second the error of the interpolant's constant
//! gradient. It scales with length^5, and grows without bound when the cell flattens.

use crate::mesh::quality::face_normals;
use glam::DVec3;

/// The cost of the tetrahedron; infinite unless its volume is positive.
pub fn cost(x: [DVec3; 4]) -> f64 {
    Shape::new(x).map_or(f64::INFINITY, |shape| shape.cost())
}

/// The cost and the minimum sine of the dihedral angles; `None` unless the volume is positive.
pub(crate) fn cost_and_sine(x: [DVec3; 4]) -> Option<(f64, f64)> {
    let shape = Shape::new(x)?;
    let squares = shape.normals.map(DVec3::length_squared);
    // sin = 6 V |e| / (|N_k| |N_l|) at the edge between the faces k and l.
    let ratio = |i: usize, j: usize, k: usize, l: usize| (x[j] - x[i]).length_squared() / (squares[k] * squares[l]);
    let least = ratio(0, 1, 2, 3)
        .min(ratio(0, 2, 1, 3))
        .min(ratio(0, 3, 1, 2))
        .min(ratio(1, 2, 0, 3))
        .min(ratio(1, 3, 0, 2))
        .min(ratio(2, 3, 0, 1));
    Some((shape.cost(), 6.0 * shape.volume * least.sqrt()))
}

/// The cost and its gradient with respect to the first vertex; `None` unless the volume is positive.
pub(crate) fn cost_and_gradient(x: [DVec3; 4]) -> Option<(f64, DVec3)> {
    let shape = Shape::new(x)?;
    Some((shape.cost(), shape.gradient(x)))
}

/// What cost and gradient have in common.
struct Shape {
    volume: f64,
    /// Outward normals of the faces opposite to the vertices, of twice the area: g_k = -N_k / (6 V).
    normals: [DVec3; 4],
    /// y_k = x_k - c.
    arms: [DVec3; 4],
    /// y_k . y_l.
    products: [[f64; 4]; 4],
    /// Sum of the squared edge lengths, = 4 sum_k |y_k|^2.
    edges: f64,
    /// sum_kl (N_k . N_l) (y_k . y_l)^2.
    constant: f64,
}

impl Shape {
    fn new(x: [DVec3; 4]) -> Option<Self> {
        let normals = face_normals(x);
        let volume = normals[3].dot(x[0] - x[3]) / 6.0;
        if volume.is_nan() || volume <= 0.0 {
            return None;
        }
        let centre = 0.25 * (x[0] + x[1] + x[2] + x[3]);
        let arms = x.map(|p| p - centre);
        let products = arms.map(|a| arms.map(|b| a.dot(b)));
        let edges = 4.0 * (0..4).map(|k| products[k][k]).sum::<f64>();
        let pair = |k: usize, l: usize| normals[k].dot(normals[l]) * products[k][l] * products[k][l];
        let diagonal: f64 = (0..4).map(|k| pair(k, k)).sum();
        let rest = pair(0, 1) + pair(0, 2) + pair(0, 3) + pair(1, 2) + pair(1, 3) + pair(2, 3);
        Some(Self { volume, normals, arms, products, edges, constant: diagonal + 2.0 * rest })
    }

    fn cost(&self) -> f64 {
        self.volume * self.edges / 20.0 + self.constant / (72.0 * self.volume)
    }

    /// By the product rule, with dV = -N_0 . dx / 6, dN_k = (w - u) x dx for the face (x_0, u, w), dy_0 = 3/4 dx and
    /// dy_k = -1/4 dx else.
    fn gradient(&self, x: [DVec3; 4]) -> DVec3 {
        let Self { volume, normals, arms, products, edges, constant } = self;
        let volume_gradient = -normals[0] / 6.0;
        let edges_gradient = 8.0 * arms[0];
        let shares = [0.75, -0.25, -0.25, -0.25];
        // sum_l (y_k . y_l)^2 N_l
        let pulls: [DVec3; 4] = std::array::from_fn(|k| {
            (0..4).fold(DVec3::ZERO, |sum, l| sum + products[k][l] * products[k][l] * normals[l])
        });
        let turning = pulls[1].cross(x[2] - x[3]) + pulls[2].cross(x[3] - x[1]) + pulls[3].cross(x[1] - x[2]);
        let stretching = (0..4).fold(DVec3::ZERO, |sum, l| {
            let factor: f64 = (0..4).map(|k| shares[k] * normals[k].dot(normals[l]) * products[k][l]).sum();
            sum + factor * arms[l]
        });
        let constant_gradient = 2.0 * turning + 4.0 * stretching;
        (volume_gradient * *edges + *volume * edges_gradient) / 20.0
            + (constant_gradient - volume_gradient * (constant / volume)) / (72.0 * volume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: [DVec3; 4] =
        [DVec3::new(-0.2, 0.1, 0.05), DVec3::new(1.0, 0.1, 0.2), DVec3::new(0.3, 1.1, -0.1), DVec3::new(0.2, 0.4, 0.9)];

    /// Integral of |grad(q - I q)|^2 for q = x.H.x / 2 by a rule exact for quadratics.
    fn exact_error(x: [DVec3; 4], h: glam::DMat3) -> f64 {
        let shape = Shape::new(x).unwrap();
        let value = |p: DVec3| 0.5 * p.dot(h * p);
        let interpolant = (0..4).fold(DVec3::ZERO, |g, k| g - shape.normals[k] / (6.0 * shape.volume) * value(x[k]));
        let (a, b) = ((5.0 + 3.0 * 5.0_f64.sqrt()) / 20.0, (5.0 - 5.0_f64.sqrt()) / 20.0);
        let at = |k: usize| (0..4).fold(DVec3::ZERO, |p, l| p + if k == l { a } else { b } * x[l]);
        (0..4).map(|k| shape.volume / 4.0 * (h * at(k) - interpolant).length_squared()).sum()
    }

    #[test]
    fn the_cost_is_the_mean_error_over_random_hessians() {
        // The expectation of a quadratic form in H is its sum over an orthonormal basis of covariance: the diagonal
        // entries have variance 2, the others 1.
        let mut expected = 0.0;
        for i in 0..3 {
            for j in i..3 {
                let mut h = glam::DMat3::ZERO;
                h.col_mut(j)[i] = 1.0;
                h.col_mut(i)[j] = 1.0;
                expected += if i == j { 2.0 } else { 1.0 } * exact_error(CELL, h);
            }
        }
        assert!((cost(CELL) / expected - 1.0).abs() < 1e-12, "{} {expected}", cost(CELL));
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let (value, gradient) = cost_and_gradient(CELL).unwrap();
        assert!((value - cost(CELL)).abs() < 1e-15);
        let moved = |d: DVec3| cost([CELL[0] + d, CELL[1], CELL[2], CELL[3]]);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = (moved(1e-6 * axis) - moved(-1e-6 * axis)) / 2e-6;
            assert!((slope - gradient.dot(axis)).abs() < 1e-7 * gradient.length().max(1.0));
        }
    }

    #[test]
    fn flat_and_inverted_cells_are_infinitely_bad_and_scaling_is_by_the_fifth_power() {
        let [a, b, c, d] = CELL;
        assert!(cost([b, a, c, d]).is_infinite());
        assert!(cost([a, b, c, a + 0.3 * (b - a) + 0.3 * (c - a)]).is_infinite() || cost([a, b, c, a]).is_infinite());
        assert!((cost(CELL.map(|p| 3.0 * p)) / cost(CELL) / 243.0 - 1.0).abs() < 1e-12);
    }
}
