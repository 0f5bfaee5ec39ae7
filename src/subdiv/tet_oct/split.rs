//! The connectivity of a mesh after each cell has been split.
//!
//! A tetrahedron becomes four at its corners and an octahedron on the middles of its edges; an octahedron becomes six at its
//! vertices and eight tetrahedra between its centroid and the middles of its faces' edges.

use crate::mesh::tet_oct::{CellEdges, OCT_EDGES, OCT_FACES, TetOctMesh, TetOctParts};
use crate::mesh::topology::sorted2;
use crate::mesh::{Crease, Face};
use glam::DVec3;
use rayon::prelude::*;

/// The split mesh at these points: old vertices keep their numbers, then come those of edges, then those of octahedra. The
/// cells of one kind come in the order of their parents, first those of tetrahedra, then those of octahedra.
pub(super) fn split(mesh: &TetOctMesh, edges: &CellEdges, points: Vec<DVec3>) -> TetOctMesh {
    let old = mesh.parts();
    let split = Split { mesh, edges, first: old.points.len() as u32 };
    let middle = |ends: [u32; 2]| edges.find(ends).map_or(u32::MAX, |e| split.first + e);
    let face = |[a, b, c]: [u32; 3]| {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(middle);
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let (tets, octs) = split.cells();
    let halves = |crease: &Crease| {
        let middle = split.first + edges.find(crease.vertices)?;
        Some(crease.vertices.map(|v| Crease { vertices: sorted2([v, middle]), ..*crease }))
    };
    TetOctMesh::refined(TetOctParts {
        points,
        tets,
        octs,
        tet_regions: children(&old.tet_regions, 4, &old.oct_regions, 8),
        oct_regions: children(&old.tet_regions, 1, &old.oct_regions, 6),
        level: old.level.saturating_add(1),
        faces: old.faces.iter().flat_map(|f| face(f.vertices).map(|vertices| Face { vertices, ..*f })).collect(),
        interfaces: old.interfaces.iter().flat_map(|f| face(*f)).collect(),
        creases: old.creases.iter().filter_map(halves).flatten().collect(),
        corners: old.corners.clone(),
        region_names: old.region_names.clone(),
        groups: old.groups.clone(),
        patches: old.patches.clone(),
    })
}

/// The tags of the children of tetrahedra and octahedra.
fn children<T: Copy>(tets: &[T], of_tet: usize, octs: &[T], of_oct: usize) -> Vec<T> {
    let mut tags = Vec::with_capacity(of_tet * tets.len() + of_oct * octs.len());
    tets.iter().for_each(|t| tags.extend(std::iter::repeat_n(*t, of_tet)));
    octs.iter().for_each(|t| tags.extend(std::iter::repeat_n(*t, of_oct)));
    tags
}

struct Split<'a> {
    mesh: &'a TetOctMesh,
    edges: &'a CellEdges,
    /// The vertex of the first edge.
    first: u32,
}

/// How many cells a thread takes at a time.
const PIECE: usize = 1 << 11;

impl Split<'_> {
    fn cells(&self) -> (Vec<[u32; 4]>, Vec<[u32; 6]>) {
        let (of_tets, of_octs) = (self.mesh.tets().len(), self.mesh.octs().len());
        let mut tets = vec![[0; 4]; 4 * of_tets + 8 * of_octs];
        let mut octs = vec![[0; 6]; of_tets + 6 * of_octs];
        let (corner_tets, face_tets) = tets.split_at_mut(4 * of_tets);
        let (inner_octs, corner_octs) = octs.split_at_mut(of_tets);
        let corners = corner_tets.par_chunks_mut(4).zip(inner_octs).enumerate().with_min_len(PIECE);
        corners.for_each(|(t, (tets, oct))| self.tetrahedron(t, tets, oct));
        let around = face_tets.par_chunks_mut(8).zip(corner_octs.par_chunks_mut(6)).enumerate().with_min_len(PIECE);
        around.for_each(|(o, (tets, octs))| self.octahedron(o, tets, octs));
        (tets, octs)
    }

    fn tetrahedron(&self, t: usize, tets: &mut [[u32; 4]], oct: &mut [u32; 6]) {
        let [a, b, c, d] = self.mesh.tets()[t];
        let [ab, ac, ad, bc, bd, cd] = self.edges.of_tet(t).map(|e| self.first + e);
        tets.copy_from_slice(&[[a, ab, ac, ad], [ab, b, bc, bd], [ac, bc, c, cd], [ad, bd, cd, d]]);
        *oct = [ab, cd, ac, bd, bc, ad];
    }

    fn octahedron(&self, o: usize, tets: &mut [[u32; 4]], octs: &mut [[u32; 6]]) {
        let own = self.mesh.octs()[o];
        let centre = self.first + (self.edges.all().len() + o) as u32;
        let mut middles = [[0; 6]; 6];
        for ([i, j], e) in OCT_EDGES.into_iter().zip(self.edges.of_oct(o)) {
            middles[i][j] = self.first + e;
            middles[j][i] = self.first + e;
        }
        for (i, child) in octs.iter_mut().enumerate() {
            // The cell scaled by half about its vertex: the opposite vertex goes to the centroid.
            *child = middles[i];
            (child[i], child[i ^ 1]) = (own[i], centre);
        }
        for (child, [i, j, k]) in tets.iter_mut().zip(OCT_FACES) {
            *child = [centre, middles[i][j], middles[j][k], middles[k][i]];
        }
    }
}
