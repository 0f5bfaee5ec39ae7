//! Element types.

use super::cards::Card;
use crate::mesh::MeshError;

/// What an element type is here.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Tet,
    Triangle,
}

/// Triangles of three and of six nodes: shells, membranes, plane elements, rigid surfaces.
const TRIANGLES: [&str; 12] =
    ["S3", "S3R", "S3RS", "STRI3", "CPS3", "CPE3", "CPEG3", "CAX3", "M3D3", "R3D3", "DS3", "SFM3D3"];
const SIX_NODES: [&str; 9] = ["S6", "STRI65", "CPS6", "CPS6M", "CPE6", "CPE6M", "CAX6", "M3D6", "SFM3D6"];

/// The kind and the number of nodes of a card's elements; `None` if they carry no stiffness here.
pub(super) fn kind(card: &Card) -> Result<Option<(Kind, usize)>, MeshError> {
    let name = card.value("TYPE")?.to_ascii_uppercase();
    // What follows the number of nodes says how the element is integrated, and what else it carries.
    let solid = name.strip_prefix("C3D").or_else(|| name.strip_prefix("DC3D"));
    let nodes = solid.map(|rest| rest.chars().take_while(char::is_ascii_digit).collect::<String>());
    let refused = match nodes.as_deref() {
        Some("4") => return Ok(Some((Kind::Tet, 4))),
        Some("10") => return Ok(Some((Kind::Tet, 10))),
        Some("8" | "20" | "27") => "hexahedra are not supported yet",
        Some("6" | "15") => "wedges are not supported yet",
        Some("5" | "13") => "pyramids are not supported yet",
        Some(_) => "this type is not read",
        None if TRIANGLES.contains(&name.as_str()) => return Ok(Some((Kind::Triangle, 3))),
        None if SIX_NODES.contains(&name.as_str()) => return Ok(Some((Kind::Triangle, 6))),
        None => return Ok(None),
    };
    let name: String = name.chars().take(40).collect();
    Err(card.error(format!("elements of type {name}: {refused}"), "mesh the volume with tetrahedra (C3D4 or C3D10)"))
}
