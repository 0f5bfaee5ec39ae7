//! The finite-element space on a mesh: which nodes each cell and each face has, its shape functions and its geometry.
//!
//! Nodes are numbered vertices first, in the mesh's order; ten-node cells add nodes on the mesh's edges, in the order of
//! [`topology::edges`], in the middle of straight edges and elsewhere on curved ones.

use super::options::Element;
use super::{quadrature, tet4};
use crate::mesh::features::face_normal;
use crate::mesh::locate::Locator;
use crate::mesh::midside::{self, Midside};
use crate::mesh::quality::EDGES;
use crate::mesh::topology::{self, sorted2};
use crate::mesh::{Face, TetMesh};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// How many places a thread looks up at a time.
const PLACES: usize = 256;

/// A mesh with the nodes of its elements.
#[derive(Debug, Clone)]
pub struct Space<'m> {
    mesh: &'m TetMesh,
    points: Cow<'m, [DVec3]>,
    on_edges: Option<OnEdges>,
}

/// The nodes on the edges of a mesh.
#[derive(Debug, Clone)]
struct OnEdges {
    /// Vertices of each edge, sorted.
    ends: Vec<[u32; 2]>,
    /// The first edge of each vertex as the lower end, and the number of edges.
    starts: Vec<u32>,
    /// Nodes of each cell, in the order of [`EDGES`].
    of_cell: Vec<[u32; 6]>,
    /// Edges that are not straight; empty if all are.
    curved: Vec<bool>,
}

impl<'m> Space<'m> {
    /// The space of an element on a mesh; `midsides` are the nodes of its curved edges, sorted by edge.
    #[must_use]
    pub fn new(mesh: &'m TetMesh, element: Element, midsides: &[Midside]) -> Self {
        match element {
            Element::Tet4 => Self::linear(mesh),
            Element::Tet10 => Self::quadratic(mesh, midsides),
        }
    }

    /// Four-node cells: the nodes are the vertices.
    #[must_use]
    pub fn linear(mesh: &'m TetMesh) -> Self {
        Self { mesh, points: Cow::Borrowed(mesh.points()), on_edges: None }
    }

    fn quadratic(mesh: &'m TetMesh, midsides: &[Midside]) -> Self {
        let vertices = mesh.points().len();
        let ends = topology::edges(mesh.tets());
        let mut starts = vec![0_u32; vertices + 1];
        for [a, _] in &ends {
            starts[*a as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut on_edges = OnEdges { ends, starts, of_cell: Vec::new(), curved: Vec::new() };
        let nodes = |tet: &[u32; 4]| EDGES.map(|[i, j]| vertices as u32 + on_edges.edge([tet[i], tet[j]]));
        on_edges.of_cell = mesh.tets().iter().map(nodes).collect();
        let mut points = mesh.points().to_vec();
        points.extend(on_edges.ends.iter().map(|e| e.map(|v| mesh.points()[v as usize])).map(|[p, q]| p.midpoint(q)));
        if !midsides.is_empty() {
            on_edges.curved = vec![false; on_edges.ends.len()];
        }
        for m in midsides {
            let edge = on_edges.edge(m.edge) as usize;
            points[vertices + edge] = m.position;
            on_edges.curved[edge] = true;
        }
        Self { mesh, points: Cow::Owned(points), on_edges: Some(on_edges) }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &'m TetMesh {
        self.mesh
    }

    /// The element.
    #[must_use]
    pub fn element(&self) -> Element {
        if self.on_edges.is_some() { Element::Tet10 } else { Element::Tet4 }
    }

    /// Positions of the nodes.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The two vertices between which each node that is no vertex lies: node `vertices + k` between those of entry `k`.
    #[must_use]
    pub fn midside(&self) -> &[[u32; 2]] {
        self.on_edges.as_ref().map_or(&[], |m| &m.ends)
    }

    /// Nodes of cell `t`: its vertices, then those on its edges in the order of [`EDGES`].
    pub fn cell(&self, t: usize) -> impl Iterator<Item = u32> + Clone + use<> {
        let edges = self.on_edges.as_ref().map(|m| m.of_cell[t]);
        self.mesh.tets()[t].into_iter().chain(edges.into_iter().flatten())
    }

    /// Nodes of a boundary face: its vertices, then those between the first and second, second and third, third and first.
    pub fn face(&self, face: &Face) -> impl Iterator<Item = u32> + Clone + use<> {
        let [a, b, c] = face.vertices;
        let vertices = self.mesh.points().len() as u32;
        let edges = self.on_edges.as_ref().map(|m| [[a, b], [b, c], [c, a]].map(|e| vertices + m.edge(e)));
        face.vertices.into_iter().chain(edges.into_iter().flatten())
    }

    /// Shape functions of a cell at barycentric coordinates, in the order of [`Space::cell`]: `L_i` of four nodes; of ten
    /// `L_i (2 L_i - 1)` at vertices and `4 L_i L_j` between them.
    #[must_use]
    pub fn shape(&self, l: [f64; 4]) -> [f64; 10] {
        let quadratic = self.on_edges.is_some();
        std::array::from_fn(|a| match a {
            0..4 if quadratic => l[a] * (2.0 * l[a] - 1.0),
            0..4 => l[a],
            _ => 4.0 * l[EDGES[a - 4][0]] * l[EDGES[a - 4][1]],
        })
    }

    /// Shape functions of a face at barycentric coordinates, in the order of [`Space::face`].
    #[must_use]
    pub fn face_shape(&self, [x, y, z]: [f64; 3]) -> [f64; 6] {
        if self.on_edges.is_none() {
            return [x, y, z, 0.0, 0.0, 0.0];
        }
        let corner = |l: f64| l * (2.0 * l - 1.0);
        [corner(x), corner(y), corner(z), 4.0 * x * y, 4.0 * y * z, 4.0 * z * x]
    }

    /// The curvature of a cell's edges: its ten nodes, if one of its edges is curved.
    fn bent(&self, t: usize) -> Option<[DVec3; 10]> {
        let on_edges = self.on_edges.as_ref().filter(|e| !e.curved.is_empty())?;
        let vertices = self.mesh.points().len();
        let edges = on_edges.of_cell[t].iter().map(|&v| v as usize - vertices);
        if !{ edges }.any(|e| on_edges.curved[e]) {
            return None;
        }
        let mut x = [DVec3::ZERO; 10];
        x.iter_mut().zip(self.cell(t)).for_each(|(x, v)| *x = self.points[v as usize]);
        Some(x)
    }

    /// Whether an edge of cell `t` is curved.
    #[must_use]
    pub fn is_curved(&self, t: usize) -> bool {
        self.bent(t).is_some()
    }

    /// Volume (a sixth of the Jacobian determinant) and gradients of the barycentric coordinates at a point of cell `t`;
    /// constant in cells of straight edges.
    #[must_use]
    pub fn frame(&self, t: usize, l: [f64; 4]) -> (f64, [DVec3; 4]) {
        match self.bent(t) {
            Some(x) => midside::quadratic_frame(&x, l),
            None => tet4::gradients(self.mesh.cell_points(t)),
        }
    }

    /// The place of barycentric coordinates of cell `t`.
    #[must_use]
    pub fn position(&self, t: usize, l: [f64; 4]) -> DVec3 {
        if self.is_curved(t) {
            return self.interpolate(&self.points, t, l);
        }
        self.mesh.cell_points(t).into_iter().zip(l).map(|(x, l)| l * x).sum()
    }

    /// Quadrature of degree five on cell `t`: barycentric coordinates, place, and weight (volume).
    #[must_use]
    pub fn cell_rule(&self, t: usize) -> [([f64; 4], DVec3, f64); 14] {
        let rule = quadrature::tetrahedron(self.mesh.cell_points(t));
        match self.bent(t) {
            None => {
                let volume = self.mesh.cell_volume(t);
                rule.map(|(l, w, x)| (l, x, w * volume))
            }
            Some(x) => {
                let place = |l| x.iter().zip(self.shape(l)).map(|(x, n)| n * *x).sum();
                rule.map(|(l, w, _)| (l, place(l), w * midside::quadratic_frame(&x, l).0))
            }
        }
    }

    /// Points of even spread in cell `t`, as [`Space::cell_rule`] has them: on a lattice of `parts` along each edge.
    #[must_use]
    pub fn cell_samples(&self, t: usize, parts: usize) -> Vec<([f64; 4], DVec3, f64)> {
        let lattice = quadrature::lattice::<4>(parts);
        let weight = 1.0 / lattice.len() as f64;
        lattice.into_iter().map(|l| (l, self.position(t, l), weight * self.frame(t, l).0)).collect()
    }

    /// Points of even spread on a boundary face, as [`Space::face_rule`] has them: on a lattice of `parts` along each edge.
    #[must_use]
    pub fn face_samples(&self, face: &Face, parts: usize) -> Vec<([f64; 3], DVec3, DVec3)> {
        let lattice = quadrature::lattice::<3>(parts);
        let weight = 1.0 / lattice.len() as f64;
        self.on_face(face, lattice.into_iter().map(|l| (l, weight))).collect()
    }

    /// Quadrature of degree five on a boundary face: barycentric coordinates, place, and weight (area vector, outward).
    #[must_use]
    pub fn face_rule(&self, face: &Face) -> [([f64; 3], DVec3, DVec3); 7] {
        let rule = quadrature::triangle([DVec3::ZERO; 3]);
        let mut points = self.on_face(face, rule.into_iter().map(|(l, w, _)| (l, w)));
        std::array::from_fn(|_| points.next().unwrap_or_default())
    }

    /// Places and weights (area vectors) of barycentric coordinates and shares of the area of a boundary face.
    fn on_face(
        &self,
        face: &Face,
        rule: impl Iterator<Item = ([f64; 3], f64)>,
    ) -> impl Iterator<Item = ([f64; 3], DVec3, DVec3)> {
        let curved = |e: u32| self.on_edges.as_ref().is_some_and(|m| !m.curved.is_empty() && m.curved[e as usize]);
        let vertices = self.mesh.points().len() as u32;
        let straight = !self.face(face).skip(3).any(|v| curved(v - vertices));
        let area = 0.5 * face_normal(self.mesh.points(), face.vertices);
        let mut x = [DVec3::ZERO; 6];
        x.iter_mut().zip(self.face(face)).for_each(|(x, v)| *x = self.points[v as usize]);
        rule.map(move |(l, w)| {
            if straight {
                return (l, l[0] * x[0] + l[1] * x[1] + l[2] * x[2], w * area);
            }
            let place = x.iter().zip(self.face_shape(l)).map(|(x, n)| n * *x).sum();
            // dx / dL_k: the two edges at corner k run to the two others.
            let along: [DVec3; 3] = std::array::from_fn(|k| {
                let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                (4.0 * l[k] - 1.0) * x[k] + 4.0 * (l[next] * x[3 + k] + l[last] * x[3 + last])
            });
            (l, place, 0.5 * w * (along[1] - along[0]).cross(along[2] - along[0]))
        })
    }

    /// A field between its values at the nodes, at barycentric coordinates of cell `t`.
    #[must_use]
    pub fn interpolate(&self, values: &[DVec3], t: usize, l: [f64; 4]) -> DVec3 {
        self.cell(t).zip(self.shape(l)).map(|(v, n)| n * values[v as usize]).sum()
    }
}

impl Space<'_> {
    /// A field of this space at places in the body: that of the cell there, and outside that of the nearest point.
    #[must_use]
    pub fn at_places(&self, values: &[DVec3], places: &[DVec3]) -> Vec<DVec3> {
        let locator = Locator::new(self.mesh);
        let value = |x: &DVec3| {
            let found = locator.nearest(*x);
            self.interpolate(values, found.cell, found.weights)
        };
        places.par_iter().with_min_len(PLACES).map(value).collect()
    }
}

impl OnEdges {
    /// The number of an edge of the mesh.
    fn edge(&self, edge: [u32; 2]) -> u32 {
        let edge = sorted2(edge);
        let first = self.starts[edge[0] as usize];
        let row = &self.ends[first as usize..self.starts[edge[0] as usize + 1] as usize];
        first + row.partition_point(|e| e[1] < edge[1]) as u32
    }
}
