//! Regions and groups of boundary faces from the tags of a file.

use super::error_at;
use super::nodes::NONE;
use super::raw::{Elements, Raw};
use super::runs::Runs;
use crate::mesh::{Face, GroupId, MeshError, PatchId, RegionId, topology};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Region of each cell, and the names: by ascending tag, one region a name.
pub(super) fn regions<const N: usize>(
    path: &Path,
    cells: &Elements<N>,
    raw: &Raw,
) -> Result<(Vec<RegionId>, Vec<String>), MeshError> {
    let tags = distinct(&cells.tags);
    if tags.len() > usize::from(u16::MAX) {
        let message = format!("the cells lie in {} regions, at most {} are possible", tags.len(), u16::MAX);
        return Err(error_at(path, raw.place(&cells.places, 0), message, "merge physical volumes"));
    }
    let (ids, names) = number_names(&tags, |tag| match (tag, raw.region_names.get(&tag)) {
        (_, Some(name)) => name.clone(),
        (0, None) => "solid".to_owned(),
        (_, None) => format!("volume-{tag}"),
    });
    let mut last = (0, None);
    let region = |tag: i64| {
        if last.1.is_none() || last.0 != tag {
            last = (tag, Some(RegionId(ids[&(tag as i32)] as u16)));
        }
        last.1.unwrap_or(RegionId(0))
    };
    Ok((cells.tags.iter().map(region).collect(), names))
}

/// The tags of a list.
fn distinct(tags: &Runs) -> BTreeSet<i32> {
    let mut last = None;
    // A look at the one before spares most searches.
    let new = tags.iter().filter(|&tag| last.replace(tag) != Some(tag));
    new.map(|tag| tag as i32).collect()
}

/// Numbers names in the order of the tags; tags of one name share its number.
fn number_names(tags: &BTreeSet<i32>, name: impl Fn(i32) -> String) -> (BTreeMap<i32, u32>, Vec<String>) {
    let (mut ids, mut names) = (BTreeMap::new(), Vec::<String>::new());
    let mut known = BTreeMap::new();
    for &tag in tags {
        let id = *known.entry(name(tag)).or_insert_with_key(|name| {
            names.push(name.clone());
            names.len() as u32 - 1
        });
        ids.insert(tag, id);
    }
    (ids, names)
}

/// The groups of a file.
pub(super) struct Groups {
    /// Pairs of a face's index and a group, sorted, each once.
    pub tagged: Vec<(usize, GroupId)>,
    /// Their names.
    pub names: Vec<String>,
    /// How many triangles or quadrilaterals are no boundary faces.
    pub ignored: usize,
    /// Names of groups that such triangles have, sorted.
    pub inside: Vec<String>,
}

/// Groups of boundary faces, given triangles by vertices.
///
/// The tags of the triangles name the groups. A file without any names them by the surfaces of the geometry.
pub(super) fn groups(raw: &Raw, triangles: &[[u32; 3]], faces: &[[u32; 3]]) -> Groups {
    let find = |v: &[u32; 3]| faces.binary_search_by_key(&topology::sorted3(*v), |&f| topology::sorted3(f)).ok();
    let places = triangles.iter().map(|v| Some(v).filter(|v| !v.contains(&NONE)).and_then(find));
    grouped(raw, &raw.triangles.tags, &raw.surfaces, places)
}

/// Groups of boundary faces, given the place among these of each triangle or quadrilateral, if it is one.
pub(super) fn grouped(raw: &Raw, tags: &Runs, surfaces: &Runs, places: impl Iterator<Item = Option<usize>>) -> Groups {
    let tagged = distinct(tags).iter().any(|&tag| tag != 0);
    let tags = if tagged { tags } else { surfaces };
    let mut found: Vec<(usize, i32)> = Vec::new();
    let (mut ignored, mut inside) = (0, BTreeSet::new());
    for (place, tag) in places.zip(tags.iter()) {
        match place {
            Some(face) => found.push((face, tag as i32)),
            None => {
                ignored += 1;
                inside.insert(tag as i32);
            }
        }
    }
    found.retain(|(_, tag)| *tag != 0);
    let tags = found.iter().map(|(_, tag)| *tag).collect();
    let name = |tag| match raw.group_names.get(&tag) {
        Some(name) if tagged => name.clone(),
        _ => format!("surface-{tag}"),
    };
    let (ids, names) = number_names(&tags, name);
    let inside: BTreeSet<String> = inside.into_iter().filter(|&tag| tag != 0).map(name).collect();
    let mut tagged: Vec<(usize, GroupId)> = found.iter().map(|(face, tag)| (*face, GroupId(ids[tag]))).collect();
    tagged.sort_unstable();
    tagged.dedup();
    Groups { tagged, names, ignored, inside: inside.into_iter().collect() }
}

/// Adds groups of the faces all whose corners a set of vertices holds. Names that groups have already stay theirs.
pub(super) fn add_vertex_sets<const N: usize>(
    sets: Vec<(String, Vec<u32>)>,
    vertex_count: usize,
    faces: &[[u32; N]],
    tagged: &mut Vec<(usize, GroupId)>,
    names: &mut Vec<String>,
) {
    for (name, vertices) in sets {
        let mut inside = vec![false; vertex_count];
        vertices.into_iter().for_each(|v| inside[v as usize] = true);
        let group = GroupId(names.len() as u32);
        let before = tagged.len();
        if !names.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
            let found = faces.iter().enumerate().filter(|(_, face)| face.iter().all(|&v| inside[v as usize]));
            tagged.extend(found.map(|(i, _)| (i, group)));
        }
        if tagged.len() > before {
            names.push(name);
        }
    }
    tagged.sort_unstable();
}

/// Faces with their patches, and the groups of each patch.
pub(super) fn patches(faces: &[[u32; 3]], tagged: &[(usize, GroupId)]) -> (Vec<Face>, Vec<Vec<GroupId>>) {
    let (of_face, patches) = patch_numbers(faces.len(), tagged);
    let faces = faces.iter().zip(of_face).map(|(&vertices, patch)| Face { vertices, patch }).collect();
    (faces, patches)
}

/// The patch of each face, and the groups of each patch; patch 0 has none, others are numbered by first face.
pub(super) fn patch_numbers(faces: usize, tagged: &[(usize, GroupId)]) -> (Vec<PatchId>, Vec<Vec<GroupId>>) {
    let mut patches = vec![Vec::new()];
    let mut known = BTreeMap::from([(Vec::new(), PatchId(0))]);
    let mut of_face = vec![PatchId(0); faces];
    for same in tagged.chunk_by(|a, b| a.0 == b.0) {
        let groups: Vec<GroupId> = same.iter().map(|(_, group)| *group).collect();
        of_face[same[0].0] = *known.entry(groups).or_insert_with_key(|groups| {
            patches.push(groups.clone());
            PatchId(patches.len() as u32 - 1)
        });
    }
    (of_face, patches)
}
