//! Gmsh MSH 2.2: one node a line, one element a line with its own tags.

use super::gmsh::{self, Place};
use super::{Lines, MeshError, Node, Raw};

/// Reads a section if it is one of this format's two.
pub(super) fn section(name: &str, lines: &mut Lines, raw: &mut Raw) -> Result<bool, MeshError> {
    match name {
        "Nodes" => nodes(lines, raw)?,
        "Elements" => elements(lines, raw)?,
        _ => return Ok(false),
    }
    Ok(true)
}

fn nodes(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let list = lines.expect("the number of nodes")?.count("nodes")?;
    lines.check_count(&list)?;
    for i in 0..list.count {
        let line = lines.entry(&list, i)?;
        let mut fields = line.fields();
        let id = fields.id("the node's id")?;
        let position = fields.position(id)?;
        fields.end()?;
        raw.nodes.push(Node { id, position, line: line.number });
    }
    Ok(())
}

/// Elements: id, type, number of tags, tags (physical, entity, ...), nodes.
fn elements(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let list = lines.expect("the number of elements")?.count("elements")?;
    lines.check_count(&list)?;
    for i in 0..list.count {
        let line = lines.entry(&list, i)?;
        let mut fields = line.fields();
        let [id, kind, tags] = fields.ids("the element's id, type or number of tags")?;
        let physical = if tags > 0 { fields.tag("the physical tag")? } else { 0 };
        let entity = if tags > 1 { fields.tag("the entity's tag")? } else { 0 };
        fields.skip((tags as usize).saturating_sub(2), "tags")?;
        let physicals: &[i32] = if physical == 0 { &[] } else { &[physical.saturating_abs()] };
        gmsh::element((line, id, kind), &mut fields, &Place { entity, physicals }, raw)?;
    }
    Ok(())
}
