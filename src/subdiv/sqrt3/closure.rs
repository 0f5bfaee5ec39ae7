//! Cells that must be refined together with the selected ones, so that no operation waits for its other side twice.

use super::super::options::Boundary;
use super::History;
use crate::mesh::{TetMesh, topology};
use rustc_hash::FxHashSet;

/// Adds to the selection, until nothing changes: the cell across a pending face of a selected cell, the whole ring of a
/// pending surface edge or odd crease of a selected cell, and with a smooth rule the cell across an interface, which is
/// refined from both sides at once. Without it quality sinks from step to step.
pub(super) fn close(mesh: &TetMesh, history: &History, selected: &[bool], boundary: Boundary) -> Vec<bool> {
    let regions = mesh.regions();
    let interfaces = boundary != Boundary::Fixed && mesh.region_names().len() > 1;
    let mut closed = selected.to_vec();
    let faces: FxHashSet<[u32; 3]> = history.pending_faces.iter().copied().collect();
    let edges: FxHashSet<[u32; 2]> = history.pending_edges.iter().chain(&history.odd_creases).copied().collect();
    if faces.is_empty() && edges.is_empty() && !interfaces {
        return closed;
    }
    let tets = mesh.tets();
    let neighbours = topology::face_neighbours(tets);
    let cells_at = topology::VertexCells::new(mesh.points().len(), tets);
    let mut open: Vec<usize> = (0..tets.len()).filter(|&t| closed[t]).collect();
    while let Some(t) = open.pop() {
        let across = topology::tet_faces(tets[t]).into_iter().zip(neighbours[t]).filter_map(|(f, u)| Some((f, u?)));
        let joined = |(f, u): (&[u32; 3], usize)| {
            faces.contains(&topology::sorted3(*f)) || (interfaces && regions[t] != regions[u])
        };
        let across = across.filter(|(f, u)| joined((f, *u as usize))).map(|(_, u)| u);
        let pending = topology::tet_edges(tets[t]).into_iter().filter(|e| edges.contains(e));
        let rings =
            pending.flat_map(|[a, b]| cells_at.at(a).iter().copied().filter(move |&u| tets[u as usize].contains(&b)));
        for u in across.chain(rings) {
            if !closed[u as usize] {
                closed[u as usize] = true;
                open.push(u as usize);
            }
        }
    }
    closed
}
