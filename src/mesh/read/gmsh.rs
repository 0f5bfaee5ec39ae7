//! What the Gmsh formats share: the version, sections, physical names, element types.

use super::lines::{Announced, Fields, Line};
use super::{Lines, MeshError, Raw, Tet, Triangle, gmsh2, gmsh4};

const CONVERT: &str = "convert it: gmsh in.msh -save -format msh41 -o out.msh (writes ASCII unless -bin is given)";

/// The reader of one section: takes the lines after `$Name` up to, and not with, `$EndName`. Gives false for a section
/// it does not know.
type Section<'f> = dyn FnMut(&str, &mut Lines, &mut Raw) -> Result<bool, MeshError> + 'f;

/// Reads a file whose first line was `$MeshFormat`.
pub(super) fn read(lines: &mut Lines, raw: &mut Raw) -> Result<&'static str, MeshError> {
    let line = lines.expect("the version of the format")?;
    let mut words = line.text.split_ascii_whitespace();
    let (version, file_type) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    match (version, file_type) {
        (_, "1") => return Err(line.error(format!("a binary Gmsh file (MSH {version}), only ASCII is read"), CONVERT)),
        (_, "0") => {}
        _ => {
            let message = format!("expected a version and file type such as \"4.1 0 8\", found {}", line.quoted());
            return Err(line.error(message, CONVERT));
        }
    }
    end(lines, "MeshFormat")?;
    match version {
        "2" | "2.0" | "2.1" | "2.2" => {
            sections(lines, raw, &mut gmsh2::section)?;
            Ok("Gmsh MSH 2.2 ASCII")
        }
        "4.1" => {
            let mut entities = gmsh4::Entities::default();
            sections(lines, raw, &mut |name, lines, raw| gmsh4::section(name, lines, raw, &mut entities))?;
            Ok("Gmsh MSH 4.1 ASCII")
        }
        _ => Err(line.error(format!("Gmsh MSH version {version}; versions 2.2 and 4.1 are read"), CONVERT)),
    }
}

/// Reads all sections, skipping those that `section` does not know.
fn sections(lines: &mut Lines, raw: &mut Raw, section: &mut Section) -> Result<(), MeshError> {
    let (mut nodes, mut elements) = (false, false);
    while let Some(line) = lines.next() {
        let name = line.text.trim_ascii();
        let Some(name) = name.strip_prefix('$').filter(|n| !n.starts_with("End")) else {
            let message = format!("expected a section ($Nodes, ...), found {}", line.quoted());
            return Err(line.error(message, "remove the line, or write the file again"));
        };
        nodes |= name == "Nodes";
        elements |= name == "Elements";
        let known = if name == "PhysicalNames" {
            physical_names(lines, raw)?;
            true
        } else {
            section(name, lines, raw)?
        };
        if known {
            end(lines, name)?;
        } else {
            while lines.expect(&format!("$End{name}"))?.text.trim_ascii().strip_prefix("$End") != Some(name) {}
        }
    }
    for (there, name) in [(nodes, "$Nodes"), (elements, "$Elements")] {
        if !there {
            return Err(lines.error_at_end(format!("the section {name} is missing"), "write the file again"));
        }
    }
    Ok(())
}

/// Expects the end of a section.
fn end(lines: &mut Lines, name: &str) -> Result<(), MeshError> {
    let line = lines.expect(&format!("$End{name}"))?;
    if line.text.trim_ascii().strip_prefix("$End") == Some(name) {
        return Ok(());
    }
    let message = format!("expected $End{name}, found {}", line.quoted());
    Err(line.error(message, "the count of the section is too small, or a line too many"))
}

/// Lines of dimension, tag and quoted name.
fn physical_names(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let list = lines.expect("the number of physical names")?.count("physical names")?;
    lines.check_count(&list)?;
    for i in 0..list.count {
        let line = lines.entry(&list, i)?;
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

/// Takes the nodes of an element of a Gmsh type. Points, lines and quadrangles give nothing.
pub(super) fn element(
    (line, id, kind): (Line, u32, u32),
    fields: &mut Fields,
    place: &Place,
    raw: &mut Raw,
) -> Result<(), MeshError> {
    match kind {
        2 | 9 => {
            let nodes = fields.ids("a node of the triangle")?;
            if kind == 9 {
                let _: [u32; 3] = fields.ids("a mid-side node of the triangle")?;
            }
            let physicals = if place.physicals.is_empty() { &[0] } else { place.physicals };
            raw.triangles.extend(physicals.iter().map(|&physical| Triangle {
                id,
                nodes,
                physical,
                entity: place.entity,
                line: line.number,
            }));
        }
        4 | 11 => {
            let nodes = fields.ids("a node of the tetrahedron")?;
            if kind == 11 {
                raw.midsides.push((fields.ids("a mid-side node of the tetrahedron")?, line.number));
            }
            let region = place.physicals.first().copied().unwrap_or(0);
            raw.tets.push(Tet { id, nodes, region, line: line.number });
        }
        1 | 3 | 8 | 10 | 15 | 16 | 26..=28 => return Ok(()),
        _ => return refuse(line, id, kind),
    }
    fields.end()
}

fn refuse(line: Line, id: u32, kind: u32) -> Result<(), MeshError> {
    let (name, help) = match kind {
        5 | 12 | 17 => ("a hexahedron", "mesh the volume with tetrahedra alone (no recombination, no extruded layers)"),
        6 | 13 | 18 => ("a prism", "mesh the volume with tetrahedra alone (no recombination, no extruded layers)"),
        7 | 14 | 19 => ("a pyramid", "mesh the volume with tetrahedra alone (no recombination, no extruded layers)"),
        20..=25 | 29..=36 => ("of third or higher order", "mesh with order 1 or 2 (Gmsh: -order 1)"),
        _ => ("of a type that is not read", "mesh the volume with tetrahedra of order 1 or 2"),
    };
    Err(line.error(format!("element {id} (Gmsh type {kind}) is {name}; only tetrahedra are computed"), help))
}

/// A count announced by a field of its own line, checked against the size of the file.
pub(super) fn announced(lines: &Lines, fields: &mut Fields, what: &'static str) -> Result<Announced, MeshError> {
    let list = fields.count(what)?;
    lines.check_count(&list)?;
    Ok(list)
}
