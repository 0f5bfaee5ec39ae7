//! Gmsh MSH 4.1: nodes and elements in blocks, one geometric entity each; physical groups belong to entities.

use super::gmsh::{self, Place};
use super::lines::Announced;
use super::raw::Raw;
use super::source::Source;
use crate::mesh::MeshError;
use std::collections::BTreeMap;

/// Physical groups of each entity, by dimension and tag.
pub(super) type Entities = BTreeMap<(i32, i32), Vec<i32>>;

/// Reads a section if it is one of this format's four.
pub(super) fn section(
    name: &str,
    source: &mut impl Source,
    raw: &mut Raw,
    entities: &mut Entities,
) -> Result<bool, MeshError> {
    match name {
        "Entities" => read_entities(source, entities, false)?,
        "PartitionedEntities" => partitioned(source, entities)?,
        "Nodes" => nodes(source, raw)?,
        "Elements" => elements(source, raw, entities)?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// Points (tag, position, physicals), then curves, surfaces and volumes (tag, box, physicals, boundary). Those of
/// `parted` meshes name their parent and their partitions too.
fn read_entities<S: Source>(source: &mut S, entities: &mut Entities, parted: bool) -> Result<(), MeshError> {
    source.begin("the numbers of entities")?;
    let mut lists = Vec::new();
    for what in ["points", "curves", "surfaces", "volumes"] {
        lists.push(source.count(what)?);
    }
    source.end_entry()?;
    for (dimension, list) in (0..).zip(&lists) {
        for i in 0..list.count {
            source.entry(list, i)?;
            let tag = source.int("the entity's tag")?;
            if parted {
                source.skip(2, 4, "the entity's parent")?;
                let partitions = source.count("partitions")?;
                source.skip(partitions.count, 4, "partitions")?;
            }
            source.skip(if dimension == 0 { 3 } else { 6 }, 8, "coordinates")?;
            let physicals = source.count("physical groups")?;
            let mut groups = Vec::new();
            for _ in 0..physicals.count {
                groups.push(source.int("a physical tag")?.saturating_abs());
            }
            if S::BINARY && dimension > 0 {
                let boundary = source.count("bounding entities")?;
                source.skip(boundary.count, 4, "bounding entities")?;
            }
            entities.insert((dimension, tag), groups);
        }
    }
    Ok(())
}

/// The entities of a mesh cut into partitions; its elements belong to them.
fn partitioned(source: &mut impl Source, entities: &mut Entities) -> Result<(), MeshError> {
    source.begin("the number of partitions")?;
    source.count("partitions")?;
    source.end_entry()?;
    source.begin("the number of ghost entities")?;
    let ghosts = source.count("ghost entities")?;
    source.end_entry()?;
    for i in 0..ghosts.count {
        source.entry(&ghosts, i)?;
        source.skip(2, 4, "a ghost entity")?;
    }
    read_entities(source, entities, true)
}

/// Header of a section in blocks: number of blocks, number of entries in all, smallest and largest tag.
fn blocks(source: &mut impl Source, what: &'static str) -> Result<(Announced, Announced), MeshError> {
    source.begin("the numbers of blocks and entries")?;
    let blocks = source.count("blocks")?;
    let entries = source.count(what)?;
    source.skip(2, 8, "smallest and largest tag")?;
    source.end_entry()?;
    Ok((blocks, entries))
}

/// Refuses blocks that hold another number of entries than the section's header says.
fn check_total(source: &impl Source, entries: &Announced, found: usize) -> Result<(), MeshError> {
    let Announced { what, count, at } = entries;
    if found == *count {
        return Ok(());
    }
    let message = format!("{count} {what} are announced in {}, but the blocks hold {found}", at.named());
    Err(source.error_at_end(message, "a block is missing or one too many: write the file again"))
}

fn nodes(source: &mut impl Source, raw: &mut Raw) -> Result<(), MeshError> {
    let (blocks, entries) = blocks(source, "nodes")?;
    let before = raw.nodes.positions.len();
    raw.nodes.positions.reserve(entries.count.min(source.remaining() as usize / gmsh::NODE_BYTES));
    for i in 0..blocks.count {
        source.entry(&blocks, i)?;
        let dimension = source.int("the entity's dimension")?;
        let _entity = source.int("the entity's tag")?;
        let parametric = source.int("the flag for parametric coordinates")? != 0;
        let list = source.count("nodes")?;
        source.end_entry()?;
        let mut ids = Vec::with_capacity(list.count.min(source.remaining() as usize / gmsh::NODE_BYTES));
        for j in 0..list.count {
            source.entry(&list, j)?;
            ids.push(source.id("the node's id")?);
            source.end_entry()?;
        }
        for (j, &id) in ids.iter().enumerate() {
            source.entry(&list, j)?;
            let position = source.position(id)?;
            if parametric {
                source.skip(dimension.clamp(0, 3) as usize, 8, "parameters")?;
            } else {
                source.end_entry()?;
            }
            raw.nodes.push(id, position, source.place());
        }
    }
    check_total(source, &entries, raw.nodes.positions.len() - before)
}

fn elements(source: &mut impl Source, raw: &mut Raw, entities: &Entities) -> Result<(), MeshError> {
    let (blocks, entries) = blocks(source, "elements")?;
    let mut found = 0;
    for i in 0..blocks.count {
        source.entry(&blocks, i)?;
        let dimension = source.int("the entity's dimension")?;
        let entity = source.int("the entity's tag")?;
        let kind = source.int("the element type")?.unsigned_abs();
        let list = source.count("elements")?;
        source.end_entry()?;
        let physicals = entities.get(&(dimension, entity)).map_or(&[][..], Vec::as_slice);
        if dimension == 3 && physicals.len() > 1 {
            raw.notes.push(format!(
                "volume {entity} is in several physical groups ({physicals:?}): the first is its region."
            ));
        }
        if dimension == 3 && matches!(kind, 4 | 11) {
            raw.tets.nodes.reserve(list.count.min(source.remaining() as usize / gmsh::ELEMENT_BYTES));
        }
        for j in 0..list.count {
            source.entry(&list, j)?;
            let id = source.id("the element's id")?;
            gmsh::element(source, id, kind, &Place { entity, physicals }, raw)?;
        }
        found += list.count;
    }
    check_total(source, &entries, found)
}
