//! Red refinement (Bey): one cell into eight, the inner octahedron cut along its shortest diagonal.

use super::{History, Info, Refined, Stencil};
use crate::mesh::{Crease, Face, MeshError, RegionId, TetMesh, TetMeshParts, quality, topology};
use glam::DVec3;

/// Refines all cells.
///
/// # Errors
/// [`MeshError::Inconsistent`] if not every cell is selected: red refinement alone has no closure.
pub(super) fn refine(mesh: &TetMesh, selected: &[bool]) -> Result<Refined, MeshError> {
    if selected.iter().any(|s| !s) {
        let message = "red refinement refines all cells or none: use strategy \"global\", or another scheme";
        return Err(MeshError::Inconsistent(message.to_owned()));
    }
    let edges = topology::edges(mesh.tets());
    let midpoints = Midpoints { first: mesh.points().len() as u32, edges: &edges };
    let old = mesh.points();
    let transfer = edges.iter().map(|e| Stencil::mean(e)).collect();
    let midpoint = |e: &[u32; 2]| 0.5 * (old[e[0] as usize] + old[e[1] as usize]);
    let points: Vec<DVec3> = old.iter().copied().chain(edges.iter().map(midpoint)).collect();

    let eightfold = |count: usize| Vec::with_capacity(8 * count);
    let (mut tets, mut regions, mut levels) = (eightfold(mesh.tets().len()), Vec::<RegionId>::new(), Vec::<u8>::new());
    for (t, &tet) in mesh.tets().iter().enumerate() {
        tets.extend(split_cell(tet, &midpoints, &points));
        regions.extend([mesh.regions()[t]; 8]);
        levels.extend([mesh.levels()[t] + 1; 8]);
    }
    let faces = mesh.faces().iter().flat_map(|f| split_face(f, &midpoints)).collect();
    let creases = mesh.creases().iter().flat_map(|c| split_crease(c, &midpoints)).collect();
    let worst_sine = worst_sine(&points, &tets);
    let parts = TetMeshParts { points, tets, regions, levels, faces, creases, ..mesh.clone().into_parts() };
    let info = Info { asked: selected.len(), split: selected.len(), worst_sine, ..Info::default() };
    Ok(Refined { mesh: TetMesh::new(parts)?, transfer, history: History::default(), info, frames: Vec::new() })
}

/// Smallest minimum sine of the cells.
fn worst_sine(points: &[DVec3], tets: &[[u32; 4]]) -> f64 {
    tets.iter().map(|t| quality::min_sine(t.map(|v| points[v as usize]))).fold(f64::INFINITY, f64::min)
}

/// Numbers of the edge midpoints.
struct Midpoints<'a> {
    first: u32,
    edges: &'a [[u32; 2]],
}

impl Midpoints<'_> {
    /// The vertex halfway between `a` and `b`, which are the ends of an edge of the mesh.
    fn of(&self, a: u32, b: u32) -> u32 {
        let key = topology::sorted2([a, b]);
        // Edges are collected from the very cells, faces and creases that are looked up here.
        let index = self.edges.binary_search(&key).unwrap_or_else(|_| unreachable!("edge {key:?} is not in the mesh"));
        self.first + index as u32
    }
}

/// Four corner cells and four around the shortest diagonal of the octahedron of midpoints.
fn split_cell([a, b, c, d]: [u32; 4], mid: &Midpoints, points: &[DVec3]) -> [[u32; 4]; 8] {
    let [ab, ac, ad] = [mid.of(a, b), mid.of(a, c), mid.of(a, d)];
    let [bc, bd, cd] = [mid.of(b, c), mid.of(b, d), mid.of(c, d)];
    // Each diagonal with the ring of the other four midpoints, ordered so that (p, q, r_i, r_i+1) is positive.
    let diagonals = [(ab, cd, [ac, ad, bd, bc]), (ac, bd, [ab, bc, cd, ad]), (ad, bc, [ab, ac, cd, bd])];
    let squared = |p: u32, q: u32| (points[p as usize] - points[q as usize]).length_squared();
    let mut best = diagonals[0];
    for candidate in &diagonals[1..] {
        if squared(candidate.0, candidate.1) < squared(best.0, best.1) {
            best = *candidate;
        }
    }
    let (p, q, r) = best;
    let around = |i: usize| [p, q, r[i], r[(i + 1) % 4]];
    [[a, ab, ac, ad], [ab, b, bc, bd], [ac, bc, c, cd], [ad, bd, cd, d], around(0), around(1), around(2), around(3)]
}

fn split_face(face: &Face, mid: &Midpoints) -> [Face; 4] {
    let [a, b, c] = face.vertices;
    let [ab, bc, ca] = [mid.of(a, b), mid.of(b, c), mid.of(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(|vertices| Face { vertices, ..*face })
}

fn split_crease(crease: &Crease, mid: &Midpoints) -> [Crease; 2] {
    let [a, b] = crease.vertices;
    let m = mid.of(a, b);
    [[a, m], [b, m]].map(|ends| Crease { vertices: topology::sorted2(ends), ..*crease })
}
