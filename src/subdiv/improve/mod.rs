//! Mesh improvement in passes over what changed: by the paper's operations (here), for the angles ([`quality`]), for the
//! interpolation error ([`error`]).

mod edge_removal;
pub(super) mod error;
mod face_flip;
mod freedom;
mod mean;
mod measured;
mod multi_face;
mod parallel;
mod quality;
mod repair;
mod smooth;
mod valence;

pub(super) use edge_removal::{Filling, Measure, flip_interface, remove_edge};
pub(super) use face_flip::FaceFlip;
pub(super) use quality::optimise_quality;

use super::options::{Mode, Optimise, QualityMeasure};
use super::solid::{Ring, Solid};
use crate::mesh::{quality::volume, topology};
use freedom::Freedom;
use smooth::{GOOD, Smoother};

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

    /// Removes each edge whose removal improves the worst cell of its ring; returns how many.
    fn remove_edges(&mut self, solid: &mut Solid, since: u32) -> usize {
        let mut edges: Vec<[u32; 2]> =
            solid.cells_since(since).flat_map(|t| topology::tet_edges(solid.tet(t))).collect();
        edges.sort_unstable();
        edges.dedup();
        edges.into_iter().filter(|&e| self.improve_edge(solid, e)).count()
    }

    fn improve_edge(&mut self, solid: &mut Solid, edge: [u32; 2]) -> bool {
        let Some(ring) = solid.ring(edge[0], edge[1]) else { return false };
        if !is_removable(solid, edge, &ring, 0.0) {
            return false;
        }
        // An improvement too small to matter would only keep the later passes busy.
        let above = |worst: f64| worst.max(0.0) + 1e-3;
        let measure = match self.measure {
            QualityMeasure::MinSine => Measure::BestWorst(above(solid.worst_sine(&ring.cells))),
            other => Measure::BestWorstBy(other, above(measured::worst(solid, &ring.cells, other))),
        };
        remove_edge(solid, edge, &ring, &measure, &mut self.filling)
    }

    /// Smooths the interior vertices of changed cells; returns how many moved.
    fn smooth(&mut self, solid: &mut Solid, since: u32) -> usize {
        let mut vertices: Vec<u32> = solid.cells_since(since).flat_map(|t| solid.tet(t)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.into_iter().filter(|&v| solid.is_interior(v) && self.smooth_vertex(solid, v)).count()
    }

    fn smooth_vertex(&mut self, solid: &mut Solid, v: u32) -> bool {
        match self.measure {
            QualityMeasure::MinSine => self.smoother.smooth(solid, v, Freedom::Space, GOOD),
            other => measured::smooth(solid, v, other),
        }
    }
}

/// The other corners of a cell in an order that makes (v, rest) an even reordering.
fn rest_of(tet: [u32; 4], v: u32) -> [u32; 3] {
    match tet.iter().position(|&w| w == v) {
        Some(0) => [tet[1], tet[2], tet[3]],
        Some(1) => [tet[0], tet[3], tet[2]],
        Some(2) => [tet[0], tet[1], tet[3]],
        _ => [tet[0], tet[2], tet[1]],
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
