//! The valence pass: fewer cells at over-full vertices, which refinement in one place again and again would otherwise
//! make ever fuller and flatter.

use super::super::solid::Solid;
use super::freedom::{Freedom, freedom};
use super::quality::Quality;
use crate::subdiv::Stencil;

/// Sine of 15 degrees: cells this good may be made on the way, smoothing improves them.
const FLOOR: f64 = 0.258_819_045_102_520_74;

impl Quality {
    /// Removes edges of the vertices with more cells than the limit, the longest edges first, unless that makes a cell
    /// worse than both the ring's worst one and 15 degrees. Where a fifth more than the limit remain and `shells` are
    /// allowed, the vertex is given a shell of nearer neighbours first.
    pub(super) fn relieve(&mut self, solid: &mut Solid, shells: bool) {
        for v in 0..solid.point_count() as u32 {
            self.relieve_vertex(solid, v);
            if shells && solid.cells_at(v).len() > self.limit + self.limit / 5 {
                self.add_shell(solid, v);
                self.relieve_vertex(solid, v);
            }
        }
    }

    fn relieve_vertex(&mut self, solid: &mut Solid, v: u32) {
        if solid.cells_at(v).len() <= self.limit {
            return;
        }
        for w in ends_by_length(solid, v) {
            if solid.cells_at(v).len() <= self.limit {
                break;
            }
            // Just below the floor, so that equally good cells will do.
            self.improve_edge(solid, [v, w], |worst| worst.min(FLOOR) - 1e-12);
        }
    }

    /// Halves edges of `v`, the longest first, no two of them in one cell: a vertex whose neighbours crowd at one
    /// distance cannot lose edges, but nearer neighbours take the place of several.
    fn add_shell(&mut self, solid: &mut Solid, v: u32) {
        let mut crowded = Vec::new();
        for w in ends_by_length(solid, v) {
            let surface = solid.is_surface_edge([v, w]);
            let flat = self.freedoms[v as usize] != Freedom::Fixed || self.freedoms[w as usize] != Freedom::Fixed;
            if crowded.contains(&w) || solid.is_crease([v, w]) || (surface && !flat) {
                continue;
            }
            let ring = solid.cells_at(v).iter().map(|&t| solid.tet(t)).filter(|tet| tet.contains(&w));
            crowded.extend(ring.flatten());
            let m = solid.add_vertex(Stencil::mean(&[v, w]));
            solid.divide_edge(v, w, &[m]);
            self.freedoms.push(freedom(solid, m, &[]));
        }
    }
}

/// The vertices joined to `v`, the farthest first.
fn ends_by_length(solid: &Solid, v: u32) -> Vec<u32> {
    let mut ends: Vec<u32> = solid.cells_at(v).iter().flat_map(|&t| solid.tet(t)).filter(|&w| w != v).collect();
    ends.sort_unstable();
    ends.dedup();
    let length = |w: &u32| (solid.point(*w) - solid.point(v)).length_squared();
    ends.sort_by(|a, b| length(b).total_cmp(&length(a)).then(a.cmp(b)));
    ends
}
