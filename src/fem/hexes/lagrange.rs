//! Lagrange elements: trilinear of 8 nodes, serendipity of 20, triquadratic of 27.

use super::super::options::HexElement;
use crate::limit::Table;
use crate::mesh::hex::{EDGES, FACES, HexMesh};
use glam::DVec3;

/// The nodes of a mesh: its vertices, then those of edges, then those of faces and cells.
#[derive(Debug)]
pub(super) struct Lagrange {
    element: HexElement,
    /// Nodes of all cells, so many a cell as the element has: corners, edges, faces, middle.
    nodes: Vec<u32>,
    each: usize,
}

impl Lagrange {
    pub fn new(mesh: &HexMesh, element: HexElement) -> Self {
        let topology = mesh.topology();
        let vertices = mesh.points().len() as u32;
        let (edges, faces) = (topology.edges().len() as u32, topology.faces().len() as u32);
        let each = match element {
            HexElement::Hex8 => 8,
            HexElement::Hex20 => 20,
            _ => 27,
        };
        let mut nodes = Vec::with_capacity(each * mesh.cells().len());
        for (t, cell) in mesh.cells().iter().enumerate() {
            nodes.extend(cell);
            if each > 8 {
                nodes.extend(topology.cell_edges()[t].map(|e| vertices + e));
            }
            if each > 20 {
                nodes.extend(topology.cell_faces()[t].map(|f| vertices + edges + f));
                nodes.push(vertices + edges + faces + t as u32);
            }
        }
        Self { element, nodes, each }
    }

    pub fn cell(&self, t: usize) -> &[u32] {
        &self.nodes[t * self.each..(t + 1) * self.each]
    }

    /// Positions of the nodes: middles of edges, faces and cells, of trilinear cells if the mesh has none.
    pub fn points(&self, mesh: &HexMesh) -> Vec<DVec3> {
        let (topology, at) = (mesh.topology(), |v: u32| mesh.points()[v as usize]);
        let mut points = mesh.points().to_vec();
        if self.each > 8 && !mesh.middles().is_empty() {
            let count = if self.each > 20 { mesh.middles().len() } else { topology.edges().len() };
            points.extend(&mesh.middles()[..count]);
            return points;
        }
        if self.each > 8 {
            points.extend(topology.edges().iter().map(|e| e.map(at).iter().sum::<DVec3>() / 2.0));
        }
        if self.each > 20 {
            points.extend(topology.faces().iter().map(|f| f.map(at).iter().sum::<DVec3>() / 4.0));
            points.extend(mesh.cells().iter().map(|c| c.map(at).iter().sum::<DVec3>() / 8.0));
        }
        points
    }

    pub fn table(&self, points: &[DVec3]) -> Table {
        let mut table = Table { functions: self.each, ..Table::default() };
        for &at in points {
            for place in PLACES.iter().take(self.each) {
                let (n, dn) = match self.element {
                    HexElement::Hex8 => product(at, *place, linear),
                    HexElement::Hex20 => serendipity(at, *place),
                    _ => product(at, *place, quadratic),
                };
                table.values.push(n);
                table.gradients.push(dn);
            }
        }
        table
    }
}

/// Where the nodes are, in halves of the unit cube: corners, edges, faces, middle.
pub(super) const PLACES: [[u8; 3]; 27] = {
    let mut places = [[1; 3]; 27];
    let mut corner = 0;
    while corner < 8 {
        places[corner] = corner_place(corner);
        corner += 1;
    }
    let mut e = 0;
    while e < 12 {
        places[8 + e] = middle(&EDGES[e]);
        e += 1;
    }
    let mut f = 0;
    while f < 6 {
        // Opposite corners of the face.
        places[20 + f] = middle(&[FACES[f][0], FACES[f][2]]);
        f += 1;
    }
    places
};

const fn corner_place(c: usize) -> [u8; 3] {
    [2 * (c & 1) as u8, 2 * (c >> 1 & 1) as u8, 2 * (c >> 2) as u8]
}

const fn middle(corners: &[usize; 2]) -> [u8; 3] {
    let (a, b) = (corner_place(corners[0]), corner_place(corners[1]));
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2]
}

/// The product of functions of the coordinates.
fn product(at: DVec3, place: [u8; 3], of: fn(f64, u8) -> [f64; 2]) -> (f64, DVec3) {
    let [[x, dx], [y, dy], [z, dz]] = [0, 1, 2].map(|axis| of(at[axis], place[axis]));
    (x * y * z, DVec3::new(dx * y * z, x * dy * z, x * y * dz))
}

/// Value and derivative of the linear function of an end.
fn linear(t: f64, place: u8) -> [f64; 2] {
    if place == 0 { [1.0 - t, -1.0] } else { [t, 1.0] }
}

/// Value and derivative of the quadratic function of an end or the middle.
fn quadratic(t: f64, place: u8) -> [f64; 2] {
    match place {
        0 => [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t - 3.0],
        1 => [4.0 * t * (1.0 - t), 4.0 - 8.0 * t],
        _ => [t * (2.0 * t - 1.0), 4.0 * t - 1.0],
    }
}

/// The serendipity functions: in coordinates r from -1 to 1 with the node at s, `(1 + r s)(1 + ..)(1 + ..)(sum r s - 2) / 8` at
/// corners and `(1 - r^2)(1 + ..)(1 + ..) / 4` on edges.
fn serendipity(at: DVec3, place: [u8; 3]) -> (f64, DVec3) {
    let r = 2.0 * at - DVec3::ONE;
    let s = DVec3::from_array(place.map(|p| f64::from(p) - 1.0));
    let factor = |axis: usize| if place[axis] == 1 { 1.0 - r[axis] * r[axis] } else { 1.0 + r[axis] * s[axis] };
    let slope = |axis: usize| if place[axis] == 1 { -2.0 * r[axis] } else { s[axis] };
    let others = |axis: usize| factor((axis + 1) % 3) * factor((axis + 2) % 3);
    let all = factor(0) * others(0);
    // The unit cube's coordinates are half as long.
    if place.contains(&1) {
        return (all / 4.0, DVec3::from_array([0, 1, 2].map(|a| slope(a) * others(a) / 2.0)));
    }
    let sum = r.dot(s) - 2.0;
    (all * sum / 8.0, DVec3::from_array([0, 1, 2].map(|a| (slope(a) * others(a) * sum + all * s[a]) / 4.0)))
}
