//! The ten-node tetrahedron with straight edges: quadratic shape functions, `N_i = L_i (2 L_i - 1)` at vertices and
//! `N_ij = 4 L_i L_j` at the midpoints of edges, with L_i the barycentric coordinates of constant gradients g_i.

use crate::mesh::quality::EDGES;
use glam::{DMat3, DVec3};

/// `int grad N_a (grad N_b)^T dV` for node `a` and all ten nodes `b` (vertices, then edges in the order of [`EDGES`]), given
/// the volume and the gradients of the barycentric coordinates.
///
/// With `int L_i L_j dV = V (1 + d_ij) / 20` and `int L_i dV = V / 4` each is a sum of one or two outer products.
#[must_use]
pub fn gradient_products(a: usize, volume: f64, g: [DVec3; 4]) -> [DMat3; 10] {
    if a < 4 {
        let own = volume * g[a];
        return std::array::from_fn(|b| outer(own, beside_vertex(a, b, g)));
    }
    let [i, j] = EDGES[a - 4];
    let [own_i, own_j] = [volume * g[i], volume * g[j]];
    std::array::from_fn(|b| {
        if b < 4 {
            return outer(volume * beside_vertex(b, a, g), g[b]);
        }
        let [k, l] = EDGES[b - 4];
        let twice = |p: usize, q: usize| if p == q { 1.6 } else { 0.8 };
        let beside = |p: usize| twice(p, k) * g[l] + twice(p, l) * g[k];
        outer(own_j, beside(i)) + outer(own_i, beside(j))
    })
}

/// The 3x3 block of the stiffness between two nodes of which G is the integral of the product of gradients,
/// `lambda G + mu G^T + mu tr(G) I`.
#[must_use]
pub fn stiffness_block(lambda: f64, mu: f64, product: DMat3) -> DMat3 {
    let trace = product.x_axis.x + product.y_axis.y + product.z_axis.z;
    lambda * product + mu * product.transpose() + DMat3::from_diagonal(DVec3::splat(mu * trace))
}

/// `a b^T`.
#[must_use]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// `int (4 L_a - 1) grad N_b dV / V`: beside the gradient of vertex `a`'s coordinate what makes G for node `b`.
fn beside_vertex(a: usize, b: usize, g: [DVec3; 4]) -> DVec3 {
    let moment = |k: usize| if k == a { 0.6 } else { -0.2 };
    if b < 4 {
        return moment(b) * g[b];
    }
    let [i, j] = EDGES[b - 4];
    moment(i) * g[j] + moment(j) * g[i]
}

/// Gradients of the ten shape functions at barycentric coordinates.
#[must_use]
pub fn gradients(g: [DVec3; 4], l: [f64; 4]) -> [DVec3; 10] {
    std::array::from_fn(|a| {
        if a < 4 {
            return (4.0 * l[a] - 1.0) * g[a];
        }
        let [i, j] = EDGES[a - 4];
        4.0 * (l[i] * g[j] + l[j] * g[i])
    })
}
