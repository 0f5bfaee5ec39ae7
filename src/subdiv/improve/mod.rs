//! Mesh improvement in passes over what changed: by the paper's operations (here), for the angles ([`quality`]), for the
//! interpolation error ([`error`]).

mod edge_removal;
mod edges;
pub(super) mod error;
mod face_flip;
mod fan;
mod freedom;
mod lanes;
mod mean;
mod measured;
mod multi_face;
mod parallel;
mod quality;
mod repair;
mod smooth;
mod star;
mod valence;

pub(super) use edge_removal::{Filling, Measure, flip_interface, remove_edge};
pub(super) use face_flip::FaceFlip;
pub(super) use quality::optimise_quality;

use super::options::{Mode, Optimise, QualityMeasure};
use super::solid::{Ring, Solid, rest_of};
use crate::mesh::quality::volume;
use edges::Rule;
use freedom::Freedom;
use parallel::{in_blocks, vertices_where};
use smooth::{GOOD, Smoother};

/// Vertices of which proposals are made at a time: many for the threads' sake, few so that they stay true.
const VERTEX_BLOCK: usize = 512;

/// Tools with their work space.
pub(super) struct Improver {
    pub(super) filling: Filling,
    smoother: Smoother,
    /// What a good cell is, for the paper's operations.
    measure: QualityMeasure,
    /// Whether to work in parallel ([`quality::improve_interior`]), which gives other results.
    parallel: bool,
}

impl Improver {
    /// Tools for a scheme's own stages; parallel ones where the quality optimiser comes after them anyway.
    pub(super) fn new(options: &Optimise) -> Self {
        let parallel = options.mode == Mode::Best;
        let measure = if parallel { QualityMeasure::MinSine } else { options.measure };
        Self { filling: Filling::default(), smoother: Smoother::default(), measure, parallel }
    }

    /// Passes of edge removal and smoothing over the cells changed since `since` (and, in later passes, since the pass
    /// before), until nothing improves or `passes` are done.
    pub(super) fn improve(&mut self, solid: &mut Solid, since: u32, passes: usize) {
        if self.parallel {
            quality::improve_interior(solid, since, passes, GOOD);
            return solid.note_stage("interior optimisation");
        }
        let mut since = since;
        for _ in 0..passes {
            let now = solid.tick();
            let removed = self.remove_edges(solid, since);
            solid.note_stage("edge removals");
            let moved = self.smooth(solid, since);
            solid.note_stage("smoothing");
            if removed + moved == 0 {
                break;
            }
            since = now;
        }
    }

    /// Removes the edges whose removal improves the worst cell of the ring; returns how many.
    fn remove_edges(&self, solid: &mut Solid, since: u32) -> usize {
        let measure = |solid: &Solid, ring: &Ring| Some(improvement(self.measure, solid, ring));
        Rule { measure, rounding: 0.0 }.remove_edges(solid, |solid, t| solid.is_changed(t, since))
    }

    /// Smooths, in their order, the interior vertices of changed cells; returns how many moved.
    fn smooth(&mut self, solid: &mut Solid, since: u32) -> usize {
        let mut vertices = vertices_where(solid, |t| solid.is_changed(t, since));
        vertices.retain(|&v| solid.is_interior(v));
        let measure = self.measure;
        let better = |smoother: &mut Smoother, solid: &Solid, v| {
            let place = match measure {
                QualityMeasure::MinSine => smoother.better(solid, v, Freedom::Space, GOOD),
                other => measured::better(solid, v, other),
            };
            place.map(|p| (p, solid.sines_with(v, p)))
        };
        let mut moved = 0;
        in_blocks(solid, &vertices, VERTEX_BLOCK, better, |solid, block| {
            let now = solid.tick();
            for (v, proposal) in block {
                // Where another vertex has moved since, it is made again.
                let is_old = solid.cells_at(v).iter().all(|&t| !solid.is_changed(t, now));
                let proposal = if is_old { proposal } else { better(&mut self.smoother, solid, v) };
                if let Some((p, sines)) = proposal {
                    solid.move_point_to(v, p, &sines);
                    moved += 1;
                }
            }
        });
        moved
    }
}

/// What the paper's edge removal has to reach: an improvement too small to matter would only keep the later passes busy.
fn improvement(measure: QualityMeasure, solid: &Solid, ring: &Ring) -> Measure {
    let above = |worst: f64| worst.max(0.0) + 1e-3;
    match measure {
        QualityMeasure::MinSine => Measure::BestWorst(above(solid.worst_sine(&ring.cells))),
        other => Measure::BestWorstBy(other, above(measured::worst(solid, &ring.cells, other))),
    }
}

/// True if the edge may go without changing the solid. `rounding` is the distance by which rounding may have moved
/// vertices off their plane.
fn is_removable(solid: &Solid, edge: [u32; 2], ring: &Ring, rounding: f64) -> bool {
    if ring.closed {
        !solid.is_crease(edge) && !solid.is_surface_edge(edge)
    } else {
        is_flat(solid, edge, ring, rounding)
    }
}

/// True if the boundary edge may be flipped without changing the solid: its faces lie in one plane and one patch, and
/// their quadrilateral is convex.
fn is_flat(solid: &Solid, edge: [u32; 2], ring: &Ring, rounding: f64) -> bool {
    if solid.is_crease(edge) {
        return false;
    }
    let faces = solid.faces_at_edge(edge);
    if faces.len() != 2 || faces[0].patch != faces[1].patch {
        return false;
    }
    let [a, b] = edge.map(|v| solid.point(v));
    let [c, d] = [ring.vertices[0], ring.vertices[ring.vertices.len() - 1]].map(|v| solid.point(v));
    let longest = [b - a, c - a, d - a, c - b, d - b, d - c].iter().map(|e| e.length_squared()).fold(0.0, f64::max);
    if volume([a, b, c, d]).abs() > (1e-14 * longest.sqrt() + rounding) * longest {
        return false;
    }
    let normal = (c - a).cross(b - a);
    let least = 1e-6 * longest * normal.length();
    (c - a).cross(d - a).dot(normal) > least && (b - c).cross(d - c).dot(normal) > least
}
