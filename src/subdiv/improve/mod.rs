//! Mesh improvement in passes over what changed: by the paper's operations (here), for the angles ([`quality`]), for the
//! interpolation error ([`error`]).

mod edge_removal;
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
use edge_removal::{can_remove, chord_is_free};
use freedom::Freedom;
use parallel::{edges_where, in_blocks, vertices_where};
use rustc_hash::FxHashSet;
use smallvec::SmallVec;
use smooth::{GOOD, Smoother};

/// Edges and vertices of which proposals are made at a time: many for the threads' sake, few so that they stay true.
const EDGE_BLOCK: usize = 1024;
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

    /// Removes, in their order, the edges whose removal improves the worst cell of the ring; returns how many.
    fn remove_edges(&mut self, solid: &mut Solid, since: u32) -> usize {
        let edges = edges_where(solid, |t| solid.is_changed(t, since));
        let (mut removed, measure) = (0, self.measure);
        let promising = |filling: &mut Filling, solid: &Solid, edge: [u32; 2]| {
            solid.ring(edge[0], edge[1]).is_some_and(|ring| {
                // Whether a chord is free depends on more than the ring.
                is_removable(solid, edge, &ring, 0.0)
                    && (!ring.closed && !chord_is_free(solid, edge, &ring)
                        || can_remove(solid, edge, &ring, improvement(measure, solid, &ring), filling))
            })
        };
        in_blocks(solid, &edges, EDGE_BLOCK, promising, |solid, block| {
            // Edges whose rings are other than the proposals saw.
            let mut changed = FxHashSet::default();
            for (edge, promising) in block {
                if (promising || changed.contains(&edge))
                    && let Some(ring) = self.improve_edge(solid, edge)
                {
                    changed.extend(pairs(edge, &ring));
                    removed += 1;
                }
            }
        });
        removed
    }

    /// Removes the edge if that improves the worst cell of its ring, which it gives then.
    fn improve_edge(&mut self, solid: &mut Solid, edge: [u32; 2]) -> Option<Ring> {
        let ring = solid.ring(edge[0], edge[1]).filter(|ring| is_removable(solid, edge, ring, 0.0))?;
        remove_edge(solid, edge, &ring, improvement(self.measure, solid, &ring), &mut self.filling).then_some(ring)
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
            // Vertices whose cells are other than the proposals saw.
            let mut changed = FxHashSet::default();
            for (v, proposal) in block {
                let proposal = if changed.contains(&v) { better(&mut self.smoother, solid, v) } else { proposal };
                if let Some((p, sines)) = proposal {
                    solid.move_point_to(v, p, &sines);
                    changed.extend(solid.cells_at(v).iter().flat_map(|&t| solid.tet(t)));
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

/// All pairs of the vertices of an edge and its link.
fn pairs(edge: [u32; 2], ring: &Ring) -> impl Iterator<Item = [u32; 2]> {
    let vertices: SmallVec<[u32; 16]> = edge.into_iter().chain(ring.vertices.iter().copied()).collect();
    let pair = |i: usize| [vertices[i / vertices.len()], vertices[i % vertices.len()]];
    (0..vertices.len() * vertices.len()).map(pair).filter(|[v, w]| v < w).collect::<SmallVec<[_; 64]>>().into_iter()
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
