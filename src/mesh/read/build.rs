//! From the lists of a file to a checked mesh: ids resolved, orphans dropped, orientation, regions, groups.

use super::lines::error_at;
use super::{MeshFile, Raw, Tet, Triangle};
use crate::mesh::{Face, GroupId, MeshError, PatchId, RegionId, TetMesh, TetMeshParts, Victim, quality, topology};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Stands for a node that is no vertex.
const UNUSED: u32 = u32::MAX;

/// Makes the mesh.
pub(super) fn build(path: &Path, format: &'static str, mut raw: Raw) -> Result<MeshFile, MeshError> {
    if raw.tets.is_empty() {
        return Err(MeshError::NoCells);
    }
    let mut notes = std::mem::take(&mut raw.notes);
    let nodes = Nodes::new(path, &raw)?;
    let mut tets = cells(&nodes, &raw.tets)?;
    check_duplicates(path, &tets, &raw.tets)?;
    let (vertices, vertex_of) = number_vertices(&mut tets, raw.nodes.len());
    notes.extend(dropped(&nodes, &raw, &vertex_of)?);
    let points: Vec<DVec3> = vertices.iter().map(|&n| raw.nodes[n as usize].position).collect();
    notes.extend(flip_if_all_inverted(&points, &mut tets));

    let triangles = triangle_vertices(&nodes, &raw.triangles, &vertex_of)?;
    let (regions, region_names) = regions(path, &raw)?;
    let faces = topology::boundary_faces(&tets);
    let (tagged, groups, ignored) = groups(&raw, &triangles, &faces);
    if ignored > 0 {
        let are = |one, many| if ignored == 1 { one } else { many };
        let (triangles, are) = (are("triangle is", "triangles are"), are("is", "are"));
        notes.push(format!("{ignored} {triangles} not on the boundary of the solid and {are} ignored."));
    }
    let (faces, patches) = patches(&faces, &tagged);
    let levels = vec![0; tets.len()];
    let parts =
        TetMeshParts { points, tets, regions, levels, faces, region_names, groups, patches, ..Default::default() };
    let mesh = TetMesh::new(parts).map_err(|error| in_file_ids(path, error, &raw, &vertices))?;
    notes.extend(coincident(&mesh));
    notes.extend(loose_parts(&mesh));
    Ok(MeshFile { mesh, format, notes })
}

/// The nodes of a file by id.
struct Nodes<'a> {
    path: &'a Path,
    by_id: FxHashMap<u32, u32>,
}

impl<'a> Nodes<'a> {
    fn new(path: &'a Path, raw: &Raw) -> Result<Self, MeshError> {
        let mut by_id = FxHashMap::default();
        for (i, node) in raw.nodes.iter().enumerate() {
            if let Some(first) = by_id.insert(node.id, i as u32) {
                let line = raw.nodes[first as usize].line;
                let message = format!("node {} is listed again, it stands in line {line} already", node.id);
                return Err(error_at(path, node.line, message, "every node needs an id of its own"));
            }
        }
        Ok(Self { path, by_id })
    }

    /// Place of a node that the element `name` in `line` uses.
    fn find(&self, id: u32, name: impl Fn() -> String, line: u32) -> Result<u32, MeshError> {
        self.by_id.get(&id).copied().ok_or_else(|| {
            let message = format!("{} uses node {id}, which the file does not list", name());
            error_at(self.path, line, message, "write the file again with all nodes")
        })
    }
}

/// The nodes of each tetrahedron as places in the file's list.
fn cells(nodes: &Nodes, tets: &[Tet]) -> Result<Vec<[u32; 4]>, MeshError> {
    let mut cells = Vec::with_capacity(tets.len());
    for tet in tets {
        let mut cell = [0; 4];
        for (place, &id) in cell.iter_mut().zip(&tet.nodes) {
            *place = nodes.find(id, || format!("tetrahedron {}", tet.id), tet.line)?;
        }
        if topology::tet_edges(cell).iter().any(|[a, b]| a == b) {
            let message = format!("tetrahedron {} {:?} repeats a node", tet.id, tet.nodes);
            return Err(error_at(nodes.path, tet.line, message, "its four corners must differ: repair the mesh"));
        }
        cells.push(cell);
    }
    Ok(cells)
}

/// Refuses a tetrahedron that is listed twice, in whatever order of nodes.
fn check_duplicates(path: &Path, cells: &[[u32; 4]], tets: &[Tet]) -> Result<(), MeshError> {
    let mut keys: Vec<([u32; 4], u32)> = cells.iter().copied().zip(0..).collect();
    keys.iter_mut().for_each(|(nodes, _)| nodes.sort_unstable());
    keys.par_sort_unstable();
    let Some(pair) = keys.windows(2).find(|pair| pair[0].0 == pair[1].0) else { return Ok(()) };
    let [first, again] = [&tets[pair[0].1 as usize], &tets[pair[1].1 as usize]];
    let (a, b) = (first.id, again.id);
    let message = format!("tetrahedron {b} {:?} repeats tetrahedron {a} of line {}", again.nodes, first.line);
    Err(error_at(path, again.line, message, "remove one; Gmsh writes a cell once for each of its physical volumes"))
}

/// Numbers the nodes that cells use in the order of the file, in the cells too. Gives the node of each vertex and the
/// vertex of each node.
fn number_vertices(tets: &mut [[u32; 4]], node_count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut vertex_of = vec![UNUSED; node_count];
    for &n in tets.iter().flatten() {
        vertex_of[n as usize] = 0;
    }
    let mut vertices = Vec::new();
    for (n, vertex) in vertex_of.iter_mut().enumerate().filter(|(_, vertex)| **vertex != UNUSED) {
        *vertex = vertices.len() as u32;
        vertices.push(n as u32);
    }
    for n in tets.iter_mut().flatten() {
        *n = vertex_of[*n as usize];
    }
    (vertices, vertex_of)
}

/// Says which nodes are no vertices: mid-side nodes, and orphans.
fn dropped(nodes: &Nodes, raw: &Raw, vertex_of: &[u32]) -> Result<Vec<String>, MeshError> {
    let mut midside = vec![false; raw.nodes.len()];
    for (ids, line) in &raw.midsides {
        for &id in ids {
            midside[nodes.find(id, || "a ten-node tetrahedron".to_owned(), *line)? as usize] = true;
        }
    }
    let count = |kind: bool| midside.iter().zip(vertex_of).filter(|&(&m, &v)| m == kind && v == UNUSED).count();
    let (midsides, orphans) = (count(true), count(false));
    let mut notes = Vec::new();
    if !raw.midsides.is_empty() {
        let tets = raw.midsides.len();
        notes.push(format!(
            "{tets} ten-node tetrahedra: the four corner nodes are used, {midsides} mid-side nodes dropped."
        ));
    }
    if orphans > 0 {
        let belong = if orphans == 1 {
            "node belongs to no tetrahedron and is"
        } else {
            "nodes belong to no tetrahedron and are"
        };
        notes.push(format!("{orphans} {belong} dropped."));
    }
    Ok(notes)
}

/// Turns all cells round if not one has a positive volume: another convention, not a bad mesh.
fn flip_if_all_inverted(points: &[DVec3], tets: &mut [[u32; 4]]) -> Option<String> {
    let inverted = |[a, b, c, d]: [u32; 4]| quality::is_positive([a, b, d, c].map(|v| points[v as usize]));
    if !tets.iter().all(|&tet| inverted(tet)) {
        return None;
    }
    tets.iter_mut().for_each(|tet| tet.swap(2, 3));
    Some(format!("all {} tetrahedra were inverted: the order of their nodes is reversed.", tets.len()))
}

/// The vertices of each triangle; `None` if one of its nodes is no vertex.
fn triangle_vertices(
    nodes: &Nodes,
    triangles: &[Triangle],
    vertex_of: &[u32],
) -> Result<Vec<Option<[u32; 3]>>, MeshError> {
    let vertex =
        |id: u32, t: &Triangle| nodes.find(id, || format!("triangle {}", t.id), t.line).map(|n| vertex_of[n as usize]);
    let corners = |t: &Triangle| {
        let [a, b, c] = t.nodes;
        let vertices = [vertex(a, t)?, vertex(b, t)?, vertex(c, t)?];
        Ok((!vertices.contains(&UNUSED)).then_some(vertices))
    };
    triangles.iter().map(corners).collect()
}

/// Region of each cell, and the names: by ascending tag, one region a name.
fn regions(path: &Path, raw: &Raw) -> Result<(Vec<RegionId>, Vec<String>), MeshError> {
    let tags: BTreeSet<i32> = raw.tets.iter().map(|t| t.region).collect();
    if tags.len() > usize::from(u16::MAX) {
        let message = format!("the tetrahedra lie in {} regions, at most {} are possible", tags.len(), u16::MAX);
        return Err(error_at(path, raw.tets[0].line, message, "merge physical volumes"));
    }
    let (ids, names) = number_names(&tags, |tag| match (tag, raw.region_names.get(&tag)) {
        (_, Some(name)) => name.clone(),
        (0, None) => "solid".to_owned(),
        (_, None) => format!("volume-{tag}"),
    });
    Ok((raw.tets.iter().map(|t| RegionId(ids[&t.region] as u16)).collect(), names))
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

/// Groups of boundary faces: pairs of a face's index and a group (sorted, each once), the names, and how many triangles
/// are no boundary faces.
///
/// The physical tags name the groups. A file without any names them by the surfaces of the geometry.
fn groups(
    raw: &Raw,
    triangles: &[Option<[u32; 3]>],
    faces: &[[u32; 3]],
) -> (Vec<(usize, GroupId)>, Vec<String>, usize) {
    let physical = raw.triangles.iter().any(|t| t.physical != 0);
    let find = |v: [u32; 3]| faces.binary_search_by_key(&topology::sorted3(v), |&f| topology::sorted3(f)).ok();
    let mut found: Vec<(usize, i32)> = Vec::new();
    let mut ignored = 0;
    for (t, vertices) in raw.triangles.iter().zip(triangles) {
        match vertices.and_then(find) {
            Some(face) => found.push((face, if physical { t.physical } else { t.entity })),
            None => ignored += 1,
        }
    }
    found.retain(|(_, tag)| *tag != 0);
    let tags = found.iter().map(|(_, tag)| *tag).collect();
    let (ids, names) = number_names(&tags, |tag| match raw.group_names.get(&tag) {
        Some(name) if physical => name.clone(),
        _ => format!("surface-{tag}"),
    });
    let mut tagged: Vec<(usize, GroupId)> = found.iter().map(|(face, tag)| (*face, GroupId(ids[tag]))).collect();
    tagged.sort_unstable();
    tagged.dedup();
    (tagged, names, ignored)
}

/// Faces with their patches, and the groups of each patch; patch 0 has none, others are numbered by first face.
fn patches(faces: &[[u32; 3]], tagged: &[(usize, GroupId)]) -> (Vec<Face>, Vec<Vec<GroupId>>) {
    let mut patches = vec![Vec::new()];
    let mut known = BTreeMap::from([(Vec::new(), PatchId(0))]);
    let mut of_face = vec![PatchId(0); faces.len()];
    for same in tagged.chunk_by(|a, b| a.0 == b.0) {
        let groups: Vec<GroupId> = same.iter().map(|(_, group)| *group).collect();
        of_face[same[0].0] = *known.entry(groups).or_insert_with_key(|groups| {
            patches.push(groups.clone());
            PatchId(patches.len() as u32 - 1)
        });
    }
    let faces = faces.iter().zip(of_face).map(|(&vertices, patch)| Face { vertices, patch }).collect();
    (faces, patches)
}

/// The error with the file's ids in place of indices; of bad cells with the file and the line of the worst.
fn in_file_ids(path: &Path, error: MeshError, raw: &Raw, vertices: &[u32]) -> MeshError {
    let node = |v: u32| raw.nodes[vertices[v as usize] as usize].id;
    let element = |cell: usize| raw.tets[cell].id as usize;
    match error {
        MeshError::NotPositive { worst, volume, count } => {
            let line = raw.tets[worst.cell].line as usize;
            let worst = Victim { cell: element(worst.cell), vertices: worst.vertices.map(node), ..worst };
            MeshError::NotPositiveIn { path: path.to_owned(), line, worst, volume, count }
        }
        MeshError::OvercrowdedFace { vertices, count, cells } => {
            let cells = cells.into_iter().map(element).collect();
            MeshError::OvercrowdedFace { vertices: vertices.map(node), count, cells }
        }
        other => other,
    }
}

/// Says how many vertices lie where another lies, within 1e-9 of the mesh's size.
fn coincident(mesh: &TetMesh) -> Option<String> {
    let (corner, _) = mesh.bounding_box();
    let cell = 1e-9 * mesh.diagonal();
    let mut places: Vec<[i64; 3]> =
        mesh.points().iter().map(|&p| ((p - corner) / cell).to_array().map(|x| x.round() as i64)).collect();
    places.par_sort_unstable();
    let count = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
    (count > 0).then(|| format!("{count} nodes lie where another node lies: the cells around them are not connected."))
}

/// Says how many parts do not hang together, and where the first five are.
fn loose_parts(mesh: &TetMesh) -> Option<String> {
    let (part, count) = topology::parts(mesh.tets());
    if count < 2 {
        return None;
    }
    let shown = count.min(5);
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY, 0_usize); shown];
    for (t, &p) in part.iter().enumerate() {
        if let Some((lo, hi, cells)) = boxes.get_mut(p as usize) {
            for q in mesh.cell_points(t) {
                (*lo, *hi) = (lo.min(q), hi.max(q));
            }
            *cells += 1;
        }
    }
    let list: Vec<String> = boxes.iter().map(|(lo, hi, cells)| format!("{cells} cells in {lo} to {hi}")).collect();
    let more = if count > shown { ", ..." } else { "" };
    Some(format!("the mesh has {count} parts that share no face: {}{more}.", list.join("; ")))
}
