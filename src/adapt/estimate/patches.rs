//! Patches: the cells of one region around one vertex that hang together through faces.

use crate::mesh::TetMesh;
use crate::mesh::topology::VertexCells;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// All patches of a mesh, ordered by vertex and region.
pub(super) struct Patches {
    vertices: Vec<u32>,
    /// The cells of patch `p` are `cells[starts[p]..starts[p + 1]]`.
    starts: Vec<u32>,
    cells: Vec<u32>,
    /// The patches at vertex `v` are `of_vertex[v]..of_vertex[v + 1]`.
    of_vertex: Vec<u32>,
    /// The patch at each vertex of each cell.
    of_cell: Vec<[u32; 4]>,
}

/// The vertex and the length of each patch, and the cells of all.
type Chunk = (Vec<(u32, u32)>, Vec<u32>);

/// How many vertices a thread takes at a time.
const CHUNK: usize = 1 << 12;

impl Patches {
    pub(super) fn new(mesh: &TetMesh) -> Self {
        let count = mesh.points().len();
        let around = VertexCells::new(count, mesh.tets());
        // Parts that touch at a vertex or an edge have nothing to do with each other's stress.
        let (parts, _) = mesh.connected_parts();
        let region = |t: u32| (mesh.regions()[t as usize], parts[t as usize]);
        let chunk = |first: usize| {
            let mut patches = Vec::new();
            let mut cells = Vec::new();
            for v in first as u32..count.min(first + CHUNK) as u32 {
                let begin = cells.len();
                cells.extend_from_slice(around.at(v));
                cells[begin..].sort_by_key(|&t| region(t));
                let same = cells[begin..].chunk_by(|&t, &u| region(t) == region(u));
                patches.extend(same.map(|same| (v, same.len() as u32)));
            }
            (patches, cells)
        };
        let chunks: Vec<Chunk> = (0..count.div_ceil(CHUNK)).into_par_iter().map(|k| chunk(k * CHUNK)).collect();
        let mut patches = Self {
            vertices: Vec::with_capacity(count),
            starts: vec![0],
            cells: Vec::with_capacity(4 * mesh.tets().len()),
            of_vertex: vec![0; count + 1],
            of_cell: Vec::new(),
        };
        for (of_chunk, cells) in chunks {
            for (vertex, length) in of_chunk {
                patches.vertices.push(vertex);
                patches.starts.push(patches.starts[patches.starts.len() - 1] + length);
                patches.of_vertex[vertex as usize + 1] += 1;
            }
            patches.cells.extend_from_slice(&cells);
        }
        for v in 0..count {
            patches.of_vertex[v + 1] += patches.of_vertex[v];
        }
        let patch = |v: u32, t: u32| {
            let mut at = patches.at_vertex(v);
            let first = at.start as u32;
            // Nearly all vertices have one patch.
            if at.len() == 1 { first } else { at.find(|&p| patches.cells(p).contains(&t)).map_or(first, |p| p as u32) }
        };
        let cells = mesh.tets().par_iter().enumerate().with_min_len(CHUNK);
        patches.of_cell = cells.map(|(t, tet)| tet.map(|v| patch(v, t as u32))).collect();
        patches
    }

    /// The patches at a vertex.
    pub(super) fn at_vertex(&self, v: u32) -> Range<usize> {
        self.of_vertex[v as usize] as usize..self.of_vertex[v as usize + 1] as usize
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    pub(super) fn vertex(&self, patch: usize) -> u32 {
        self.vertices[patch]
    }

    /// Ascending.
    pub(super) fn cells(&self, patch: usize) -> &[u32] {
        &self.cells[self.starts[patch] as usize..self.starts[patch + 1] as usize]
    }

    /// The patch at each vertex of cell `t`, of its own region.
    pub(super) fn of_cell(&self, t: usize) -> [u32; 4] {
        self.of_cell[t]
    }

    /// The cells that the stress at the vertex of a patch is recovered from, ascending: the patch; where this is a single
    /// cell, whose own stress would say that it has no error, all cells of its region that share a vertex with it.
    pub(super) fn to_recover_from(&self, patch: usize) -> Cow<'_, [u32]> {
        let cells = self.cells(patch);
        if let [_] = cells { Cow::Owned(self.around(cells)) } else { Cow::Borrowed(cells) }
    }

    /// All cells of the same region that share a vertex with one of these (of one region), ascending.
    pub(super) fn around(&self, cells: &[u32]) -> Vec<u32> {
        let patches = cells.iter().flat_map(|&t| self.of_cell(t as usize));
        let mut around: Vec<u32> = patches.flat_map(|p| self.cells(p as usize)).copied().collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// The patch at each vertex of each cell.
    pub(super) fn into_cells(self) -> Vec<[u32; 4]> {
        self.of_cell
    }

    /// Cells, ascending, that share no vertex with another cell of their region.
    pub(super) fn isolated(&self) -> Vec<u32> {
        let cells = (0..self.of_cell.len() as u32).into_par_iter().with_min_len(CHUNK);
        cells.filter(|&t| self.is_isolated(t as usize)).collect()
    }

    /// Whether cell `t` shares no vertex with another cell of its region.
    pub(super) fn is_isolated(&self, t: usize) -> bool {
        self.of_cell(t).iter().all(|&p| self.cells(p as usize).len() == 1)
    }
}
