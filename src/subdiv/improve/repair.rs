//! The last bad cells: a new vertex on one of their edges, kept if the neighbourhood can be made better than
//! the bad cell was.

use super::super::solid::Solid;
use super::freedom::freedom;
use super::parallel::vertices_of;
use super::quality::Quality;
use crate::mesh::topology;
use crate::subdiv::Stencil;

/// Rounds of edge removal and smoothing around a new vertex.
const ROUNDS: usize = 4;

/// Edges of a cell that are tried, the longest.
const EDGES: usize = 6;

/// A run gives up repairing after this many failures, plus a few for each success: almost all repairs succeed on sound
/// meshes, and each failure is dear where needles or flat regions leave nothing to gain.
const PATIENCE: usize = 24;
const FAILURES_A_SUCCESS: usize = 2;

/// Cells touched from which a repair spreads no further.
const WIDE: usize = 400;

/// A repair must raise the worst sine by this much.
const GAIN: f64 = 0.01;

/// Around a new vertex cells are improved until they are this much better (in the sine) than the bad cell was.
const AHEAD: f64 = 0.15;

impl Quality {
    /// Tries to repair each bad cell changed since `since`, the worst first; returns when it began.
    pub(super) fn repair_since(&mut self, solid: &mut Solid, since: u32) -> u32 {
        let now = solid.tick();
        let mut bad: Vec<(u32, f64, [u32; 4])> = solid
            .cells_since(since)
            .map(|t| (t, solid.sine(t), solid.tet(t)))
            .filter(|(_, sine, _)| *sine < self.repair)
            .collect();
        bad.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        for (t, _, tet) in bad {
            if self.failed > PATIENCE + FAILURES_A_SUCCESS * self.repaired {
                break;
            }
            // Repairs of its neighbours may have changed or removed it.
            if solid.tet(t) == tet && solid.sine(t) < self.repair {
                let repaired = self.split_edges(solid, t);
                self.repaired += usize::from(repaired);
                self.failed += usize::from(!repaired);
            }
        }
        now
    }

    /// Splits an edge of the cell, the first that helps, inner ones before those of surfaces, long before short; true if one
    /// does. Creases are left to the scheme.
    fn split_edges(&mut self, solid: &mut Solid, t: u32) -> bool {
        let mut edges = topology::tet_edges(solid.tet(t));
        let length = |[a, b]: &[u32; 2]| (solid.point(*a) - solid.point(*b)).length_squared();
        // Inner edges first: a vertex on a chord of a curved surface is a dent in it.
        let on_surface = |e: &[u32; 2]| solid.is_surface_edge(*e);
        edges.sort_by(|e, f| on_surface(e).cmp(&on_surface(f)).then(length(f).total_cmp(&length(e))).then(e.cmp(f)));
        let old = solid.sine(t);
        edges.into_iter().take(EDGES).any(|[a, b]| {
            let split = |solid: &mut Solid| {
                let m = solid.add_vertex(Stencil::mean(&[a, b]));
                solid.divide_edge(a, b, &[m]);
                m
            };
            !solid.is_crease([a, b]) && self.attempt(solid, old, split)
        })
    }

    /// Makes a vertex, improves around it, and keeps the result if every cell touched is better than `old`.
    fn attempt(&mut self, solid: &mut Solid, old: f64, make: impl FnOnce(&mut Solid) -> u32) -> bool {
        solid.begin();
        let m = make(solid);
        self.freedoms.push(freedom(solid, m, &[]));
        let good = (old + AHEAD).min(self.goal);
        for round in 0..ROUNDS {
            let mut cells = solid.cells_in_trial();
            // What the first round touched needs no more than not to stand in the way.
            let enough = if round == 0 { good } else { (old + 2.0 * GAIN).min(self.goal) };
            if round > 0 && cells.len() > WIDE {
                break;
            }
            cells.retain(|&t| solid.sine(t) < enough);
            if cells.is_empty() {
                break;
            }
            self.improve_around(solid, m, cells, good);
        }
        let better = solid.cells_in_trial().iter().all(|&t| solid.sine(t) > old + GAIN);
        if better {
            solid.keep();
        } else {
            solid.take_back();
            self.freedoms.truncate(solid.point_count());
        }
        better
    }

    /// Smoothing and edge removal for the given cells, the new vertex `m` first.
    fn improve_around(&mut self, solid: &mut Solid, m: u32, cells: Vec<u32>, good: f64) {
        let mut edges: Vec<[u32; 2]> = cells.iter().flat_map(|&t| topology::tet_edges(solid.tet(t))).collect();
        edges.sort_unstable();
        edges.dedup();
        let vertices = vertices_of(solid, cells.into_iter());
        self.smoother.smooth(solid, m, self.freedoms[m as usize], self.goal);
        for edge in edges {
            self.improve_edge(solid, edge, |worst| worst + GAIN);
        }
        for v in [m].into_iter().chain(vertices) {
            self.smoother.smooth(solid, v, self.freedoms[v as usize], good);
        }
    }
}
