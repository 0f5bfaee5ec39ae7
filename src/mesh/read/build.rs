//! From the lists of a file to a checked mesh: ids resolved, orphans dropped, orientation.

use super::error_at;
use super::groups::{Groups, add_vertex_sets, groups, patches, regions};
use super::midsides;
use super::nodes::{Index, Merged, NONE, number_vertices, positions};
use super::raw::Raw;
use super::{Edges, MeshFile, Reading, doubts};
use crate::mesh::midside::Midside;
use crate::mesh::{MeshError, TetMesh, TetMeshParts, Victim, quality, topology};
use glam::DVec3;
use std::path::Path;

/// Makes the mesh.
pub(super) fn build(
    path: &Path,
    format: &'static str,
    mut raw: Raw,
    Reading { edges, merge }: Reading,
) -> Result<MeshFile, MeshError> {
    refuse_hexahedra(path, &raw)?;
    if raw.tets.nodes.is_empty() {
        return Err(MeshError::NoCells);
    }
    let mut notes = std::mem::take(&mut raw.notes);
    let index = Index::new(path, &raw)?;
    let mut tets = std::mem::take(&mut raw.tets.nodes);
    index.resolve("tetrahedron", &mut tets, &raw, &raw.tets.ids, &raw.tets.places)?;
    let merged = merge.then(|| Merged::new(&raw.nodes.positions));
    notes.extend(merged.iter().flat_map(|m| m.apply(&mut tets)));
    check_corners(path, &tets, &raw)?;
    let (vertices, mut vertex_of) = number_vertices(&mut tets, raw.nodes.positions.len());
    merged.iter().for_each(|m| m.number(&mut vertex_of));
    let mids = midside_nodes(&index, &mut raw)?;
    let midsides = match edges {
        Edges::Straight => Vec::new(),
        Edges::Curved => midsides::at_edges(path, &mids, &raw, &tets, &vertices)?,
    };
    notes.extend(unused(&mids, edges, &midsides, &vertex_of));
    drop(mids);
    let mut triangles = std::mem::take(&mut raw.triangles.nodes);
    index.resolve("triangle", &mut triangles, &raw, &raw.triangles.ids, &raw.triangles.places)?;
    triangles.iter_mut().flatten().for_each(|n| *n = vertex_of[*n as usize]);
    let vertex = |id: u32| index.get(id).map(|n| vertex_of[n as usize]).filter(|&v| v != NONE);
    let sets: Vec<(String, Vec<u32>)> = std::mem::take(&mut raw.node_groups)
        .into_iter()
        .map(|(name, ids)| (name, ids.into_iter().filter_map(vertex).collect()))
        .collect();
    drop((index, vertex_of));

    let points = positions(std::mem::take(&mut raw.nodes.positions), &vertices);
    notes.extend(flip_if_all_inverted(&points, &mut tets));
    let (regions, region_names) = regions(path, &raw.tets, &raw)?;
    let repeated = |cells| repeated(path, cells, &tets, &raw, &vertices);
    let connection = topology::connect(&tets).map_err(repeated)?;
    let faces = &connection.faces;
    let Groups { mut tagged, names: mut groups, ignored, inside } = groups(&raw, &triangles, faces);
    add_vertex_sets(sets, points.len(), faces, &mut tagged, &mut groups);
    drop(triangles);
    notes.extend(not_on_boundary(ignored, &inside));
    let inner_groups = inside.into_iter().filter(|name| !groups.contains(name)).collect();
    let (faces, patches) = patches(faces, &tagged);
    let levels = vec![0; tets.len()];
    let lists =
        TetMeshParts { points, tets, regions, levels, faces, region_names, groups, patches, ..Default::default() };
    let mesh = TetMesh::connected(lists, connection).map_err(|error| in_file_ids(path, error, &raw, &vertices))?;
    if !midsides.is_empty() {
        midsides::check(path, &mesh, &midsides, &raw)?;
    }
    let name = |v: u32| raw.nodes.ids.get(vertices[v as usize] as usize);
    let element = |t: u32| raw.tets.ids.get(t as usize);
    doubts::refuse_hanging(path, &mesh, &raw, &name)?;
    notes.extend(doubts::about(&mesh, &name, &element));
    Ok(MeshFile { mesh, format, notes, midsides, inner_groups })
}

/// Refuses files with hexahedra.
fn refuse_hexahedra(path: &Path, raw: &Raw) -> Result<(), MeshError> {
    let (hexes, tets) = (raw.hexes.nodes.len(), raw.tets.nodes.len());
    if hexes == 0 {
        return Ok(());
    }
    let beside = if tets == 0 { "no".to_owned() } else { tets.to_string() };
    let message = format!(
        "element {} is a hexahedron; the mesh has {hexes} hexahedra and {beside} tetrahedra, and tetrahedra alone \
         are asked for",
        raw.hexes.ids.get(0)
    );
    let help = "mesh the volume with tetrahedra alone (no recombination, no extruded layers), or with hexahedra alone: \
                in a scenario choose analysis.element = \"hex20\" or \"catmull-clark\", with `subdivide` --scheme catmull-clark";
    Err(error_at(path, raw.place(&raw.hexes.places, 0), message, help))
}

/// Refuses a tetrahedron, of nodes as places in the file's list, that uses a node twice.
fn check_corners(path: &Path, tets: &[[u32; 4]], raw: &Raw) -> Result<(), MeshError> {
    let repeats = |&tet: &[u32; 4]| topology::tet_edges(tet).iter().any(|[a, b]| a == b);
    let Some(t) = tets.iter().position(repeats) else { return Ok(()) };
    let nodes = tets[t].map(|n| raw.nodes.ids.get(n as usize));
    let message = format!("tetrahedron {} {nodes:?} repeats a node", raw.tets.ids.get(t));
    let at = raw.place(&raw.tets.places, t);
    Err(error_at(path, at, message, "its four corners must differ: repair the mesh"))
}

/// The error of a tetrahedron that is listed twice, in whatever order of nodes.
fn repeated(path: &Path, [first, again]: [usize; 2], tets: &[[u32; 4]], raw: &Raw, vertices: &[u32]) -> MeshError {
    let [a, b] = [first, again].map(|t| raw.tets.ids.get(t));
    let nodes = tets[again].map(|v| raw.nodes.ids.get(vertices[v as usize] as usize));
    let place = raw.place(&raw.tets.places, first).named();
    let message = format!("tetrahedron {b} {nodes:?} repeats tetrahedron {a} of {place}");
    let at = raw.place(&raw.tets.places, again);
    error_at(path, at, message, "remove one; Gmsh writes a cell once for each of its physical volumes")
}

/// The mid-side nodes of the ten-node tetrahedra, as places in the file's list.
fn midside_nodes(index: &Index, raw: &mut Raw) -> Result<Vec<[u32; 6]>, MeshError> {
    let mut mids = std::mem::take(&mut raw.midsides.nodes);
    index.resolve("ten-node tetrahedron", &mut mids, raw, &raw.midsides.ids, &raw.midsides.places)?;
    Ok(mids)
}

/// Says what comes of the nodes that are no vertices: mid-side nodes, and orphans.
fn unused(mids: &[[u32; 6]], edges: Edges, curved: &[Midside], vertex_of: &[u32]) -> Vec<String> {
    let mut midside = vec![false; vertex_of.len()];
    mids.iter().flatten().for_each(|&n| midside[n as usize] = true);
    let count = |kind: bool| midside.iter().zip(vertex_of).filter(|&(&m, &v)| m == kind && v == NONE).count();
    let (midsides, orphans) = (count(true), count(false));
    let mut notes = Vec::new();
    if !mids.is_empty() {
        let tets = mids.len();
        notes.push(match edges {
            Edges::Straight => format!(
                "{tets} ten-node tetrahedra: the four corner nodes are used, {midsides} mid-side nodes dropped \
                 (mesh.midside = \"curved\" keeps curved edges, with analysis.element = \"tet10\")."
            ),
            Edges::Curved => format!("{tets} ten-node tetrahedra, {} edges of them curved.", curved.len()),
        });
    }
    if orphans > 0 {
        let belong = if orphans == 1 {
            "node belongs to no tetrahedron and is"
        } else {
            "nodes belong to no tetrahedron and are"
        };
        notes.push(format!("{orphans} {belong} dropped."));
    }
    notes
}

/// Says how many triangles are no boundary faces, and the first five of their groups.
fn not_on_boundary(count: usize, groups: &[String]) -> Option<String> {
    let are = |one, many| if count == 1 { one } else { many };
    let (triangles, are) = (are("triangle is", "triangles are"), are("is", "are"));
    let shown: Vec<String> = groups.iter().take(5).map(|name| format!("`{name}`")).collect();
    let more = if groups.len() > shown.len() { ", ..." } else { "" };
    let of = if shown.is_empty() { String::new() } else { format!(" (of {}{more})", shown.join(", ")) };
    (count > 0).then(|| format!("{count} {triangles} not on the boundary of the solid and {are} ignored{of}."))
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

/// The error with the file's ids in place of indices; of bad cells with the file and the place of the worst.
fn in_file_ids(path: &Path, error: MeshError, raw: &Raw, vertices: &[u32]) -> MeshError {
    let node = |v: u32| raw.nodes.ids.get(vertices[v as usize] as usize) as u32;
    let element = |cell: usize| raw.tets.ids.get(cell) as usize;
    match error {
        MeshError::NotPositive { worst, volume, count } => {
            let at = raw.place(&raw.tets.places, worst.cell);
            let worst = Victim { cell: element(worst.cell), vertices: worst.vertices.map(node), ..worst };
            MeshError::NotPositiveIn { path: path.to_owned(), at, worst, volume, count }
        }
        MeshError::OvercrowdedFace { vertices, count, cells } => {
            let cells = cells.into_iter().map(element).collect();
            MeshError::OvercrowdedFace { vertices: vertices.map(node), count, cells }
        }
        other => other,
    }
}
