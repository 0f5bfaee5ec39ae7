//! The masks of a step, split and smoothed at once, as rows over the old vertices.
//!
//! Inside, a new vertex is the mean over the new cells at it of a centroid of each (Schaefer, Hakenberg and Warren 2004, section
//! 2.2): of a tetrahedron -1/16 of the vertex itself and 17/48 of each other; of an octahedron 3/8 of itself, 1/12 of each of
//! the four adjacent and 7/24 of the opposite one. All new cells at a new vertex lie in old cells with its old vertex, edge or
//! cell, so the sums over those in one old cell are constants. With (cells, weights; their sum is the number of cells):
//! - vertex v in a tetrahedron (1): v 15/32, others 17/96; in an octahedron (1): v 85/144, opposite 7/144, others 13/144;
//! - edge ab in a tetrahedron (3): a and b 11/12, others 7/12; in an octahedron (4): a and b 9/8, their opposites 7/24, others 7/12;
//! - the centroid of an octahedron stays the centroid.
//!
//! On surfaces the step is Loop's (1987), on creases that of cubic B-splines, corners stay (Hoppe et al. 1994).

use super::surface::{EdgeKind, Surfaces, VertexKind};
use crate::mesh::quality::EDGES;
use crate::mesh::rows::Rows;
use crate::mesh::tet_oct::{CellEdges, EdgeUse, OCT_EDGES, TetOctMesh};
use std::f64::consts::TAU;

/// What the masks depend on: connectivity and tags, no positions.
pub(super) struct Masks<'a> {
    mesh: &'a TetOctMesh,
    edges: &'a CellEdges,
    surfaces: Surfaces,
    /// The cells at each vertex, tetrahedra first.
    cells: Rows,
}

/// Entries of a row.
pub(super) type Row = Vec<(u32, f64)>;

impl<'a> Masks<'a> {
    pub fn new(mesh: &'a TetOctMesh, edges: &'a CellEdges) -> Self {
        let (tets, octs) = (mesh.tets(), mesh.octs());
        let cells = Rows::new(mesh.points().len(), mesh.cell_count(), |cell| {
            let own: &[u32] = cell.checked_sub(tets.len()).map_or_else(|| &tets[cell][..], |oct| &octs[oct]);
            own.iter().map(move |&v| (v, cell as u32))
        });
        Self { mesh, edges, surfaces: Surfaces::new(mesh, edges), cells }
    }

    /// Number of new vertices: the old ones, then those of edges, then those of octahedra.
    pub fn count(&self) -> usize {
        self.mesh.points().len() + self.edges.all().len() + self.mesh.octs().len()
    }

    /// The entries of a new vertex; a column may come more than once.
    pub fn row(&self, new: usize, row: &mut Row) {
        let (vertices, edges) = (self.mesh.points().len(), self.edges.all().len());
        match new {
            v if v < vertices => self.vertex(v as u32, row),
            e if e < vertices + edges => self.edge(e - vertices, row),
            o => row.extend(self.mesh.octs()[o - vertices - edges].map(|v| (v, 1.0 / 6.0))),
        }
    }

    /// As [`Masks::row`] for the split alone: middles of edges, centroids of octahedra.
    pub fn linear_row(&self, new: usize, row: &mut Row) {
        let (vertices, edges) = (self.mesh.points().len(), self.edges.all().len());
        match new {
            v if v < vertices => row.push((v as u32, 1.0)),
            e if e < vertices + edges => row.extend(self.edges.all()[e - vertices].map(|v| (v, 0.5))),
            o => row.extend(self.mesh.octs()[o - vertices - edges].map(|v| (v, 1.0 / 6.0))),
        }
    }

    fn vertex(&self, v: u32, row: &mut Row) {
        match self.surfaces.vertices[v as usize] {
            VertexKind::Inside => self.vertex_inside(v, row),
            VertexKind::Smooth => {
                let ring = self.surfaces.neighbours(v);
                let n = ring.len() as f64;
                let share = 0.5 * loop_share(ring.len());
                row.push((v, 1.0 - share));
                row.extend(ring.iter().map(|&(_, w)| (w, share / n)));
            }
            VertexKind::Crease => {
                row.push((v, 0.75));
                row.extend(self.surfaces.neighbours(v).iter().map(|&(_, w)| (w, 0.125)));
            }
            VertexKind::Corner => row.push((v, 1.0)),
        }
    }

    fn vertex_inside(&self, v: u32, row: &mut Row) {
        let cells = self.cells.row(v as usize);
        if cells.is_empty() {
            // A vertex of no cell.
            row.push((v, 1.0));
        }
        let mean = 1.0 / cells.len() as f64;
        for &cell in cells {
            match (cell as usize).checked_sub(self.mesh.tets().len()) {
                None => {
                    let tet = self.mesh.tets()[cell as usize];
                    row.extend(tet.map(|w| (w, mean * if w == v { 15.0 / 32.0 } else { 17.0 / 96.0 })));
                }
                Some(o) => {
                    let oct = self.mesh.octs()[o];
                    let own = oct.iter().position(|w| *w == v).unwrap_or(0);
                    row.extend((0..6).map(|i| {
                        let weight = [85.0, 7.0, 13.0][if i == own { 0 } else { 2 - usize::from(i == own ^ 1) }];
                        (oct[i], mean * weight / 144.0)
                    }));
                }
            }
        }
    }

    fn edge(&self, edge: usize, row: &mut Row) {
        let [a, b] = self.edges.all()[edge];
        match self.surfaces.edges[edge] {
            EdgeKind::Inside => self.edge_inside(edge, row),
            EdgeKind::Smooth => {
                row.extend([(a, 0.375), (b, 0.375)]);
                row.extend(self.surfaces.opposite(edge as u32).map(|c| (c, 0.125)));
            }
            EdgeKind::Crease => row.extend([(a, 0.5), (b, 0.5)]),
        }
    }

    fn edge_inside(&self, edge: usize, row: &mut Row) {
        let cells = |edge_use| match edge_use {
            EdgeUse::Tet(..) => 3.0,
            EdgeUse::Oct(..) => 4.0,
        };
        let mean = 1.0 / self.edges.uses(edge).map(cells).sum::<f64>();
        for edge_use in self.edges.uses(edge) {
            match edge_use {
                EdgeUse::Tet(t, own) => {
                    let tet = self.mesh.tets()[t];
                    let weight = |i: usize| if EDGES[own].contains(&i) { 11.0 / 12.0 } else { 7.0 / 12.0 };
                    row.extend((0..4).map(|i| (tet[i], mean * weight(i))));
                }
                EdgeUse::Oct(o, own) => {
                    let (oct, ends) = (self.mesh.octs()[o], OCT_EDGES[own]);
                    let weight = |i: usize| match ends {
                        _ if ends.contains(&i) => 9.0 / 8.0,
                        _ if ends.contains(&(i ^ 1)) => 7.0 / 24.0,
                        _ => 7.0 / 12.0,
                    };
                    row.extend((0..6).map(|i| (oct[i], mean * weight(i))));
                }
            }
        }
    }
}

/// The share of the neighbours' mean in Loop's rule for a vertex of the split surface with `n` neighbours,
/// `5/4 - 2 (3/8 + cos(2 pi / n) / 4)^2`.
fn loop_share(n: usize) -> f64 {
    1.25 - 2.0 * (0.375 + 0.25 * (TAU / n as f64).cos()).powi(2)
}
