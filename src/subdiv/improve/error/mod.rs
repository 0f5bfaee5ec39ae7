//! The error-driven optimiser: for analysis, the mesh on which a quadratic displacement is interpolated best.
//!
//! It lowers the sum over the cells of the expected interpolation error of a random quadratic, without a direction
//! ([`cost::cost`] times a weight) or with one ([`directional`]). The weights come from an error estimate, so that accuracy
//! is bought where it pays. Moves: edge removal (at
//! flat boundary edges too), vertex moves (boundary vertices slide in their plane or along their crease), contraction of
//! vertices that are not worth their price, inside and on flat parts of the surface. The worst angle is a floor only: no move makes a cell below the floor
//! that was not.

mod contract;
mod cost;
mod directional;
mod filling;
mod relocate;
mod weight;
mod weighted;
mod weights;

use super::edge_removal::{cells_of, may_replace, replace_ring};
use super::freedom::freedoms;
use super::is_removable;
use super::parallel::{select, sweep, vertices_of};
use crate::mesh::{MeshError, topology};
use crate::subdiv::solid::Solid;
use contract::contract;
use cost::Shape;
pub use cost::cost;
use filling::Filling;
use rayon::prelude::*;
pub use weight::Directions;
use weight::Weight;
use weighted::Fan;
pub use weights::Weights;

/// Sine of 15 degrees: cells at least this good stay so.
const FLOOR: f64 = 0.258_819_045_102_520_74;

/// Least share by which a change of topology must lower the cost.
const GAIN: f64 = 1e-3;

/// Least weight of a vertex, as a share of the mean.
const LEAST_WEIGHT: f64 = 1e-6;

/// Weight of a cell: the mean of those of its vertices.
fn mean<W: Weight>(weights: &[W], tet: [u32; 4]) -> W {
    let [a, b, c, d] = tet.map(|v| weights[v as usize]);
    (a + b + c + d) * 0.25
}

/// Weighted cost of a cell.
fn weighted_cost<W: Weight>(weights: &[W], solid: &Solid, t: u32) -> f64 {
    let mut block = W::Block::default();
    mean(weights, solid.tet(t)).put(&mut block, 0);
    W::cost(&Shape::of(solid.cell_points(t)), &block, 0)
}

/// Lowers the weighted cost of the mesh by up to `passes` passes. Vertices with numbers from `first` on may go.
///
/// # Errors
/// [`MeshError::Inconsistent`] if there is not one weight a vertex, or one is negative or not finite.
pub(crate) fn optimise_error(solid: &mut Solid, weights: &Weights, passes: usize, first: u32) -> Result<(), MeshError> {
    match weights {
        Weights::Factors(weights) => optimise(solid, &checked(weights, solid.point_count())?, passes, first),
        Weights::Directions(weights) => optimise(solid, &checked(weights, solid.point_count())?, passes, first),
    }
    Ok(())
}

/// The weights, all positive: a vertex without weight could go anywhere, a small one keeps its cells in shape.
fn checked<W: Weight>(weights: &[W], vertices: usize) -> Result<Vec<W>, MeshError> {
    if weights.len() != vertices {
        return Err(MeshError::Inconsistent(format!("{} weights for {vertices} vertices", weights.len())));
    }
    if let Some(v) = weights.iter().position(|w| !w.is_sound()) {
        return Err(MeshError::Inconsistent(format!("the weight of vertex {v} is negative or not finite")));
    }
    let least = LEAST_WEIGHT * weights.iter().map(|w| w.size()).sum::<f64>() / weights.len().max(1) as f64;
    Ok(weights.iter().map(|w| w.raised(least.max(f64::MIN_POSITIVE))).collect())
}

/// Each pass after the first looks only at what the pass before changed.
fn optimise<W: Weight>(solid: &mut Solid, weights: &[W], passes: usize, first: u32) {
    let freedoms = freedoms(solid);
    let rounding = 4.0 * f64::EPSILON * solid.largest_coordinate();
    let mut since = 0;
    for _ in 0..passes {
        let now = solid.tick();
        let removed = remove_edges(solid, weights, since, rounding);
        let gone = contract(solid, weights, &freedoms, (since, first), (price_of_a_vertex(solid, weights), FLOOR));
        let vertices = vertices_of(solid, solid.cells_since(since));
        let propose =
            |fan: &mut Fan<W>, solid: &Solid, v, freedom| relocate::better(fan, solid, weights, v, freedom, FLOOR);
        let moved = sweep(solid, &freedoms, vertices, Fan::default, propose);
        if removed + gone + moved == 0 {
            break;
        }
        since = now;
    }
}

/// What a vertex may save at least of the weighted cost W to be worth it.
///
/// With N vertices the squared error of linear elements falls as `W ~ N^(-2/3)` on meshes of one kind, so a mesh is
/// better than another if its `W N^(2/3)` is smaller: a vertex must lower W by `2/3 W / N`.
fn price_of_a_vertex<W: Weight>(solid: &Solid, weights: &[W]) -> f64 {
    let cells: Vec<u32> = solid.live_cells().collect();
    // Sums of fixed blocks: they do not depend on the threads.
    let cost = |t: &u32| weighted_cost(weights, solid, *t);
    let sums: Vec<f64> = cells.par_chunks(1024).map(|block| block.iter().map(cost).sum()).collect();
    let used = (0..solid.point_count() as u32).filter(|&v| !solid.cells_at(v).is_empty()).count();
    2.0 / 3.0 * sums.iter().sum::<f64>() / used.max(1) as f64
}

/// Removes the edges whose rings cost less without them; returns how many.
fn remove_edges<W: Weight>(solid: &mut Solid, weights: &[W], since: u32, rounding: f64) -> usize {
    let mut edges: Vec<[u32; 2]> = solid.cells_since(since).flat_map(|t| topology::tet_edges(solid.tet(t))).collect();
    edges.par_sort_unstable();
    edges.dedup();
    let cheaper = |filling: &mut Filling<W>, solid: &Solid, edge: [u32; 2]| {
        let ring = solid.ring(edge[0], edge[1]).filter(|ring| is_removable(solid, edge, ring, rounding))?;
        let found = may_replace(solid, edge, &ring) && filling.solve(solid, weights, edge, &ring, (1.0 - GAIN, FLOOR));
        found.then_some(ring)
    };
    let mut filling = Filling::default();
    let mut removed = 0;
    for edge in select(edges, |filling, &edge| cheaper(filling, solid, edge).is_some()) {
        if let Some(ring) = cheaper(&mut filling, solid, edge) {
            let cells = cells_of(solid, edge, &ring, &filling.triangles());
            replace_ring(solid, edge, &ring, &cells);
            removed += 1;
        }
    }
    removed
}
