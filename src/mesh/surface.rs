//! The surfaces that subdivision refines as surfaces: the boundary, and the interfaces between regions.

use super::{PatchId, TetMesh, topology};

/// A triangle of the boundary or of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SurfaceFace {
    /// Vertex indices, counter-clockwise seen from the outer side.
    pub vertices: [u32; 3],
    /// The cell on the inner side; at an interface the one with the smaller region number.
    pub inner: u32,
    /// The cell on the outer side of an interface; `None` on the boundary.
    pub outer: Option<u32>,
    /// The patch of a boundary face; `None` on an interface.
    pub patch: Option<PatchId>,
}

impl SurfaceFace {
    /// The one or two cells with this face.
    pub fn cells(&self) -> impl Iterator<Item = u32> {
        [self.inner].into_iter().chain(self.outer)
    }
}

/// The boundary faces, in the order of [`TetMesh::faces`], and after them the interfaces.
#[must_use]
pub fn surface_faces(mesh: &TetMesh) -> Vec<SurfaceFace> {
    let cells = topology::boundary_cells(mesh.tets());
    let boundary = mesh.faces().iter().zip(cells).map(|(face, inner)| SurfaceFace {
        vertices: face.vertices,
        inner,
        outer: None,
        patch: Some(face.patch),
    });
    boundary.chain(interfaces(mesh)).collect()
}

/// The faces between cells of different regions, in the order of their inner cells.
#[must_use]
pub fn interfaces(mesh: &TetMesh) -> Vec<SurfaceFace> {
    if mesh.region_names().len() < 2 {
        return Vec::new();
    }
    let mut faces = Vec::new();
    for (t, around) in topology::face_neighbours(mesh.tets()).into_iter().enumerate() {
        for (i, outer) in around.into_iter().enumerate() {
            if outer.is_some_and(|u| mesh.regions()[t] < mesh.regions()[u as usize]) {
                let vertices = topology::tet_faces(mesh.tets()[t])[i];
                faces.push(SurfaceFace { vertices, inner: t as u32, outer, patch: None });
            }
        }
    }
    faces
}

/// The edges of the faces, sorted by vertices, with the indices of the faces at each.
#[must_use]
pub fn surface_edges(faces: &[SurfaceFace]) -> Vec<([u32; 2], Vec<usize>)> {
    topology::triangle_edges(faces.iter().map(|f| f.vertices))
}
