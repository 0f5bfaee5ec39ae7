//! Regions and groups from sets, sections and surfaces.

use super::super::raw::Raw;
use super::sets::{Set, Sets};
use super::{Deck, SurfaceEntry};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// The nodes of the faces S1 to S4 of a tetrahedron.
const SIDES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

/// The nodes of the faces S1 to S6 of a hexahedron, in our order of corners.
const HEX_SIDES: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [1, 5, 7, 3], [3, 7, 6, 2], [2, 6, 4, 0]];

/// The elements of a file by id.
struct Known {
    /// Ascending.
    ids: Vec<u32>,
    /// How many cells there are; of those with the same id the last is known.
    cell_count: usize,
    /// Hexahedra, or tetrahedra if the file has none.
    cells: FxHashMap<u32, usize>,
    triangles: FxHashMap<u32, usize>,
    quads: FxHashMap<u32, usize>,
}

/// Tags the cells of `raw` with their regions, and gives it the triangles of its groups.
pub(super) fn tag(deck: Deck, raw: &mut Raw) {
    let ids = if raw.hexes.nodes.is_empty() { &raw.tets.ids } else { &raw.hexes.ids };
    let mut ids: Vec<u32> = ids.iter().map(|id| id as u32).collect();
    let cell_count = ids.len();
    let cells: FxHashMap<u32, usize> = ids.iter().copied().zip(0..).collect();
    let triangles: FxHashMap<u32, usize> = deck.triangles.iter().map(|t| t.0).zip(0..).collect();
    let quads: FxHashMap<u32, usize> = deck.quads.iter().map(|q| q.0).zip(0..).collect();
    ids.extend(deck.triangles.iter().map(|t| t.0).chain(deck.quads.iter().map(|q| q.0)));
    ids.sort_unstable();
    ids.dedup();
    let known = Known { ids, cell_count, cells, triangles, quads };
    regions(&deck, &known, raw);
    groups(&deck, &known, raw);
    node_groups(&deck, raw);
}

/// Regions are the element sets of the sections; without sections, sets that cut the cells into disjoint parts: those of
/// `*ELSET` cards if they do, else those of the `*ELEMENT` cards.
fn regions(deck: &Deck, known: &Known, raw: &mut Raw) {
    let sets = &deck.element_sets;
    let sections: Vec<(&str, usize)> =
        deck.sections.iter().filter_map(|name| sets.find(name).map(|set| (name.as_str(), set))).collect();
    let of = |block: bool| sets.iter().filter(move |s| s.1 == block).map(|(name, _, set)| (name, set)).collect();
    let (cards, blocks): (Vec<_>, Vec<_>) = (of(false), of(true));
    let choice = if sections.is_empty() {
        [cards, blocks].into_iter().find_map(|list| Some((partition(&list, sets, known)?, list)))
    } else {
        Some((assign(&sections, sets, known), sections))
    };
    let Some((regions, list)) = choice else { return };
    let tags = regions.iter().map(|region| region.map_or(0, |r| r as i32 + 1));
    raw.region_names = (1..).zip(list.iter().map(|(name, _)| (*name).to_owned())).collect();
    let of_cells = if raw.hexes.nodes.is_empty() { &mut raw.tets.tags } else { &mut raw.hexes.tags };
    *of_cells = Default::default();
    tags.for_each(|tag| of_cells.push(i64::from(tag)));
}

/// The set of each cell, the last one that holds it.
fn assign(list: &[(&str, usize)], sets: &Sets, known: &Known) -> Vec<Option<usize>> {
    let mut regions = vec![None; known.cell_count];
    for (r, (_, set)) in list.iter().enumerate() {
        sets.members(sets.get(*set), &known.ids, |id| {
            if let Some(&t) = known.cells.get(&id) {
                regions[t] = Some(r);
            }
        });
    }
    regions
}

/// The set of each cell if every one is in exactly one of the sets; sets of all cells do not count if there
/// are others.
fn partition(list: &[(&str, usize)], sets: &Sets, known: &Known) -> Option<Vec<Option<usize>>> {
    let mut regions = vec![None; known.cell_count];
    let mut whole = None;
    for (r, (_, set)) in list.iter().enumerate() {
        let mut members = Vec::new();
        sets.members(sets.get(*set), &known.ids, |id| members.extend(known.cells.get(&id).copied()));
        members.sort_unstable();
        members.dedup();
        if members.len() == regions.len() {
            whole = whole.or(Some(r));
            continue;
        }
        for t in members {
            if regions[t].replace(r).is_some() {
                return None;
            }
        }
    }
    if regions.iter().all(Option::is_none) {
        return whole.map(|r| vec![Some(r); known.cell_count]);
    }
    regions.iter().all(Option::is_some).then_some(regions)
}

/// Groups are the sets that hold triangles or quadrilaterals, and the surfaces.
fn groups(deck: &Deck, known: &Known, raw: &mut Raw) {
    let push = |raw: &mut Raw, name: &str, entries: &[(&Set, Range<usize>)]| {
        let tag = raw.group_names.len() as i32 + 1;
        let sides_of = |raw: &Raw| raw.triangles.nodes.len() + raw.quads.nodes.len();
        let before = sides_of(raw);
        for (set, sides) in entries {
            deck.element_sets.members(set, &known.ids, |id| {
                if let Some(&t) = known.triangles.get(&id) {
                    let (id, nodes, place) = deck.triangles[t];
                    raw.triangle(id, nodes, [tag, 0], place);
                } else if let Some(&q) = known.quads.get(&id) {
                    let (id, nodes, place) = deck.quads[q];
                    raw.quad(id, nodes, [tag, 0], place);
                } else if let Some(&t) = known.cells.get(&id).filter(|_| !raw.hexes.nodes.is_empty()) {
                    let (cell, place) = (raw.hexes.nodes[t], raw.hexes.places.get(t) as u64);
                    let faces = &HEX_SIDES[sides.clone()];
                    faces.iter().for_each(|face| raw.quad(id, face.map(|i| cell[i]), [tag, 0], place));
                } else if let Some(&t) = known.cells.get(&id) {
                    let (tet, place) = (raw.tets.nodes[t], raw.tets.places.get(t) as u64);
                    let faces = &SIDES[sides.start.min(4)..sides.end.min(4)];
                    faces.iter().for_each(|face| raw.triangle(id, face.map(|i| tet[i]), [tag, 0], place));
                }
            });
        }
        if sides_of(raw) > before {
            raw.group_names.insert(tag, name.to_owned());
        }
    };
    for (name, _, set) in deck.element_sets.iter() {
        push(raw, name, &[(deck.element_sets.get(set), 0..0)]);
    }
    for (name, entries) in &deck.surfaces {
        let sides = |entry: &SurfaceEntry| entry.side.map_or(0..6, |side| side - 1..side);
        let entries: Vec<_> = entries.iter().map(|entry| (&entry.elements, sides(entry))).collect();
        push(raw, name, &entries);
    }
}

/// Sets of nodes that give groups of faces all whose corners they hold.
fn node_groups(deck: &Deck, raw: &mut Raw) {
    let mut ids: Vec<u32> = raw.nodes.ids.iter().map(|id| id as u32).collect();
    ids.sort_unstable();
    for (name, _, set) in deck.node_sets.iter() {
        let mut members = Vec::new();
        deck.node_sets.members(deck.node_sets.get(set), &ids, |id| members.push(id));
        members.sort_unstable();
        members.dedup();
        if !members.is_empty() {
            raw.node_groups.push((name.to_owned(), members));
        }
    }
}
