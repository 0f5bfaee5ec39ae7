//! What is drawn of a step, before anything is left out.

use crate::fem::hexes::{HexSpace, Lattice};
use crate::fem::{Space, SymTensor};
use crate::mesh::TetMesh;
use crate::mesh::hex::FACES;
use crate::mesh::topology::{sorted3, tet_faces};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::borrow::Cow;

/// The values of a solution that are drawn: at points, and in elements.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// At points.
    pub displacement: &'a [DVec3],
    /// At points, recovered.
    pub stress: &'a [SymTensor],
    /// In elements: the estimated error in the energy norm.
    pub error: &'a [f64],
    /// In elements: the smallest angle between faces, in degrees.
    pub quality: &'a [f64],
    /// In elements: how often they were refined.
    pub level: &'a [u8],
}

/// Points of a mesh, its boundary faces and its cells.
#[derive(Debug)]
pub struct Shown<'a> {
    pub(super) points: Cow<'a, [DVec3]>,
    /// Points of the faces, `face_points` each: three corners, and the middles of the sides after each; or of quadrilaterals a
    /// square of points, row by row, counter-clockwise seen from outside.
    pub(super) faces: Vec<u32>,
    pub(super) face_points: usize,
    /// The cell of each face.
    pub(super) face_cells: Vec<u32>,
    /// The set of groups of each face, an index into `patches`.
    pub(super) face_patches: Vec<u32>,
    /// Groups of each set.
    pub(super) patches: Vec<Vec<u32>>,
    /// Points of the cells, `cell_points` each: four corners, or a cube of points, x fastest.
    pub(super) cells: Cow<'a, [u32]>,
    pub(super) cell_points: usize,
}

impl<'a> Shown<'a> {
    /// A mesh of tetrahedra with the nodes of its elements.
    #[must_use]
    pub fn tetrahedra(space: &'a Space<'_>) -> Self {
        let mesh = space.mesh();
        let face_points = if space.midside().is_empty() { 3 } else { 6 };
        Self {
            points: Cow::Borrowed(space.points()),
            faces: mesh.faces().iter().flat_map(|f| space.face(f)).collect(),
            face_points,
            face_cells: owners(mesh),
            face_patches: mesh.faces().iter().map(|f| f.patch.0).collect(),
            patches: mesh.patch_groups().iter().map(|groups| groups.iter().map(|g| g.0).collect()).collect(),
            cells: Cow::Borrowed(mesh.tets().as_flattened()),
            cell_points: 4,
        }
    }

    /// A mesh of hexahedra at the points of a lattice.
    #[must_use]
    pub fn hexahedra(space: &HexSpace<'_>, lattice: &'a Lattice) -> Self {
        let (mesh, side) = (space.mesh(), lattice.order + 1);
        let cell_points = side.pow(3);
        let owners: Vec<(usize, usize)> = (0..mesh.faces().len()).map(|f| space.cell_of_face(f)).collect();
        let face = |&(t, k): &(usize, usize)| {
            let own = &lattice.cells[cell_points * t..][..cell_points];
            face_places(lattice.order, k).map(|q| own[q]).collect::<Vec<u32>>()
        };
        Self {
            points: Cow::Owned(lattice.places(space)),
            faces: owners.iter().flat_map(face).collect(),
            face_points: side * side,
            face_cells: owners.iter().map(|(t, _)| *t as u32).collect(),
            face_patches: mesh.faces().iter().map(|f| f.patch.0).collect(),
            patches: mesh.patch_groups().iter().map(|groups| groups.iter().map(|g| g.0).collect()).collect(),
            cells: Cow::Borrowed(&lattice.cells),
            cell_points,
        }
    }

    pub(super) fn cell_count(&self) -> usize {
        self.cells.len() / self.cell_points
    }

    /// Whether cells are tetrahedra.
    pub(super) fn is_tetrahedral(&self) -> bool {
        self.cell_points == 4
    }

    /// Steps of the lattice along a side of a face.
    pub(super) fn order(&self) -> usize {
        match self.face_points {
            3 => 1,
            6 => 2,
            n => n.isqrt() - 1,
        }
    }
}

/// The cell of each boundary face. Few cells have three vertices on the boundary: only these are looked at closely.
fn owners(mesh: &TetMesh) -> Vec<u32> {
    let mut outside = vec![false; mesh.points().len()];
    mesh.faces().iter().flat_map(|f| f.vertices).for_each(|v| outside[v as usize] = true);
    let numbers: FxHashMap<[u32; 3], u32> = mesh.faces().iter().map(|f| sorted3(f.vertices)).zip(0..).collect();
    let near = |(t, cell): (usize, &[u32; 4])| {
        (cell.iter().filter(|v| outside[**v as usize]).count() > 2).then_some((t as u32, *cell))
    };
    let near: Vec<(u32, [u32; 4])> = mesh.tets().par_iter().enumerate().filter_map(near).collect();
    let mut owners = vec![0; mesh.faces().len()];
    for (t, cell) in near {
        for face in tet_faces(cell) {
            if let Some(&f) = numbers.get(&sorted3(face)) {
                owners[f as usize] = t;
            }
        }
    }
    owners
}

/// Places in a cell's lattice of the points of its face `k`, counter-clockwise seen from outside, row by row.
pub(super) fn face_places(order: usize, k: usize) -> impl Iterator<Item = usize> {
    let side = order + 1;
    let corner = |c: usize| [c & 1, c >> 1 & 1, c >> 2].map(|b| b as i64);
    let [a, b, _, d] = FACES[k].map(corner);
    (0..side * side).map(move |q| {
        let (i, j) = ((q % side) as i64, (q / side) as i64);
        let at: [i64; 3] = std::array::from_fn(|x| a[x] * order as i64 + i * (b[x] - a[x]) + j * (d[x] - a[x]));
        at[0] as usize + side * (at[1] as usize + side * at[2] as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Space;
    use crate::mesh::generate::box_tets;
    use crate::mesh::topology::boundary_cells;

    #[test]
    fn faces_know_their_cells() {
        let mesh = box_tets([1.0; 3], [3; 3]).unwrap();
        assert_eq!(Shown::tetrahedra(&Space::linear(&mesh)).face_cells, boundary_cells(mesh.tets()));
    }

    #[test]
    fn faces_of_a_lattice_have_the_corners_of_the_cell_in_order() {
        for (order, k) in [(1, 0), (2, 3), (3, 5)] {
            let places: Vec<usize> = face_places(order, k).collect();
            let side = order + 1;
            let corners = [0, order, side * side - 1, side * order].map(|q| places[q]);
            let of = |c: usize| [c & 1, c >> 1 & 1, c >> 2].map(|b| b * order);
            let expected = FACES[k].map(of).map(|[x, y, z]| x + side * (y + side * z));
            assert_eq!(corners, expected);
        }
    }
}
