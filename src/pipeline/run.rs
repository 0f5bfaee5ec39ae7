//! `subsolid run`: the loop.

use super::RunOptions;
use crate::error::Error;
use crate::scenario::Scenario;

/// Runs a scenario; see the pipeline's own branch.
///
/// # Errors
/// Always, here.
pub fn run(_scenario: &Scenario, _options: &RunOptions) -> Result<(), Error> {
    Err(crate::mesh::MeshError::Generator("run is not in this branch".to_owned()).into())
}
