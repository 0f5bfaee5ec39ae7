//! 2-3 flips of old interior faces.

use super::super::solid::Solid;
use super::{Flips, OldMesh};
use crate::mesh::quality;

/// A flip is valid if its cells have sines above this: positive, and not by rounding alone.
pub(super) const VALID: f64 = 1e-3;

/// Flips each old interior face between two refined cells where the result is valid.
pub(super) fn flip_faces(solid: &mut Solid, old: &OldMesh) -> Flips<3> {
    let mut flips = Flips { done: 0, refused: Vec::new(), one_sided: old.border_faces.clone() };
    for &face in &old.inner_faces {
        if flip_face(solid, face, |_| VALID) {
            flips.done += 1;
        } else {
            flips.refused.push(face);
        }
    }
    flips
}

/// Tries the refused flips again, now only where they improve the worst of the cells.
pub(super) fn retry_faces(solid: &mut Solid, flips: &mut Flips<3>) {
    let refused = std::mem::take(&mut flips.refused);
    for face in refused {
        if flip_face(solid, face, |worst| worst.max(VALID)) {
            flips.done += 1;
        } else {
            flips.refused.push(face);
        }
    }
}

/// Replaces the two cells at a face by three around the line between their far vertices, if the worst new sine exceeds
/// `floor(worst old sine)`.
fn flip_face(solid: &mut Solid, face: [u32; 3], floor: impl Fn(f64) -> f64) -> bool {
    let cells = solid.cells_at_face(face);
    let [t, u] = cells[..] else { return false };
    let far = |cell: u32| solid.tet(cell).into_iter().find(|v| !face.contains(v));
    let (Some(d), Some(e)) = (far(t), far(u)) else { return false };
    let floor = floor(solid.sine(t).min(solid.sine(u)));
    // The face as cell t sees it from inside: (a, b, c, d) is positive.
    let [a, b, c] = face;
    let positive = quality::volume([a, b, c, d].map(|v| solid.point(v))) > 0.0;
    let [a, b, c] = if positive { [a, b, c] } else { [b, a, c] };
    let children = [[a, b, e, d], [b, c, e, d], [c, a, e, d]];
    if children.iter().any(|child| quality::min_sine(child.map(|v| solid.point(v))) <= floor) {
        return false;
    }
    let mut tag = solid.tag(t);
    tag.level = tag.level.max(solid.tag(u).level);
    solid.remove_cell(t);
    solid.remove_cell(u);
    for child in children {
        solid.add_cell(child, tag);
    }
    true
}
