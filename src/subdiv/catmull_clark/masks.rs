//! The masks of Catmull-Clark solids, as sparse rows over the old vertices.
//!
//! With C the mean of a cell's vertices, A of a face's, M of an edge's, all old, and bars for means over incident items.
//! Inside: cells C; faces (C0 + 2 A + C1) / 4; edges (Cbar + 2 Abar + M) / 4 and vertices (Cbar + 3 Abar + 3 Mbar + V) / 8, with
//! means in which a face or an edge counts once for each of its cells (Bajaj), or (Cbar + 2 Abar + (n - 3) M) / n at an edge of
//! n faces and plain means at a vertex (the 2011 paper). On the boundary the rules are those of Catmull-Clark surfaces; a
//! crease is a cubic B-spline, a corner stays.

use crate::mesh::hex::{HexMesh, HexTopology};
use crate::mesh::weights::WeightRows;
use crate::subdiv::options::CatmullClark;

/// What the masks depend on: the connectivity and the tags of a mesh, but no positions.
#[derive(Debug)]
pub struct Control<'a> {
    /// Vertices of the cells.
    pub cells: &'a [[u32; 8]],
    /// Their edges and faces.
    pub topology: &'a HexTopology,
    /// Whether each edge is a crease.
    pub creased: Vec<bool>,
    /// Whether each vertex is tagged as a corner.
    pub corner: Vec<bool>,
}

/// How the boundary's rules see a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VertexKind {
    /// Inside the solid.
    Interior,
    /// On the smooth boundary; creases that end here do not count.
    Smooth,
    /// On a crease between these neighbours.
    Crease([u32; 2]),
    /// Kept.
    Corner,
}

/// Entries of a row.
pub(super) type Row = Vec<(u32, f64)>;

impl<'a> Control<'a> {
    /// That of a mesh.
    #[must_use]
    pub fn of(mesh: &'a HexMesh) -> Self {
        let mut creased = vec![false; mesh.topology().edges().len()];
        for crease in mesh.creases() {
            if let Some(e) = mesh.topology().edge(crease.vertices) {
                creased[e as usize] = true;
            }
        }
        let mut corner = vec![false; mesh.points().len()];
        mesh.corners().iter().for_each(|&v| corner[v as usize] = true);
        Self { cells: mesh.cells(), topology: mesh.topology(), creased, corner }
    }

    /// How the boundary's rules see a vertex.
    #[must_use]
    pub fn kind(&self, v: u32) -> VertexKind {
        let edges = self.topology.vertex_edges(v);
        let on_boundary = |e: &u32| self.topology.boundary_faces_at(*e).next().is_some();
        if !edges.iter().any(on_boundary) {
            return VertexKind::Interior;
        }
        let creases: Vec<u32> = edges.iter().copied().filter(|&e| self.creased[e as usize]).collect();
        match creases[..] {
            _ if self.corner[v as usize] => VertexKind::Corner,
            [] | [_] => VertexKind::Smooth,
            [a, b] => VertexKind::Crease([a, b].map(|e| self.other_end(e, v))),
            _ => VertexKind::Corner,
        }
    }

    fn other_end(&self, e: u32, v: u32) -> u32 {
        let [a, b] = self.topology.edges()[e as usize];
        if a == v { b } else { a }
    }

    /// The rows of all new vertices, in their order.
    #[must_use]
    pub fn stencils(&self, variant: CatmullClark) -> WeightRows {
        self.rows(|item, row| self.new_point(item, variant, row))
    }

    /// The rows of the vertices that plain splitting makes.
    #[must_use]
    pub fn linear_stencils(&self) -> WeightRows {
        self.rows(|item, row| match item {
            Item::Vertex(v) => row.push((v, 1.0)),
            Item::Edge(e) => self.edge(e, 1.0, row),
            Item::Face(f) => self.face(f, 1.0, row),
            Item::Cell(t) => self.cell(t, 1.0, row),
        })
    }

    fn rows(&self, of: impl Fn(Item, &mut Row) + Sync) -> WeightRows {
        let topology = self.topology;
        let vertices = self.corner.len();
        let edges = vertices + topology.edges().len();
        let faces = edges + topology.faces().len();
        WeightRows::collect(faces + self.cells.len(), self.corner.len(), |i, row| {
            let item = match i {
                _ if i < vertices => Item::Vertex(i as u32),
                _ if i < edges => Item::Edge((i - vertices) as u32),
                _ if i < faces => Item::Face((i - edges) as u32),
                _ => Item::Cell((i - faces) as u32),
            };
            of(item, row);
        })
    }

    pub(super) fn new_point(&self, item: Item, variant: CatmullClark, row: &mut Row) {
        match item {
            Item::Cell(t) => self.cell(t, 1.0, row),
            Item::Face(f) if self.topology.is_boundary(f) => self.face(f, 1.0, row),
            Item::Face(f) => {
                self.topology.face_cells()[f as usize].iter().for_each(|&t| self.cell(t, 0.25, row));
                self.face(f, 0.5, row);
            }
            Item::Edge(e) => self.edge_mask(e, variant, row),
            Item::Vertex(v) => self.vertex_mask(v, variant, row),
        }
    }

    fn edge_mask(&self, e: u32, variant: CatmullClark, row: &mut Row) {
        let topology = self.topology;
        let boundary: Vec<u32> = topology.boundary_faces_at(e).collect();
        if boundary.is_empty() {
            let (cells, faces) = (topology.edge_cells(e), topology.edge_faces(e));
            let n = cells.len() as f64;
            let (cell, face, middle) = match variant {
                CatmullClark::Bajaj => (0.25 / n, 0.5 / n, 0.25),
                CatmullClark::Printed => (1.0 / (n * n), 2.0 / (n * n), (n - 3.0) / n),
            };
            cells.iter().for_each(|&t| self.cell(t, cell, row));
            faces.iter().for_each(|&f| self.face(f, face, row));
            self.edge(e, middle, row);
        } else if self.creased[e as usize] {
            self.edge(e, 1.0, row);
        } else {
            boundary.iter().for_each(|&f| self.face(f, 0.5 / boundary.len() as f64, row));
            self.edge(e, 0.5, row);
        }
    }

    fn vertex_mask(&self, v: u32, variant: CatmullClark, row: &mut Row) {
        match self.kind(v) {
            VertexKind::Interior => self.interior_mask(v, variant, row),
            VertexKind::Smooth => {
                let (faces, edges) = self.surface_at(v);
                let n = faces.len() as f64;
                faces.iter().for_each(|&f| self.face(f, 1.0 / (n * n), row));
                edges.iter().for_each(|&e| self.edge(e, 2.0 / (n * n), row));
                row.push((v, (n - 3.0) / n));
            }
            VertexKind::Crease([a, b]) => row.extend([(v, 0.75), (a, 0.125), (b, 0.125)]),
            VertexKind::Corner => row.push((v, 1.0)),
        }
    }

    fn interior_mask(&self, v: u32, variant: CatmullClark, row: &mut Row) {
        let topology = self.topology;
        let cells = topology.vertex_cells(v);
        let edges = topology.vertex_edges(v);
        let faces = self.faces_at(v);
        let per_cell = 1.0 / cells.len() as f64;
        cells.iter().for_each(|&t| self.cell(t, 0.125 * per_cell, row));
        // In each cell at a vertex three faces and three edges meet there.
        let weighted = |count: usize, all: usize| match variant {
            CatmullClark::Bajaj => 0.375 * count as f64 * per_cell / 3.0,
            CatmullClark::Printed => 0.375 / all as f64,
        };
        faces.iter().for_each(|&f| self.face(f, weighted(2, faces.len()), row));
        edges.iter().for_each(|&e| self.edge(e, weighted(topology.edge_cells(e).len(), edges.len()), row));
        row.push((v, 0.125));
    }

    /// The faces at a vertex, ascending.
    pub(super) fn faces_at(&self, v: u32) -> Vec<u32> {
        let topology = self.topology;
        let mut faces: Vec<u32> =
            topology.vertex_edges(v).iter().flat_map(|&e| topology.edge_faces(e)).copied().collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// The faces and edges of the boundary at a vertex, ascending.
    fn surface_at(&self, v: u32) -> (Vec<u32>, Vec<u32>) {
        let mut faces = self.faces_at(v);
        faces.retain(|&f| self.topology.is_boundary(f));
        let mut edges = self.topology.vertex_edges(v).to_vec();
        edges.retain(|&e| self.topology.boundary_faces_at(e).next().is_some());
        (faces, edges)
    }

    fn cell(&self, t: u32, weight: f64, row: &mut Row) {
        row.extend(self.cells[t as usize].map(|v| (v, 0.125 * weight)));
    }

    fn face(&self, f: u32, weight: f64, row: &mut Row) {
        row.extend(self.topology.faces()[f as usize].map(|v| (v, 0.25 * weight)));
    }

    fn edge(&self, e: u32, weight: f64, row: &mut Row) {
        row.extend(self.topology.edges()[e as usize].map(|v| (v, 0.5 * weight)));
    }
}

/// What gets a new vertex.
pub(super) enum Item {
    Vertex(u32),
    Edge(u32),
    Face(u32),
    Cell(u32),
}
