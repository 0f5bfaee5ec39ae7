//! A mesh that looks the same at all scales around a place, and the matrices of subdivision there.

use super::super::{WeightRows, refine_with_rows, split_linearly};
use crate::mesh::tet_oct::{TetOctMesh, TetOctParts};
use glam::DVec3;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// How often the base cells are split linearly first.
const LEVELS: u32 = 3;

/// Denominator of the places of the split mesh.
pub(super) const UNITS: i32 = 1 << LEVELS;

/// A place by its barycentric numerators over the base vertices, all of them; zero for most.
pub(super) type Place = Vec<i32>;

/// Base tetrahedra split linearly until the mesh is uniform but across their faces, edges and vertices, and one step of
/// subdivision of that. Vertices of both meshes are identified by their linear places, whatever smoothing does.
#[derive(Debug)]
pub(super) struct Reference {
    /// The split mesh; its points are not used.
    pub mesh: TetOctMesh,
    /// The vertices of the mesh one step later as combinations of those of `mesh`.
    rows: WeightRows,
    /// The places of the vertices of `mesh`, in units of 1/8 of a base edge.
    pub places: Vec<Place>,
    numbers: BTreeMap<Place, u32>,
    /// The vertices of the mesh one step later at their places, in units of 1/16.
    fine_numbers: BTreeMap<Place, u32>,
    /// The vertices of cells at each vertex, itself among them, ascending.
    rings: Vec<Vec<u32>>,
}

impl Reference {
    /// That of base tetrahedra over `vertices` vertices, positively oriented.
    pub fn new(vertices: usize, tets: Vec<[u32; 4]>) -> Self {
        let mut places: Vec<Place> =
            (0..vertices).map(|v| (0..vertices).map(|w| i32::from(v == w)).collect()).collect();
        let parts =
            TetOctParts { points: vec![DVec3::ZERO; vertices], tet_regions: vec![], tets, ..TetOctParts::default() };
        // Neither surfaces nor regions: all masks are those of the inside.
        let mut mesh = TetOctMesh::refined(parts);
        for _ in 0..LEVELS {
            let (split, rows) = split_linearly(&mesh);
            places = refined(&places, &rows);
            mesh = split;
        }
        let fine_places = refined(&places, &split_linearly(&mesh).1);
        let (_, rows) = refine_with_rows(&mesh);
        let numbered = |places: &[Place]| places.iter().cloned().zip(0..).collect();
        let (numbers, fine_numbers) = (numbered(&places), numbered(&fine_places));
        let rings = rings(&mesh);
        Self { mesh, rows, places, numbers, fine_numbers, rings }
    }

    /// The vertex at a place.
    pub fn at(&self, place: &Place) -> u32 {
        self.numbers[place]
    }

    /// The vertices of the cells at a vertex, ascending.
    pub fn ring(&self, v: usize) -> &[u32] {
        &self.rings[v]
    }

    /// The vertices of the cells that have `least` of some vertices or more, ascending.
    pub fn of_cells_at(&self, vertices: &[u32], least: usize) -> Vec<u32> {
        let cells = self.mesh.tets().iter().map(|t| &t[..]).chain(self.mesh.octs().iter().map(|o| &o[..]));
        let at = |cell: &&[u32]| cell.iter().filter(|v| vertices.contains(v)).count() >= least;
        let mut found: Vec<u32> = cells.filter(at).flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// What lies within `steps` cells of some vertices, ascending.
    pub fn around(&self, vertices: &[u32], steps: usize) -> Vec<u32> {
        let mut found = vertices.to_vec();
        for _ in 0..steps {
            found = found.iter().flat_map(|&v| &self.rings[v as usize]).copied().collect();
            found.sort_unstable();
            found.dedup();
        }
        found
    }

    /// The square matrix of one step on the values at `support`, where the finer vertices are identified with those of the
    /// support twice as far from the `centre`.
    ///
    /// # Panics
    /// If the values there depend on others.
    pub fn matrix(&self, support: &[u32], centre: &Place) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(support.len(), support.len());
        for (i, &v) in support.iter().enumerate() {
            for (column, weight) in self.rows.row(self.halfway(v, centre) as usize) {
                let j = support.binary_search(&column);
                matrix[(i, j.unwrap_or_else(|_| unreachable!("the support is not closed")))] = weight;
            }
        }
        matrix
    }

    /// The finer vertex halfway between a vertex and the centre.
    fn halfway(&self, v: u32, centre: &Place) -> u32 {
        let place: Place = self.places[v as usize].iter().zip(centre).map(|(a, b)| a + b).collect();
        self.fine_numbers[&place]
    }
}

/// The places of new vertices, in units half as long.
fn refined(places: &[Place], rows: &WeightRows) -> Vec<Place> {
    let place = |i: usize| {
        let mut place = vec![0.0; places[0].len()];
        for (v, weight) in rows.row(i) {
            place.iter_mut().zip(&places[v as usize]).for_each(|(sum, x)| *sum += 2.0 * weight * f64::from(*x));
        }
        // Middles, and centroids of octahedra, which are middles of their diagonals here: whole numbers but for rounding.
        place.into_iter().map(|x| x.round() as i32).collect()
    };
    (0..rows.rows()).map(place).collect()
}

fn rings(mesh: &TetOctMesh) -> Vec<Vec<u32>> {
    let mut rings = vec![Vec::new(); mesh.points().len()];
    let cells = mesh.tets().iter().map(|t| &t[..]).chain(mesh.octs().iter().map(|o| &o[..]));
    for cell in cells {
        cell.iter().for_each(|&v| rings[v as usize].extend_from_slice(cell));
    }
    for ring in &mut rings {
        ring.sort_unstable();
        ring.dedup();
    }
    rings
}
