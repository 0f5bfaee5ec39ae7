//! Mesh files.
//!
//! The format is found from the content. Every reader turns its file into `raw::Raw` lists of nodes, tetrahedra and
//! triangles with the place each came from; `build` checks the lists and makes a mesh of them, alike for all formats.

mod abaqus;
mod binary;
mod build;
mod doubts;
mod gid;
mod gmsh;
mod gmsh2;
mod gmsh4;
mod groups;
pub mod hexes;
mod lines;
mod list;
mod medit;
mod midsides;
mod nodes;
mod raw;
mod runs;
mod shape;
mod source;
#[cfg(test)]
mod tests;
mod vtk;
mod words;

pub use list::read_list;
pub use shape::{Shape, read_shape};
pub use vtk::{VtuArray, VtuPart, arrays as read_vtu_arrays};

use super::hex::HexError;
use super::midside::Midside;
use super::{MeshError, Place, TetMesh};
use hexes::HexFile;
use lines::Lines;
use raw::Raw;
use std::io::BufRead;
use std::path::Path;

/// A mesh, and what was done to make it of a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The mesh; vertices are numbered in the order of the file's nodes, cells in the order of its tetrahedra.
    pub mesh: TetMesh,
    /// Name of the format.
    pub format: &'static str,
    /// The nodes of curved edges, sorted by edge; none unless asked for.
    pub midsides: Vec<Midside>,
    /// Names of the groups all of whose triangles lie inside the solid, or beside it, sorted: the mesh does not have them.
    pub inner_groups: Vec<String>,
    /// What a user should know: what was dropped, flipped or ignored, and what looks odd. Whole sentences.
    pub notes: Vec<String>,
}

/// What becomes of the mid-side nodes of second-order tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// They are dropped.
    Straight,
    /// Those that do not lie in the middle of their edges are kept.
    Curved,
}

/// How a mesh is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// What becomes of mid-side nodes.
    pub edges: Edges,
    /// Whether nodes at the same place are made one.
    pub merge: bool,
}

impl From<Edges> for Reading {
    fn from(edges: Edges) -> Self {
        Self { edges, merge: false }
    }
}

/// Reads a mesh with straight edges; see [`read_with`].
///
/// # Errors
/// As [`read_with`].
pub fn read(path: &Path) -> Result<MeshFile, MeshError> {
    read_with(path, Edges::Straight)
}

/// Reads a mesh: Gmsh MSH 2.2 and 4.1 (text and binary), Abaqus and CalculiX input, MEDIT, VTK legacy and XML
/// unstructured grids, GiD.
///
/// Ten-node tetrahedra give their four corners and, if asked for, their curved edges. Orphan nodes are dropped. If all cells are inverted, all are flipped.
/// What was changed is said in [`MeshFile::notes`].
///
/// # Errors
/// [`MeshError::Unreadable`], [`MeshError::UnknownFormat`], [`MeshError::Syntax`] with the place, [`MeshError::NoCells`],
/// and what [`TetMesh::new`] refuses, where cells and vertices are then named by the file's ids.
pub fn read_with(path: &Path, reading: impl Into<Reading>) -> Result<MeshFile, MeshError> {
    let (format, raw) = open(path)?;
    build::build(path, format, raw, reading.into())
}

/// A mesh of one kind of cells or the other.
#[derive(Debug, Clone)]
pub enum AnyMesh {
    /// Tetrahedra.
    Tets(Box<MeshFile>),
    /// Hexahedra.
    Hexes(Box<HexFile>),
}

/// Reads a mesh of hexahedra if the file has any, with straight edges if they are tetrahedra.
///
/// # Errors
/// As [`read_with`] and [`hexes::read`].
pub fn read_any(path: &Path) -> Result<AnyMesh, HexError> {
    let (format, raw) = open(path)?;
    either(path, format, raw, Edges::Straight)
}

/// Reads a mesh of either kind from the content of a file; `path` is for messages, and says where files lie that the content names.
///
/// # Errors
/// As [`read_any`].
pub fn read_any_from(path: &Path, content: &[u8], edges: Edges) -> Result<AnyMesh, HexError> {
    let (format, raw) = lists(path, content, content.len() as u64)?;
    either(path, format, raw, edges)
}

fn either(path: &Path, format: &'static str, raw: Raw, edges: Edges) -> Result<AnyMesh, HexError> {
    if raw.hexes.nodes.is_empty() {
        return Ok(AnyMesh::Tets(Box::new(build::build(path, format, raw, edges.into())?)));
    }
    Ok(AnyMesh::Hexes(Box::new(hexes::build(path, format, raw, false)?)))
}

/// The format and the lists of a file.
fn open(path: &Path) -> Result<(&'static str, Raw), MeshError> {
    let open = || {
        let file = std::fs::File::open(path)?;
        let length = file.metadata()?.len();
        Ok((std::io::BufReader::with_capacity(1 << 16, file), length))
    };
    let (reader, length) = open().map_err(|source| unreadable(path, source))?;
    lists(path, reader, length)
}

fn unreadable(path: &Path, source: std::io::Error) -> MeshError {
    unreadable_file("mesh", path, source)
}

fn unreadable_file(what: &'static str, path: &Path, source: std::io::Error) -> MeshError {
    let place = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let help = format!("looked for in {}; check the name and the permissions", place.display());
    MeshError::Unreadable { what, path: path.to_owned(), source, help }
}

/// An error at a place of a file.
fn error_at(path: &Path, at: Place, message: impl Into<String>, help: &str) -> MeshError {
    MeshError::Syntax { path: path.to_owned(), at, message: message.into(), help: help.to_owned() }
}

/// What to do about a word that is no number.
fn number_help(word: &str) -> &'static str {
    if word.contains(',') && word.replace(',', ".").parse::<f64>().is_ok() {
        "a decimal comma: export with a decimal point"
    } else if word.len() > 1 && word.starts_with('-') && word[1..].bytes().all(|b| b.is_ascii_digit()) {
        "it must not be negative"
    } else if !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit()) {
        "the number is too large; counts and ids are at most 4294967295"
    } else {
        "correct this field, or write the file again"
    }
}

/// What is wrong with a coordinate that is not finite, and what to do.
fn finite(x: f64, name: &str, node: u32) -> Result<(), (String, &'static str)> {
    if x.is_finite() {
        return Ok(());
    }
    let message = format!("{name} of node {node} is {x}, which is not a finite number");
    Err((message, "every coordinate must be a finite number below 1.8e308"))
}

/// Reads a mesh from a file's content of `length` bytes.
#[cfg(test)]
fn parse(path: &Path, reader: impl BufRead, length: u64, edges: Edges) -> Result<MeshFile, MeshError> {
    let (format, raw) = lists(path, reader, length)?;
    build::build(path, format, raw, edges.into())
}

/// The format and the lists of a file's content of `length` bytes; `path` is for messages, and says where files lie that this
/// one names.
fn lists(path: &Path, mut reader: impl BufRead, length: u64) -> Result<(&'static str, Raw), MeshError> {
    let mut raw = Raw::default();
    let head = reader.fill_buf().map_err(|source| unreadable(path, source))?;
    if gmsh::is_binary(head) {
        return Ok((gmsh::read_binary(path, reader, length, &mut raw)?, raw));
    }
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).map_err(|source| unreadable(path, source))?;
    Ok((parse_whole(path, &bytes, &mut raw)?, raw))
}

/// Reads a file that is in memory.
fn parse_whole(path: &Path, bytes: &[u8], raw: &mut Raw) -> Result<&'static str, MeshError> {
    let unknown = |message: String| MeshError::UnknownFormat { path: path.to_owned(), message };
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(unknown("the text is encoded in UTF-16, save it as UTF-8".to_owned()));
    }
    if let Some(format) = vtk::read(path, bytes, raw)? {
        return Ok(format);
    }
    if medit::is_binary(bytes) {
        return Err(unknown("it is a binary MEDIT file (.meshb), save it as text (.mesh)".to_owned()));
    }
    // A name in another encoding spoils nothing but the name. Text in UTF-8 is not copied.
    let text = String::from_utf8_lossy(bytes);
    let mut lines = Lines::new(path, &text);
    // Files may begin with comments of GiD, MEDIT or Abaqus.
    let mut first = lines.next();
    while first.is_some_and(|line| line.text.trim_ascii_start().starts_with('#') || line.text.starts_with("**")) {
        first = lines.next();
    }
    let Some(first) = first else {
        return Err(lines.error_at_end("the file is empty", "export the mesh again"));
    };
    match first.keyword().as_str() {
        "$meshformat" => gmsh::read_text(path, lines, raw),
        "mesh" => gid::read(first, &mut lines, raw),
        "meshversionformatted" => medit::read(path, &text, raw),
        word if word.starts_with('*') => abaqus::read(path, &text, raw),
        _ => Err(unknown(format!("it begins with {}", first.quoted()))),
    }
}
