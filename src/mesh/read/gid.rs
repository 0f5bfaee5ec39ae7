//! GiD ASCII meshes: blocks of `MESH` header, `Coordinates` and `Elements`. Keywords in any case, `#` begins a comment.

use super::lines::{Line, Lines};
use super::raw::{MidsideOrder, Raw};
use crate::mesh::MeshError;

/// What a `MESH` header says about the elements that follow.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Tet4,
    Tet10,
    /// Points, lines and triangles, which carry no stiffness here.
    Skipped,
}

/// Reads the blocks; `first` is the first `MESH` line.
pub(super) fn read(first: Line, lines: &mut Lines, raw: &mut Raw) -> Result<&'static str, MeshError> {
    let mut kind = header(first)?;
    let (mut coordinates, mut elements, mut skipped) = (false, false, 0);
    while let Some(line) = lines.next() {
        match line.keyword().as_str() {
            "mesh" => kind = header(line)?,
            "coordinates" => {
                coordinates = true;
                section(lines, "coordinates", |line| node(line, raw))?;
            }
            "elements" => {
                elements = true;
                section(lines, "elements", |line| element(line, kind, raw, &mut skipped))?;
            }
            "unit" => {}
            word if word.starts_with('#') => {}
            _ => {
                let message = format!("expected MESH, Coordinates or Elements, found {}", line.quoted());
                return Err(line.error(message, "GiD meshes have these three sections"));
            }
        }
    }
    for (there, name) in [(coordinates, "Coordinates"), (elements, "Elements")] {
        if !there {
            return Err(lines.error_at_end(format!("the section {name} is missing"), "write the file again"));
        }
    }
    if skipped > 0 {
        raw.notes.push(format!("{skipped} points, lines and triangles are ignored."));
    }
    Ok("GiD ASCII")
}

/// The kind of the elements under a `MESH` line.
fn header(line: Line) -> Result<Kind, MeshError> {
    // The name of the block stands in quotes and may hold anything.
    let unquoted: String = line.text.split('"').step_by(2).collect::<Vec<_>>().join(" ").to_lowercase();
    let words: Vec<&str> = unquoted.split_ascii_whitespace().collect();
    let value = |key: &str| words.iter().position(|w| *w == key).and_then(|i| words.get(i + 1).copied());
    let refuse = |message: String| {
        Err(line.error(message, "expected: MESH dimension 3 ElemType Tetrahedra Nnode 4 (or Nnode 10)"))
    };
    match value("dimension") {
        Some("3") => {}
        other => return refuse(format!("the mesh has dimension {}, not 3", other.unwrap_or("(not given)"))),
    }
    match (value("elemtype"), value("nnode")) {
        (Some("tetrahedra"), Some("4")) => Ok(Kind::Tet4),
        (Some("tetrahedra"), Some("10")) => Ok(Kind::Tet10),
        (Some("point" | "linear" | "triangle"), _) => Ok(Kind::Skipped),
        (Some("tetrahedra"), nodes) => refuse(format!("tetrahedra of {} nodes", nodes.unwrap_or("(not given)"))),
        (Some(other), _) => refuse(format!("elements of type {other:?}, not tetrahedra")),
        (None, _) => refuse("the MESH line has no ElemType".to_owned()),
    }
}

/// Reads lines up to `end <name>`.
fn section(
    lines: &mut Lines,
    name: &str,
    mut entry: impl FnMut(Line) -> Result<(), MeshError>,
) -> Result<(), MeshError> {
    loop {
        let line = lines.expect(&format!("\"end {name}\""))?;
        let text = line.text.trim_ascii();
        if text.get(..3).is_some_and(|word| word.eq_ignore_ascii_case("end")) {
            let rest = text[3..].trim_ascii();
            if rest.eq_ignore_ascii_case(name) {
                return Ok(());
            }
            return Err(line.error(format!("expected \"end {name}\", found {}", line.quoted()), "a section is cut off"));
        }
        if !text.starts_with('#') {
            entry(line)?;
        }
    }
}

fn node(line: Line, raw: &mut Raw) -> Result<(), MeshError> {
    let mut fields = line.fields();
    let id = fields.id("the node's id")?;
    let position = fields.position(id)?;
    fields.end()?;
    raw.nodes.push(id, position, line.place());
    Ok(())
}

/// An element: id, nodes, and perhaps the number of a material.
fn element(line: Line, kind: Kind, raw: &mut Raw, skipped: &mut usize) -> Result<(), MeshError> {
    if kind == Kind::Skipped {
        *skipped += 1;
        return Ok(());
    }
    let mut fields = line.fields();
    let id = fields.id("the element's id")?;
    let nodes = fields.ids("a node of the element")?;
    if kind == Kind::Tet10 {
        let cell = raw.tets.nodes.len();
        raw.midsides(id, MidsideOrder::Vtk, fields.ids("a mid-side node of the element")?, cell, line.place());
    }
    let region = fields.optional_tag("the element's material")?.unwrap_or(0);
    fields.end()?;
    if region != 0 {
        raw.region_names.entry(region).or_insert_with(|| format!("material-{region}"));
    }
    raw.tets.push(id, nodes, region, line.place());
    Ok(())
}
