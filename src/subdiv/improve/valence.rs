//! The valence pass: fewer cells at over-full vertices, which refinement in one place again and again would otherwise
//! make ever fuller and flatter.

use super::super::solid::Solid;
use super::quality::Quality;

/// Sine of 15 degrees: cells this good may be made on the way, smoothing improves them.
const FLOOR: f64 = 0.258_819_045_102_520_74;

impl Quality {
    /// Removes edges of the vertices with more cells than the limit, the longest edges first, unless that makes a cell
    /// worse than both the ring's worst one and 15 degrees.
    pub(super) fn relieve(&mut self, solid: &mut Solid) {
        for v in 0..solid.point_count() as u32 {
            if solid.cells_at(v).len() > self.limit {
                self.relieve_vertex(solid, v);
            }
        }
    }

    fn relieve_vertex(&mut self, solid: &mut Solid, v: u32) {
        let mut ends: Vec<u32> =
            solid.cells_at(v).iter().flat_map(|&t| solid.tet(t)).filter(|&w| w != v).collect();
        ends.sort_unstable();
        ends.dedup();
        let length = |w: &u32| (solid.point(*w) - solid.point(v)).length_squared();
        ends.sort_by(|a, b| length(b).total_cmp(&length(a)).then(a.cmp(b)));
        for w in ends {
            if solid.cells_at(v).len() <= self.limit {
                break;
            }
            // Just below the floor, so that equally good cells will do.
            self.improve_edge(solid, [v, w], |worst| worst.min(FLOOR) - 1e-12);
        }
    }
}
