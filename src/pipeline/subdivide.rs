//! `subsolid subdivide`: refine a mesh and write it.

use crate::error::Error;
use crate::subdiv::options::Options;
use std::path::PathBuf;

/// What the command line says about a subdivision.
#[derive(Debug, Clone)]
pub struct Subdivision {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Scheme, boundary rule, passes.
    pub options: Options,
    /// Refinement steps of all cells.
    pub steps: usize,
    /// Feature angle in degrees.
    pub feature_angle: f64,
    /// The file to write.
    pub output: PathBuf,
    /// Print errors only.
    pub quiet: bool,
    /// File for the counts and the quality of the final mesh.
    pub json: Option<PathBuf>,
}

/// Subdivides; see the pipeline's own branch.
///
/// # Errors
/// Always, here.
pub fn subdivide(_subdivision: &Subdivision) -> Result<(), Error> {
    Err(crate::mesh::MeshError::Generator("subdivide is not in this branch".to_owned()).into())
}
