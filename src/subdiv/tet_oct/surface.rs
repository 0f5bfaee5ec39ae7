//! The surfaces of a mesh and the curves on them, as the masks see them.

use crate::mesh::tet_oct::{CellEdges, TetOctMesh};

/// How the masks see an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EdgeKind {
    /// Inside a region.
    Inside,
    /// On a smooth surface.
    Smooth,
    /// On a crease.
    Crease,
}

/// How the masks see a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VertexKind {
    /// Inside a region.
    Inside,
    /// On a smooth surface; creases that end here do not count.
    Smooth,
    /// On a crease.
    Crease,
    /// Kept.
    Corner,
}

/// An edge of the surfaces, with the third vertex of a face at it.
type Side = (u32, u32);

/// The boundary and the crease surfaces inside, with creases and corners.
#[derive(Debug)]
pub(super) struct Surfaces {
    pub edges: Vec<EdgeKind>,
    pub vertices: Vec<VertexKind>,
    /// The sides of all faces, sorted by edge.
    sides: Vec<Side>,
    /// A vertex and its neighbour on its surface, or along its crease; sorted.
    neighbours: Vec<(u32, u32)>,
}

impl Surfaces {
    pub fn new(mesh: &TetOctMesh, edges: &CellEdges) -> Self {
        let parts = mesh.parts();
        let faces = parts.faces.iter().map(|f| f.vertices).chain(parts.interfaces.iter().copied());
        let mut sides: Vec<Side> = faces
            .flat_map(|[a, b, c]| [([a, b], c), ([b, c], a), ([c, a], b)])
            .filter_map(|(ends, third)| Some((edges.find(ends)?, third)))
            .collect();
        sides.sort_unstable();
        let mut kinds = vec![EdgeKind::Inside; edges.all().len()];
        for faces in sides.chunk_by(|a, b| a.0 == b.0) {
            // Where other than two faces meet there is no smooth surface.
            kinds[faces[0].0 as usize] = if faces.len() == 2 { EdgeKind::Smooth } else { EdgeKind::Crease };
        }
        for edge in parts.creases.iter().filter_map(|c| edges.find(c.vertices)) {
            kinds[edge as usize] = EdgeKind::Crease;
        }
        let vertices = vertex_kinds(mesh, edges, &kinds);
        let mut neighbours = Vec::new();
        for (&[a, b], &kind) in edges.all().iter().zip(&kinds).filter(|(_, kind)| **kind != EdgeKind::Inside) {
            let ends = [(a, b), (b, a)];
            let counts = |v: u32| match vertices[v as usize] {
                VertexKind::Smooth => true,
                VertexKind::Crease => kind == EdgeKind::Crease,
                VertexKind::Inside | VertexKind::Corner => false,
            };
            neighbours.extend(ends.into_iter().filter(|&(v, _)| counts(v)));
        }
        neighbours.sort_unstable();
        Self { edges: kinds, vertices, sides, neighbours }
    }

    /// The vertices opposite to an edge in the faces at it.
    pub fn opposite(&self, edge: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.sides.partition_point(|side| side.0 < edge);
        self.sides[first..].iter().take_while(move |side| side.0 == edge).map(|side| side.1)
    }

    /// The neighbours of a vertex on its smooth surface, or along its crease.
    pub fn neighbours(&self, v: u32) -> &[(u32, u32)] {
        let first = self.neighbours.partition_point(|n| n.0 < v);
        let count = self.neighbours[first..].iter().take_while(|n| n.0 == v).count();
        &self.neighbours[first..first + count]
    }
}

fn vertex_kinds(mesh: &TetOctMesh, edges: &CellEdges, kinds: &[EdgeKind]) -> Vec<VertexKind> {
    let mut vertices = vec![VertexKind::Inside; mesh.points().len()];
    let mut creases = vec![0_u32; mesh.points().len()];
    for (ends, kind) in edges.all().iter().zip(kinds) {
        for &v in ends {
            match kind {
                EdgeKind::Inside => {}
                EdgeKind::Smooth => vertices[v as usize] = VertexKind::Smooth,
                EdgeKind::Crease => creases[v as usize] += 1,
            }
        }
    }
    for (kind, count) in vertices.iter_mut().zip(creases) {
        *kind = match count {
            0 | 1 => *kind,
            2 => VertexKind::Crease,
            _ => VertexKind::Corner,
        };
    }
    mesh.parts().corners.iter().for_each(|&v| vertices[v as usize] = VertexKind::Corner);
    vertices
}
