//! The boundary: sqrt(3) subdivision of its triangles with creases, by Kobbelt's rule or by that of Labsik and Greiner, or
//! halved edges that keep it as it is.

use super::super::Stencil;
use super::super::improve::{Filling, Improver, Measure, remove_edge};
use super::super::solid::Solid;
use super::flip::VALID;
use super::{Flips, History, OldMesh, interpolate};
use crate::mesh::{Face, features, topology};
use glam::DVec3;

/// A boundary flip that is tried again may not leave a cell worse than this, unless one was before.
const RETRY_FLOOR: f64 = 0.1;

/// Floors under the worst sine, one a round, for moving boundary vertices to their smooth positions.
const MOVE_FLOORS: [f64; 5] = [0.25, 0.2, 0.15, 0.1, 0.05];

/// Boundary `fixed`: bisects every edge of the surface faces of refined cells, the longest first, with all cells around
/// it. The surface stays the same set of points.
pub(super) fn halve_edges(solid: &mut Solid, old: &OldMesh) -> Flips<2> {
    let faces = refined_faces(old).map(|f| f.vertices).chain(old.interfaces.iter().copied());
    let mut edges: Vec<[u32; 2]> = faces.flat_map(face_edges).collect();
    edges.sort_unstable();
    edges.dedup();
    let length = |e: &[u32; 2]| (old.mesh.points()[e[0] as usize] - old.mesh.points()[e[1] as usize]).length_squared();
    edges.sort_by(|e, f| length(f).total_cmp(&length(e)).then(e.cmp(f)));
    for [a, b] in edges {
        let m = solid.add_vertex(Stencil::mean(&[a, b]));
        solid.divide_edge(a, b, &[m]);
    }
    solid.note_stage("boundary bisections");
    Flips { done: 0, refused: Vec::new(), one_sided: Vec::new() }
}

/// Vertices with the positions they should have.
pub(super) type Targets = Vec<(u32, DVec3)>;

/// Boundary `approximating` and `interpolating`, topology: 1-3 splits of the boundary faces of refined cells, trisection
/// of the listed creases, flips of the old boundary edges. Gives the flips and the centres of the old faces, each with
/// the index of its face.
pub(super) fn subdivide(solid: &mut Solid, old: &OldMesh, filling: &mut Filling) -> (Flips<2>, Vec<(u32, usize)>) {
    let mut centres = Vec::new();
    for (i, face) in old.mesh.faces().iter().enumerate().filter(|(i, _)| old.refined[*i]) {
        if !face_edges(face.vertices).iter().any(|&e| old.is_listed(e)) {
            centres.extend(split_face(solid, face).map(|m| (m, i)));
        }
    }
    solid.note_stage("boundary 1-3 splits");
    for &[a, b] in &old.listed {
        let inner = [1.0 / 3.0, 2.0 / 3.0].map(|share| solid.add_vertex(Stencil::between(a, b, share)));
        solid.divide_edge(a, b, &inner);
    }
    solid.note_stage("crease trisections");
    let flips = flip_edges(solid, old, filling);
    solid.note_stage("boundary flips");
    (flips, centres)
}

/// 1-3 split of a boundary face and its cell at the barycentre of the face, the new vertex.
fn split_face(solid: &mut Solid, face: &Face) -> Option<u32> {
    let [a, b, c] = face.vertices;
    let cell = *solid.cells_at_face([a, b, c]).first()?;
    let m = solid.add_vertex(Stencil::mean(&face.vertices));
    let tet = solid.tet(cell);
    let children = [a, b, c].map(|v| tet.map(|w| if w == v { m } else { w }));
    solid.split_cell(cell, children, false);
    solid.remove_face(face.vertices);
    for v in [a, b, c] {
        solid.add_face(Face { vertices: face.vertices.map(|w| if w == v { m } else { w }), ..*face });
    }
    Some(m)
}

/// Flips the old boundary edges, creases apart, both of whose faces are refined.
fn flip_edges(solid: &mut Solid, old: &OldMesh, filling: &mut Filling) -> Flips<2> {
    let mut flips = Flips { done: 0, refused: Vec::new(), one_sided: Vec::new() };
    for (edge, refined) in old_edges(old) {
        match refined[..] {
            [true, true] if flip_edge(solid, edge, filling, |_| VALID) => flips.done += 1,
            [true, true] => flips.refused.push(edge),
            [false, false] => {}
            _ => flips.one_sided.push(edge),
        }
    }
    flips
}

/// Tries the refused boundary flips again.
pub(super) fn retry_edges(solid: &mut Solid, flips: &mut Flips<2>, filling: &mut Filling) {
    let refused = std::mem::take(&mut flips.refused);
    for edge in refused {
        if flip_edge(solid, edge, filling, |worst| worst.clamp(VALID, RETRY_FLOOR)) {
            flips.done += 1;
        } else {
            flips.refused.push(edge);
        }
    }
}

/// Flips a boundary edge by edge removal, if the quadrilateral is convex in the surface (both new triangles agree with
/// the mean old normal: else the new boundary would fold, which nothing in the interior can repair) and the worst new
/// sine exceeds `floor(worst old sine)`.
fn flip_edge(solid: &mut Solid, edge: [u32; 2], filling: &mut Filling, floor: impl Fn(f64) -> f64) -> bool {
    let Some(ring) = solid.ring(edge[0], edge[1]) else { return false };
    if ring.closed || solid.is_crease(edge) {
        return false;
    }
    let [a, b] = edge.map(|v| solid.point(v));
    let [c, d] = [ring.vertices[0], ring.vertices[ring.vertices.len() - 1]].map(|v| solid.point(v));
    let normal = (c - a).cross(b - a).normalize_or_zero() + (b - a).cross(d - a).normalize_or_zero();
    if (c - a).cross(d - a).dot(normal) <= 0.0 || (b - c).cross(d - c).dot(normal) <= 0.0 {
        return false;
    }
    let floor = floor(solid.worst_sine(&ring.cells));
    remove_edge(solid, edge, &ring, &Measure::BestWorst(floor), filling)
}

/// Moves boundary vertices to their targets, as far as the cells allow, improving the interior in between by so many
/// passes. Returns how many could not arrive.
pub(super) fn smooth(solid: &mut Solid, mut targets: Targets, improver: &mut Improver, passes: usize) -> usize {
    for floor in MOVE_FLOORS {
        if targets.is_empty() {
            break;
        }
        let now = solid.tick();
        targets.retain(|&(v, target)| !move_towards(solid, v, target, floor));
        solid.note_stage("boundary smoothing");
        improver.improve(solid, now, passes);
    }
    targets.len()
}

/// Moves vertex `v` by the largest of 1, 1/2, 1/4, 1/8 of the way under the floor; true if it arrived.
fn move_towards(solid: &mut Solid, v: u32, target: DVec3, floor: f64) -> bool {
    let start = solid.point(v);
    let worst = solid.worst_sine(solid.cells_at(v));
    let floor = floor.min(worst);
    for factor in [1.0, 0.5, 0.25, 0.125] {
        // At factor 1 the target itself, not its rounded neighbour.
        let p = if factor == 1.0 { target } else { start + factor * (target - start) };
        if solid.worst_sine_with(v, p, floor) >= floor {
            solid.move_point(v, p);
            return factor == 1.0;
        }
    }
    false
}

/// The rule of Labsik and Greiner for the centres of old faces.
pub(super) fn interpolating_targets(old: &OldMesh, centres: &[(u32, usize)]) -> Targets {
    let points = interpolate::face_points(old.mesh);
    centres.iter().map(|&(v, face)| (v, points[face])).collect()
}

/// Kobbelt's rule for the smooth boundary vertices all of whose faces are refined, on the old positions:
/// `(1 - beta_n) v + beta_n mean(neighbours)` with `beta_n = (4 - 2 cos(2 pi / n)) / 9` (Kobbelt 2000).
pub(super) fn approximating_targets(old: &OldMesh) -> Targets {
    let mesh = old.mesh;
    let mut sums = vec![(DVec3::ZERO, 0_usize); mesh.points().len()];
    let mut moves = vec![true; mesh.points().len()];
    for (face, &refined) in mesh.faces().iter().zip(&old.refined) {
        let [a, b, c] = face.vertices;
        for [v, next] in [[a, b], [b, c], [c, a]] {
            // Each neighbour follows v in exactly one face.
            let (sum, n) = &mut sums[v as usize];
            *sum += mesh.points()[next as usize];
            *n += 1;
            moves[v as usize] &= refined;
        }
    }
    for v in mesh.creases().iter().flat_map(|c| c.vertices).chain(mesh.corners().iter().copied()) {
        moves[v as usize] = false;
    }
    let target = |v: usize| {
        let (sum, n) = sums[v];
        let beta = (4.0 - 2.0 * (std::f64::consts::TAU / n as f64).cos()) / 9.0;
        (1.0 - beta) * mesh.points()[v] + beta * sum / n as f64
    };
    (0..mesh.points().len()).filter(|&v| moves[v] && sums[v].1 > 0).map(|v| (v as u32, target(v))).collect()
}

/// The creases that are odd after this step, and those with one refined face only.
///
/// A crease becomes odd when both its faces are refined in one step; an odd crease that is refined is trisected, and its
/// thirds are even.
pub(super) fn crease_parities(before: &History, old: &OldMesh) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let is_odd = |e: &[u32; 2]| before.odd_creases.binary_search(e).is_ok();
    let mut odd: Vec<[u32; 2]> = before.odd_creases.iter().filter(|e| !old.is_listed(**e)).copied().collect();
    let mut half: Vec<[u32; 2]> = Vec::new();
    for (edge, refined) in crease_faces(old).into_iter().filter(|(e, _)| !is_odd(e)) {
        let count = refined.iter().filter(|r| **r).count();
        if count == refined.len() {
            odd.push(edge);
        } else if count > 0 || before.pending_edges.binary_search(&edge).is_ok() {
            half.push(edge);
        }
    }
    odd.sort_unstable();
    (odd, half)
}

/// Boundary faces of refined cells.
fn refined_faces<'a>(old: &'a OldMesh) -> impl Iterator<Item = &'a Face> {
    old.mesh.faces().iter().zip(&old.refined).filter(|(_, refined)| **refined).map(|(f, _)| f)
}

fn face_edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(topology::sorted2)
}

/// Old boundary edges that are no creases, each with the refined flags of its faces.
fn old_edges(old: &OldMesh) -> Vec<([u32; 2], Vec<bool>)> {
    let mut edges = edge_flags(old);
    edges.retain(|(e, _)| !is_old_crease(old, *e));
    edges
}

/// Old creases on the boundary, each with the refined flags of its faces.
fn crease_faces(old: &OldMesh) -> Vec<([u32; 2], Vec<bool>)> {
    let mut edges = edge_flags(old);
    edges.retain(|(e, _)| is_old_crease(old, *e));
    edges
}

fn is_old_crease(old: &OldMesh, edge: [u32; 2]) -> bool {
    old.mesh.creases().binary_search_by_key(&edge, |c| c.vertices).is_ok()
}

/// Old boundary edges, each with the refined flags of its faces.
fn edge_flags(old: &OldMesh) -> Vec<([u32; 2], Vec<bool>)> {
    features::boundary_edges(old.mesh.faces())
        .into_iter()
        .map(|(edge, faces)| (edge, faces.into_iter().map(|i| old.refined[i]).collect()))
        .collect()
}
