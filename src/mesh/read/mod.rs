//! Mesh files.

use super::{MeshError, TetMesh};
use std::path::Path;

/// A mesh that was read.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The mesh.
    pub mesh: TetMesh,
    /// Name of the file's format.
    pub format: &'static str,
    /// What was dropped or repaired.
    pub notes: Vec<String>,
}

/// Reads a mesh; see the mesh branch.
///
/// # Errors
/// Always, here.
pub fn read(path: &Path) -> Result<MeshFile, MeshError> {
    Err(MeshError::UnknownFormat { path: path.to_owned(), message: "no readers in this branch".to_owned() })
}
