//! 2-3 flips: the two cells at a face give way to three around the line between their far vertices.

use super::super::solid::Solid;
use crate::mesh::quality;

/// A flip that is possible by topology; whether it is wanted is for the caller to say.
pub(crate) struct FaceFlip {
    /// The two cells that go.
    pub cells: [u32; 2],
    /// The three that come.
    pub children: [[u32; 4]; 3],
}

impl FaceFlip {
    /// The flip of a face; `None` at the boundary and between regions. In an embedded mesh the new edge cannot exist
    /// already where the flip is valid.
    pub(crate) fn of(solid: &Solid, face: [u32; 3]) -> Option<Self> {
        let cells = solid.cells_at_face(face);
        let [t, u] = cells[..] else { return None };
        if solid.tag(t).region != solid.tag(u).region {
            return None;
        }
        let far = |cell: u32| solid.tet(cell).into_iter().find(|v| !face.contains(v));
        let (d, e) = (far(t)?, far(u)?);
        // The face as cell t sees it from inside: (a, b, c, d) is positive.
        let [a, b, c] = super::rest_of(solid.tet(t), d);
        // (d, a, b, c) is positive, so (a, b, c, d) is negative: an odd permutation apart.
        let children = [[b, a, e, d], [c, b, e, d], [a, c, e, d]];
        Some(Self { cells: [t, u], children })
    }

    /// Smallest minimum sine of the cells that come.
    pub(crate) fn worst_sine(&self, solid: &Solid) -> f64 {
        let sine = |child: &[u32; 4]| quality::positive_min_sine(child.map(|v| solid.point(v)));
        self.children.iter().map(sine).fold(f64::INFINITY, f64::min)
    }

    /// Performs the flip.
    pub(crate) fn perform(&self, solid: &mut Solid) {
        let [t, u] = self.cells;
        let mut tag = solid.tag(t);
        tag.level = tag.level.max(solid.tag(u).level);
        for cell in self.cells {
            solid.remove_cell(cell);
        }
        for child in self.children {
            solid.add_cell(child, tag);
        }
    }
}
