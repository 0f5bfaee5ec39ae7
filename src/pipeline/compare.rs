//! `subsolid compare`: adaptive against global.

use super::RunOptions;
use crate::error::Error;
use crate::scenario::Scenario;

/// Compares; see the pipeline's own branch.
///
/// # Errors
/// Always, here.
pub fn compare(_scenario: &Scenario, _options: &RunOptions, _repeat: usize) -> Result<(), Error> {
    Err(crate::mesh::MeshError::Generator("compare is not in this branch".to_owned()).into())
}
