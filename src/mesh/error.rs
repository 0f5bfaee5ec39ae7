//! What can be wrong with a mesh, said with the ids of the victim.

use glam::DVec3;
use std::path::PathBuf;

/// The entity an error is about: a cell with its vertices. Indices from 0; where a file is being read, the ids that the
/// file gives its elements and nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Victim {
    /// Cell index.
    pub cell: usize,
    /// Its vertices.
    pub vertices: [u32; 4],
    /// Its centroid.
    pub centroid: DVec3,
}

impl std::fmt::Display for Victim {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c, d] = self.vertices;
        let p = self.centroid;
        write!(f, "tet {} ({a}, {b}, {c}, {d}) near ({:.4}, {:.4}, {:.4})", self.cell, p.x, p.y, p.z)
    }
}

/// Where in a file something stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line of a text, from 1.
    Line(usize),
    /// Byte of a file that is not all text, from 0.
    Byte(usize),
}

impl Place {
    /// The place in words.
    #[must_use]
    pub fn named(self) -> String {
        match self {
            Self::Line(line) => format!("line {line}"),
            Self::Byte(byte) => format!("byte {byte}"),
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "{line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a mesh cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum MeshError {
    /// The file cannot be opened or read.
    #[error("cannot read {what} {path}", path = path.display())]
    #[diagnostic(help("{help}"))]
    Unreadable {
        /// What the file should hold.
        what: &'static str,
        /// The file asked for.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
        /// Where it was looked for, and what to do.
        help: String,
    },
    /// The file's content is not what its format asks for.
    #[error("{path}:{at}: {message}", path = path.display())]
    #[diagnostic(help("{help}"))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line or byte.
        at: Place,
        /// What was expected and what was found.
        message: String,
        /// What to do.
        help: String,
    },
    /// The format is not known.
    #[error("{path}: not a mesh this program reads: {message}", path = path.display())]
    #[diagnostic(help(
        "read: Gmsh MSH 2.2 and 4.1 (.msh), Abaqus and CalculiX (.inp), MEDIT (.mesh), VTK (.vtk, .vtu), GiD (.msh); \
         Gmsh or meshio convert others"
    ))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// What was found.
        message: String,
    },
    /// There is nothing to compute on.
    #[error("the mesh has no tetrahedra")]
    #[diagnostic(help("a surface mesh is not enough: mesh the volume (Gmsh: -3) and save all elements"))]
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
    #[error("tet {cell} ({vertices:?}) uses vertex {vertex}, but there are only {count} vertices")]
    VertexOutOfRange {
        /// Cell index.
        cell: usize,
        /// Its vertices.
        vertices: [u32; 4],
        /// The vertex that does not exist.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A cell uses a vertex twice.
    #[error("{0} repeats a vertex")]
    RepeatedVertex(Victim),
    /// Cells without positive volume.
    #[error("{worst}: volume {volume:.3e} is not positive beyond rounding ({count} such cells)")]
    #[diagnostic(help("the worst cell is named; repair the mesh (Gmsh: Mesh.Optimize) or its node order"))]
    NotPositive {
        /// The cell with the smallest volume.
        worst: Victim,
        /// Its volume.
        volume: f64,
        /// How many cells are not positive.
        count: usize,
    },
    /// Cells without positive volume in a file.
    #[error("{path}:{at}: {worst}: volume {volume:.3e} is not positive beyond rounding ({count} such cells)", path = path.display())]
    #[diagnostic(help("the worst cell is named; repair the mesh (Gmsh: Mesh.Optimize) or its node order"))]
    NotPositiveIn {
        /// The file.
        path: PathBuf,
        /// Where the cell with the smallest volume stands.
        at: Place,
        /// That cell, with the ids of the file.
        worst: Victim,
        /// Its volume.
        volume: f64,
        /// How many cells are not positive.
        count: usize,
    },
    /// More than two cells at a face.
    #[error("face {vertices:?} is shared by {count} cells: {cells:?}")]
    #[diagnostic(help("each face may have one or two cells; look for duplicated or overlapping cells"))]
    OvercrowdedFace {
        /// Vertices of the face; as [`Victim`], these and the cells are ids where a file is being read.
        vertices: [u32; 3],
        /// How many cells share it.
        count: usize,
        /// Their indices.
        cells: Vec<usize>,
    },
    /// The listed boundary faces are not the boundary of the cells.
    #[error("boundary face {vertices:?} {problem}")]
    Boundary {
        /// Its vertices.
        vertices: [u32; 3],
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A generator was asked for something impossible.
    #[error("{0}")]
    Generator(String),
    /// Parts that do not fit together; a programming error of the caller.
    #[error("inconsistent mesh parts: {0}")]
    Inconsistent(String),
}
