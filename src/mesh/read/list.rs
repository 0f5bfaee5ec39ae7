//! Lists of numbers in a text file, one entry a line: cells to refine, edges and corners to keep.

use super::lines::Lines;
use super::unreadable_file;
use crate::mesh::MeshError;
use std::path::Path;

/// The entries of a file, each of `N` whole numbers from 0, with their line numbers from 1. `what` names an entry in
/// messages.
///
/// # Errors
/// [`MeshError::Unreadable`]; [`MeshError::Syntax`] with the line of an entry that is not `N` such numbers, or if there
/// is no entry.
pub fn read_list<const N: usize>(path: &Path, what: &str) -> Result<Vec<(usize, [u32; N])>, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| unreadable_file("list", path, source))?;
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = Lines::new(path, &text);
    let mut entries = Vec::new();
    while let Some(line) = lines.next() {
        let mut fields = line.fields();
        entries.push((line.place() as usize, fields.ids(what)?));
        fields.end()?;
    }
    if entries.is_empty() {
        return Err(lines.error_at_end(format!("expected {what}, found none"), "write one entry a line"));
    }
    Ok(entries)
}
