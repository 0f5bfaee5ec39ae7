//! Tetrahedral sqrt(3) subdivision.

use super::{Refined, options::Options};
use crate::mesh::{MeshError, TetMesh};

/// What a step leaves for the next.
#[derive(Debug, Clone, Default)]
pub struct History {}

pub(super) fn refine(_: &TetMesh, _: &History, _: &[bool], _: &Options) -> Result<Refined, MeshError> {
    Err(MeshError::Generator("under construction".to_owned()))
}
