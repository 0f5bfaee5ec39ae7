//! 2-3 flips of old interior faces.

use super::super::improve::FaceFlip;
use super::super::solid::Solid;
use super::{Flips, OldMesh};
use rayon::prelude::*;

/// A flip is valid if its cells have sines above this: positive, and not by rounding alone.
pub(super) const VALID: f64 = 1e-3;

/// Flips each old interior face between two refined cells where the result is valid.
pub(super) fn flip_faces(solid: &mut Solid, old: &OldMesh) -> Flips<3> {
    let mut flips = Flips { done: 0, refused: Vec::new(), one_sided: old.border_faces.clone() };
    // No two of these faces share a cell (a child of a split cell has one of its faces), so that no flip touches another.
    let valid = |face: &[u32; 3]| FaceFlip::of(solid, *face).filter(|flip| flip.worst_sine(solid) > VALID);
    let found: Vec<Option<FaceFlip>> = old.inner_faces.par_iter().with_min_len(64).map(valid).collect();
    for (&face, flip) in old.inner_faces.iter().zip(found) {
        match flip {
            Some(flip) => {
                flip.perform(solid);
                flips.done += 1;
            }
            None => flips.refused.push(face),
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
    let Some(flip) = FaceFlip::of(solid, face) else { return false };
    if flip.worst_sine(solid) <= floor(solid.worst_sine(&flip.cells)) {
        return false;
    }
    flip.perform(solid);
    true
}
