//! Feature edges of a surface as it is drawn.

use super::shown::Shown;
use glam::DVec3;
use rayon::prelude::*;
use smallvec::{SmallVec, smallvec};

/// A side of a face: its ends, the face, and which of its sides.
type Side = ([u32; 2], u32, u8);

/// Points of a side; few, so that none is put on the heap.
type Row = SmallVec<[u32; 8]>;

/// The lines where the boundary turns by more than an angle in degrees, each a row of `order + 1` points.
pub(super) fn features(shown: &Shown<'_>, angle: f64) -> Vec<u32> {
    let sides = if shown.is_tetrahedral() { 3 } else { 4 };
    let faces = shown.faces.len() / shown.face_points;
    let mut all: Vec<Side> = Vec::with_capacity(sides * faces);
    for f in 0..faces {
        for s in 0..sides {
            let [a, b] = ends(shown, f, s);
            all.push(([a.min(b), a.max(b)], f as u32, s as u8));
        }
    }
    all.par_sort_unstable();
    let sharpest = angle.to_radians().cos();
    let mut lines = Vec::new();
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        let normal = |&(_, f, s): &Side| normal(shown, f as usize, s as usize);
        let is_sharp = match same {
            [a, b] => normal(a).dot(normal(b)) < sharpest,
            _ => true,
        };
        if is_sharp {
            lines.extend(side(shown, same[0].1 as usize, same[0].2 as usize).0);
        }
    }
    lines
}

/// The ends of a side.
fn ends(shown: &Shown<'_>, face: usize, side: usize) -> [u32; 2] {
    let own = &shown.faces[shown.face_points * face..][..shown.face_points];
    let order = shown.order();
    if shown.is_tetrahedral() {
        return [own[side], own[(side + 1) % 3]];
    }
    let corners = [own[0], own[order], own[own.len() - 1], own[own.len() - 1 - order]];
    [corners[side], corners[(side + 1) % 4]]
}

/// The points of a side, and those that face it: the opposite corner, or the next row of a square.
fn side(shown: &Shown<'_>, face: usize, side: usize) -> (Row, Row) {
    let own = &shown.faces[shown.face_points * face..][..shown.face_points];
    let (next, order) = ((side + 1) % 3, shown.order());
    let rows = order + 1;
    let at = |i: usize, j: usize| own[i + rows * j];
    let square = |line: &dyn Fn(usize, usize) -> u32| -> (Row, Row) {
        ((0..rows).map(|i| line(i, 0)).collect(), (0..rows).map(|i| line(i, 1)).collect())
    };
    match (shown.face_points, side) {
        (3, _) => (smallvec![own[side], own[next]], smallvec![own[(side + 2) % 3]]),
        (6, _) => (smallvec![own[side], own[3 + side], own[next]], smallvec![own[(side + 2) % 3]]),
        (_, 0) => square(&|i, d| at(i, d)),
        (_, 1) => square(&|i, d| at(order - d, i)),
        (_, 2) => square(&|i, d| at(order - i, order - d)),
        _ => square(&|i, d| at(d, order - i)),
    }
}

/// The unit normal of a face in the middle of a side.
fn normal(shown: &Shown<'_>, face: usize, s: usize) -> DVec3 {
    let (line, inner) = side(shown, face, s);
    let at = |v: u32| shown.points[v as usize];
    let i = (line.len() - 1) / 2;
    let [a, b] = [at(line[i]), at(line[i + 1])];
    let inward = match inner[..] {
        [v] => at(v),
        _ => at(inner[i]).midpoint(at(inner[i + 1])),
    };
    (b - a).cross(inward - a.midpoint(b)).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Space;
    use crate::fem::hexes::{HexSpace, Lattice};
    use crate::fem::options::{Element, HexElement, HexOptions};
    use crate::mesh::generate::box_tets;
    use crate::mesh::hex::generate::box_hexes;

    /// The length of the lines.
    fn length(shown: &Shown<'_>, angle: f64) -> f64 {
        let lines = features(shown, angle);
        let at = |v: u32| shown.points[v as usize];
        let line = |row: &[u32]| row.windows(2).map(|ends| at(ends[0]).distance(at(ends[1]))).sum::<f64>();
        lines.chunks_exact(shown.order() + 1).map(line).sum()
    }

    #[test]
    fn the_features_of_a_box_are_its_twelve_edges() {
        let mesh = box_tets([1.0, 2.0, 3.0], [2, 2, 3]).unwrap();
        let hexes = box_hexes([1.0, 2.0, 3.0], [2, 2, 3]).unwrap();
        for element in [Element::Tet4, Element::Tet10] {
            let space = Space::new(&mesh, element, &[]);
            assert!((length(&Shown::tetrahedra(&space), 40.0) - 24.0).abs() < 1e-12);
            assert!(length(&Shown::tetrahedra(&space), 100.0) < 1e-12);
        }
        for order in 1..4 {
            let space = HexSpace::new(&hexes, HexElement::Hex8, HexOptions::default());
            let lattice = Lattice::new(&space, order);
            assert!((length(&Shown::hexahedra(&space, &lattice), 40.0) - 24.0).abs() < 1e-12);
        }
    }
}
