//! The error-driven optimiser: for analysis, the mesh on which a quadratic displacement is interpolated best.
//!
//! It lowers the sum over the cells of weight times [`cost::cost`], the expected interpolation error of a random
//! quadratic. The weights come from an error estimate, so that accuracy is bought where it pays. Moves: edge removal (at
//! flat boundary edges too), 2-3 flips, vertex moves (boundary vertices slide in their plane or along their crease). The
//! worst angle is a floor only: no move makes a cell below the floor that was not.

mod cost;
mod relocate;

use super::edge_removal::{Filling, Measure, remove_edge};
use super::{is_flat, is_removable};
use crate::mesh::{TetMesh, topology};
use crate::subdiv::solid::Solid;
pub use cost::cost;
use cost::cost_and_sine;

/// Sine of 15 degrees: cells at least this good stay so.
const FLOOR: f64 = 0.258_819_045_102_520_74;

/// Least share by which a change of topology must lower the cost.
const GAIN: f64 = 1e-3;

/// Weights of the vertices on `mesh` from a squared error in each cell: at a vertex the error of the cells around it
/// over their cost. Where the error is spread as the cost would have it, all weights are equal.
pub fn vertex_weights(mesh: &TetMesh, squared_errors: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); mesh.points().len()];
    for (t, tet) in mesh.tets().iter().enumerate() {
        let cost = cost(mesh.cell_points(t));
        for v in tet {
            let (error, total) = &mut sums[*v as usize];
            *error += squared_errors[t];
            *total += cost;
        }
    }
    sums.into_iter().map(|(error, total)| if total > 0.0 { error / total } else { 0.0 }).collect()
}

/// Weight of a cell: the mean of those of its vertices.
fn weight(weights: &[f64], tet: [u32; 4]) -> f64 {
    0.25 * tet.iter().map(|&v| weights[v as usize]).sum::<f64>()
}

/// Lowers the weighted cost of the mesh by up to `passes` passes; `weights` has one positive entry a vertex. Each pass
/// after the first looks only at what the pass before changed.
pub(crate) fn optimise(solid: &mut Solid, weights: &[f64], passes: usize) {
    let mut filling = Filling::default();
    let mut since = 0;
    for _ in 0..passes {
        let now = solid.tick();
        let removed = remove_edges(solid, weights, since, &mut filling);
        let flipped = flip_faces(solid, weights, since);
        let moved = relocate_vertices(solid, weights, since);
        if removed + flipped + moved == 0 {
            break;
        }
        since = now;
    }
}

/// Removes the edges whose rings cost less without them; returns how many.
fn remove_edges(solid: &mut Solid, weights: &[f64], since: u32, filling: &mut Filling) -> usize {
    let mut edges: Vec<[u32; 2]> = solid.cells_since(since).flat_map(|t| topology::tet_edges(solid.tet(t))).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.into_iter().filter(|&e| remove(solid, weights, e, filling)).count()
}

fn remove(solid: &mut Solid, weights: &[f64], edge: [u32; 2], filling: &mut Filling) -> bool {
    let Some(ring) = solid.ring(edge[0], edge[1]) else { return false };
    if !(if ring.closed { is_removable(solid, edge) } else { is_flat(solid, edge, &ring) }) {
        return false;
    }
    let worst = solid.worst_sine(&ring.cells);
    let old: f64 = ring.cells.iter().map(|&t| weight(weights, solid.tet(t)) * cost(solid.cell_points(t))).sum();
    let measure = Measure::LeastSum {
        cost: &|tet, points| cost_and_sine(points).map(|(c, sine)| (weight(weights, tet) * c, sine)),
        below: (1.0 - GAIN) * old,
        floor: worst.min(FLOOR),
    };
    remove_edge(solid, edge, &ring, &measure, filling)
}

/// 2-3 flips of the interior faces that lower the cost; returns how many.
fn flip_faces(solid: &mut Solid, weights: &[f64], since: u32) -> usize {
    let mut faces: Vec<[u32; 3]> =
        solid.cells_since(since).flat_map(|t| topology::tet_faces(solid.tet(t))).map(topology::sorted3).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.into_iter().filter(|&f| flip(solid, weights, f)).count()
}

fn flip(solid: &mut Solid, weights: &[f64], face: [u32; 3]) -> bool {
    let Some(flip) = super::FaceFlip::of(solid, face) else { return false };
    let price = |tet: [u32; 4]| weight(weights, tet) * cost(tet.map(|v| solid.point(v)));
    let old: f64 = flip.cells.iter().map(|&t| price(solid.tet(t))).sum();
    let floor = solid.worst_sine(&flip.cells).min(FLOOR);
    let new: f64 = flip.children.iter().map(|&c| price(c)).sum();
    if new >= (1.0 - GAIN) * old || flip.worst_sine(solid) < floor {
        return false;
    }
    flip.perform(solid);
    true
}

/// Moves the vertices of changed cells; returns how many moved.
fn relocate_vertices(solid: &mut Solid, weights: &[f64], since: u32) -> usize {
    let mut vertices: Vec<u32> = solid.cells_since(since).flat_map(|t| solid.tet(t)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.into_iter().filter(|&v| relocate::relocate(solid, weights, v, FLOOR)).count()
}
