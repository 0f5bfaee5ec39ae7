//! The nodes of a file by id, and which of them are vertices of the mesh.

use super::error_at;
use super::raw::Raw;
use super::runs::Runs;
use crate::mesh::MeshError;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::path::Path;

/// Stands for no node, and for a node that is no vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Where the node of each id stands in the file's list.
pub(super) struct Index<'a> {
    path: &'a Path,
    by_id: ById,
}

/// Ids are mostly dense: a table is smaller than a hash map then.
enum ById {
    Table(Vec<u32>),
    Map(FxHashMap<u32, u32>),
}

impl ById {
    fn get(&self, id: u32) -> Option<u32> {
        match self {
            Self::Table(table) => table.get(id as usize).copied().filter(|&n| n != NONE),
            Self::Map(map) => map.get(&id).copied(),
        }
    }

    /// Enters a node; gives the one that had the id before.
    fn insert(&mut self, id: u32, node: u32) -> Option<u32> {
        match self {
            Self::Table(table) => Some(std::mem::replace(&mut table[id as usize], node)).filter(|&n| n != NONE),
            Self::Map(map) => map.insert(id, node),
        }
    }
}

impl<'a> Index<'a> {
    /// Enters all nodes; refuses an id that comes twice.
    pub(super) fn new(path: &'a Path, raw: &Raw) -> Result<Self, MeshError> {
        let count = raw.nodes.ids.len();
        let largest = raw.nodes.ids.iter().max().unwrap_or(0) as usize;
        let dense = largest <= 3 * count + 1000;
        let mut by_id = if dense { ById::Table(vec![NONE; largest + 1]) } else { ById::Map(FxHashMap::default()) };
        for (id, n) in raw.nodes.ids.iter().zip(0..) {
            if let Some(first) = by_id.insert(id as u32, n) {
                let [first, again] = [first, n].map(|n| raw.place(&raw.nodes.places, n as usize));
                let message = format!("node {id} is listed again, it stands in {} already", first.named());
                return Err(error_at(path, again, message, "every node needs an id of its own"));
            }
        }
        Ok(Self { path, by_id })
    }

    /// The place of a node in the file's list.
    pub(super) fn get(&self, id: u32) -> Option<u32> {
        self.by_id.get(id)
    }

    /// Replaces the node ids of elements by places in the file's list; `kind`, `ids` and `places` name the elements.
    pub(super) fn resolve<const N: usize>(
        &self,
        kind: &str,
        elements: &mut [[u32; N]],
        raw: &Raw,
        ids: &Runs,
        places: &Runs,
    ) -> Result<(), MeshError> {
        for (e, node) in elements.iter_mut().enumerate().flat_map(|(e, nodes)| nodes.iter_mut().map(move |n| (e, n))) {
            *node = self.by_id.get(*node).ok_or_else(|| {
                let message = format!("{kind} {} uses node {node}, which the file does not list", ids.get(e));
                error_at(self.path, raw.place(places, e), message, "write the file again with all nodes")
            })?;
        }
        Ok(())
    }
}

/// Distance within which nodes are at the same place, over the size of the mesh.
pub(super) const SAME_PLACE: f64 = 1e-9;

/// The first node at the place of each node.
pub(super) struct Merged(Vec<u32>);

impl Merged {
    pub(super) fn new(positions: &[DVec3]) -> Self {
        let (lo, hi) =
            positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let unit = SAME_PLACE * lo.distance(hi);
        let place = |p: &DVec3| ((*p - lo) / unit).to_array().map(|x| x.round() as i64);
        let mut sorted: Vec<([i64; 3], u32)> = positions.iter().map(place).zip(0..).collect();
        sorted.sort_unstable();
        let mut first = vec![0; positions.len()];
        for same in sorted.chunk_by(|a, b| a.0 == b.0) {
            same.iter().for_each(|(_, n)| first[*n as usize] = same[0].1);
        }
        Self(first)
    }

    /// Gives cells the first node of each place, and says how many nodes that were others this concerns.
    pub(super) fn apply<const N: usize>(&self, cells: &mut [[u32; N]]) -> Option<String> {
        let mut others: Vec<u32> = Vec::new();
        for n in cells.iter_mut().flatten().filter(|n| self.0[**n as usize] != **n) {
            others.push(*n);
            *n = self.0[*n as usize];
        }
        others.sort_unstable();
        others.dedup();
        let count = others.len();
        (count > 0).then(|| format!("{count} nodes were made one with another at their place (mesh.merge)."))
    }

    /// Gives every node the vertex of the first at its place.
    pub(super) fn number(&self, vertex_of: &mut [u32]) {
        for n in 0..vertex_of.len() {
            vertex_of[n] = vertex_of[self.0[n] as usize];
        }
    }
}

/// Numbers the nodes that cells use in the order of the file, in the cells too. Gives the node of each vertex and the
/// vertex of each node.
pub(super) fn number_vertices<const N: usize>(tets: &mut [[u32; N]], node_count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut vertex_of = vec![NONE; node_count];
    for &n in tets.iter().flatten() {
        vertex_of[n as usize] = 0;
    }
    let mut vertices = Vec::new();
    for (n, vertex) in vertex_of.iter_mut().enumerate().filter(|(_, vertex)| **vertex != NONE) {
        *vertex = vertices.len() as u32;
        vertices.push(n as u32);
    }
    for n in tets.iter_mut().flatten() {
        *n = vertex_of[*n as usize];
    }
    (vertices, vertex_of)
}

/// The positions of the vertices (ascending nodes), moved to the front of the list.
pub(super) fn positions(mut positions: Vec<DVec3>, vertices: &[u32]) -> Vec<DVec3> {
    for (v, &n) in vertices.iter().enumerate() {
        positions[v] = positions[n as usize];
    }
    positions.truncate(vertices.len());
    positions.shrink_to_fit();
    positions
}
