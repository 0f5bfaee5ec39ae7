//! Mid-side nodes of second-order tetrahedra that do not lie in the middle of their edges.

use super::error_at;
use super::raw::Raw;
use crate::mesh::midside::{self, Midside};
use crate::mesh::quality::EDGES;
use crate::mesh::topology::sorted2;
use crate::mesh::{MeshError, TetMesh};
use std::path::Path;

/// Distance from the middle over the edge's length from which an edge counts as curved: above the rounding of files that
/// keep seven digits.
const CURVED: f64 = 1e-6;

/// The curved edges, sorted; `mids` are places in the file's list of nodes, `tets` vertices, `vertices` the place of each.
///
/// # Errors
/// [`MeshError::Syntax`] if two cells have different nodes on an edge.
pub(super) fn at_edges(
    path: &Path,
    mids: &[[u32; 6]],
    raw: &Raw,
    tets: &[[u32; 4]],
    vertices: &[u32],
) -> Result<Vec<Midside>, MeshError> {
    let at = |node: u32| raw.nodes.positions[node as usize];
    let mut curved = Vec::new();
    for (nodes, cell) in mids.iter().zip(raw.midsides.tags.iter()) {
        let tet = tets[cell as usize];
        for ([i, j], &node) in EDGES.into_iter().zip(nodes) {
            let edge = sorted2([tet[i], tet[j]]);
            let [p, q] = edge.map(|v| at(vertices[v as usize]));
            let straight = at(node).distance(p.midpoint(q)) <= CURVED * p.distance(q);
            curved.push((Midside { edge, position: at(node) }, cell, straight));
        }
    }
    curved.sort_unstable_by_key(|(m, cell, _)| (m.edge, *cell));
    for pair in curved.windows(2) {
        let [(a, ..), (b, cell, _)] = [pair[0], pair[1]];
        let [p, q] = a.edge.map(|v| at(vertices[v as usize]));
        if a.edge == b.edge && a.position.distance(b.position) > CURVED * p.distance(q) {
            let ends = a.edge.map(|v| raw.nodes.ids.get(vertices[v as usize] as usize));
            let message = format!(
                "tetrahedron {} has its mid-side node between {} and {} at {}, another cell at {}",
                raw.tets.ids.get(cell as usize),
                ends[0],
                ends[1],
                b.position,
                a.position
            );
            let place = raw.place(&raw.tets.places, cell as usize);
            return Err(error_at(path, place, message, "cells that share an edge must share its mid-side node"));
        }
    }
    let mut curved: Vec<Midside> = curved.into_iter().filter(|(.., straight)| !straight).map(|(m, ..)| m).collect();
    curved.dedup_by_key(|m| m.edge);
    Ok(curved)
}

/// Refuses curved cells whose Jacobian determinant is not positive.
///
/// # Errors
/// [`MeshError::Syntax`] names the worst by the file's ids.
pub(super) fn check(path: &Path, mesh: &TetMesh, curved: &[Midside], raw: &Raw) -> Result<(), MeshError> {
    let folded = midside::folded(mesh, curved);
    let Some((ratio, worst)) = folded.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let ids: Vec<String> = folded.iter().take(5).map(|(_, t)| raw.tets.ids.get(*t).to_string()).collect();
    let more = if folded.len() > 5 { ", ..." } else { "" };
    let message = format!(
        "{} of the curved tetrahedra are folded (ids {}{more}): their Jacobian is not positive everywhere; the worst is {}, \
         where it is {ratio:.3} of that with straight edges",
        folded.len(),
        ids.join(", "),
        raw.tets.ids.get(worst)
    );
    let at = raw.place(&raw.tets.places, worst);
    let help = "mesh finer there, let the mesher optimise its high-order nodes, or use mesh.midside = \"straight\"";
    Err(error_at(path, at, message, help))
}
