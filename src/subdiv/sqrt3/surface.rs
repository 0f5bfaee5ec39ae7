//! The surfaces, boundary and interfaces between regions: sqrt(3) subdivision of their triangles with creases, by Kobbelt's
//! rule or by that of Labsik and Greiner, or halved edges that keep them as they are.

use super::super::Stencil;
use super::super::improve::{Filling, Improver, Measure, flip_interface, remove_edge};
use super::super::solid::{Ring, Solid};
use super::flip::VALID;
use super::{Flips, History, OldMesh, interpolate};
use crate::mesh::{Face, topology};
use glam::DVec3;

/// A surface flip that is tried again may not leave a cell worse than this, unless one was before.
const RETRY_FLOOR: f64 = 0.1;

/// Floors under the worst sine, one a round, for moving surface vertices to their smooth positions.
const MOVE_FLOORS: [f64; 5] = [0.25, 0.2, 0.15, 0.1, 0.05];

/// Boundary `fixed`: bisects every edge of the surface faces of refined cells and every inner crease of theirs, the
/// longest first, with all cells around it. The surface stays the same set of points.
pub(super) fn halve_edges(solid: &mut Solid, old: &OldMesh) -> Flips<2> {
    let faces = old.surface.iter().zip(&old.refined).filter(|(_, refined)| **refined);
    let creases = old.inner_creases.iter().filter(|(_, refined)| refined.contains(&true)).map(|(e, _)| *e);
    let mut edges: Vec<[u32; 2]> = faces.flat_map(|(f, _)| face_edges(f.vertices)).chain(creases).collect();
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

/// Boundary `approximating` and `interpolating`, topology: 1-3 splits of the surface faces of refined cells, trisection
/// of the listed creases, flips of the old surface edges. Gives the flips and the centres of the old faces, each with
/// the index of its face.
pub(super) fn subdivide(solid: &mut Solid, old: &OldMesh, filling: &mut Filling) -> (Flips<2>, Vec<(u32, usize)>) {
    let mut centres = Vec::new();
    for (i, face) in old.surface.iter().enumerate().filter(|(i, _)| old.refined[*i]) {
        if !face_edges(face.vertices).iter().any(|&e| old.is_listed(e)) {
            centres.extend(split_face(solid, face.vertices).map(|m| (m, i)));
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

/// 1-3 split of a surface face and the cells at it at the barycentre of the face, the new vertex.
fn split_face(solid: &mut Solid, corners: [u32; 3]) -> Option<u32> {
    let face = solid.remove_face(corners)?;
    let m = solid.add_vertex(Stencil::mean(&corners));
    for cell in solid.cells_at_face(corners) {
        let tet = solid.tet(cell);
        let children = corners.map(|v| tet.map(|w| if w == v { m } else { w }));
        solid.split_cell(cell, children, false);
    }
    for v in corners {
        solid.add_face(Face { vertices: face.vertices.map(|w| if w == v { m } else { w }), ..face });
    }
    Some(m)
}

/// Flips the old surface edges, creases apart, both of whose faces are refined.
fn flip_edges(solid: &mut Solid, old: &OldMesh, filling: &mut Filling) -> Flips<2> {
    let mut flips = Flips { done: 0, refused: Vec::new(), one_sided: Vec::new() };
    for (edge, refined) in edge_flags(old, false) {
        match refined[..] {
            [true, true] if flip_edge(solid, edge, filling, |_| VALID) => flips.done += 1,
            [true, true] => flips.refused.push(edge),
            [false, false] => {}
            _ => flips.one_sided.push(edge),
        }
    }
    flips
}

/// Tries the refused surface flips again.
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

/// Flips a surface edge by edge removal, at an interface on both sides, if the quadrilateral is convex in the surface
/// (both new triangles agree with the mean old normal: else the new surface would fold, which nothing in the interior
/// can repair) and the worst new sine exceeds `floor(worst old sine)`.
fn flip_edge(solid: &mut Solid, edge: [u32; 2], filling: &mut Filling, floor: impl Fn(f64) -> f64) -> bool {
    let Some(ring) = solid.ring(edge[0], edge[1]) else { return false };
    let parts = if ring.closed { interface_parts(solid, &ring) } else { None };
    if solid.is_crease(edge) || ring.closed != parts.is_some() {
        return false;
    }
    let link = parts.as_ref().map_or(&ring.vertices, |[part, _]| &part.vertices);
    let [a, b] = edge.map(|v| solid.point(v));
    let [c, d] = [link[0], link[link.len() - 1]].map(|v| solid.point(v));
    let normal = (c - a).cross(b - a).normalize_or_zero() + (b - a).cross(d - a).normalize_or_zero();
    if (c - a).cross(d - a).dot(normal) <= 0.0 || (b - c).cross(d - c).dot(normal) <= 0.0 {
        return false;
    }
    let measure = Measure::BestWorst(floor(solid.worst_sine(&ring.cells)));
    match &parts {
        Some(parts) => flip_interface(solid, edge, parts, measure, filling),
        None => remove_edge(solid, edge, &ring, measure, filling),
    }
}

/// The two parts of the closed ring of an interface edge, that of the smaller region number first; `None` unless exactly
/// two interface faces have the edge.
fn interface_parts(solid: &Solid, ring: &Ring) -> Option<[Ring; 2]> {
    let n = ring.cells.len();
    let region = |i: usize| solid.tag(ring.cells[i % n]).region;
    let starts: Vec<usize> = (0..n).filter(|&i| region(i) != region(i + n - 1)).collect();
    let [i, j] = starts[..] else { return None };
    let part = |from: usize, to: usize| Ring {
        vertices: (from..=to).map(|k| ring.vertices[k % n]).collect(),
        cells: (from..to).map(|k| ring.cells[k % n]).collect(),
        closed: false,
    };
    Some(if region(i) < region(j) { [part(i, j), part(j, i + n)] } else { [part(j, i + n), part(i, j)] })
}

/// Moves surface vertices to their targets, as far as the cells allow, improving the interior in between by so many
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
    let points = interpolate::face_points(old);
    centres.iter().map(|&(v, face)| (v, points[face])).collect()
}

/// Kobbelt's rule for the smooth surface vertices all of whose faces are refined, on the old positions:
/// `(1 - beta_n) v + beta_n mean(neighbours)` with `beta_n = (4 - 2 cos(2 pi / n)) / 9` (Kobbelt 2000).
pub(super) fn approximating_targets(old: &OldMesh) -> Targets {
    let mesh = old.mesh;
    let mut sums = vec![(DVec3::ZERO, 0_usize); mesh.points().len()];
    let mut moves = vec![true; mesh.points().len()];
    for (face, &refined) in old.surface.iter().zip(&old.refined) {
        let [a, b, c] = face.vertices;
        for [v, next] in [[a, b], [b, c], [c, a]] {
            // Each neighbour follows v in exactly one face.
            let (sum, n) = &mut sums[v as usize];
            *sum += mesh.points()[next as usize];
            *n += 1;
            moves[v as usize] &= refined;
        }
    }
    let borders = old.surface_edges.iter().filter(|(_, at)| at.len() != 2).map(|(e, _)| *e);
    let still = mesh.creases().iter().map(|c| c.vertices).chain(borders).flatten();
    for v in still.chain(mesh.corners().iter().copied()) {
        moves[v as usize] = false;
    }
    let target = |v: usize| {
        let (sum, n) = sums[v];
        let beta = (4.0 - 2.0 * (std::f64::consts::TAU / n as f64).cos()) / 9.0;
        (1.0 - beta) * mesh.points()[v] + beta * sum / n as f64
    };
    (0..mesh.points().len()).filter(|&v| moves[v] && sums[v].1 > 0).map(|v| (v as u32, target(v))).collect()
}

/// The creases that are odd after this step, and those with some refined faces only.
///
/// A crease becomes odd when all its faces (the cells around, if it is on no surface) are refined in one step; an odd crease that is refined is trisected, and its
/// thirds are even.
pub(super) fn crease_parities(before: &History, old: &OldMesh) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let is_odd = |e: &[u32; 2]| before.odd_creases.binary_search(e).is_ok();
    let mut odd: Vec<[u32; 2]> = before.odd_creases.iter().filter(|e| !old.is_listed(**e)).copied().collect();
    let mut half: Vec<[u32; 2]> = Vec::new();
    let creases = edge_flags(old, true).chain(old.inner_creases.iter().cloned());
    for (edge, refined) in creases.filter(|(e, flags)| !is_odd(e) && !flags.is_empty()) {
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

fn face_edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(topology::sorted2)
}

/// Old surface edges that are, or are not, creases, each with the refined flags of its faces.
fn edge_flags(old: &OldMesh, creases: bool) -> impl Iterator<Item = ([u32; 2], Vec<bool>)> {
    let is_crease = |edge: &[u32; 2]| old.mesh.creases().binary_search_by_key(edge, |c| c.vertices).is_ok();
    let edges = old.surface_edges.iter().filter(move |(edge, _)| is_crease(edge) == creases);
    edges.map(|(edge, faces)| (*edge, faces.iter().map(|&i| old.refined[i]).collect()))
}
