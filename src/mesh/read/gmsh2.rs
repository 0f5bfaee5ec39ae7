//! Gmsh MSH 2.2: nodes one by one, elements with tags of their own.

use super::gmsh::{self, Place};
use super::raw::Raw;
use super::source::Source;
use crate::mesh::MeshError;

/// Reads a section if it is one of this format's two.
pub(super) fn section(name: &str, source: &mut impl Source, raw: &mut Raw) -> Result<bool, MeshError> {
    match name {
        "Nodes" => nodes(source, raw)?,
        "Elements" => elements(source, raw)?,
        _ => return Ok(false),
    }
    Ok(true)
}

fn nodes(source: &mut impl Source, raw: &mut Raw) -> Result<(), MeshError> {
    let list = source.line_count("nodes")?;
    raw.nodes.positions.reserve(list.count.min(source.remaining() as usize / gmsh::NODE_BYTES));
    for i in 0..list.count {
        source.entry(&list, i)?;
        let id = source.id("the node's id")?;
        let position = source.position(id)?;
        source.end_entry()?;
        raw.nodes.push(id, position, source.place());
    }
    Ok(())
}

/// Elements: in a text each with id, type, number of tags, tags (physical, entity, ...), nodes; in a binary file in
/// blocks of type, number of elements, number of tags, and then each with id, tags, nodes.
fn elements<S: Source>(source: &mut S, raw: &mut Raw) -> Result<(), MeshError> {
    let list = source.line_count("elements")?;
    raw.tets.nodes.reserve(list.count.min(source.remaining() as usize / gmsh::ELEMENT_BYTES));
    let mut i = 0;
    while i < list.count {
        source.entry(&list, i)?;
        if !S::BINARY {
            let [id, kind, tags] = source.ids("the element's id, type or number of tags")?;
            element(source, id, kind, tags, raw)?;
            i += 1;
            continue;
        }
        let [kind, follow, tags] = source.ids("the type, number of elements or number of tags of the block")?;
        if follow as usize > list.count - i {
            let message = format!("a block of {follow} elements, but only {} are left", list.count - i);
            return Err(source.error(message, "the file is damaged: write it again"));
        }
        for j in 0..follow as usize {
            source.entry(&list, i + j)?;
            let id = source.id("the element's id")?;
            element(source, id, kind, tags, raw)?;
        }
        i += follow as usize;
    }
    Ok(())
}

/// The tags and nodes of an element.
fn element(source: &mut impl Source, id: u32, kind: u32, tags: u32, raw: &mut Raw) -> Result<(), MeshError> {
    let physical = if tags > 0 { source.int("the physical tag")? } else { 0 };
    let entity = if tags > 1 { source.int("the entity's tag")? } else { 0 };
    source.skip((tags as usize).saturating_sub(2), 4, "tags")?;
    let physicals: &[i32] = if physical == 0 { &[] } else { &[physical.saturating_abs()] };
    gmsh::element(source, id, kind, &Place { entity, physicals }, raw)
}
