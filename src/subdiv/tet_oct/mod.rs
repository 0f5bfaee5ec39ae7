//! Smooth subdivision of meshes of tetrahedra and octahedra (Schaefer, Hakenberg and Warren 2004).
//!
//! A step splits each cell linearly, then moves each vertex to the mean of weighted centroids of the cells at it. The limit is
//! twice continuously differentiable but along the edges of the control mesh; boundary, interfaces between regions, creases
//! and corners follow the rules of Hoppe et al. (1994), so that no region depends on vertices inside another. New points are
//! convex combinations of old ones.

mod embed;
mod masks;
pub mod smoothness;
mod split;
mod surface;

pub use crate::mesh::weights::WeightRows;
pub use embed::{EmbedError, Embedding};

use crate::mesh::tet_oct::{CellEdges, TetOctMesh};
use glam::DVec3;
use masks::Masks;
use rayon::prelude::*;

/// How many points a thread makes at a time.
const PIECE: usize = 1 << 11;

/// One step. Regions, groups, crease surfaces, creases and corners follow.
#[must_use]
pub fn refine(mesh: &TetOctMesh) -> TetOctMesh {
    let edges = CellEdges::new(mesh);
    let points = smoothed(&Masks::new(mesh, &edges), mesh.points());
    split::split(mesh, &edges, points)
}

/// One step, with the matrix of its weights: row `i` makes the new vertex `i` of the old ones.
#[must_use]
pub fn refine_with_rows(mesh: &TetOctMesh) -> (TetOctMesh, WeightRows) {
    with_rows(mesh, |masks, new, row| masks.row(new, row))
}

/// One step without smoothing: cells are split at the middles of their edges and the centroids of octahedra.
#[must_use]
pub fn split_linearly(mesh: &TetOctMesh) -> (TetOctMesh, WeightRows) {
    with_rows(mesh, |masks, new, row| masks.linear_row(new, row))
}

/// `steps` steps, with the composite matrix S of their weights: row `i` has the values at the vertex `i` of the smooth basis
/// functions of the vertices of `mesh`.
#[must_use]
pub fn composite(mesh: &TetOctMesh, steps: usize) -> (TetOctMesh, WeightRows) {
    let first = (mesh.clone(), WeightRows::identity(mesh.points().len()));
    (0..steps).fold(first, |(mesh, rows), _| {
        let (finer, step) = refine_with_rows(&mesh);
        (finer, step.after(&rows))
    })
}

fn with_rows(mesh: &TetOctMesh, row: impl Fn(&Masks<'_>, usize, &mut masks::Row) + Sync) -> (TetOctMesh, WeightRows) {
    let edges = CellEdges::new(mesh);
    let masks = Masks::new(mesh, &edges);
    let rows = WeightRows::collect(masks.count(), mesh.points().len(), |new, entries| row(&masks, new, entries));
    let points = rows.apply(mesh.points());
    (split::split(mesh, &edges, points), rows)
}

/// The new points.
fn smoothed(masks: &Masks<'_>, old: &[DVec3]) -> Vec<DVec3> {
    let mut points = vec![DVec3::ZERO; masks.count()];
    points.par_chunks_mut(PIECE).enumerate().for_each(|(piece, points)| {
        let mut row = Vec::new();
        for (i, point) in points.iter_mut().enumerate() {
            row.clear();
            masks.row(piece * PIECE + i, &mut row);
            *point = row.iter().map(|&(v, weight)| weight * old[v as usize]).sum();
        }
    });
    points
}
