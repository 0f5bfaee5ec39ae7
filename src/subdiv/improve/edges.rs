//! Edge removal all over a mesh: fillings are found in parallel, for a block of vertices at a time, and carried out in order.

use super::super::solid::{Ring, Solid};
use super::edge_removal::{Cells, Filling, Measure, best_filling, may_replace, replace_ring};
use super::is_removable;
use super::parallel::vertices_where;
use rayon::prelude::*;

/// Vertices whose edges are looked at at a time: many for the threads' sake, few so that what is found stays true.
const BLOCK: usize = 256;

/// Which edges may go, and what for.
pub(super) struct Rule<M> {
    /// What a filling has to reach; `None` for rings that are good enough.
    pub(super) measure: M,
    /// How far rounding may have moved vertices off their planes.
    pub(super) rounding: f64,
}

/// A ring and what takes its place.
struct Found {
    edge: [u32; 2],
    ring: Ring,
    cells: Cells,
}

impl<M: Fn(&Solid, &Ring) -> Option<Measure> + Sync> Rule<M> {
    /// Removes the edges with a wanted cell that the rule finds a filling for, in the order of their vertices; returns how
    /// many. Edges that appear on the way are left for the next time.
    pub(super) fn remove_edges(&self, solid: &mut Solid, wanted: impl Fn(&Solid, u32) -> bool + Sync) -> usize {
        let vertices = vertices_where(solid, |t| wanted(solid, t));
        let (mut removed, mut filling) = (0, Filling::default());
        for block in vertices.chunks(BLOCK) {
            let now = solid.tick();
            let mesh = &*solid;
            let at = |filling: &mut Filling, &v: &u32| self.find_at(mesh, v, |t| wanted(mesh, t), filling);
            let found = block.par_iter().with_min_len(8).map_init(Filling::default, at).collect::<Vec<_>>();
            for found in found.into_iter().flatten() {
                // Where an edge removed before has changed the ring, it is looked at again.
                let is_old = found.ring.cells.iter().all(|&t| !solid.is_changed(t, now));
                if !is_old {
                    removed += usize::from(self.remove_edge(solid, found.edge, &mut filling));
                } else if found.ring.closed || may_replace(solid, found.edge, &found.ring) {
                    replace_ring(solid, found.edge, &found.ring, &found.cells);
                    removed += 1;
                }
            }
        }
        removed
    }

    /// Removes the edge if the rule finds a filling for its ring; returns whether it did.
    pub(super) fn remove_edge(&self, solid: &mut Solid, edge: [u32; 2], filling: &mut Filling) -> bool {
        let ring = solid.ring(edge[0], edge[1]);
        let found = ring.and_then(|ring| self.find(solid, edge, ring, filling));
        if let Some(Found { edge, ring, cells }) = &found {
            replace_ring(solid, *edge, ring, cells);
        }
        found.is_some()
    }

    /// What is found at the edges from `v` to vertices with larger numbers.
    fn find_at(&self, solid: &Solid, v: u32, wanted: impl Fn(u32) -> bool, filling: &mut Filling) -> Vec<Found> {
        let mut found = Vec::new();
        solid.rings_above(v, wanted, |w, ring| found.extend(self.find(solid, [v, w], ring, filling)));
        found
    }

    fn find(&self, solid: &Solid, edge: [u32; 2], ring: Ring, filling: &mut Filling) -> Option<Found> {
        let measure = (self.measure)(solid, &ring).filter(|_| is_removable(solid, edge, &ring, self.rounding))?;
        let cells = best_filling(solid, edge, &ring, measure, filling)?;
        Some(Found { edge, ring, cells })
    }
}
