//! What looks odd about a mesh that is sound, and nodes that hang.

use super::error_at;
use super::raw::Raw;
use crate::mesh::contact::{self, Hanging};
use crate::mesh::{MeshError, TetMesh, features};
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

/// Distance from the origin over the size of a mesh from which its coordinates lose digits that its shape needs.
const FAR: f64 = 1e5;

/// Sizes beyond which volumes, and stiffnesses in them, come near the ends of the range of numbers.
const SIZES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Digits of a number.
const DIGITS: f64 = 15.95;

/// Edges of the boundary, with the faces at each.
pub(super) type Edges = [([u32; 2], Vec<usize>)];

/// Whole sentences about a mesh; `node` and `element` give the ids of the file.
pub(super) fn about(
    mesh: &TetMesh,
    edges: &Edges,
    node: &dyn Fn(u32) -> i64,
    element: &dyn Fn(u32) -> i64,
) -> Vec<String> {
    let (lo, hi) = mesh.bounding_box();
    let notes = [coincident(mesh), loose_parts(mesh), extent(lo, hi), overlaps(mesh, node, element)];
    notes.into_iter().flatten().chain(pinched(mesh, edges, node)).collect()
}

/// Refuses a node that lies on an edge or face of a cell without being its corner.
pub(super) fn refuse_hanging(
    path: &Path,
    mesh: &TetMesh,
    edges: &Edges,
    raw: &Raw,
    node: &dyn Fn(u32) -> i64,
) -> Result<(), MeshError> {
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| f.vertices).collect();
    let edges: Vec<[u32; 2]> = edges.iter().map(|e| e.0).collect();
    let found = contact::hanging(mesh.points(), &edges, &faces, mesh.tets().iter().map(|t| &t[..]));
    let Some(first) = found.first() else { return Ok(()) };
    let cell = mesh.tets().iter().position(|t| first.on.iter().all(|v| t.contains(v))).unwrap_or_default();
    let message = hanging(first, found.len(), &format!("tetrahedron {}", raw.tets.ids.get(cell)), node);
    Err(error_at(path, raw.place(&raw.tets.places, cell), message, HANGING))
}

/// What to do about hanging nodes.
pub(super) const HANGING: &str =
    "cells must share whole faces: split the larger cell there too, or remesh without hanging nodes";

/// What is wrong with the first of several hanging nodes, beside a cell that has its edge or face.
pub(super) fn hanging(first: &Hanging, count: usize, cell: &str, node: &dyn Fn(u32) -> i64) -> String {
    let [a, b, c] = first.on.map(node);
    let on = if b == c { format!("edge {a} {b}") } else { format!("face {a} {b} {c}") };
    let vertex = node(first.vertex);
    let of = if count == 1 { String::new() } else { format!(" (the first of {count} hanging nodes)") };
    format!("node {vertex} lies on the {on} of {cell}, but is no corner of it{of}")
}

/// Says that parts of the mesh lie within each other.
fn overlaps(mesh: &TetMesh, node: &dyn Fn(u32) -> i64, element: &dyn Fn(u32) -> i64) -> Option<String> {
    let found = contact::overlaps(mesh.points(), mesh.tets(), mesh.faces().iter().map(|f| f.vertices));
    let first = found.first()?;
    let what = match first.other {
        Some(other) => format!("the centre of tetrahedron {}", element(other)),
        None => format!("node {}", node(first.vertex)),
    };
    let and = if found.len() == 1 { String::new() } else { format!(", and {} more such", found.len() - 1) };
    Some(format!(
        "cells overlap: tetrahedron {} holds {what} of the boundary{and}. What lies twice in one place is computed twice: join the \
         parts before meshing, or move them apart.",
        element(first.cell)
    ))
}

/// Says where the solid touches itself in an edge or a vertex only.
fn pinched(mesh: &TetMesh, edges: &Edges, node: &dyn Fn(u32) -> i64) -> Vec<String> {
    let (edges, vertices) = features::pinches(mesh.faces(), edges);
    let count = |n: usize, one: &str, many: &str| if n == 1 { one.to_owned() } else { format!("{n} {many}") };
    let edge = edges.first().map(|&[a, b]| {
        let (edges, a, b) = (count(edges.len(), "an edge", "edges"), node(a), node(b));
        format!(
            "the solid touches itself in {edges} only, at nodes {a} and {b}: kept as features, and a hinge in bending."
        )
    });
    let vertex = vertices.first().map(|&v| {
        let (vertices, v) = (count(vertices.len(), "a node", "nodes"), node(v));
        format!(
            "the solid touches itself in {vertices} only, at node {v}: kept as corners; such joints transmit no moment."
        )
    });
    edge.into_iter().chain(vertex).collect()
}

/// Says that numbers lose digits, as where a part lies far from the origin.
pub(super) fn extent(lo: DVec3, hi: DVec3) -> Option<String> {
    let (size, reach) = (lo.distance(hi), lo.abs().max(hi.abs()).max_element());
    if reach > FAR * size {
        let left = (DIGITS - (reach / size).log10()).floor().max(0.0);
        return Some(format!(
            "the mesh lies {:.0e} times its size away from the origin: of the 16 digits of a coordinate {left} are left for its \
             shape. Move it to the origin.",
            reach / size
        ));
    }
    (!SIZES.contains(&size)).then(|| {
        format!("the mesh is {size:.1e} across: volumes and stiffnesses come near the ends of the range of numbers. Check its units.")
    })
}

/// Says how many vertices lie where another lies, within 1e-9 of the mesh's size.
fn coincident(mesh: &TetMesh) -> Option<String> {
    let (corner, _) = mesh.bounding_box();
    let cell = 1e-9 * mesh.diagonal();
    let mut places: Vec<[i64; 3]> =
        mesh.points().iter().map(|&p| ((p - corner) / cell).to_array().map(|x| x.round() as i64)).collect();
    places.par_sort_unstable();
    let count = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
    (count > 0).then(|| {
        format!(
            "{count} nodes lie where another node lies: the cells around them are not connected (mesh.merge = true \
                                makes them one)."
        )
    })
}

/// Says how many parts do not hang together, and where the first five are.
fn loose_parts(mesh: &TetMesh) -> Option<String> {
    let (part, count) = mesh.connected_parts();
    if count < 2 {
        return None;
    }
    let shown = count.min(5);
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY, 0_usize); shown];
    for (t, &p) in part.iter().enumerate() {
        if let Some((lo, hi, cells)) = boxes.get_mut(p as usize) {
            for q in mesh.cell_points(t) {
                (*lo, *hi) = (lo.min(q), hi.max(q));
            }
            *cells += 1;
        }
    }
    let list: Vec<String> = boxes.iter().map(|(lo, hi, cells)| format!("{cells} cells in {lo} to {hi}")).collect();
    let more = if count > shown { ", ..." } else { "" };
    Some(format!("the mesh has {count} parts that share no face: {}{more}.", list.join("; ")))
}
