//! Mesh files: GiD ASCII and Gmsh MSH 2.2 and 4.1 ASCII.
//!
//! The format is found from the content. Every reader turns text into a [`Raw`] list of nodes, tetrahedra and triangles
//! with the line each came from; [`build`] checks the list and makes a mesh of it, alike for all formats.

mod build;
mod gid;
mod gmsh;
mod gmsh2;
mod gmsh4;
mod lines;
mod list;
#[cfg(test)]
mod tests;

pub use list::read_list;

use super::{MeshError, TetMesh};
use glam::DVec3;
use lines::{Line, Lines};
use std::collections::BTreeMap;
use std::path::Path;

/// A mesh, and what was done to make it of a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The mesh; vertices are numbered in the order of the file's nodes, cells in the order of its tetrahedra.
    pub mesh: TetMesh,
    /// Name of the format.
    pub format: &'static str,
    /// What a user should know: what was dropped, flipped or ignored, and what looks odd. Whole sentences.
    pub notes: Vec<String>,
}

/// A node as the file gives it.
#[derive(Debug)]
struct Node {
    id: u32,
    position: DVec3,
    line: u32,
}

/// A tetrahedron as the file gives it: ids, not indices.
#[derive(Debug)]
struct Tet {
    id: u32,
    nodes: [u32; 4],
    /// Tag of its region, 0 if it has none.
    region: i32,
    line: u32,
}

/// A triangle as the file gives it; one that belongs to several physical groups is listed once for each.
#[derive(Debug)]
struct Triangle {
    id: u32,
    nodes: [u32; 3],
    /// Tag of its physical group, 0 if it has none.
    physical: i32,
    /// Tag of the surface it was made on, 0 if unknown.
    entity: i32,
    line: u32,
}

/// What a file lists, before anything is checked across its lines.
#[derive(Debug, Default)]
struct Raw {
    nodes: Vec<Node>,
    tets: Vec<Tet>,
    triangles: Vec<Triangle>,
    /// The six mid-side nodes of each second-order tetrahedron, with its line.
    midsides: Vec<([u32; 6], u32)>,
    region_names: BTreeMap<i32, String>,
    group_names: BTreeMap<i32, String>,
    notes: Vec<String>,
}

/// Reads a mesh.
///
/// Ten-node tetrahedra give their four corners. Orphan nodes are dropped. If all cells are inverted, all are flipped.
/// What was changed is said in [`MeshFile::notes`].
///
/// # Errors
/// [`MeshError::Unreadable`], [`MeshError::UnknownFormat`], [`MeshError::Syntax`] with the line, [`MeshError::NoCells`],
/// and what [`TetMesh::new`] refuses, where cells and vertices are then named by the file's ids.
pub fn read(path: &Path) -> Result<MeshFile, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| unreadable(path, source))?;
    parse(path, &bytes)
}

fn unreadable(path: &Path, source: std::io::Error) -> MeshError {
    let place = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let help = format!("looked for in {}; check the name and the permissions", place.display());
    MeshError::Unreadable { path: path.to_owned(), source, help }
}

/// Reads a mesh from a file's content; `path` is for messages only.
fn parse(path: &Path, bytes: &[u8]) -> Result<MeshFile, MeshError> {
    let unknown = |message: String| MeshError::UnknownFormat { path: path.to_owned(), message };
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(unknown("the text is encoded in UTF-16, save it as UTF-8".to_owned()));
    }
    // A name in another encoding spoils nothing but the name; binary data is told by the format's first lines.
    let text = String::from_utf8_lossy(bytes);
    let mut lines = Lines::new(path, &text);
    // GiD files may begin with comments.
    let mut first = lines.next();
    while first.is_some_and(|line| line.keyword().starts_with('#')) {
        first = lines.next();
    }
    let Some(first) = first else {
        return Err(lines.error_at_end("the file is empty", "export the mesh again"));
    };
    let mut raw = Raw::default();
    let format = match first.keyword().as_str() {
        "$meshformat" => gmsh::read(&mut lines, &mut raw)?,
        "mesh" => gid::read(first, &mut lines, &mut raw)?,
        _ => return Err(unknown(format!("it begins with {}", first.quoted()))),
    };
    build::build(path, format, raw)
}
