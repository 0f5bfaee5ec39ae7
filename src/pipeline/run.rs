//! `subsolid run`: the loop.

use super::{RunOptions, load, resolve};
use crate::error::Error;
use crate::scenario::Scenario;

/// Runs a scenario; see the pipeline's own branch.
///
/// # Errors
/// Always, here.
pub fn run(scenario: &Scenario, _options: &RunOptions) -> Result<(), Error> {
    resolve::resolve(scenario, load::load(scenario)?.mesh)?;
    Err(crate::mesh::MeshError::Generator("run is not in this branch".to_owned()).into())
}
