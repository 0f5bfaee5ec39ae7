//! Choices of the output and figures to print beside its own, plain data.

use serde::{Deserialize, Serialize};

/// How the arrays of VTK files are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// Not at all.
    None,
    /// LZ4: faster to write than no compression, because less is written.
    #[default]
    Lz4,
    /// Zlib: smaller files, slower.
    Zlib,
}

/// Figures from a publication, printed beside ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Where they are from.
    pub source: String,
    /// One entry a mesh.
    pub steps: Vec<PublishedStep>,
}

/// A published simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedStep {
    /// The row of ours it is printed beside: `base`, `adaptive 1`, `global 1`, ...
    pub label: String,
    /// Cells of the mesh.
    pub cells: usize,
    /// Computation time.
    pub milliseconds: f64,
    /// Average normalised error.
    pub error: f64,
}
