//! The ten-node tetrahedron with straight edges: quadratic shape functions, `N_i = L_i (2 L_i - 1)` at vertices and
//! `N_ij = 4 L_i L_j` at the midpoints of edges, with L_i the barycentric coordinates of constant gradients g_i.

use crate::mesh::quality::EDGES;
use glam::{DMat3, DVec3};

/// `int grad N_a (grad N_b)^T dV / V` for node `a` and all ten nodes `b`: vertices, then edges in the order of [`EDGES`].
///
/// From the moments `int L_i L_j dV = V (1 + d_ij) / 20` and `int L_i dV = V / 4`.
#[must_use]
pub fn gradient_products(a: usize, g: [DVec3; 4]) -> [DMat3; 10] {
    // grad N_a = sum_k (4 L_k - s) c_k, with one or two terms.
    let own = terms(a, g);
    std::array::from_fn(|b| {
        let mut sum = DMat3::ZERO;
        for (k, c, s) in own {
            // int (sum_m (4 L_m - r) d_m) (4 L_k - s) dV / V
            let row: DVec3 = terms(b, g).into_iter().map(|(m, d, r)| moment(k, m, s, r) * d).sum();
            sum += outer(c, row);
        }
        sum
    })
}

/// The 3x3 block of the element stiffness between two nodes of which G is the integral of the product of gradients:
/// `lambda G + mu G^T + mu tr(G) I`.
#[must_use]
pub fn stiffness_block(lambda: f64, mu: f64, product: DMat3) -> DMat3 {
    let trace = product.x_axis.x + product.y_axis.y + product.z_axis.z;
    lambda * product + mu * product.transpose() + DMat3::from_diagonal(DVec3::splat(mu * trace))
}

/// `int (4 L_k - s) (4 L_m - r) dV / V`.
fn moment(k: usize, m: usize, s: f64, r: f64) -> f64 {
    let squares = if k == m { 1.6 } else { 0.8 };
    squares - s - r + s * r
}

/// The gradient of shape function `a` as `sum (4 L_k - s) c`; entries (k, c, s).
fn terms(a: usize, g: [DVec3; 4]) -> [(usize, DVec3, f64); 2] {
    if a < 4 {
        [(a, g[a], 1.0), (a, DVec3::ZERO, 1.0)]
    } else {
        let [i, j] = EDGES[a - 4];
        [(i, g[j], 0.0), (j, g[i], 0.0)]
    }
}

/// `a b^T`.
#[must_use]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Gradients of the ten shape functions at barycentric coordinates.
#[must_use]
pub fn gradients(g: [DVec3; 4], l: [f64; 4]) -> [DVec3; 10] {
    std::array::from_fn(|a| terms(a, g).into_iter().map(|(k, c, s)| (4.0 * l[k] - s) * c).sum())
}
