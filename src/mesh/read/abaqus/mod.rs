//! Abaqus and CalculiX input (`.inp`): nodes, elements, sets and surfaces; sections name the regions.

mod cards;
mod elements;
mod sets;
mod tags;

use super::raw::{MidsideOrder, Raw};
use crate::mesh::MeshError;
use cards::{Card, Cards};
use elements::Kind;
use sets::{Set, Sets};
use std::path::Path;

/// What the cards of a file say, beside its nodes and solids.
#[derive(Default)]
struct Deck {
    /// Triangles: id, nodes, line.
    triangles: Vec<(u32, [u32; 3], u64)>,
    /// Quadrilaterals: id, nodes, line.
    quads: Vec<(u32, [u32; 4], u64)>,
    element_sets: Sets,
    node_sets: Sets,
    /// Surfaces with their entries.
    surfaces: Vec<(String, Vec<SurfaceEntry>)>,
    /// Element sets that have a section.
    sections: Vec<String>,
}

/// An entry of a surface: elements and one of their faces, S1 to S6; `None` for all of them.
struct SurfaceEntry {
    elements: Set,
    side: Option<usize>,
}

/// Reads a text.
pub(super) fn read(path: &Path, text: &str, raw: &mut Raw) -> Result<&'static str, MeshError> {
    let mut cards = Cards::new(path, text);
    let mut deck = Deck::default();
    let (mut nodes, mut parts, mut skipped, mut ignored) = (false, 0, 0, Vec::new());
    while let Some(card) = cards.next()? {
        match card.keyword.as_str() {
            "NODE" => {
                nodes = true;
                read_nodes(&card, &mut cards, raw, &mut deck)?;
            }
            "ELEMENT" => skipped += read_elements(&card, &mut cards, raw, &mut deck)?,
            "NSET" => sets::read(&card, &mut cards, "NSET", &mut deck.node_sets)?,
            "ELSET" => sets::read(&card, &mut cards, "ELSET", &mut deck.element_sets)?,
            "SURFACE" => surface(&card, &mut cards, raw, &mut deck)?,
            "SOLIDSECTION" => deck.sections.push(card.value("ELSET")?.to_owned()),
            "PART" if parts == 0 => parts = 1,
            "PART" => {
                let message = "a second *PART: parts have ids of their own, which are not read";
                return Err(card.error(message, "write a flat file: without parts and assemblies, or of one part"));
            }
            "INCLUDE" => {
                let message = format!("*INCLUDE of {:?}: other files are not read", card.value("INPUT")?);
                return Err(card.error(message, "put the content of that file in place of this line"));
            }
            "SYSTEM" | "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => {
                let message =
                    format!("*{}: nodes and elements that are not listed one by one are not read", card.keyword);
                return Err(card.error(message, "write the mesh out in full (most preprocessors do)"));
            }
            "HEADING" | "ENDPART" | "ASSEMBLY" | "ENDASSEMBLY" | "INSTANCE" | "ENDINSTANCE" | "PREPRINT" => {}
            other if ignored.iter().any(|known| known == other) => {}
            other => ignored.push(other.to_owned()),
        }
    }
    for (there, name) in
        [(nodes, "*NODE"), (raw.element_count() + deck.triangles.len() + deck.quads.len() > 0, "*ELEMENT")]
    {
        if !there && skipped == 0 {
            return Err(cards.error_at_end(format!("there is no {name} card with data"), "write the file again"));
        }
    }
    if skipped > 0 {
        raw.notes
            .push(format!("{skipped} lines of elements that are no solids, triangles or quadrilaterals are ignored."));
    }
    if !ignored.is_empty() {
        let list: Vec<String> = ignored.iter().map(|keyword| format!("*{keyword}")).collect();
        raw.notes.push(format!("ignored: {} (supports, loads and materials come from the scenario).", list.join(", ")));
    }
    tags::tag(deck, raw);
    Ok("Abaqus input")
}

/// Lines of id, x, y, z.
fn read_nodes(card: &Card, cards: &mut Cards, raw: &mut Raw, deck: &mut Deck) -> Result<(), MeshError> {
    if let Some(system) = card.find("SYSTEM").filter(|system| *system != "R") {
        let message = format!("*NODE in the coordinate system {system:?}, only rectangular coordinates are read");
        return Err(card.error(message, "write rectangular coordinates"));
    }
    let mut set = Set::default();
    while let Some(mut data) = cards.data() {
        let id = data.id("the node's id")?;
        raw.nodes.push(id, data.position(id)?, data.place());
        set.push(id);
    }
    if let Some(name) = card.find("NSET") {
        deck.node_sets.add(name, set);
    }
    Ok(())
}

/// Lines of id and nodes. Gives the number of lines that were passed over.
fn read_elements(card: &Card, cards: &mut Cards, raw: &mut Raw, deck: &mut Deck) -> Result<usize, MeshError> {
    let kind = elements::kind(card)?;
    let mut skipped = 0;
    let mut set = Set::default();
    while let Some(mut data) = cards.data() {
        let Some((kind, nodes)) = kind else {
            skipped += 1;
            continue;
        };
        let (id, place) = (data.id("the element's id")?, data.place());
        let ids = cards.ids(data, nodes, id)?;
        match (kind, ids.as_slice()) {
            (Kind::Tet, &[a, b, c, d, ref mids @ ..]) => {
                raw.tets.push(id, [a, b, c, d], 0, place);
                if let &[e, f, g, h, i, j] = mids {
                    let cell = raw.tets.nodes.len() - 1;
                    raw.midsides(id, MidsideOrder::Vtk, [e, f, g, h, i, j], cell, place);
                }
            }
            (Kind::Hex, &[a, b, c, d, e, f, g, h, ref mids @ ..]) => {
                raw.hex(id, [a, b, c, d, e, f, g, h], 0, place);
                if let Some(mids) = mids.first_chunk() {
                    raw.hex_midsides(id, MidsideOrder::Vtk, *mids, place);
                }
            }
            (Kind::Quad, &[a, b, c, d, ..]) => deck.quads.push((id, [a, b, c, d], place)),
            (Kind::Triangle, &[a, b, c, ..]) => deck.triangles.push((id, [a, b, c], place)),
            _ => {}
        }
        set.push(id);
    }
    if let Some(name) = card.find("ELSET") {
        deck.element_sets.add_block(name, set);
    }
    Ok(skipped)
}

/// Lines of an element or a set and the label of a face; of a node surface, of a node or a set.
fn surface(card: &Card, cards: &mut Cards, raw: &Raw, deck: &mut Deck) -> Result<(), MeshError> {
    let name = card.value("NAME")?;
    if card.find("TYPE").is_some_and(|kind| kind.eq_ignore_ascii_case("NODE")) {
        let mut set = Set::default();
        while let Some(mut data) = cards.data() {
            set.extend(&deck.node_sets.parse(&mut data)?);
        }
        deck.node_sets.add(name, set);
        return Ok(());
    }
    let (sides, cell) = if raw.hexes.nodes.is_empty() { (4, "tetrahedron") } else { (6, "hexahedron") };
    let mut entries = Vec::new();
    while let Some(mut data) = cards.data() {
        let elements = deck.element_sets.parse(&mut data)?;
        let side = match data.word().to_ascii_uppercase().as_str() {
            "" | "SPOS" | "SNEG" => None,
            label => match label.strip_prefix('S').and_then(|n| n.parse().ok()) {
                Some(n) if (1..=sides).contains(&n) => Some(n),
                _ => {
                    let message = format!("face {label:?}, expected S1 to S{sides}");
                    return Err(data.error(message, &format!("name a {cell}'s face")));
                }
            },
        };
        entries.push(SurfaceEntry { elements, side });
    }
    deck.surfaces.push((name.to_owned(), entries));
    Ok(())
}
