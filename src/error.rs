//! What a command can end with, and its exit code.

use crate::mesh::MeshError;
use crate::pipeline::ModelError;
use crate::scenario::ScenarioError;
use std::path::PathBuf;

/// Why a command failed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum Error {
    /// The scenario cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scenario(#[from] ScenarioError),
    /// The mesh cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mesh(#[from] MeshError),
    /// Supports, loads and materials do not fit the mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    /// A file or folder cannot be written.
    #[error("cannot write {path}", path = path.display())]
    #[diagnostic(help("choose another folder with --output, or make room"))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// Standard output cannot be written.
    #[error("cannot write to standard output")]
    Print(#[source] std::io::Error),
    /// All refinement steps are done and the error is still above what the scenario asks for.
    #[error("the estimated relative error is {reached:.4}, above the {asked} asked for")]
    #[diagnostic(help("allow more: refine.steps, or the limits of [refine.stop]"))]
    ToleranceNotReached {
        /// `refine.stop.relative_error`.
        asked: f64,
        /// What the last step reached.
        reached: f64,
    },
}

impl Error {
    /// The exit code of a command that ends with this error: 3 scenario, 4 mesh, 5 ill-posed model, 6 solver, memory or
    /// output, 7 asked tolerance not reached. (0 is success, 1 a failed verification, 2 wrong usage.)
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scenario(_) => 3,
            Self::Mesh(_) => 4,
            Self::Model(_) => 5,
            Self::Write { .. } | Self::Print(_) => 6,
            Self::ToleranceNotReached { .. } => 7,
        }
    }
}
