//! Where control points go in the limit, and control points whose limit is given.
//!
//! After a step, the closed ring of a vertex (itself, and the far corners of its edges, faces and cells) depends on the closed
//! ring before it, by a square matrix whose rows sum to one. The vertex's limit is the left eigenvector of the eigenvalue 1
//! applied to the ring: what powers of the matrix make of its row.

use super::masks::{Control, Item, Row};
use crate::mesh::hex::{HexError, HexMesh, HexTopology};
use crate::mesh::weights::WeightRows;
use crate::subdiv::options::CatmullClark;
use glam::DVec3;

/// Steps after which a row counts as converged; other eigenvalues are about 0.65 at most.
const POWERS: usize = 1000;
/// Largest change of a weight in the last step.
const CONVERGED: f64 = 1e-17;
/// Sweeps for control points of a given limit. On regular meshes some 300 are needed, whatever their size.
const SWEEPS: usize = 20_000;
/// Distance to the given limit that is reached, over the size of the mesh.
const REACHED: f64 = 1e-14;

impl Control<'_> {
    /// The limit of each vertex, as a combination of control points.
    #[must_use]
    pub fn limit_stencils(&self, variant: CatmullClark) -> WeightRows {
        WeightRows::collect(self.corner.len(), self.corner.len(), |v, row| {
            let star = Star::of(self, v as u32);
            row.extend(star.limit(variant).into_iter().map(|(i, weight)| (star.vertices[i as usize], weight)));
        })
    }
}

/// The cells at a vertex, cut out of the mesh: vertex 0 is the one in the middle, and each of its edges, faces and cells has a
/// far corner of its own.
struct Star {
    /// The mesh's number of each vertex.
    vertices: Vec<u32>,
    cells: Vec<[u32; 8]>,
    /// Ends of the creases, other than the middle.
    creases: Vec<u32>,
    corner: bool,
}

impl Star {
    fn of(control: &Control<'_>, v: u32) -> Self {
        let topology = control.topology;
        // What stands for a far corner: the edge, face or cell, of that dimension.
        let mut items = vec![(0, v)];
        let mut star =
            Self { vertices: vec![v], cells: Vec::new(), creases: Vec::new(), corner: control.corner[v as usize] };
        for &t in topology.vertex_cells(v) {
            let cell = control.cells[t as usize];
            let own = cell.iter().position(|w| *w == v).unwrap_or(0);
            star.cells.push(std::array::from_fn(|c| {
                let item = match own ^ c {
                    0 => (0, v),
                    way @ (1 | 2 | 4) => {
                        let from = own & !way;
                        let ends = [cell[from], cell[from | way]];
                        (1, topology.edge(ends).unwrap_or(0))
                    }
                    way @ (3 | 5 | 6) => {
                        let axis = (7 ^ way).trailing_zeros() as usize;
                        (2, topology.cell_faces()[t as usize][2 * axis + (own >> axis & 1)])
                    }
                    _ => (3, t),
                };
                let known = items.iter().position(|i| *i == item);
                known.unwrap_or_else(|| {
                    items.push(item);
                    star.vertices.push(cell[c]);
                    if item.0 == 1 && control.creased[item.1 as usize] {
                        star.creases.push(items.len() as u32 - 1);
                    }
                    items.len() - 1
                }) as u32
            }));
        }
        star
    }

    /// The limit of the vertex in the middle.
    fn limit(&self, variant: CatmullClark) -> Row {
        let count = self.vertices.len();
        // Cut out of a mesh, the cells are those of one.
        let Ok(topology) = HexTopology::new(count, &self.cells) else { return vec![(0, 1.0)] };
        let matrix = self.matrix(&topology, variant);
        let (mut weights, mut next) = (vec![0.0; count], vec![0.0; count]);
        weights[0] = 1.0;
        for _ in 0..POWERS {
            next.fill(0.0);
            for (row, weight) in matrix.iter().zip(&weights) {
                row.iter().for_each(|&(column, entry)| next[column as usize] += weight * entry);
            }
            let change = weights.iter().zip(&next).map(|(a, b): (&f64, &f64)| (a - b).abs()).fold(0.0, f64::max);
            std::mem::swap(&mut weights, &mut next);
            if change <= CONVERGED {
                break;
            }
        }
        // Rounding adds up over the steps.
        let sum: f64 = weights.iter().sum();
        (0..).zip(weights).filter(|(_, weight)| *weight != 0.0).map(|(i, weight)| (i, weight / sum)).collect()
    }

    /// The rows of the ring.
    fn matrix(&self, topology: &HexTopology, variant: CatmullClark) -> Vec<Row> {
        let mut creased = vec![false; topology.edges().len()];
        for &end in &self.creases {
            if let Some(e) = topology.edge([0, end]) {
                creased[e as usize] = true;
            }
        }
        let mut corner = vec![false; self.vertices.len()];
        corner[0] = self.corner;
        let control = Control { cells: &self.cells, topology, creased, corner };
        let mut rows = vec![Row::new(); self.vertices.len()];
        let mut set = |far: u32, item: Item| control.new_point(item, variant, &mut rows[far as usize]);
        set(0, Item::Vertex(0));
        for &e in topology.vertex_edges(0) {
            let [_, far] = topology.edges()[e as usize];
            set(far, Item::Edge(e));
        }
        for f in control.faces_at(0) {
            let face = topology.faces()[f as usize];
            let own = face.iter().position(|v| *v == 0).unwrap_or(0);
            set(face[(own + 2) % 4], Item::Face(f));
        }
        for (t, cell) in (0..).zip(&self.cells) {
            let own = cell.iter().position(|v| *v == 0).unwrap_or(0);
            set(cell[7 ^ own], Item::Cell(t));
        }
        rows
    }
}

/// The mesh with control points whose limits are the vertices it has: the limit passes through them.
///
/// Solves `L P = X`, one limit a row: boundary rows see the boundary only, those of creases their curve.
///
/// # Errors
/// [`HexMesh::check_smoothable`]'s; [`HexError::NoInterpolation`] if no such control points are found.
pub fn interpolated(mesh: HexMesh, variant: CatmullClark) -> Result<HexMesh, HexError> {
    mesh.check_smoothable()?;
    let limits = Control::of(&mesh).limit_stencils(variant);
    let points = control_points(&limits, mesh.points(), REACHED * mesh.diagonal())?;
    HexMesh::refined(crate::mesh::hex::HexMeshParts { points, ..mesh.into_parts() })
}

/// Gauss-Seidel's method.
fn control_points(limits: &WeightRows, given: &[DVec3], close: f64) -> Result<Vec<DVec3>, HexError> {
    let mut points = given.to_vec();
    for _ in 0..SWEEPS {
        let (mut worst, mut at) = (0.0_f64, 0);
        for (v, &want) in given.iter().enumerate() {
            let (mut sum, mut own) = (DVec3::ZERO, 1.0);
            for (w, weight) in limits.row(v) {
                sum += weight * points[w as usize];
                if w as usize == v {
                    own = weight;
                }
            }
            let miss = want - sum;
            points[v] += miss / own;
            let distance = miss.length();
            if distance > worst || distance.is_nan() {
                (worst, at) = (distance, v);
            }
        }
        if worst <= close {
            return Ok(points);
        }
        if !worst.is_finite() {
            return Err(HexError::NoInterpolation { vertex: at, at: given[at] });
        }
    }
    let miss = limits.apply(&points).into_iter().zip(given).map(|(a, b)| a.distance(*b)).enumerate();
    let (vertex, _) = miss.fold((0, 0.0), |worst, next| if next.1 > worst.1 { next } else { worst });
    Err(HexError::NoInterpolation { vertex, at: given[vertex] })
}
