//! `subsolid compare`: adaptive against global.

use super::{RunOptions, load, resolve};
use crate::error::Error;
use crate::scenario::Scenario;

/// Compares; see the pipeline's own branch.
///
/// # Errors
/// Always, here.
pub fn compare(scenario: &Scenario, _options: &RunOptions, _repeat: usize) -> Result<(), Error> {
    resolve::resolve(scenario, load::load(scenario)?.mesh)?;
    Err(crate::mesh::MeshError::Generator("compare is not in this branch".to_owned()).into())
}
