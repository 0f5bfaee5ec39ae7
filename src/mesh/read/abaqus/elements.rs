//! Element types.

use super::cards::Card;
use crate::mesh::MeshError;

/// What an element type is here.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Tet,
    Triangle,
    Hex,
    Quad,
}

/// Triangles of three and of six nodes: shells, membranes, plane elements, rigid surfaces.
const TRIANGLES: [&str; 12] =
    ["S3", "S3R", "S3RS", "STRI3", "CPS3", "CPE3", "CPEG3", "CAX3", "M3D3", "R3D3", "DS3", "SFM3D3"];
const SIX_NODES: [&str; 9] = ["S6", "STRI65", "CPS6", "CPS6M", "CPE6", "CPE6M", "CAX6", "M3D6", "SFM3D6"];

/// Quadrilaterals of four, eight and nine nodes.
const QUADS: [&str; 14] =
    ["S4", "S4R", "S4RS", "S4RSW", "S4R5", "CPS4", "CPS4R", "CPE4", "CPE4R", "CAX4", "M3D4", "M3D4R", "R3D4", "SFM3D4"];
const EIGHT_NODES: [&str; 10] = ["S8R", "S8R5", "CPS8", "CPS8R", "CPE8", "CPE8R", "CAX8", "M3D8", "M3D8R", "SFM3D8"];
const NINE_NODES: [&str; 3] = ["M3D9", "M3D9R", "S9R5"];

/// The kind and the number of nodes of a card's elements; `None` if they carry no stiffness here.
pub(super) fn kind(card: &Card) -> Result<Option<(Kind, usize)>, MeshError> {
    let name = card.value("TYPE")?.to_ascii_uppercase();
    // What follows the number of nodes says how the element is integrated, and what else it carries.
    let solid = name.strip_prefix("C3D").or_else(|| name.strip_prefix("DC3D"));
    let nodes = solid.map(|rest| rest.chars().take_while(char::is_ascii_digit).collect::<String>());
    let refused = match nodes.as_deref() {
        Some("4") => return Ok(Some((Kind::Tet, 4))),
        Some("10") => return Ok(Some((Kind::Tet, 10))),
        Some(nodes @ ("8" | "20" | "27")) => return Ok(nodes.parse().ok().map(|nodes| (Kind::Hex, nodes))),
        Some("6" | "15") => "wedges are not supported yet",
        Some("5" | "13") => "pyramids are not supported yet",
        Some(_) => "this type is not read",
        None if TRIANGLES.contains(&name.as_str()) => return Ok(Some((Kind::Triangle, 3))),
        None if SIX_NODES.contains(&name.as_str()) => return Ok(Some((Kind::Triangle, 6))),
        None if QUADS.contains(&name.as_str()) => return Ok(Some((Kind::Quad, 4))),
        None if EIGHT_NODES.contains(&name.as_str()) => return Ok(Some((Kind::Quad, 8))),
        None if NINE_NODES.contains(&name.as_str()) => return Ok(Some((Kind::Quad, 9))),
        None => return Ok(None),
    };
    let name: String = name.chars().take(40).collect();
    Err(card.error(
        format!("elements of type {name}: {refused}"),
        "mesh the volume with tetrahedra (C3D4 or C3D10), or with hexahedra (C3D8 or C3D20)",
    ))
}
