//! The connectivity of a mesh after each cell has been split into eight.

use crate::mesh::hex::{FACES, HexMesh, HexTopology, QuadFace};
use crate::mesh::{Crease, hex};

/// The refined cells: vertices keep their numbers, then come the points of edges, faces and cells.
#[derive(Debug, Clone)]
pub struct Split {
    /// Cell `8 t + c` is the child of cell `t` at its corner `c`, with parallel axes.
    pub cells: Vec<[u32; 8]>,
    vertices: u32,
    edges: u32,
}

/// The place of a child's corner in its parent: coordinates 0, 1 or 2 (halves of the parent's edge).
#[must_use]
pub fn child_lattice(child: usize, corner: usize) -> [usize; 3] {
    std::array::from_fn(|axis| (child >> axis & 1) + (corner >> axis & 1))
}

impl Split {
    /// Splits cells over `vertices` vertices.
    #[must_use]
    pub fn new(cells: &[[u32; 8]], topology: &HexTopology, vertices: usize) -> Self {
        let counts = Self { cells: Vec::new(), vertices: vertices as u32, edges: topology.edges().len() as u32 };
        let middles = counts.face_point(topology.faces().len() as u32);
        let mut children = Vec::with_capacity(8 * cells.len());
        for (t, cell) in cells.iter().enumerate() {
            let point = |at: [usize; 3]| match at.iter().filter(|x| **x == 1).count() {
                0 => cell[corner_at(at)],
                1 => counts.edge_point(topology.cell_edges()[t][edge_at(at)]),
                2 => counts.face_point(topology.cell_faces()[t][face_at(at)]),
                _ => middles + t as u32,
            };
            children.extend((0..8).map(|c| std::array::from_fn::<u32, 8, _>(|d| point(child_lattice(c, d)))));
        }
        Self { cells: children, ..counts }
    }

    /// The new point of an edge.
    #[must_use]
    pub fn edge_point(&self, edge: u32) -> u32 {
        self.vertices + edge
    }

    /// The new point of a face.
    #[must_use]
    pub fn face_point(&self, face: u32) -> u32 {
        self.vertices + self.edges + face
    }

    /// The boundary faces after the split.
    pub(super) fn faces(&self, mesh: &HexMesh) -> Vec<QuadFace> {
        let topology = mesh.topology();
        let mut faces = Vec::with_capacity(4 * mesh.faces().len());
        for ((f, vertices), face) in topology.boundary().zip(mesh.faces()) {
            let edges = topology.face_edges()[f as usize].map(|e| self.edge_point(e));
            let quad = |i: usize| [vertices[i], edges[i], self.face_point(f), edges[(i + 3) % 4]];
            faces.extend((0..4).map(|i| QuadFace { vertices: quad(i), patch: face.patch }));
        }
        faces
    }

    /// The halves of the creases.
    pub(super) fn creases(&self, mesh: &HexMesh) -> Vec<Crease> {
        let halves = |crease: &Crease| {
            let edge = mesh.topology().edge(crease.vertices);
            edge.map(|e| crease.vertices.map(|v| Crease { vertices: [v, self.edge_point(e)], feature: crease.feature }))
        };
        mesh.creases().iter().filter_map(halves).flatten().collect()
    }
}

/// The corner at lattice coordinates 0 and 2.
fn corner_at(at: [usize; 3]) -> usize {
    (at[0] / 2) | (at[1] / 2) << 1 | (at[2] / 2) << 2
}

/// The edge of a cell, in the order of [`hex::EDGES`], whose middle is at lattice coordinates with one 1.
fn edge_at(at: [usize; 3]) -> usize {
    let axis = at.iter().position(|x| *x == 1).unwrap_or(0);
    let lower = corner_at(at);
    let [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
    debug_assert_eq!(hex::EDGES[4 * axis + (lower >> u & 1) + 2 * (lower >> v & 1)][0], lower);
    4 * axis + (lower >> u & 1) + 2 * (lower >> v & 1)
}

/// The face of a cell, in the order of [`FACES`], whose middle is at lattice coordinates with two 1.
fn face_at(at: [usize; 3]) -> usize {
    let axis = at.iter().position(|x| *x != 1).unwrap_or(0);
    debug_assert!(FACES[2 * axis + at[axis] / 2].iter().all(|c| c >> axis & 1 == at[axis] / 2));
    2 * axis + at[axis] / 2
}
