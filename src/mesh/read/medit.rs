//! MEDIT texts (`.mesh`), versions 1 and 2: keywords, each with a count and its entries, whose last field is a reference.

use super::lines::Announced;
use super::raw::{MidsideOrder, Raw};
use super::words::{Words, shown};
use crate::mesh::MeshError;
use std::path::Path;

/// Whether the bytes begin a binary file (`.meshb`): the number 1 in either order, then a version.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    matches!(bytes, [1, 0, 0, 0, 1..=4, 0, 0, 0, ..] | [0, 0, 0, 1, 0, 0, 0, 1..=4, ..])
}

/// Reads a text.
pub(super) fn read(path: &Path, text: &str, raw: &mut Raw) -> Result<&'static str, MeshError> {
    let mut words = Words::new(path, text.as_bytes(), true);
    let (mut skipped, mut vertices) = (0, false);
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_slice() {
            b"meshversionformatted" => version(&mut words)?,
            b"dimension" => dimension(&mut words)?,
            b"vertices" => {
                vertices = true;
                read_vertices(&mut words, raw)?;
            }
            b"tetrahedra" => tetrahedra(&mut words, false, raw)?,
            b"tetrahedrap2" => tetrahedra(&mut words, true, raw)?,
            b"triangles" => triangles(&mut words, 0, raw)?,
            b"trianglesp2" => triangles(&mut words, 3, raw)?,
            b"hexahedra" | b"prisms" | b"pyramids" => refuse(&mut words, word)?,
            b"quadrilaterals" => skipped += skip_list(&mut words, 5)?,
            b"end" => break,
            // Whatever else a file holds: corners, ridges, normals, required entities.
            _ if word[0].is_ascii_alphabetic() => skip_unknown(&mut words)?,
            _ => {
                let message = format!("expected a keyword such as Vertices or Tetrahedra, found {}", shown(word));
                return Err(words.error(message, "a count is too small, or an entry too long"));
            }
        }
    }
    if !vertices {
        return Err(words.error("the section Vertices is missing", "write the file again"));
    }
    if skipped > 0 {
        raw.notes.push(format!("{skipped} quadrilaterals are ignored."));
    }
    Ok("MEDIT ASCII")
}

fn version(words: &mut Words) -> Result<(), MeshError> {
    match words.number("the version")? {
        1..=4 => Ok(()),
        other => Err(words.error(format!("MEDIT version {other}; versions 1 to 4 are read"), "write another version")),
    }
}

fn dimension(words: &mut Words) -> Result<(), MeshError> {
    match words.number("the dimension")? {
        3 => Ok(()),
        other => Err(words.error(format!("the mesh has dimension {other}, not 3"), "a solid has dimension 3")),
    }
}

/// Calls `entry` for each of an announced list with its index from 0.
fn entries(
    words: &mut Words,
    what: &'static str,
    mut entry: impl FnMut(u32, &mut Words) -> Result<(), MeshError>,
) -> Result<Announced, MeshError> {
    let list = words.count(what)?;
    for i in 0..list.count {
        entry(i as u32, words)?;
    }
    Ok(list)
}

/// Positions and references; vertices are numbered from 1.
fn read_vertices(words: &mut Words, raw: &mut Raw) -> Result<(), MeshError> {
    let before = raw.nodes.positions.len() as u32;
    entries(words, "vertices", |i, words| {
        let id = before + i + 1;
        let position = words.position(id)?;
        let place = words.place();
        let _: i64 = words.number("the reference of a vertex")?;
        raw.nodes.push(id, position, place);
        Ok(())
    })?;
    Ok(())
}

fn ids<const N: usize>(words: &mut Words, what: &str) -> Result<[u32; N], MeshError> {
    let mut ids = [0; N];
    for id in &mut ids {
        *id = words.number(what)?;
    }
    Ok(ids)
}

fn tetrahedra(words: &mut Words, second_order: bool, raw: &mut Raw) -> Result<(), MeshError> {
    let before = raw.tets.nodes.len() as u32;
    entries(words, "tetrahedra", |i, words| {
        let id = before + i + 1;
        let nodes = ids(words, "a vertex of a tetrahedron")?;
        let place = words.place();
        if second_order {
            let mids = ids(words, "a mid-side node of a tetrahedron")?;
            raw.midsides(id, MidsideOrder::Vtk, mids, raw.tets.nodes.len(), place);
        }
        let region = words.number("the reference of a tetrahedron")?;
        raw.tets.push(id, nodes, region, place);
        Ok(())
    })?;
    Ok(())
}

fn triangles(words: &mut Words, midsides: usize, raw: &mut Raw) -> Result<(), MeshError> {
    let before = raw.triangles.nodes.len() as u32;
    entries(words, "triangles", |i, words| {
        let nodes = ids(words, "a vertex of a triangle")?;
        let place = words.place();
        for _ in 0..midsides {
            let _: u32 = words.number("a mid-side node of a triangle")?;
        }
        let group = words.number("the reference of a triangle")?;
        raw.triangle(before + i + 1, nodes, [group, 0], place);
        Ok(())
    })?;
    Ok(())
}

/// Passes over a list of entries of `fields` fields; gives their number.
fn skip_list(words: &mut Words, fields: usize) -> Result<usize, MeshError> {
    let list = entries(words, "elements", |_, words| {
        for _ in 0..fields {
            words.expect("a field of an element")?;
        }
        Ok(())
    })?;
    Ok(list.count)
}

/// Passes over the numbers up to the next keyword.
fn skip_unknown(words: &mut Words) -> Result<(), MeshError> {
    while words.peek().is_some_and(|word| !word[0].is_ascii_alphabetic()) {
        words.next();
    }
    Ok(())
}

/// Refuses cells that are not tetrahedra, if there are any.
fn refuse(words: &mut Words, kind: &[u8]) -> Result<(), MeshError> {
    let list = words.count("elements")?;
    if list.count == 0 {
        return Ok(());
    }
    let kind = String::from_utf8_lossy(kind).to_lowercase();
    let message = format!("{} {kind}: of files of this format only tetrahedra are read", list.count);
    Err(words
        .error(message, "mesh the volume with tetrahedra alone; hexahedra are read from Gmsh, VTK and Abaqus files"))
}
