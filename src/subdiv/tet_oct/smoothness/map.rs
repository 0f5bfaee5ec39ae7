//! Characteristic maps: the three leading eigenvectors as coordinates.

use super::super::{refine_with_rows, split_linearly};
use super::reference::Reference;
use crate::mesh::tet_oct::{OCT_FACES, TetOctMesh, TetOctParts};
use crate::mesh::{RegionId, quality};
use glam::DVec3;
use nalgebra::{DMatrix, DVector};

/// The cells around a place of the control mesh at the values of the leading eigenvectors, which are its control points, and
/// what subdivision makes of them.
///
/// Halving the distance to the place scales the coordinates by the eigenvalues. So the limit is that of an annulus, repeated at all
/// scales: here of what the second layer of control cells becomes, between the distances 1 and 2. The cells next to the place itself
/// are the control cells scaled, whatever the number of steps.
#[derive(Debug, Clone)]
pub struct CharacteristicMap {
    /// The cells after one step.
    pub mesh: TetOctMesh,
    /// The annulus after 0, 1, ... steps: after 4, if cells are still inverted but ever fewer, what is near these alone.
    pub annulus: Vec<Annulus>,
}

/// The cells between two distances from the place.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Annulus {
    /// The worst shape of the tetrahedra and of the cones of the octahedra's faces over their centroids: the volume over that of
    /// a regular tetrahedron with the longest edge. Positive if none is inverted.
    pub worst: f64,
    /// The part of them that is inverted.
    pub inverted: f64,
}

/// Steps of subdivision after which all of an annulus is looked at, and most steps where cells are inverted.
const STEPS: usize = 4;
const MOST_STEPS: usize = 8;

/// Layers of cells around inverted ones that are subdivided further.
const NEAR: usize = 3;

/// The inverted part, relative to that one step before, from which on it stays.
const STAYS: f64 = 0.5;

/// Cells with a shape below this have no volume but for rounding.
const NO_VOLUME: f64 = 1e-12;

/// Layers of cells, kept as regions: these follow subdivision, which looks at surfaces between them alone.
const AT_THE_PLACE: RegionId = RegionId(0);
const ANNULUS: RegionId = RegionId(1);
const BEYOND: RegionId = RegionId(2);

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
    /// What the last steps left of the annulus.
    #[must_use]
    pub fn finest(&self) -> Annulus {
        self.annulus.last().copied().unwrap_or(Annulus { worst: f64::NAN, inverted: 1.0 })
    }

    /// Whether no cell of the annulus is inverted after all steps. Control cells may be where their limit is not.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        self.finest().inverted == 0.0
    }

    /// Whether the last step left the inverted part much as it was.
    #[must_use]
    pub fn folds(&self) -> bool {
        let before = self.annulus.len().checked_sub(2).map_or(0.0, |i| self.annulus[i].inverted);
        self.finest().inverted > STAYS * before
    }

    /// The map with these values at the vertices of `support`, three rings around the vertex `middle`.
    pub(super) fn new(reference: &Reference, middle: u32, support: &[u32], values: &[DVec3]) -> Self {
        let mut places = vec![None; reference.mesh.points().len()];
        support.iter().zip(values).for_each(|(&v, &z)| places[v as usize] = Some(z));
        let complete = (0..places.len()).map(|v| reference.ring(v).iter().all(|&w| places[w as usize].is_some()));
        let complete: Vec<bool> = complete.collect();
        let start = at_places(&in_layers(reference, middle), &places);
        let kept = |v: &usize| places[*v].is_some();
        let mut complete: Vec<bool> = (0..places.len()).filter(kept).map(|v| complete[v]).collect();
        let mut levels = vec![start];
        for step in 0..STEPS {
            let (finer, follows) = refined(&levels[step], &complete);
            levels.push(finer);
            complete = follows;
        }
        // The sign of an eigenvector is free.
        let sign = volume(&levels[STEPS]).signum();
        let annulus = levels.iter().map(|mesh| annulus(mesh, sign)).collect();
        let finest = levels.pop();
        let once = levels.swap_remove(1);
        let points = once.points().iter().map(|p| *p * sign).collect();
        let mut map = Self { mesh: once.with_points(points), annulus };
        if let Some(finest) = finest {
            map.follow(finest, complete, sign);
        }
        map
    }

    /// Subdivides what is near inverted cells, until none is, or their part stays.
    fn follow(&mut self, mut mesh: TetOctMesh, mut complete: Vec<bool>, sign: f64) {
        let mut all = pieces(&mesh).count() as f64;
        while !self.is_regular() && !self.folds() && self.annulus.len() <= MOST_STEPS {
            let (near, kept) = near_inverted(&mesh, &complete, sign);
            (mesh, complete) = refined(&near, &kept);
            all *= 8.0;
            let found = annulus(&mesh, sign);
            let part = pieces(&mesh).count() as f64 / all;
            self.annulus.push(Annulus { inverted: found.inverted * part, ..found });
        }
    }
}

/// The cells near the inverted ones, and at which of their vertices no cell is missing.
fn near_inverted(mesh: &TetOctMesh, complete: &[bool], sign: f64) -> (TetOctMesh, Vec<bool>) {
    let at = |v: u32| mesh.points()[v as usize];
    let parts = mesh.parts();
    let mut near = vec![false; complete.len()];
    for (t, _) in parts.tets.iter().zip(&parts.tet_regions).filter(|(_, layer)| **layer == ANNULUS) {
        if shape(t.map(at), sign) <= NO_VOLUME {
            t.iter().for_each(|&v| near[v as usize] = true);
        }
    }
    for (o, _) in parts.octs.iter().zip(&parts.oct_regions).filter(|(_, layer)| **layer == ANNULUS) {
        if cones(o.map(at)).into_iter().any(|cone| shape(cone, sign) <= NO_VOLUME) {
            o.iter().for_each(|&v| near[v as usize] = true);
        }
    }
    for _ in 0..NEAR {
        let before = near.clone();
        let cells = parts.tets.iter().map(|t| &t[..]).chain(parts.octs.iter().map(|o| &o[..]));
        for cell in cells.filter(|cell| cell.iter().any(|&v| before[v as usize])) {
            cell.iter().for_each(|&v| near[v as usize] = true);
        }
    }
    let places: Vec<Option<DVec3>> = mesh.points().iter().zip(&near).map(|(p, near)| near.then_some(*p)).collect();
    let mut whole = complete.to_vec();
    let cells = parts.tets.iter().map(|t| &t[..]).chain(parts.octs.iter().map(|o| &o[..]));
    for cell in cells.filter(|cell| cell.iter().any(|&v| !near[v as usize])) {
        cell.iter().for_each(|&v| whole[v as usize] = false);
    }
    let kept = whole.iter().zip(&near).filter(|(_, near)| **near).map(|(whole, _)| *whole).collect();
    (at_places(mesh, &places), kept)
}

/// The mesh of the reference with its cells in layers around a vertex.
fn in_layers(reference: &Reference, middle: u32) -> TetOctMesh {
    let near = reference.ring(middle as usize);
    let layer = |cell: &[u32]| match cell {
        cell if cell.contains(&middle) => AT_THE_PLACE,
        cell if cell.iter().any(|v| near.binary_search(v).is_ok()) => ANNULUS,
        _ => BEYOND,
    };
    let parts = reference.mesh.parts();
    TetOctMesh::refined(TetOctParts {
        tet_regions: parts.tets.iter().map(|t| layer(t)).collect(),
        oct_regions: parts.octs.iter().map(|o| layer(o)).collect(),
        ..parts.clone()
    })
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
    let parts = mesh.parts();
    let (tets, tet_regions) = of_places(&parts.tets, &parts.tet_regions, number);
    let (octs, oct_regions) = of_places(&parts.octs, &parts.oct_regions, number);
    TetOctMesh::refined(TetOctParts { points, tets, octs, tet_regions, oct_regions, ..TetOctParts::default() })
}

/// The cells all of whose vertices have a number, and their regions.
fn of_places<const N: usize>(
    cells: &[[u32; N]],
    regions: &[RegionId],
    number: impl Fn(u32) -> u32,
) -> (Vec<[u32; N]>, Vec<RegionId>) {
    let numbered = cells.iter().map(|cell| cell.map(&number)).zip(regions.iter().copied());
    numbered.filter(|(cell, _)| !cell.contains(&u32::MAX)).unzip()
}

/// The tetrahedra of the annulus, and the cones of the faces of its octahedra over their centroids.
fn pieces(mesh: &TetOctMesh) -> impl Iterator<Item = [DVec3; 4]> + '_ {
    let at = |v: u32| mesh.points()[v as usize];
    let parts = mesh.parts();
    let tets = parts.tets.iter().zip(&parts.tet_regions).filter(|(_, layer)| **layer == ANNULUS);
    let octs = parts.octs.iter().zip(&parts.oct_regions).filter(|(_, layer)| **layer == ANNULUS);
    tets.map(move |(t, _)| t.map(at)).chain(octs.flat_map(move |(o, _)| cones(o.map(at))))
}

/// The cones of the faces of an octahedron over its centroid.
fn cones(p: [DVec3; 6]) -> [[DVec3; 4]; 8] {
    let centroid = p.iter().sum::<DVec3>() / 6.0;
    OCT_FACES.map(|[i, j, k]| [centroid, p[i], p[j], p[k]])
}

/// The volume over that of a regular tetrahedron with the longest edge.
fn shape(p: [DVec3; 4], sign: f64) -> f64 {
    let longest = quality::EDGES.iter().map(|&[i, j]| p[i].distance(p[j])).fold(0.0, f64::max);
    sign * quality::volume(p) * 6.0 * 2.0_f64.sqrt() / longest.powi(3)
}

fn volume(mesh: &TetOctMesh) -> f64 {
    pieces(mesh).map(quality::volume).sum()
}

fn annulus(mesh: &TetOctMesh, sign: f64) -> Annulus {
    let (mut worst, mut inverted, mut count) = (f64::INFINITY, 0, 0);
    for shape in pieces(mesh).map(|p| shape(p, sign)) {
        worst = worst.min(shape);
        inverted += usize::from(shape <= NO_VOLUME);
        count += 1;
    }
    Annulus { worst, inverted: inverted as f64 / count.max(1) as f64 }
}
