//! The finite-element space on a mesh: which nodes each cell and each face has, and its shape functions.
//!
//! Nodes are numbered vertices first, in the mesh's order; ten-node cells add the midpoints of the mesh's edges, in the
//! order of [`topology::edges`]. Edges are straight, so a cell's map from barycentric coordinates stays affine.

use super::options::Element;
use crate::mesh::quality::EDGES;
use crate::mesh::topology::{self, sorted2};
use crate::mesh::{Face, TetMesh};
use glam::DVec3;
use std::borrow::Cow;

/// A mesh with the nodes of its elements.
#[derive(Debug, Clone)]
pub struct Space<'m> {
    mesh: &'m TetMesh,
    points: Cow<'m, [DVec3]>,
    midside: Option<Midside>,
}

/// The nodes on the edges of a mesh.
#[derive(Debug, Clone)]
struct Midside {
    /// Vertices of each edge, sorted.
    ends: Vec<[u32; 2]>,
    /// The first edge of each vertex as the lower end, and the number of edges.
    starts: Vec<u32>,
    /// Midside nodes of each cell, in the order of [`EDGES`].
    of_cell: Vec<[u32; 6]>,
}

impl<'m> Space<'m> {
    /// The space of an element on a mesh.
    #[must_use]
    pub fn new(mesh: &'m TetMesh, element: Element) -> Self {
        match element {
            Element::Tet4 => Self::linear(mesh),
            Element::Tet10 => Self::quadratic(mesh),
        }
    }

    /// Four-node cells: the nodes are the vertices.
    #[must_use]
    pub fn linear(mesh: &'m TetMesh) -> Self {
        Self { mesh, points: Cow::Borrowed(mesh.points()), midside: None }
    }

    fn quadratic(mesh: &'m TetMesh) -> Self {
        let vertices = mesh.points().len();
        let ends = topology::edges(mesh.tets());
        let mut starts = vec![0_u32; vertices + 1];
        for [a, _] in &ends {
            starts[*a as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut midside = Midside { ends, starts, of_cell: Vec::new() };
        let nodes = |tet: &[u32; 4]| EDGES.map(|[i, j]| vertices as u32 + midside.edge([tet[i], tet[j]]));
        midside.of_cell = mesh.tets().iter().map(nodes).collect();
        let mut points = mesh.points().to_vec();
        points.extend(midside.ends.iter().map(|e| e.map(|v| mesh.points()[v as usize])).map(|[p, q]| p.midpoint(q)));
        Self { mesh, points: Cow::Owned(points), midside: Some(midside) }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &'m TetMesh {
        self.mesh
    }

    /// The element.
    #[must_use]
    pub fn element(&self) -> Element {
        if self.midside.is_some() { Element::Tet10 } else { Element::Tet4 }
    }

    /// Positions of the nodes.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The two vertices between which each node that is no vertex lies: node `vertices + k` between those of entry `k`.
    #[must_use]
    pub fn midside(&self) -> &[[u32; 2]] {
        self.midside.as_ref().map_or(&[], |m| &m.ends)
    }

    /// Nodes of cell `t`: its vertices, then those on its edges in the order of [`EDGES`].
    pub fn cell(&self, t: usize) -> impl Iterator<Item = u32> + Clone + use<> {
        let edges = self.midside.as_ref().map(|m| m.of_cell[t]);
        self.mesh.tets()[t].into_iter().chain(edges.into_iter().flatten())
    }

    /// Nodes of a boundary face: its vertices, then those between the first and second, second and third, third and first.
    pub fn face(&self, face: &Face) -> impl Iterator<Item = u32> + Clone + use<> {
        let [a, b, c] = face.vertices;
        let vertices = self.mesh.points().len() as u32;
        let edges = self.midside.as_ref().map(|m| [[a, b], [b, c], [c, a]].map(|e| vertices + m.edge(e)));
        face.vertices.into_iter().chain(edges.into_iter().flatten())
    }

    /// Shape functions of a cell at barycentric coordinates, in the order of [`Space::cell`]: `L_i` of four nodes; of ten
    /// `L_i (2 L_i - 1)` at vertices and `4 L_i L_j` between them.
    #[must_use]
    pub fn shape(&self, l: [f64; 4]) -> [f64; 10] {
        let quadratic = self.midside.is_some();
        std::array::from_fn(|a| match a {
            0..4 if quadratic => l[a] * (2.0 * l[a] - 1.0),
            0..4 => l[a],
            _ => 4.0 * l[EDGES[a - 4][0]] * l[EDGES[a - 4][1]],
        })
    }

    /// Shape functions of a face at barycentric coordinates, in the order of [`Space::face`].
    #[must_use]
    pub fn face_shape(&self, [x, y, z]: [f64; 3]) -> [f64; 6] {
        if self.midside.is_none() {
            return [x, y, z, 0.0, 0.0, 0.0];
        }
        let corner = |l: f64| l * (2.0 * l - 1.0);
        [corner(x), corner(y), corner(z), 4.0 * x * y, 4.0 * y * z, 4.0 * z * x]
    }

    /// Mean of each shape function over a cell.
    #[must_use]
    pub fn cell_means(&self) -> [f64; 10] {
        let corner = if self.midside.is_some() { -0.05 } else { 0.25 };
        std::array::from_fn(|a| if a < 4 { corner } else { 0.2 })
    }

    /// Mean of each shape function over a face.
    #[must_use]
    pub fn face_means(&self) -> [f64; 6] {
        let corner = if self.midside.is_some() { 0.0 } else { 1.0 / 3.0 };
        std::array::from_fn(|a| if a < 3 { corner } else { 1.0 / 3.0 })
    }

    /// A field between its values at the nodes, at barycentric coordinates of cell `t`.
    #[must_use]
    pub fn interpolate(&self, values: &[DVec3], t: usize, l: [f64; 4]) -> DVec3 {
        self.cell(t).zip(self.shape(l)).map(|(v, n)| n * values[v as usize]).sum()
    }
}

impl Midside {
    /// The number of an edge of the mesh.
    fn edge(&self, edge: [u32; 2]) -> u32 {
        let edge = sorted2(edge);
        let first = self.starts[edge[0] as usize];
        let row = &self.ends[first as usize..self.starts[edge[0] as usize + 1] as usize];
        first + row.partition_point(|e| e[1] < edge[1]) as u32
    }
}
