//! Multi-face removal: the inverse of edge removal. Faces between the same two vertices a and b give way to the edge ab.
//!
//! From a first face the set grows over its edges while the cells behind are those of a and b and that is better than
//! to stop there (Shewchuk 2002, Two discrete optimization algorithms for the topological improvement of tetrahedral
//! meshes).

use super::super::solid::Solid;
use crate::mesh::quality;

/// Faces removed at once, at most.
const MOST_FACES: usize = 10;

/// The faces chosen, and the edges around them.
#[derive(Default)]
pub(super) struct Sandwich {
    cells: smallvec::SmallVec<[u32; 20]>,
    rim: smallvec::SmallVec<[[u32; 2]; 12]>,
    faces: usize,
}

/// Removes `face`, and with it neighbouring faces between the same two vertices, if that raises the worst sine by more
/// than `gain`; only if it is then still below `goal`. Returns whether it was done.
pub(crate) fn remove_faces(solid: &mut Solid, face: [u32; 3], goal: f64, gain: f64) -> bool {
    let [t, u] = solid.cells_at_face(face)[..] else { return false };
    let Some(([a, b], found)) = find_faces(solid, face, [t, u], goal, gain) else { return false };
    let mut tag = solid.tag(found.cells[0]);
    for &t in &found.cells {
        tag.level = tag.level.max(solid.tag(t).level);
        solid.remove_cell(t);
    }
    for [p, q] in found.rim {
        solid.add_cell([p, q, b, a], tag);
    }
    true
}

/// The two vertices and the set of faces that [`remove_faces`] would work with, from the face between two cells.
pub(super) fn find_faces(
    solid: &Solid,
    face: [u32; 3],
    [t, u]: [u32; 2],
    goal: f64,
    gain: f64,
) -> Option<([u32; 2], Sandwich)> {
    let floor = (solid.sine(t).min(solid.sine(u)) + gain).max(0.0);
    if floor >= goal {
        return None;
    }
    let far = |cell: u32| solid.tet(cell).into_iter().find(|v| !face.contains(v));
    let (a, b) = (far(t)?, far(u)?);
    let [p, q, r] = oriented(solid, face, a);
    let edges = [[p, q], [q, r], [r, p]];
    // Where the line ab passes two of the edges on their far sides no set that holds this face can do.
    let passes = |[p, q]: [u32; 2]| quality::volume([p, q, b, a].map(|v| solid.point(v))) <= 0.0;
    if edges.into_iter().filter(|&e| passes(e)).count() > 1 {
        return None;
    }
    let mut found = Sandwich { faces: 1, ..Sandwich::default() };
    found.cells.extend([t, u]);
    for edge in edges {
        if grow(solid, [a, b], edge, &mut found, floor) <= floor {
            return None;
        }
    }
    let region = solid.tag(t).region;
    let one_region = found.cells.iter().all(|&c| solid.tag(c).region == region);
    (one_region && !solid.has_edge(a, b)).then_some(([a, b], found))
}

/// Ends the set at an edge, or goes on beyond it, whichever is better; returns the worst new sine on that side.
fn grow(solid: &Solid, ends: [u32; 2], [p, q]: [u32; 2], found: &mut Sandwich, floor: f64) -> f64 {
    let [a, b] = ends;
    let here = quality::positive_min_sine([p, q, b, a].map(|v| solid.point(v)));
    if found.faces < MOST_FACES && here <= floor {
        let (cells, rim, faces) = (found.cells.len(), found.rim.len(), found.faces);
        if let Some((w, t, u)) = beyond(solid, ends, [p, q], found) {
            found.cells.extend([t, u]);
            found.faces += 1;
            let left = grow(solid, ends, [p, w], found, floor);
            let worst = if left > floor { left.min(grow(solid, ends, [w, q], found, floor)) } else { left };
            if worst > here {
                return worst;
            }
            found.cells.truncate(cells);
            found.rim.truncate(rim);
            found.faces = faces;
        }
    }
    found.rim.push([p, q]);
    here
}

/// The vertex w such that (p, q, w) is a face between a and b not yet in the set, with its cells.
fn beyond(solid: &Solid, [a, b]: [u32; 2], [p, q]: [u32; 2], found: &Sandwich) -> Option<(u32, u32, u32)> {
    // With the faces at both sides of it the edge itself would go.
    if solid.is_crease([p, q]) {
        return None;
    }
    // The lists of p and q are nearer at hand than those of a and b.
    let (first, second) = if p < q { (p, q) } else { (q, p) };
    let t = *solid.cells_at_face([first, second, a]).iter().find(|t| !found.cells.contains(t))?;
    let w = solid.tet(t).into_iter().find(|v| ![a, p, q].contains(v))?;
    let u = *solid.cells_at_face([first, second, b]).iter().find(|u| !found.cells.contains(u))?;
    (w != b && solid.tet(u).contains(&w)).then_some((w, t, u))
}

/// The face ordered so that (p, q, r, a) is positive.
fn oriented(solid: &Solid, [p, q, r]: [u32; 3], a: u32) -> [u32; 3] {
    if quality::volume([p, q, r, a].map(|v| solid.point(v))) > 0.0 { [p, q, r] } else { [q, p, r] }
}
