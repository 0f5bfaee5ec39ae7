//! VTK unstructured grids: legacy (`.vtk`) and XML (`.vtu`).

mod arrays;
mod decode;
mod grid;
mod legacy;
mod names;
mod xml;

pub use xml::{VtuArray, VtuPart};

use super::raw::Raw;
use super::unreadable_file;
use crate::mesh::MeshError;
use std::path::Path;

/// All arrays of a `.vtu` file of one piece.
///
/// # Errors
/// [`MeshError::Unreadable`]; [`MeshError::Syntax`] with the place.
pub fn arrays(path: &Path) -> Result<Vec<VtuArray>, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| unreadable_file("result", path, source))?;
    xml::arrays(path, &bytes)
}

/// Reads a file if it is one of the two formats.
pub(super) fn read(path: &Path, bytes: &[u8], raw: &mut Raw) -> Result<Option<&'static str>, MeshError> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if start.get(..5).is_some_and(|head| head.eq_ignore_ascii_case(b"# vtk")) {
        return legacy::read(path, bytes, raw).map(Some);
    }
    // Other XML files may mention the tag anywhere; in a grid it stands at the beginning.
    let head = &start[..start.len().min(4000)];
    if start.starts_with(b"<") && head.windows(8).any(|word| word == b"<VTKFile") {
        return xml::read(path, bytes, raw).map(Some);
    }
    Ok(None)
}
