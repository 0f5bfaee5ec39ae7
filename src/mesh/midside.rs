//! Curved edges: places of mid-side nodes, and the quadratic map of a ten-node tetrahedron.

use super::quality::EDGES;
use glam::DVec3;

/// The node on an edge of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Midside {
    /// The vertices of the edge, sorted.
    pub edge: [u32; 2],
    /// Where the node lies.
    pub position: DVec3,
}

/// The quadratic map `x(L) = sum_a N_a(L) x_a` of a ten-node tetrahedron (vertices, then edges in the order of [`EDGES`]) at
/// barycentric coordinates: a sixth of its Jacobian determinant, which for straight edges is the volume, and the gradients
/// of the four barycentric coordinates.
#[must_use]
pub fn quadratic_frame(x: &[DVec3; 10], l: [f64; 4]) -> (f64, [DVec3; 4]) {
    // dx / dL_k, the L taken as independent.
    let along: [DVec3; 4] = std::array::from_fn(|k| {
        let edges = EDGES.iter().zip(&x[4..]).filter(|(e, _)| e.contains(&k));
        let bend: DVec3 = edges.map(|([i, j], x)| 4.0 * l[i + j - k] * *x).sum();
        (4.0 * l[k] - 1.0) * x[k] + bend
    });
    let [a, b, c] = [1, 2, 3].map(|k| along[k] - along[0]);
    let determinant = a.dot(b.cross(c));
    let [ga, gb, gc] = [b.cross(c), c.cross(a), a.cross(b)].map(|n| n / determinant);
    (determinant / 6.0, [-(ga + gb + gc), ga, gb, gc])
}

/// The smallest Jacobian determinant (over six) of a ten-node tetrahedron, of those at the points of the cubic lattice.
#[must_use]
pub fn smallest_jacobian(x: &[DVec3; 10]) -> f64 {
    let mut smallest = f64::INFINITY;
    for i in 0..4_u8 {
        for j in 0..4 - i {
            for k in 0..4 - i - j {
                let l = [i, j, k, 3 - i - j - k].map(|n| f64::from(n) / 3.0);
                smallest = smallest.min(quadratic_frame(x, l).0);
            }
        }
    }
    smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ten-node cell whose edges follow a smooth map.
    fn bent(map: impl Fn(DVec3) -> DVec3) -> [DVec3; 10] {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        std::array::from_fn(|a| {
            let straight = if a < 4 { corners[a] } else { corners[EDGES[a - 4][0]].midpoint(corners[EDGES[a - 4][1]]) };
            map(straight)
        })
    }

    #[test]
    fn the_frame_of_a_quadratic_map_is_its_derivative() {
        // Quadratic, so that the cell's map is this one, with barycentric coordinates (1 - x - y - z, x, y, z).
        let map = |p: DVec3| p + DVec3::new(0.2 * p.y * p.z, 0.1 * p.x * p.x, -0.15 * p.x * p.y);
        let derivative = |p: DVec3| {
            glam::DMat3::from_cols(
                DVec3::new(1.0, 0.2 * p.x, -0.15 * p.y),
                DVec3::new(0.2 * p.z, 1.0, -0.15 * p.x),
                DVec3::new(0.2 * p.y, 0.0, 1.0),
            )
        };
        for p in [DVec3::new(0.1, 0.2, 0.3), DVec3::ZERO, DVec3::X] {
            let (volume, g) = quadratic_frame(&bent(map), [1.0 - p.element_sum(), p.x, p.y, p.z]);
            let inverse = derivative(p).inverse();
            assert!((6.0 * volume - derivative(p).determinant()).abs() < 1e-14);
            for (k, g) in g[1..].iter().enumerate() {
                assert!((*g - inverse.row(k)).length() < 1e-14, "{k} at {p}");
            }
            assert!(g.iter().sum::<DVec3>().length() < 1e-14);
        }
    }

    #[test]
    fn a_cell_folded_by_one_node_has_a_negative_jacobian() {
        let mut cell = bent(|p| p);
        assert!((smallest_jacobian(&cell) - 1.0 / 6.0).abs() < 1e-15);
        cell[4] = DVec3::new(0.8, 0.0, 0.0);
        assert!(smallest_jacobian(&cell) < 0.0);
    }
}
