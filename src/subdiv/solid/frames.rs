//! The mesh after each stage of a step, kept only where somebody wants to watch.

use super::Solid;
use crate::mesh::{MeshError, TetMesh, TetMeshParts};
use crate::subdiv::Frame;

/// The stages so far, none unless they are watched.
#[derive(Debug, Default)]
pub(super) struct Stages(Option<Vec<(&'static str, TetMeshParts)>>);

impl Solid {
    /// Keeps the mesh at every stage from now on, if `wanted`.
    pub(in crate::subdiv) fn watch(&mut self, wanted: bool) {
        self.stages.0 = wanted.then(Vec::new);
    }

    /// Keeps the mesh as it is now, after the stage of this name.
    pub(in crate::subdiv) fn note_stage(&mut self, name: &'static str) {
        if self.stages.0.is_none() {
            return;
        }
        let parts = self.parts(self.points.clone(), self.rest.clone());
        self.stages.0.get_or_insert_default().push((name, parts));
    }

    /// Takes the stages kept so far.
    ///
    /// # Errors
    /// [`MeshError`] if one of them left an invalid mesh.
    pub(in crate::subdiv) fn take_frames(&mut self) -> Result<Vec<Frame>, MeshError> {
        let stages = self.stages.0.take().unwrap_or_default();
        stages.into_iter().map(|(stage, parts)| Ok(Frame { stage, mesh: TetMesh::new(parts)? })).collect()
    }
}
