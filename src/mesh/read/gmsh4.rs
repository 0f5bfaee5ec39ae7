//! Gmsh MSH 4.1: nodes and elements in blocks, one geometric entity each; physical groups belong to entities.

use super::gmsh::{self, Place, announced};
use super::lines::{Announced, Line};
use super::{Lines, MeshError, Node, Raw};
use std::collections::BTreeMap;

/// Physical groups of each entity, by dimension and tag.
pub(super) type Entities = BTreeMap<(u32, i32), Vec<i32>>;

/// Reads a section if it is one of this format's three.
pub(super) fn section(
    name: &str,
    lines: &mut Lines,
    raw: &mut Raw,
    entities: &mut Entities,
) -> Result<bool, MeshError> {
    match name {
        "Entities" => read_entities(lines, entities)?,
        "Nodes" => nodes(lines, raw)?,
        "Elements" => elements(lines, raw, entities)?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// Points (tag, position, physicals), then curves, surfaces and volumes (tag, box, physicals, boundary).
fn read_entities(lines: &mut Lines, entities: &mut Entities) -> Result<(), MeshError> {
    let mut header = lines.expect("the numbers of entities")?.fields();
    let mut lists = Vec::new();
    for what in ["points", "curves", "surfaces", "volumes"] {
        lists.push(announced(lines, &mut header, what)?);
    }
    header.end()?;
    for (dimension, list) in (0..).zip(&lists) {
        for i in 0..list.count {
            let mut fields = lines.entry(list, i)?.fields();
            let tag = fields.tag("the entity's tag")?;
            fields.skip(if dimension == 0 { 3 } else { 6 }, "coordinates")?;
            let physicals = fields.count("physical groups")?;
            let mut groups = Vec::new();
            for _ in 0..physicals.count {
                groups.push(fields.tag("a physical tag")?.saturating_abs());
            }
            entities.insert((dimension, tag), groups);
        }
    }
    Ok(())
}

/// Header of a section in blocks: number of blocks, number of entries in all, smallest and largest tag.
fn blocks(lines: &mut Lines, what: &'static str) -> Result<(Announced, Announced), MeshError> {
    let mut fields = lines.expect("the numbers of blocks and entries")?.fields();
    let blocks = announced(lines, &mut fields, "blocks")?;
    let entries = announced(lines, &mut fields, what)?;
    fields.skip(2, "smallest and largest tag")?;
    fields.end()?;
    Ok((blocks, entries))
}

/// Refuses blocks that hold another number of entries than the section's header says.
fn check_total(lines: &Lines, entries: &Announced, found: usize) -> Result<(), MeshError> {
    let Announced { what, count, line } = entries;
    if found == *count {
        return Ok(());
    }
    let message = format!("{count} {what} are announced in line {line}, but the blocks hold {found}");
    Err(lines.error_at_end(message, "a block is missing or one too many: write the file again"))
}

fn nodes(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let (blocks, entries) = blocks(lines, "nodes")?;
    let before = raw.nodes.len();
    for i in 0..blocks.count {
        let mut header = lines.entry(&blocks, i)?.fields();
        let [_dimension] = header.ids("the entity's dimension")?;
        let _entity = header.tag("the entity's tag")?;
        let [parametric] = header.ids("the flag for parametric coordinates")?;
        let list = announced(lines, &mut header, "nodes")?;
        header.end()?;
        let mut ids = Vec::new();
        for j in 0..list.count {
            let mut fields = lines.entry(&list, j)?.fields();
            ids.push(fields.id("the node's id")?);
            fields.end()?;
        }
        for (j, &id) in ids.iter().enumerate() {
            let line = lines.entry(&list, j)?;
            raw.nodes.push(node(line, id, parametric != 0)?);
        }
    }
    check_total(lines, &entries, raw.nodes.len() - before)
}

/// A position, followed by parameters on its curve or surface where the block is parametric.
fn node(line: Line, id: u32, parametric: bool) -> Result<Node, MeshError> {
    let mut fields = line.fields();
    let position = fields.position(id)?;
    if !parametric {
        fields.end()?;
    }
    Ok(Node { id, position, line: line.number })
}

fn elements(lines: &mut Lines, raw: &mut Raw, entities: &Entities) -> Result<(), MeshError> {
    let (blocks, entries) = blocks(lines, "elements")?;
    let mut found = 0;
    for i in 0..blocks.count {
        let mut header = lines.entry(&blocks, i)?.fields();
        let [dimension] = header.ids("the entity's dimension")?;
        let entity = header.tag("the entity's tag")?;
        let [kind] = header.ids("the element type")?;
        let list = announced(lines, &mut header, "elements")?;
        header.end()?;
        let physicals = entities.get(&(dimension, entity)).map_or(&[][..], Vec::as_slice);
        if dimension == 3 && physicals.len() > 1 {
            raw.notes.push(format!(
                "volume {entity} is in several physical groups ({physicals:?}): the first is its region."
            ));
        }
        for j in 0..list.count {
            let line = lines.entry(&list, j)?;
            let mut fields = line.fields();
            let id = fields.id("the element's id")?;
            gmsh::element((line, id, kind), &mut fields, &Place { entity, physicals }, raw)?;
        }
        found += list.count;
    }
    check_total(lines, &entries, found)
}
