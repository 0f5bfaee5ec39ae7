//! Characteristic maps: the three leading eigenvectors as coordinates.

use super::super::{refine_with_rows, split_linearly};
use super::reference::Reference;
use crate::mesh::quality;
use crate::mesh::tet_oct::{OCT_FACES, TetOctMesh, TetOctParts};
use glam::DVec3;
use nalgebra::{DMatrix, DVector};

/// The cells around a place of the control mesh at the values of the leading eigenvectors, which are its control points, and
/// what subdivision makes of them.
#[derive(Debug, Clone)]
pub struct CharacteristicMap {
    /// The cells after one step.
    pub mesh: TetOctMesh,
    /// The worst shape of the tetrahedra and of the cones of the octahedra's faces over their centroids after 0, 1 and 2 steps:
    /// the volume over that of a regular tetrahedron with the longest edge. Positive if none is inverted.
    pub worst: [f64; 3],
}

/// Continues an eigenvector from `inner` vertices, on which those values depend alone, to all of the support of `matrix`.
pub(super) fn extended(matrix: &DMatrix<f64>, inner: &[usize], values: &[f64], eigenvalue: f64) -> Vec<f64> {
    let outer: Vec<usize> = (0..matrix.nrows()).filter(|i| !inner.contains(i)).collect();
    let own = DMatrix::from_fn(outer.len(), outer.len(), |i, j| {
        f64::from(u8::from(i == j)) * eigenvalue - matrix[(outer[i], outer[j])]
    });
    let load =
        DVector::from_fn(outer.len(), |i, _| inner.iter().zip(values).map(|(&j, z)| matrix[(outer[i], j)] * z).sum());
    let mut all = vec![f64::NAN; matrix.nrows()];
    inner.iter().zip(values).for_each(|(&i, &z)| all[i] = z);
    if let Some(solution) = own.lu().solve(&load) {
        outer.iter().zip(solution.iter()).for_each(|(&i, &z)| all[i] = z);
    }
    all
}

impl CharacteristicMap {
    /// Whether no cell is inverted after two steps. Control cells may be where their limit is not.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        self.worst[2] > 0.0
    }

    /// The map with these values at the vertices of `support`.
    pub(super) fn new(reference: &Reference, support: &[u32], values: &[DVec3]) -> Self {
        let mut places = vec![None; reference.mesh.points().len()];
        support.iter().zip(values).for_each(|(&v, &z)| places[v as usize] = Some(z));
        let complete = (0..places.len()).map(|v| reference.ring(v).iter().all(|&w| places[w as usize].is_some()));
        let complete: Vec<bool> = complete.collect();
        let mut start = at_places(&reference.mesh, &places);
        if start.volume() < 0.0 {
            // The sign of an eigenvector is free.
            start = start.with_points(start.points().iter().map(|p| -*p).collect());
        }
        let kept = |v: &usize| places[*v].is_some();
        let complete: Vec<bool> = (0..places.len()).filter(kept).map(|v| complete[v]).collect();
        let (once, complete) = refined(&start, &complete);
        let (twice, _) = refined(&once, &complete);
        let worst = [&start, &once, &twice].map(worst_shape);
        Self { mesh: once, worst }
    }
}

/// One step of a part of a mesh, of which `complete` says at which vertices no cell is missing: what follows from it, and where that
/// is complete.
fn refined(mesh: &TetOctMesh, complete: &[bool]) -> (TetOctMesh, Vec<bool>) {
    let (fine, rows) = refine_with_rows(mesh);
    let (_, parents) = split_linearly(mesh);
    // No cell is missing at the middle of an edge if none is at one of its ends, nor inside an octahedron.
    let is_complete = |i: usize| {
        let mut parents = parents.row(i).map(|(v, _)| complete[v as usize]);
        parents.len() > 2 || parents.any(|c| c)
    };
    let fine_complete: Vec<bool> = (0..rows.rows()).map(is_complete).collect();
    let places: Vec<Option<DVec3>> =
        fine.points().iter().zip(&fine_complete).map(|(p, complete)| complete.then_some(*p)).collect();
    let part = at_places(&fine, &places);
    // Of the vertices that follow, those whose cells all follow.
    let mut whole = fine_complete.clone();
    let cells = fine.tets().iter().map(|t| &t[..]).chain(fine.octs().iter().map(|o| &o[..]));
    for cell in cells.filter(|cell| cell.iter().any(|&v| !fine_complete[v as usize])) {
        cell.iter().for_each(|&v| whole[v as usize] = false);
    }
    let kept = whole.iter().zip(&fine_complete).filter(|(_, follows)| **follows).map(|(whole, _)| *whole).collect();
    (part, kept)
}

/// The cells all of whose vertices have a place.
fn at_places(mesh: &TetOctMesh, places: &[Option<DVec3>]) -> TetOctMesh {
    let mut numbers = vec![u32::MAX; places.len()];
    let mut points = Vec::new();
    for (number, place) in numbers.iter_mut().zip(places) {
        if let Some(place) = place {
            *number = points.len() as u32;
            points.push(*place);
        }
    }
    let number = |v: u32| numbers[v as usize];
    let tets: Vec<[u32; 4]> = mesh.tets().iter().map(|t| t.map(number)).filter(|t| !t.contains(&u32::MAX)).collect();
    let octs: Vec<[u32; 6]> = mesh.octs().iter().map(|o| o.map(number)).filter(|o| !o.contains(&u32::MAX)).collect();
    TetOctMesh::refined(TetOctParts { points, tets, octs, ..TetOctParts::default() })
}

fn worst_shape(mesh: &TetOctMesh) -> f64 {
    let at = |v: u32| mesh.points()[v as usize];
    let shape = |p: [DVec3; 4]| {
        let longest = quality::EDGES.iter().map(|&[i, j]| p[i].distance(p[j])).fold(0.0, f64::max);
        quality::volume(p) * 6.0 * 2.0_f64.sqrt() / longest.powi(3)
    };
    let tets = mesh.tets().iter().map(|t| shape(t.map(at)));
    let octs = mesh.octs().iter().flat_map(|o| {
        let p = o.map(at);
        let centroid = p.iter().sum::<DVec3>() / 6.0;
        OCT_FACES.map(|[i, j, k]| shape([centroid, p[i], p[j], p[k]]))
    });
    tets.chain(octs).fold(f64::INFINITY, f64::min)
}
