//! Curved edges: places of mid-side nodes, and the quadratic map of a ten-node tetrahedron.

use super::TetMesh;
use super::quality::EDGES;
use super::topology::sorted2;
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

/// A lower bound of the Jacobian determinant (over six) of a ten-node tetrahedron: positive where the smallest Bernstein
/// coefficient is, for the determinant is a cubic polynomial and lies between its coefficients; where that does not decide,
/// the smallest value on a fine lattice.
#[must_use]
pub fn smallest_jacobian(x: &[DVec3; 10]) -> f64 {
    let at = |l: [f64; 4]| quadratic_frame(x, l).0;
    let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
    let corner: [f64; 4] = std::array::from_fn(|k| at(unit(k)));
    // The coefficients that lie at thirds of an edge, by its two ends, from the values there.
    let thirds = |i: usize, j: usize| {
        let value = |near: usize| {
            at(std::array::from_fn(|k| {
                if k == near {
                    2.0 / 3.0
                } else if k == i + j - near {
                    1.0 / 3.0
                } else {
                    0.0
                }
            }))
        };
        let coefficient = |near: usize, far: usize| {
            (18.0 * value(near) - 9.0 * value(far) - 5.0 * corner[near] + 2.0 * corner[far]) / 6.0
        };
        [coefficient(i, j), coefficient(j, i)]
    };
    let edges = EDGES.map(|[i, j]| thirds(i, j));
    let faces = std::array::from_fn(|k: usize| {
        let value = at(std::array::from_fn(|i| if i == k { 0.0 } else { 1.0 / 3.0 }));
        let corners: f64 = corner.iter().sum::<f64>() - corner[k];
        let sides: f64 = EDGES.iter().zip(&edges).filter(|(e, _)| !e.contains(&k)).map(|(_, c)| c[0] + c[1]).sum();
        (27.0 * value - corners - 3.0 * sides) / 6.0
    });
    let all = corner.iter().chain(edges.iter().flatten()).chain::<&[f64; 4]>(&faces);
    let least = all.copied().fold(f64::INFINITY, f64::min);
    if least > 0.0 { least } else { lattice(FINE).map(at).fold(f64::INFINITY, f64::min) }
}

/// The cells of a mesh whose Jacobian determinant is not positive everywhere, each with its smallest value over its straight
/// volume; `curved` are the nodes of the curved edges, sorted by edge.
#[must_use]
pub fn folded(mesh: &TetMesh, curved: &[Midside]) -> Vec<(f64, usize)> {
    let position = |edge: [u32; 2]| {
        let [p, q] = edge.map(|v| mesh.points()[v as usize]);
        curved.binary_search_by_key(&edge, |m| m.edge).map_or(p.midpoint(q), |k| curved[k].position)
    };
    let smallest = |tet: &[u32; 4]| {
        smallest_jacobian(&std::array::from_fn(|a| match a {
            0..4 => mesh.points()[tet[a] as usize],
            _ => position(sorted2(EDGES[a - 4].map(|i| tet[i]))),
        }))
    };
    let cells = mesh.tets().iter().map(smallest).enumerate().filter(|(_, j)| j.is_nan() || *j <= 0.0);
    cells.map(|(t, j)| (j / mesh.cell_volume(t), t)).collect()
}

/// Divisions of an edge in the lattice that decides where Bernstein coefficients do not.
const FINE: u8 = 12;

/// The points of a cell whose barycentric coordinates are multiples of `1 / n`.
fn lattice(n: u8) -> impl Iterator<Item = [f64; 4]> {
    let all = (0..=n)
        .flat_map(move |i| (0..=n - i).flat_map(move |j| (0..=n - i - j).map(move |k| [i, j, k, n - i - j - k])));
    all.map(move |l| l.map(|m| f64::from(m) / f64::from(n)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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

    proptest! {
        /// Whatever the edges, the bound is below the determinant anywhere, if it is positive.
        #[test]
        fn a_positive_bound_holds_inside(shifts in prop::array::uniform18(-0.15_f64..0.15), l in prop::array::uniform4(0.0_f64..1.0)) {
            let mut cell = bent(|p| p);
            for (k, x) in cell[4..].iter_mut().enumerate() {
                *x += DVec3::new(shifts[3 * k], shifts[3 * k + 1], shifts[3 * k + 2]);
            }
            let sum: f64 = l.iter().sum();
            prop_assume!(sum > 0.1);
            let inside = quadratic_frame(&cell, l.map(|l| l / sum)).0;
            let bound = smallest_jacobian(&cell);
            prop_assert!(bound <= 0.0 || bound <= inside + 1e-15, "{bound} {inside}");
            prop_assert!(inside > 0.0 || bound <= 0.01);
        }
    }
}
