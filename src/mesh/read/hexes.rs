//! From the lists of a file to a checked mesh of hexahedra.

use super::groups::{Groups, add_vertex_sets, grouped, patch_numbers, regions};
#[cfg(test)]
use super::lists;
use super::nodes::{Index, Merged, NONE, number_vertices, positions};
use super::raw::Raw;
use super::{doubts, error_at};
use crate::mesh::contact;
use crate::mesh::hex::{EDGES, HexError, HexMesh, HexMeshParts, HexTopology, QuadFace, cell_volume, check_cells};
use crate::mesh::midside::Midside;
use crate::mesh::topology::sorted2;
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use miette::Diagnostic;
use std::path::Path;

/// Distance from the middle over the edge's length from which an edge counts as curved: above the rounding of files that
/// keep seven digits.
const CURVED: f64 = 1e-6;

/// A mesh of hexahedra, and what was done to make it of a file.
#[derive(Debug, Clone)]
pub struct HexFile {
    /// The mesh; vertices are numbered in the order of the file's nodes, cells in the order of its hexahedra.
    pub mesh: HexMesh,
    /// Name of the format.
    pub format: &'static str,
    /// The nodes of the curved edges of 20- and 27-node hexahedra, sorted by edge.
    pub midsides: Vec<Midside>,
    /// Names of the groups all of whose quadrilaterals lie inside the solid, or beside it, sorted: the mesh does not have
    /// them.
    pub inner_groups: Vec<String>,
    /// What a user should know: what was dropped, flipped or ignored. Whole sentences.
    pub notes: Vec<String>,
}

/// Reads a mesh of hexahedra: Gmsh MSH 2.2 and 4.1, Abaqus and CalculiX input, VTK legacy and XML unstructured grids.
///
/// Of 20- and 27-node cells the corners are vertices, and the nodes of curved edges are kept. Orphan nodes are dropped. If all
/// cells are inverted, all are flipped.
///
/// # Errors
/// [`HexError::File`] if the file cannot be read, holds other cells, or makes no mesh that [`HexMesh::new`] accepts: cells and
/// vertices are then named by the file's ids.
pub fn read(path: &Path) -> Result<HexFile, HexError> {
    read_with(path, false)
}

/// As [`read`]; nodes at the same place are made one if `merge` says so.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, merge: bool) -> Result<HexFile, HexError> {
    let (format, raw) = super::open(path)?;
    build(path, format, raw, merge)
}

/// Reads a file's content of `length` bytes.
#[cfg(test)]
pub(super) fn parse(path: &Path, reader: impl std::io::BufRead, length: u64) -> Result<HexFile, HexError> {
    let (format, raw) = lists(path, reader, length)?;
    build(path, format, raw, false)
}

/// Makes the mesh.
pub(super) fn build(path: &Path, format: &'static str, mut raw: Raw, merge: bool) -> Result<HexFile, HexError> {
    check_kinds(path, &raw)?;
    let mut notes = std::mem::take(&mut raw.notes);
    let index = Index::new(path, &raw)?;
    let mut cells = std::mem::take(&mut raw.hexes.nodes);
    index.resolve("hexahedron", &mut cells, &raw, &raw.hexes.ids, &raw.hexes.places)?;
    let mut mids = std::mem::take(&mut raw.hex_midsides.nodes);
    index.resolve("hexahedron", &mut mids, &raw, &raw.hex_midsides.ids, &raw.hex_midsides.places)?;
    let merged = merge.then(|| Merged::new(&raw.nodes.positions));
    notes.extend(merged.iter().flat_map(|m| m.apply(&mut cells)));
    let (vertices, mut vertex_of) = number_vertices(&mut cells, raw.nodes.positions.len());
    merged.iter().for_each(|m| m.number(&mut vertex_of));
    let midsides = curved_edges(path, &mids, &cells, &raw, &vertices)?;
    if !mids.is_empty() {
        notes.push(format!("{} hexahedra of second order, {} edges of them curved.", mids.len(), midsides.len()));
    }
    let mut is_used: Vec<bool> = vertex_of.iter().map(|v| *v != NONE).collect();
    mids.iter().flatten().for_each(|&n| is_used[n as usize] = true);
    let orphans = is_used.iter().filter(|used| !**used).count();
    if orphans > 0 {
        notes.push(format!("{orphans} nodes that are no corners or edges' middles of a hexahedron are dropped."));
    }
    let mut quads = std::mem::take(&mut raw.quads.nodes);
    index.resolve("quadrilateral", &mut quads, &raw, &raw.quads.ids, &raw.quads.places)?;
    quads.iter_mut().flatten().for_each(|n| *n = vertex_of[*n as usize]);
    let vertex = |id: u32| index.get(id).map(|n| vertex_of[n as usize]).filter(|&v| v != NONE);
    let sets: Vec<(String, Vec<u32>)> = std::mem::take(&mut raw.node_groups)
        .into_iter()
        .map(|(name, ids)| (name, ids.into_iter().filter_map(vertex).collect()))
        .collect();

    let points = positions(std::mem::take(&mut raw.nodes.positions), &vertices);
    notes.extend(flip_if_all_inverted(&points, &mut cells));
    let named = |error| in_file_ids(path, error, &raw, &vertices);
    check_cells(&points, &cells).map_err(named)?;
    let topology = HexTopology::new(points.len(), &cells).map_err(named)?;
    refuse_hanging(path, &points, &cells, &topology, &raw, &vertices)?;
    let (lo, hi) = points.iter().fold((points[0], points[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    notes.extend(doubts::extent(lo, hi));
    let boundary: Vec<[u32; 4]> = topology.boundary().map(|(_, vertices)| vertices).collect();
    let find = |v: &[u32; 4]| boundary.binary_search_by_key(&sorted4(*v), |&f| sorted4(f)).ok();
    let places = quads.iter().map(|v| Some(v).filter(|v| !v.contains(&NONE)).and_then(find));
    let Groups { mut tagged, names: mut groups, ignored, inside } =
        grouped(&raw, &raw.quads.tags, &raw.quad_surfaces, places);
    add_vertex_sets(sets, points.len(), &boundary, &mut tagged, &mut groups);
    if ignored > 0 {
        notes.push(format!("{ignored} quadrilaterals are not on the boundary of the solid and are ignored."));
    }
    let (of_face, patches) = patch_numbers(boundary.len(), &tagged);
    let faces = boundary.iter().zip(of_face).map(|(&vertices, patch)| QuadFace { vertices, patch }).collect();
    let (regions, region_names) = regions(path, &raw.hexes, &raw)?;
    let inner_groups = inside.into_iter().filter(|name| !groups.contains(name)).collect();
    let parts = HexMeshParts { points, cells, regions, faces, region_names, groups, patches, ..Default::default() };
    Ok(HexFile { mesh: HexMesh::new(parts).map_err(named)?, format, midsides, inner_groups, notes })
}

/// Refuses files without hexahedra, and those with tetrahedra too.
fn check_kinds(path: &Path, raw: &Raw) -> Result<(), HexError> {
    let (hexes, tets) = (raw.hexes.nodes.len(), raw.tets.nodes.len());
    match (hexes, tets) {
        (0, 0) => Err(HexError::NoCells),
        (_, 0) => Ok(()),
        _ => {
            let message = format!("the mesh has {tets} tetrahedra, the first is element {}", raw.tets.ids.get(0));
            let (message, help) = match hexes {
                0 => (
                    message + ", and no hexahedra",
                    "this element needs hexahedra; for tetrahedra choose analysis.element = \"tet10\" or \"tet4\"",
                ),
                _ => (
                    format!("{message}, beside {hexes} hexahedra"),
                    "a mesh is of one kind of cells: mesh the whole volume with hexahedra, or with tetrahedra",
                ),
            };
            Err(error_at(path, raw.place(&raw.tets.places, 0), message, help).into())
        }
    }
}

/// The edges whose nodes do not lie in their middle, sorted; `mids` are places in the file's list of nodes.
fn curved_edges(
    path: &Path,
    mids: &[[u32; 12]],
    cells: &[[u32; 8]],
    raw: &Raw,
    vertices: &[u32],
) -> Result<Vec<Midside>, HexError> {
    let at = |node: u32| raw.nodes.positions[node as usize];
    let mut all: Vec<([u32; 2], u32, i64)> = Vec::with_capacity(12 * mids.len());
    for (nodes, cell) in mids.iter().zip(raw.hex_midsides.tags.iter()) {
        let own = cells[cell as usize];
        all.extend(EDGES.iter().zip(nodes).map(|([a, b], &node)| (sorted2([own[*a], own[*b]]), node, cell)));
    }
    all.sort_unstable();
    let differs = |pair: &[([u32; 2], u32, i64)]| pair[0].0 == pair[1].0 && at(pair[0].1) != at(pair[1].1);
    if let Some([(edge, ..), (_, _, cell)]) = all.windows(2).find(|pair| differs(pair)) {
        let [a, b] = edge.map(|v| raw.nodes.ids.get(vertices[v as usize] as usize));
        let id = raw.hexes.ids.get(*cell as usize);
        let message = format!("hexahedron {id} has another mid-side node between {a} and {b} than a cell before it");
        let place = raw.place(&raw.hexes.places, *cell as usize);
        return Err(error_at(path, place, message, "cells that share an edge must share its mid-side node").into());
    }
    all.dedup_by_key(|m| m.0);
    let node = |(edge, node, _): &([u32; 2], u32, i64)| {
        let [p, q] = edge.map(|v| at(vertices[v as usize]));
        let is_curved = at(*node).distance(p.midpoint(q)) > CURVED * p.distance(q);
        is_curved.then_some(Midside { edge: *edge, position: at(*node) })
    };
    Ok(all.iter().filter_map(node).collect())
}

/// Refuses a node that lies on an edge of the boundary without belonging to a cell of it.
fn refuse_hanging(
    path: &Path,
    points: &[DVec3],
    cells: &[[u32; 8]],
    topology: &HexTopology,
    raw: &Raw,
    vertices: &[u32],
) -> Result<(), HexError> {
    let quads = topology.boundary().map(|(_, [a, b, c, d])| [[a, b], [b, c], [c, d], [d, a]]);
    let mut edges: Vec<[u32; 2]> = quads.flatten().map(sorted2).collect();
    edges.sort_unstable();
    edges.dedup();
    let found = contact::hanging(points, &edges, &[], cells.iter().map(|c| &c[..]));
    let Some(first) = found.first() else { return Ok(()) };
    let cell = cells.iter().position(|c| first.on.iter().all(|v| c.contains(v))).unwrap_or_default();
    let node = |v: u32| raw.nodes.ids.get(vertices[v as usize] as usize);
    let message = doubts::hanging(first, found.len(), &format!("hexahedron {}", raw.hexes.ids.get(cell)), &node);
    Err(error_at(path, raw.place(&raw.hexes.places, cell), message, doubts::HANGING).into())
}

/// Turns all cells round if not one has a positive volume: another convention, not a bad mesh.
fn flip_if_all_inverted(points: &[DVec3], cells: &mut [[u32; 8]]) -> Option<String> {
    if cells.iter().any(|cell| cell_volume(&cell.map(|v| points[v as usize])) >= 0.0) {
        return None;
    }
    cells.iter_mut().for_each(|cell| *cell = std::array::from_fn(|c| cell[c ^ 4]));
    Some(format!("all {} hexahedra were inverted: the order of their nodes is reversed.", cells.len()))
}

/// The error at the place of its cell, with the file's ids in place of indices.
fn in_file_ids(path: &Path, mut error: HexError, raw: &Raw, nodes: &[u32]) -> HexError {
    let node = |v: &mut u32| *v = raw.nodes.ids.get(nodes[*v as usize] as usize) as u32;
    let element = |cell: &mut usize| std::mem::replace(cell, raw.hexes.ids.get(*cell) as usize);
    let index = match &mut error {
        HexError::RepeatedVertex { cell, vertices, vertex } | HexError::Twisted { cell, vertices, vertex, .. } => {
            vertices.iter_mut().for_each(node);
            node(vertex);
            element(cell)
        }
        HexError::CrowdedFace { cells: [a, b, c], vertices } => {
            vertices.iter_mut().for_each(node);
            element(a);
            element(b);
            element(c)
        }
        HexError::InwardFace { cells: [a, b], vertices } => {
            vertices.iter_mut().for_each(node);
            element(a);
            element(b)
        }
        _ => return error,
    };
    let help = error.help().map(|help| help.to_string()).unwrap_or_default();
    let at: Place = raw.place(&raw.hexes.places, index);
    MeshError::Syntax { path: path.to_owned(), at, message: error.to_string(), help }.into()
}

fn sorted4(mut vertices: [u32; 4]) -> [u32; 4] {
    vertices.sort_unstable();
    vertices
}
