//! The ten-node tetrahedron with straight edges: quadratic shape functions, `N_i = L_i (2 L_i - 1)` at vertices and
//! `N_ij = 4 L_i L_j` at the midpoints of edges, with L_i the barycentric coordinates of constant gradients g_i.

use super::tet4;
use crate::mesh::quality::EDGES;
use glam::{DMat3, DVec3};

/// The blocks of row `a` of the element stiffness, `int lambda G + mu G^T + mu tr(G) I dV` with `G = grad N_a (grad N_b)^T`,
/// for all ten nodes `b` (vertices, then edges in the order of [`EDGES`]), given `V lambda`, `V mu` and the gradients of the
/// barycentric coordinates.
///
/// With `int L_i L_j dV = V (1 + d_ij) / 20` and `int L_i dV = V / 4` each integral of G is a sum of one or two outer
/// products of gradients.
#[must_use]
pub fn stiffness_row(a: usize, lambda: f64, mu: f64, g: [DVec3; 4]) -> [DMat3; 10] {
    let block = |left: DVec3, right: DVec3| tet4::stiffness_block(lambda, mu, left, right);
    if a < 4 {
        return std::array::from_fn(|b| block(g[a], beside_vertex(a, b, g)));
    }
    let [i, j] = EDGES[a - 4];
    std::array::from_fn(|b| {
        if b < 4 {
            return block(beside_vertex(b, a, g), g[b]);
        }
        let [k, l] = EDGES[b - 4];
        let twice = |p: usize, q: usize| if p == q { 1.6 } else { 0.8 };
        let beside = |p: usize| twice(p, k) * g[l] + twice(p, l) * g[k];
        block(g[j], beside(i)) + block(g[i], beside(j))
    })
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
