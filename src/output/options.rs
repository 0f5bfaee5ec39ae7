//! Choices of the output, plain data.

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
