//! What VTK files say of the whole mesh: the names of regions and groups, and the units.

use super::options::Units;
use crate::mesh::hex::HexMesh;
use crate::mesh::{GroupId, Tagged, TetMesh};
use std::fmt::Write as _;

/// Arrays of field data in XML: `region_names` and `group_names` (strings, by number), `group_faces` (a row for each face
/// of each group: the group, then three points) and `units` (strings such as "length mm"). Readers that know none of them
/// carry them along.
#[must_use]
pub(super) fn arrays(mesh: &TetMesh, units: &Units) -> String {
    let mut text = names(mesh, units);
    let rows = |group: u32| mesh.group_faces(GroupId(group)).map(move |face| (group, face.vertices));
    let faces: Vec<(u32, [u32; 3])> = (0..mesh.groups().len() as u32).flat_map(rows).collect();
    if !faces.is_empty() {
        let count = faces.len();
        let head = "<DataArray type=\"Int64\" Name=\"group_faces\" NumberOfComponents=\"4\"";
        text += &format!("{head} NumberOfTuples=\"{count}\" format=\"ascii\">");
        for (group, [a, b, c]) in faces {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{group} {a} {b} {c}");
        }
        text += "</DataArray>";
    }
    text
}

/// As [`arrays`], of hexahedra: `group_quads` has rows of a group and four points.
#[must_use]
pub(super) fn hex_arrays(mesh: &HexMesh, units: &Units) -> String {
    let mut text = names(mesh, units);
    let rows = |group: u32| mesh.group_faces(GroupId(group)).map(move |f| (group, mesh.faces()[f].vertices));
    let faces: Vec<(u32, [u32; 4])> = (0..mesh.groups().len() as u32).flat_map(rows).collect();
    if !faces.is_empty() {
        let count = faces.len();
        let head = "<DataArray type=\"Int64\" Name=\"group_quads\" NumberOfComponents=\"5\"";
        text += &format!("{head} NumberOfTuples=\"{count}\" format=\"ascii\">");
        for (group, [a, b, c, d]) in faces {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{group} {a} {b} {c} {d}");
        }
        text += "</DataArray>";
    }
    text
}

/// The arrays of strings alone.
#[must_use]
pub(super) fn names(mesh: &impl Tagged, units: &Units) -> String {
    let units: Vec<String> = units.declared().iter().map(|(name, unit)| format!("{name} {unit}")).collect();
    strings("region_names", mesh.region_names()) + &strings("group_names", mesh.groups()) + &strings("units", &units)
}

/// An array of strings: the bytes of each, ended by a zero. Nothing if there are none.
fn strings(name: &str, values: &[String]) -> String {
    if values.is_empty() {
        return String::new();
    }
    let bytes = |value: &String| value.bytes().chain([0]).map(|byte| byte.to_string()).collect::<Vec<_>>().join(" ");
    let data: Vec<String> = values.iter().map(bytes).collect();
    let count = values.len();
    format!(
        "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">{}</Array>",
        data.join("\n")
    )
}
