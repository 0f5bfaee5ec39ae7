//! The error-driven optimiser: for analysis, the mesh on which a quadratic displacement is interpolated best.
//!
//! It lowers the sum over the cells of weight times [`cost::cost`], the expected interpolation error of a random
//! quadratic. The weights come from an error estimate, so that accuracy is bought where it pays. Moves: edge removal (at
//! flat boundary edges too), 2-3 flips, vertex moves (boundary vertices slide in their plane or along their crease). The
//! worst angle is a floor only: no move makes a cell below the floor that was not.

mod cost;
mod relocate;

use super::edge_removal::{CellPrice, Filling, Measure, can_remove, remove_edge};
use super::freedom::freedoms;
use super::parallel::{select, sweep, vertices_of};
use super::{FaceFlip, is_removable};
use crate::mesh::{TetMesh, topology};
use crate::subdiv::solid::{Ring, Solid};
pub use cost::cost;
use cost::cost_and_sine;
use glam::DVec3;
use rayon::prelude::*;

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
pub(crate) fn optimise_error(solid: &mut Solid, weights: &[f64], passes: usize) {
    let freedoms = freedoms(solid);
    let rounding = 4.0 * f64::EPSILON * solid.largest_coordinate();
    let mut filling = Filling::default();
    let mut since = 0;
    for _ in 0..passes {
        let now = solid.tick();
        let removed = remove_edges(solid, weights, since, rounding, &mut filling);
        let flipped = flip_faces(solid, weights, since);
        let vertices = vertices_of(solid, solid.cells_since(since));
        let propose = |(): &mut (), solid: &Solid, v, freedom| relocate::better(solid, weights, v, freedom, FLOOR);
        let moved = sweep(solid, &freedoms, vertices, || (), propose);
        if removed + flipped + moved == 0 {
            break;
        }
        since = now;
    }
}

/// Removes the edges whose rings cost less without them; returns how many.
fn remove_edges(solid: &mut Solid, weights: &[f64], since: u32, rounding: f64, filling: &mut Filling) -> usize {
    let mut edges: Vec<[u32; 2]> = solid.cells_since(since).flat_map(|t| topology::tet_edges(solid.tet(t))).collect();
    edges.par_sort_unstable();
    edges.dedup();
    let worth = |filling: &mut Filling, &edge: &[u32; 2]| {
        removable_ring(solid, edge, rounding).is_some_and(|ring| {
            let price = priced(weights);
            can_remove(solid, edge, &ring, &cheaper(solid, weights, &ring, &price), filling)
        })
    };
    let mut removed = 0;
    for edge in select(edges, worth) {
        let Some(ring) = removable_ring(solid, edge, rounding) else { continue };
        let price = priced(weights);
        let measure = cheaper(solid, weights, &ring, &price);
        removed += usize::from(remove_edge(solid, edge, &ring, &measure, filling));
    }
    removed
}

/// The ring of an edge that may go.
fn removable_ring(solid: &Solid, edge: [u32; 2], rounding: f64) -> Option<Ring> {
    solid.ring(edge[0], edge[1]).filter(|ring| is_removable(solid, edge, ring, rounding))
}

/// Weighted cost and minimum sine of a cell.
fn priced(weights: &[f64]) -> impl Fn([u32; 4], [DVec3; 4]) -> Option<(f64, f64)> {
    |tet, points| cost_and_sine(points).map(|(cost, sine)| (weight(weights, tet) * cost, sine))
}

/// What a filling of the ring must be better than.
fn cheaper<'a>(solid: &Solid, weights: &[f64], ring: &Ring, price: &'a CellPrice<'a>) -> Measure<'a> {
    let old: f64 = ring.cells.iter().map(|&t| weight(weights, solid.tet(t)) * cost(solid.cell_points(t))).sum();
    Measure::LeastSum { cost: price, below: (1.0 - GAIN) * old, floor: solid.worst_sine(&ring.cells).min(FLOOR) }
}

/// 2-3 flips of the interior faces that lower the cost; returns how many.
fn flip_faces(solid: &mut Solid, weights: &[f64], since: u32) -> usize {
    let mut faces: Vec<[u32; 3]> =
        solid.cells_since(since).flat_map(|t| topology::tet_faces(solid.tet(t))).map(topology::sorted3).collect();
    faces.par_sort_unstable();
    faces.dedup();
    let worth = |(): &mut (), face: &[u32; 3]| cheaper_flip(solid, weights, *face).is_some();
    let mut flipped = 0;
    for face in select(faces, worth) {
        if let Some(flip) = cheaper_flip(solid, weights, face) {
            flip.perform(solid);
            flipped += 1;
        }
    }
    flipped
}

/// The flip of a face if it lowers the cost.
fn cheaper_flip(solid: &Solid, weights: &[f64], face: [u32; 3]) -> Option<FaceFlip> {
    let flip = FaceFlip::of(solid, face)?;
    let price = |tet: [u32; 4]| weight(weights, tet) * cost(tet.map(|v| solid.point(v)));
    let old: f64 = flip.cells.iter().map(|&t| price(solid.tet(t))).sum();
    let new: f64 = flip.children.iter().map(|&c| price(c)).sum();
    let floor = solid.worst_sine(&flip.cells).min(FLOOR);
    (new < (1.0 - GAIN) * old && flip.worst_sine(solid) >= floor).then_some(flip)
}
