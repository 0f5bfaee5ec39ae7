//! What the Gmsh formats share: the version, sections, physical names, element types.

use super::binary::Binary;
use super::lines::{Line, Lines};
use super::raw::{MidsideOrder, Raw};
use super::source::{Source, Text};
use super::{gmsh2, gmsh4};
use crate::mesh::MeshError;
use std::io::BufRead;
use std::path::Path;

const CONVERT: &str = "convert it: gmsh in.msh -save -format msh41 -o out.msh";

/// A node and a tetrahedron take at least so many bytes, in a text or not: announced lists get no more memory.
pub(super) const NODE_BYTES: usize = 8;
pub(super) const ELEMENT_BYTES: usize = 10;

/// The versions that are read.
#[derive(Clone, Copy)]
enum Version {
    Two,
    Four,
}

/// Whether a file that begins with `head` is a binary Gmsh file.
pub(super) fn is_binary(head: &[u8]) -> bool {
    let mut words = head.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.next() == Some(b"$MeshFormat") && words.nth(1) == Some(b"1")
}

/// Reads a text whose first line was `$MeshFormat`.
pub(super) fn read_text(path: &Path, lines: Lines, raw: &mut Raw) -> Result<&'static str, MeshError> {
    let mut source = Text::new(path, lines);
    let version = version(source.line("the version of the format")?)?;
    end(&mut source, "MeshFormat")?;
    sections(&mut source, version, raw)?;
    Ok(match version {
        Version::Two => "Gmsh MSH 2.2 ASCII",
        Version::Four => "Gmsh MSH 4.1 ASCII",
    })
}

/// Reads a binary file of `length` bytes.
pub(super) fn read_binary(
    path: &Path,
    reader: impl BufRead,
    length: u64,
    raw: &mut Raw,
) -> Result<&'static str, MeshError> {
    raw.binary = true;
    let mut source = Binary::new(path, reader, length);
    source.line("$MeshFormat")?;
    let version = version(source.line("the version of the format")?)?;
    source.read_byte_order()?;
    end(&mut source, "MeshFormat")?;
    source.set_id_bytes(match version {
        Version::Two => 4,
        Version::Four => 8,
    });
    sections(&mut source, version, raw)?;
    Ok(match version {
        Version::Two => "Gmsh MSH 2.2 binary",
        Version::Four => "Gmsh MSH 4.1 binary",
    })
}

/// The version from the line "4.1 0 8": version, 1 if binary, bytes of a number.
fn version(line: Line) -> Result<Version, MeshError> {
    let words: Vec<&str> = line.text.split_ascii_whitespace().collect();
    match words[..] {
        ["2" | "2.0" | "2.1" | "2.2", "0" | "1", ..] => Ok(Version::Two),
        ["4.1", "0", ..] | ["4.1", "1", "8", ..] => Ok(Version::Four),
        [version, "0" | "1", ..] => {
            Err(line.error(format!("Gmsh MSH version {version}; versions 2.2 and 4.1 (of 8 bytes) are read"), CONVERT))
        }
        _ => {
            let message = format!("expected a version and file type such as \"4.1 0 8\", found {}", line.quoted());
            Err(line.error(message, CONVERT))
        }
    }
}

/// Reads all sections, skipping those that are not needed.
fn sections(source: &mut impl Source, version: Version, raw: &mut Raw) -> Result<(), MeshError> {
    let (mut nodes, mut elements) = (false, false);
    let mut entities = gmsh4::Entities::default();
    while let Some(line) = source.next_line()? {
        let Some(name) = line.text.trim_ascii().strip_prefix('$').filter(|n| !n.starts_with("End")) else {
            let message = format!("expected a section ($Nodes, ...), found {}", line.quoted());
            return Err(line.error(message, "remove the line, or write the file again"));
        };
        let name = name.to_owned();
        nodes |= name == "Nodes";
        elements |= name == "Elements";
        let known = match (name.as_str(), version) {
            ("PhysicalNames", _) => {
                physical_names(source, raw)?;
                true
            }
            (name, Version::Two) => gmsh2::section(name, source, raw)?,
            (name, Version::Four) => gmsh4::section(name, source, raw, &mut entities)?,
        };
        if known {
            end(source, &name)?;
        } else {
            let last = format!("$End{name}");
            while !source.line(&last)?.text.trim_ascii().ends_with(&last) {}
        }
    }
    for (there, name) in [(nodes, "$Nodes"), (elements, "$Elements")] {
        if !there {
            return Err(source.error_at_end(format!("the section {name} is missing"), "write the file again"));
        }
    }
    Ok(())
}

/// Expects the end of a section.
fn end(source: &mut impl Source, name: &str) -> Result<(), MeshError> {
    let line = source.line(&format!("$End{name}"))?;
    if line.text.trim_ascii().strip_prefix("$End") == Some(name) {
        return Ok(());
    }
    let message = format!("expected $End{name}, found {}", line.quoted());
    Err(line.error(message, "the count of the section is too small, or a line too many"))
}

/// Lines of dimension, tag and quoted name, in binary files too.
fn physical_names(source: &mut impl Source, raw: &mut Raw) -> Result<(), MeshError> {
    let list = source.line_count("physical names")?;
    for _ in 0..list.count {
        let line = source.line("a physical name")?;
        let mut fields = line.fields();
        let (dimension, tag) = (fields.id("the dimension")?, fields.tag("the physical tag")?);
        let name = line.text.split_once('"').and_then(|(_, rest)| rest.rsplit_once('"')).map(|(name, _)| name);
        let Some(name) = name else {
            return Err(line.error(format!("expected a name in quotes in {}", line.quoted()), "put quotes around it"));
        };
        match dimension {
            2 => raw.group_names.insert(tag, name.to_owned()),
            3 => raw.region_names.insert(tag, name.to_owned()),
            _ => None,
        };
    }
    Ok(())
}

/// Where an element belongs.
pub(super) struct Place<'a> {
    /// Tag of the geometric entity.
    pub(super) entity: i32,
    /// Tags of its physical groups.
    pub(super) physicals: &'a [i32],
}

/// Takes the nodes of an element of a Gmsh type. Points and lines give nothing.
pub(super) fn element(
    source: &mut impl Source,
    id: u32,
    kind: u32,
    place: &Place,
    raw: &mut Raw,
) -> Result<(), MeshError> {
    match kind {
        2 | 9 => {
            let nodes = source.ids("a node of the triangle")?;
            if kind == 9 {
                let _: [u32; 3] = source.ids("a mid-side node of the triangle")?;
            }
            let physicals = if place.physicals.is_empty() { &[0] } else { place.physicals };
            physicals.iter().for_each(|&p| raw.triangle(id, nodes, [p, place.entity], source.place()));
        }
        4 | 11 => {
            let nodes = source.ids("a node of the tetrahedron")?;
            if kind == 11 {
                let mids = source.ids("a mid-side node of the tetrahedron")?;
                raw.midsides(id, MidsideOrder::Gmsh, mids, raw.tets.nodes.len(), source.place());
            }
            let region = place.physicals.first().copied().unwrap_or(0);
            raw.tets.push(id, nodes, region, source.place());
        }
        3 | 10 | 16 => {
            let nodes = source.ids("a node of the quadrangle")?;
            skip_nodes(source, [(10, 5), (16, 4)].iter().find(|k| k.0 == kind).map_or(0, |k| k.1))?;
            let physicals = if place.physicals.is_empty() { &[0] } else { place.physicals };
            physicals.iter().for_each(|&p| raw.quad(id, nodes, [p, place.entity], source.place()));
        }
        5 | 12 | 17 => {
            let nodes = source.ids("a node of the hexahedron")?;
            raw.hex(id, nodes, place.physicals.first().copied().unwrap_or(0), source.place());
            if kind != 5 {
                let mids = source.ids("a mid-side node of the hexahedron")?;
                raw.hex_midsides(id, MidsideOrder::Gmsh, mids, source.place());
                // In the middle of faces and of the cell.
                skip_nodes(source, if kind == 12 { 7 } else { 0 })?;
            }
        }
        _ => match skipped(kind) {
            Some(nodes) => skip_nodes(source, nodes)?,
            None => return refuse(source, id, kind),
        },
    }
    source.end_entry()
}

/// Passes over nodes.
fn skip_nodes(source: &mut impl Source, count: usize) -> Result<(), MeshError> {
    (0..count).try_for_each(|_| source.id("a node of an element").map(drop))
}

/// The number of nodes of points and lines, which are not needed.
fn skipped(kind: u32) -> Option<usize> {
    Some(match kind {
        15 => 1,
        1 => 2,
        8 => 3,
        26 => 4,
        27 => 5,
        28 => 6,
        _ => return None,
    })
}

const ALONE: &str =
    "mesh the volume with tetrahedra alone (no recombination, no extruded layers), or with hexahedra alone";

fn refuse(source: &impl Source, id: u32, kind: u32) -> Result<(), MeshError> {
    let (name, help) = match kind {
        6 | 13 | 18 => ("a prism", ALONE),
        7 | 14 | 19 => ("a pyramid", ALONE),
        20..=25 | 29..=36 => ("of third or higher order", "mesh with order 1 or 2 (Gmsh: -order 1)"),
        _ => ("of a type that is not read", "mesh the volume with tetrahedra of order 1 or 2"),
    };
    Err(source
        .error(format!("element {id} (Gmsh type {kind}) is {name}; only tetrahedra and hexahedra are computed"), help))
}
