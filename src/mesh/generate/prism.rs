//! Regular prisms: any number of wedges around one axis.

use super::{MAX_CELLS, tagged_mesh};
use crate::mesh::{MeshError, TetMesh, quality};
use glam::DVec3;
use std::f64::consts::TAU;

/// A prism about the z axis from z = 0 whose ends are regular polygons of `sides` corners at distance `radius`, the first
/// on the x axis: `sides` wedges meet at the axis, so that its inner vertices have that valence in each layer. `cells` are
/// the rings around the axis and the layers along it; every triangle between rings carries a column of prisms of three
/// tetrahedra each. Groups "side", "z-min", "z-max".
///
/// # Errors
/// [`MeshError::Generator`] if there are fewer than three sides, a measure is not positive and finite, or a number of
/// cells is zero or too large.
pub fn prism(sides: usize, radius: f64, length: f64, cells: [usize; 2]) -> Result<TetMesh, MeshError> {
    let refuse = |problem: String| Err(MeshError::Generator(format!("the prism: {problem}")));
    for (what, x) in [("radius", radius), ("length", length)] {
        if !(x > 0.0 && x.is_finite()) {
            return refuse(format!("the {what} is {x}, it must be positive"));
        }
    }
    let [rings, layers] = cells;
    if sides < 3 || rings == 0 || layers == 0 {
        return refuse(format!("{sides} sides, {cells:?} cells: it needs three sides, a ring and a layer at least"));
    }
    let product = [3, sides, rings, rings, layers].into_iter().try_fold(1_usize, usize::checked_mul);
    if product.is_none_or(|tets| tets > MAX_CELLS) {
        return refuse(format!("{sides} sides with {cells:?} cells are more than {MAX_CELLS} tetrahedra"));
    }
    let polygon = Polygon { sides, rings };
    let points: Vec<DVec3> = (0..=layers)
        .flat_map(|k| polygon.points(radius).map(move |p| p.with_z(length * k as f64 / layers as f64)))
        .collect();
    let level = polygon.first(rings + 1) as u32;
    let triangles = polygon.triangles();
    let tets =
        (0..layers as u32).flat_map(|k| triangles.iter().flat_map(move |t| column(t.map(|v| v + k * level), level)));
    let positive = |tet: [u32; 4]| {
        let [a, b, c, d] = tet;
        if quality::volume(tet.map(|v| points[v as usize])) < 0.0 { [a, b, d, c] } else { tet }
    };
    let tets: Vec<[u32; 4]> = tets.map(positive).collect();
    let rim = polygon.first(rings) as u32;
    let top = layers as u32 * level;
    tagged_mesh(
        "the prism",
        points,
        tets,
        &[("z-min", &|v| v < level), ("z-max", &|v| v >= top), ("side", &|v| v % level >= rim)],
    )
}

/// The three tetrahedra of the prism over a triangle. Each side of it is cut from its lowest number, so that neighbours
/// match.
fn column(bottom: [u32; 3], level: u32) -> [[u32; 4]; 3] {
    let mut bottom = bottom;
    bottom.sort_unstable();
    let [a, b, c] = bottom;
    let [d, e, f] = bottom.map(|v| v + level);
    [[a, b, c, f], [a, b, f, e], [a, e, f, d]]
}

/// A regular polygon cut into triangles: ring 0 is the centre, ring i has i points a side.
#[derive(Clone, Copy)]
struct Polygon {
    sides: usize,
    rings: usize,
}

impl Polygon {
    /// Number of the first point of a ring; of the last ring but one, the number of points.
    fn first(self, ring: usize) -> usize {
        if ring == 0 { 0 } else { 1 + self.sides * ring * (ring - 1) / 2 }
    }

    /// The point `step` steps around a ring from the x axis.
    fn number(self, ring: usize, step: usize) -> u32 {
        (self.first(ring) + if ring == 0 { 0 } else { step % (self.sides * ring) }) as u32
    }

    fn points(self, radius: f64) -> impl Iterator<Item = DVec3> {
        let corner = move |side: usize| {
            let (sin, cos) = (TAU * (side % self.sides) as f64 / self.sides as f64).sin_cos();
            radius * DVec3::new(cos, sin, 0.0)
        };
        let ring = move |i: usize| {
            let share = i as f64 / self.rings as f64;
            (0..self.sides).flat_map(move |side| {
                (0..i).map(move |step| share * corner(side).lerp(corner(side + 1), step as f64 / i as f64))
            })
        };
        [DVec3::ZERO].into_iter().chain((1..=self.rings).flat_map(ring))
    }

    fn triangles(self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.sides * self.rings * self.rings);
        for ring in 1..=self.rings {
            for side in 0..self.sides {
                let outer = |step: usize| self.number(ring, side * ring + step);
                let inner = |step: usize| self.number(ring - 1, side * (ring - 1) + step);
                for step in 0..ring {
                    triangles.push([outer(step), outer(step + 1), inner(step)]);
                    if step > 0 {
                        triangles.push([inner(step - 1), outer(step), inner(step)]);
                    }
                }
            }
        }
        triangles
    }
}
