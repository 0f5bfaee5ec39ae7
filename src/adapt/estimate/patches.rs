//! Patches: the cells of one region around one vertex that hang together through faces.

use crate::mesh::TetMesh;
use crate::mesh::topology::{self, VertexCells};
use std::borrow::Cow;

/// All patches of a mesh, ordered by vertex and region.
pub(super) struct Patches {
    vertices: Vec<u32>,
    /// The cells of patch `p` are `cells[starts[p]..starts[p + 1]]`.
    starts: Vec<u32>,
    cells: Vec<u32>,
    /// The patch at each vertex of each cell.
    of_cell: Vec<[u32; 4]>,
}

impl Patches {
    pub(super) fn new(mesh: &TetMesh) -> Self {
        let around = VertexCells::new(mesh.points().len(), mesh.tets());
        let mut patches = Self {
            vertices: Vec::with_capacity(mesh.points().len()),
            starts: vec![0],
            cells: Vec::with_capacity(4 * mesh.tets().len()),
            of_cell: vec![[0; 4]; mesh.tets().len()],
        };
        // Parts that touch at a vertex or an edge have nothing to do with each other's stress.
        let (parts, _) = topology::parts(mesh.tets());
        let region = |t: u32| (mesh.regions()[t as usize], parts[t as usize]);
        let mut cells = Vec::new();
        for v in 0..mesh.points().len() as u32 {
            cells.clear();
            cells.extend_from_slice(around.at(v));
            cells.sort_by_key(|&t| region(t));
            for same in cells.chunk_by(|&t, &u| region(t) == region(u)) {
                patches.push(mesh, v, same);
            }
        }
        patches
    }

    fn push(&mut self, mesh: &TetMesh, vertex: u32, cells: &[u32]) {
        let patch = self.vertices.len() as u32;
        for &t in cells {
            let corners = mesh.tets()[t as usize].iter().zip(&mut self.of_cell[t as usize]);
            corners.filter(|(v, _)| **v == vertex).for_each(|(_, p)| *p = patch);
        }
        self.vertices.push(vertex);
        self.cells.extend_from_slice(cells);
        self.starts.push(self.cells.len() as u32);
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

    /// Whether cell `t` shares no vertex with another cell of its region.
    pub(super) fn is_isolated(&self, t: usize) -> bool {
        self.of_cell(t).iter().all(|&p| self.cells(p as usize).len() == 1)
    }
}
