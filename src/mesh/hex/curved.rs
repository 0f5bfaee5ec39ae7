//! Curved cells: triquadratic maps through the middles of edges, faces and cells.

use super::{EDGES, FACES, HexMesh, HexTopology};
use crate::mesh::midside::Midside;
use crate::mesh::topology::sorted2;
use glam::DVec3;
use rayon::prelude::*;

/// How far the radii of two ends of an arc may differ, relative to them.
const ROUND: f64 = 1e-9;

/// What a round body is round about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Round {
    /// The z axis; only edges at this radius are arcs, if given.
    Axis(Option<f64>),
    /// The origin.
    Origin,
}

/// The edges of a mesh whose ends lie at one distance from an axis or a point, with the middles of their arcs.
#[must_use]
pub fn arcs(mesh: &HexMesh, round: Round) -> Vec<Midside> {
    let flat = |x: DVec3| match round {
        Round::Axis(_) => DVec3::new(x.x, x.y, 0.0),
        Round::Origin => x,
    };
    let arc = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|v| mesh.points()[v as usize]);
        let ([p, q], middle) = ([a, b].map(flat), a.midpoint(b));
        let radius = p.length();
        let is_arc = (radius - q.length()).abs() <= ROUND * radius
            && match round {
                Round::Axis(Some(only)) => (radius - only).abs() <= ROUND * only,
                _ => true,
            };
        let position = middle - flat(middle) + radius * flat(middle).normalize_or_zero();
        (is_arc && p.distance(q) > ROUND * radius).then_some(Midside { edge: sorted2(*edge), position })
    };
    mesh.topology().edges().iter().filter_map(arc).collect()
}

impl HexMesh {
    /// The mesh with curved edges; the middles of faces and cells are those of serendipity cells, `sum edges / 2 - sum corners / 4`
    /// and `sum edges / 4 - sum corners / 4`.
    #[must_use]
    pub fn with_midsides(self, midsides: &[Midside]) -> Self {
        if midsides.is_empty() {
            return self;
        }
        let topology = self.topology();
        let at = |v: u32| self.points()[v as usize];
        let sum = |corners: &[u32]| corners.iter().map(|v| at(*v)).sum::<DVec3>();
        let mut middles: Vec<DVec3> = topology.edges().iter().map(|[a, b]| at(*a).midpoint(at(*b))).collect();
        for midside in midsides {
            if let Some(e) = topology.edge(midside.edge) {
                middles[e as usize] = midside.position;
            }
        }
        let of_edges = |edges: &[u32]| edges.iter().map(|e| middles[*e as usize]).sum::<DVec3>();
        let faces = topology.faces().iter().zip(topology.face_edges());
        let faces: Vec<DVec3> = faces.map(|(f, edges)| of_edges(edges) / 2.0 - sum(f) / 4.0).collect();
        let cells = self.cells().iter().zip(topology.cell_edges());
        let cells: Vec<DVec3> = cells.map(|(c, edges)| of_edges(edges) / 4.0 - sum(c) / 4.0).collect();
        middles.extend(faces);
        middles.extend(cells);
        self.with_middles(middles)
    }
}

/// The middles of the edges, faces and cells of a mesh whose cells were split into eight each (children of cell `t` from `8 t`,
/// at its corners, with parallel axes), so that the body stays as it is; nothing if it is straight.
#[must_use]
pub fn split_middles(mesh: &HexMesh, cells: &[[u32; 8]], finer: &HexTopology) -> Vec<DVec3> {
    if mesh.middles().is_empty() {
        return Vec::new();
    }
    let lattices: Vec<Vec<DVec3>> = (0..mesh.cells().len()).into_par_iter().map(|t| quarters(mesh, t)).collect();
    let (edges, faces) = (finer.edges().len(), finer.faces().len());
    let mut middles = vec![DVec3::ZERO; edges + faces + cells.len()];
    // Cells that share an edge or a face agree about it but for rounding: the first has the last word.
    for child in (0..cells.len()).rev() {
        let lattice = &lattices[child / 8];
        let at = |[x, y, z]: [usize; 3]| {
            let [a, b, c] = [0, 1, 2].map(|axis| 2 * (child >> axis & 1));
            lattice[(x + a) + 5 * ((y + b) + 5 * (z + c))]
        };
        for (e, ends) in finer.cell_edges()[child].iter().zip(&EDGES) {
            middles[*e as usize] = at(between(*ends));
        }
        for (f, corners) in finer.cell_faces()[child].iter().zip(&FACES) {
            middles[edges + *f as usize] = at(between([corners[0], corners[2]]));
        }
        middles[edges + faces + child] = at([1; 3]);
    }
    middles
}

/// Half way between two corners, in halves of the unit cube.
fn between(corners: [usize; 2]) -> [usize; 3] {
    let [a, b] = corners.map(|c| [c & 1, c >> 1 & 1, c >> 2]);
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// The triquadratic map of a cell at quarters of its unit cube, x fastest.
fn quarters(mesh: &HexMesh, t: usize) -> Vec<DVec3> {
    let (topology, middles) = (mesh.topology(), mesh.middles());
    let (edges, faces) = (topology.edges().len(), topology.faces().len());
    let mut nodes = [DVec3::ZERO; 27];
    let mut put = |[x, y, z]: [usize; 3], p: DVec3| nodes[x + 3 * (y + 3 * z)] = p;
    for (c, p) in mesh.cell_points(t).into_iter().enumerate() {
        put(between([c, c]), p);
    }
    for (e, ends) in topology.cell_edges()[t].iter().zip(&EDGES) {
        put(between(*ends), middles[*e as usize]);
    }
    for (f, corners) in topology.cell_faces()[t].iter().zip(&FACES) {
        put(between([corners[0], corners[2]]), middles[edges + *f as usize]);
    }
    put([1; 3], middles[edges + faces + t]);
    // Quadratic polynomials at quarters, from their values at halves.
    const WEIGHTS: [[f64; 3]; 5] =
        [[1.0, 0.0, 0.0], [0.375, 0.75, -0.125], [0.0, 1.0, 0.0], [-0.125, 0.75, 0.375], [0.0, 0.0, 1.0]];
    let value = |i: usize| -> DVec3 {
        let [x, y, z] = [i % 5, i / 5 % 5, i / 25].map(|k| WEIGHTS[k]);
        (0..27).map(|n| x[n % 3] * y[n / 3 % 3] * z[n / 9] * nodes[n]).sum()
    };
    (0..125).map(value).collect()
}
