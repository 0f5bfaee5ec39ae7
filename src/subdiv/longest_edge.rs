//! Conforming longest-edge bisection (Rivara 1984; in space Rivara and Levin 1992): a cell is cut at its longest edge.
//!
//! An edge is bisected, with all cells of its ring, only when it is the longest edge of each of them; where it is not,
//! the longer edge goes first, and so on along the path of longest edges. Hence the mesh conforms at every moment.
//!
//! **Order.** Edges are compared by length, then by vertex numbers: a strict total order, so that ties are broken alike
//! for all cells of a ring and "the longest edge" of a cell is one edge.
//!
//! **Termination.** The path climbs strictly in the order among finitely many edges, so it has an end, where an edge is
//! bisected. With the longest edge c of a triangle, its halves measure c / 2 and the median on it at most sqrt(3)/2 c
//! (the median's square is (2 a^2 + 2 b^2 - c^2) / 4, and a, b <= c). So each bisection replaces one edge by edges
//! shorter than it by a fixed factor: after finitely many, none above the edge that waits is left.

use super::solid::Solid;
use super::{History, Info, Refined, Stencil};
use crate::mesh::{MeshError, TetMesh, topology};
use std::cmp::Ordering;

/// A half of an edge is at most this share of it; more means that the midpoint was rounded onto an end.
const LARGEST_HALF: f64 = 0.6;

/// Bisects each selected cell once at its longest edge, the longest first, and whatever cells must be bisected with it.
///
/// # Errors
/// [`MeshError::Generator`] if an edge is too short to be halved in double precision.
pub(super) fn refine(mesh: &TetMesh, selected: &[bool]) -> Result<Refined, MeshError> {
    let mut solid = Solid::new(mesh);
    let mut cells: Vec<(Edge, u32)> = (0..selected.len())
        .filter(|&t| selected[t])
        .map(|t| (longest_edge(&solid, mesh.tets()[t]), t as u32))
        .collect();
    // Where everything around is selected too, the longest edges are bisected without any path.
    cells.sort_unstable_by(|(e, t), (f, u)| f.cmp(e).then(t.cmp(u)));
    for &(edge, t) in &cells {
        // Slots are used again, but the cells in them have new vertices.
        if solid.tet(t) == mesh.tets()[t as usize] {
            bisect(&mut solid, edge)?;
        }
    }
    let kept = (0..selected.len()).filter(|&t| solid.tet(t as u32) == mesh.tets()[t]).count();
    let worst_sine = solid.worst_sine_of_all();
    let info = Info { asked: cells.len(), split: selected.len() - kept, worst_sine, ..Info::default() };
    let transfer = solid.take_transfer();
    Ok(Refined { mesh: solid.finish()?, transfer, history: History::default(), info, frames: Vec::new() })
}

/// An edge in the order of bisection.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    length_squared: f64,
    vertices: [u32; 2],
}

impl Eq for Edge {}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        self.length_squared.total_cmp(&other.length_squared).then(self.vertices.cmp(&other.vertices))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The longest edge of a cell.
fn longest_edge(solid: &Solid, tet: [u32; 4]) -> Edge {
    let [first, rest @ ..] = topology::tet_edges(tet).map(|vertices| {
        let [a, b] = vertices.map(|v| solid.point(v));
        Edge { length_squared: a.distance_squared(b), vertices }
    });
    rest.into_iter().fold(first, Edge::max)
}

/// Bisects an edge after all that must go before it.
fn bisect(solid: &mut Solid, edge: Edge) -> Result<(), MeshError> {
    let mut path = vec![edge];
    while let Some(&edge) = path.last() {
        let [a, b] = edge.vertices;
        let ring: Vec<u32> = solid.cells_at(a).iter().copied().filter(|&t| solid.tet(t).contains(&b)).collect();
        let longest = ring.iter().map(|&t| longest_edge(solid, solid.tet(t))).fold(edge, Edge::max);
        if longest == edge {
            halve(solid, edge, &ring)?;
            path.pop();
        } else {
            path.push(longest);
        }
    }
    Ok(())
}

/// Bisects an edge with the cells around it.
fn halve(solid: &mut Solid, Edge { length_squared, vertices: [a, b] }: Edge, ring: &[u32]) -> Result<(), MeshError> {
    let [p, q] = [a, b].map(|v| solid.point(v));
    let middle = 0.5 * (p + q);
    let half = middle.distance_squared(p).max(middle.distance_squared(q));
    if half.is_nan() || half > LARGEST_HALF * LARGEST_HALF * length_squared {
        let message = format!("the edge from vertex {a} to {b} at {p} is too short to be halved in double precision");
        return Err(MeshError::Generator(message));
    }
    ring.iter().for_each(|&t| solid.deepen(t));
    let m = solid.add_vertex(Stencil::mean(&[a, b]));
    solid.divide_edge(a, b, &[m]);
    Ok(())
}
