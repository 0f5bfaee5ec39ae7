//! What can be wrong with a hexahedral mesh, said with the ids of the victim.

use super::{HexMeshParts, HexTopology, jacobian};
use glam::DVec3;

/// Why a hexahedral mesh cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum HexError {
    /// A file cannot be read, or does not hold such a mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(#[from] crate::mesh::MeshError),
    /// There is nothing to compute on.
    #[error("the mesh has no hexahedra")]
    #[diagnostic(help(
        "this element needs a volume mesh of hexahedra; for tetrahedra choose analysis.element = \"tet10\""
    ))]
    NoCells,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is at ({}, {}, {}), which is not a finite position", position.x, position.y, position.z)]
    NotFinite {
        /// Vertex index.
        vertex: usize,
        /// Its position.
        position: DVec3,
    },
    /// A cell names a vertex that does not exist.
    #[error("hexahedron {cell} ({vertices:?}) uses vertex {vertex}, but there are only {count} vertices")]
    VertexOutOfRange {
        /// Cell index.
        cell: usize,
        /// Its vertices.
        vertices: [u32; 8],
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A cell has the same vertex twice.
    #[error("hexahedron {cell} ({vertices:?}) has vertex {vertex} twice")]
    #[diagnostic(help(
        "wedges and pyramids written as collapsed hexahedra are not supported: split them into hexahedra"
    ))]
    RepeatedVertex {
        /// Cell index.
        cell: usize,
        /// Its vertices.
        vertices: [u32; 8],
        /// The vertex.
        vertex: u32,
    },
    /// A cell is turned inside out at a corner.
    #[error(
        "hexahedron {cell} ({vertices:?}) near ({:.4}, {:.4}, {:.4}) is twisted: its Jacobian at vertex {vertex} is \
         {determinant:.3e}", centroid.x, centroid.y, centroid.z
    )]
    #[diagnostic(help("its edges there must form a right-handed frame: reorder its nodes, or move them apart"))]
    Twisted {
        /// Cell index.
        cell: usize,
        /// Its vertices.
        vertices: [u32; 8],
        /// Where it is twisted.
        vertex: u32,
        /// The Jacobian determinant there.
        determinant: f64,
        /// Mean of its vertices.
        centroid: DVec3,
    },
    /// A face is shared by more than two cells.
    #[error("face {vertices:?} is shared by the hexahedra {}, {} and {}", cells[0], cells[1], cells[2])]
    #[diagnostic(help("cells overlap: a face has two cells at most"))]
    CrowdedFace {
        /// The cells.
        cells: [usize; 3],
        /// The face.
        vertices: [u32; 4],
    },
    /// Two cells lie on the same side of their face, or see its vertices in different orders.
    #[error("the hexahedra {} and {} do not match at face {vertices:?}", cells[0], cells[1])]
    #[diagnostic(help("one of them lists its nodes in another order, or they overlap"))]
    InwardFace {
        /// The cells.
        cells: [usize; 2],
        /// The face.
        vertices: [u32; 4],
    },
    /// A boundary face is not in the list.
    #[error("the boundary face {vertices:?} is missing from the list of boundary faces")]
    MissingFace {
        /// The face.
        vertices: [u32; 4],
    },
    /// A listed boundary face is none.
    #[error("{vertices:?} is no face of the boundary, or is listed twice")]
    ForeignFace {
        /// The face.
        vertices: [u32; 4],
    },
    /// A crease or corner is not part of the mesh.
    #[error("{what} {vertices:?} is not part of the boundary")]
    ForeignTag {
        /// "crease" or "corner".
        what: &'static str,
        /// Its vertices.
        vertices: Vec<u32>,
    },
    /// Too few cells meet at an edge inside the solid.
    #[error("only {cells} hexahedra meet at the interior edge {edge:?}, near ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)]
    #[diagnostic(help(
        "Catmull-Clark solids need three at least: two cells that share two faces must be merged or split"
    ))]
    LowValence {
        /// Ends of the edge.
        edge: [u32; 2],
        /// Cells there.
        cells: usize,
        /// Its middle.
        at: DVec3,
    },
    /// The solid touches itself.
    #[error("the solid touches itself in {what} {vertices:?}, near ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)]
    #[diagnostic(help("a Catmull-Clark solid is bounded by a surface: separate the parts, or join them by faces"))]
    NotManifold {
        /// "edge" or "vertex".
        what: &'static str,
        /// Its vertices.
        vertices: Vec<u32>,
        /// Where.
        at: DVec3,
    },
    /// An edge of a single cell that is smooth.
    #[error("the boundary edge {edge:?} belongs to one cell only and must be a crease, near ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)]
    #[diagnostic(help(
        "a smooth edge of a single cell flattens it: tag the edge as a crease, or put a layer of cells around it (O-grid)"
    ))]
    SmoothSingleCell {
        /// Ends of the edge.
        edge: [u32; 2],
        /// Its middle.
        at: DVec3,
    },
    /// No control points whose limit is given.
    #[error("no control points were found whose limit passes through vertex {vertex} at ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)]
    #[diagnostic(help("take the vertices as control points instead, or refine the mesh there"))]
    NoInterpolation {
        /// Where the miss is largest.
        vertex: usize,
        /// Its position.
        at: DVec3,
    },
    /// More cells than can be.
    #[error("{cells} hexahedra split into eight each, {steps} times, are more than {most}")]
    #[diagnostic(help("ask for fewer steps"))]
    TooManyCells {
        /// Cells there are.
        cells: usize,
        /// Steps asked for.
        steps: usize,
        /// The most there may be.
        most: usize,
    },
    /// Lists that do not fit together.
    #[error("the parts of the mesh do not fit together: {0}")]
    Inconsistent(String),
    /// Numbers of a generated mesh that make none.
    #[error("{0}")]
    Generator(String),
}

pub(super) fn check_lists(parts: &HexMeshParts) -> Result<(), HexError> {
    if parts.cells.is_empty() {
        return Err(HexError::NoCells);
    }
    if parts.regions.len() != parts.cells.len() {
        let (got, want) = (parts.regions.len(), parts.cells.len());
        return Err(HexError::Inconsistent(format!("regions: {got} entries for {want} cells")));
    }
    if let Some(r) = parts.regions.iter().find(|r| r.0 as usize >= parts.region_names.len()) {
        return Err(HexError::Inconsistent(format!("region {} has no name", r.0)));
    }
    if let Some(f) = parts.faces.iter().find(|f| f.patch.0 as usize >= parts.patches.len()) {
        return Err(HexError::Inconsistent(format!("patch {} of face {:?} does not exist", f.patch.0, f.vertices)));
    }
    match parts.points.iter().position(|p| !p.is_finite()) {
        Some(vertex) => Err(HexError::NotFinite { vertex, position: parts.points[vertex] }),
        None => Ok(()),
    }
}

pub(super) fn check_vertices(count: usize, cells: &[[u32; 8]]) -> Result<(), HexError> {
    for (cell, &vertices) in cells.iter().enumerate() {
        if let Some(&vertex) = vertices.iter().find(|v| **v as usize >= count) {
            return Err(HexError::VertexOutOfRange { cell, vertices, vertex, count });
        }
        if let Some(i) = (1..8).find(|&i| vertices[..i].contains(&vertices[i])) {
            return Err(HexError::RepeatedVertex { cell, vertices, vertex: vertices[i] });
        }
    }
    Ok(())
}

/// Cells of vertices that exist must have eight, and the Jacobian of each must be positive at its corners.
///
/// # Errors
/// [`HexError::VertexOutOfRange`], [`HexError::RepeatedVertex`], [`HexError::Twisted`].
pub(crate) fn check_cells(points: &[DVec3], cells: &[[u32; 8]]) -> Result<(), HexError> {
    check_vertices(points.len(), cells)?;
    for (cell, &vertices) in cells.iter().enumerate() {
        let points = vertices.map(|v| points[v as usize]);
        for corner in 0..8 {
            let at = DVec3::new((corner & 1) as f64, (corner >> 1 & 1) as f64, (corner >> 2) as f64);
            let frame = jacobian(&points, at);
            let determinant = frame.determinant();
            let size = frame.x_axis.length() * frame.y_axis.length() * frame.z_axis.length();
            if determinant.is_nan() || determinant <= f64::EPSILON * size {
                let centroid = points.iter().sum::<DVec3>() / 8.0;
                return Err(HexError::Twisted { cell, vertices, vertex: vertices[corner], determinant, centroid });
            }
        }
    }
    Ok(())
}

pub(super) fn check_tags(parts: &HexMeshParts, topology: &HexTopology) -> Result<(), HexError> {
    for crease in &parts.creases {
        let on_boundary = |e: u32| topology.boundary_faces_at(e).next().is_some();
        if !topology.edge(crease.vertices).is_some_and(on_boundary) {
            return Err(HexError::ForeignTag { what: "crease", vertices: crease.vertices.to_vec() });
        }
    }
    match parts.corners.iter().find(|v| **v as usize >= parts.points.len()) {
        Some(&v) => Err(HexError::ForeignTag { what: "corner", vertices: vec![v] }),
        None => Ok(()),
    }
}
