//! Tetrahedral sqrt(3) subdivision, uniform and adaptive (Burkhart, Hamann and Umlauf 2010).
//!
//! One step: close the selection, split cells at their barycentres, flip the old interior faces, refine the surface,
//! optimise, smooth the surface, flip what had to wait, optimise again. Every operation is local and conforming, and
//! none leaves a cell without positive volume.

mod closure;
mod flip;
mod interpolate;
mod surface;

use super::improve::{Improver, optimise_quality};
use super::options::{Boundary, Optimise, Options};
use super::solid::Solid;
use super::{Info, Refined, Stencil};
use crate::mesh::{MeshError, TetMesh, topology};

/// Target angle in degrees of the repair before an error-driven stage: just enough that its floor of 15 degrees holds.
const REPAIR_ANGLE: f64 = 22.0;

/// What one step leaves for the next: operations that wait for their other side, and the parity of creases. All lists
/// are sorted; vertices are sorted within each entry.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct History {
    /// Old interior faces that could not be flipped yet.
    pending_faces: Vec<[u32; 3]>,
    /// Old boundary edges, and creases with one refined face, that wait for their other side.
    pending_edges: Vec<[u32; 2]>,
    /// Creases both of whose faces were split once: the next step trisects them.
    odd_creases: Vec<[u32; 2]>,
}

/// Refines the selected cells.
///
/// # Errors
/// [`MeshError::Generator`] for a smooth boundary (approximating or interpolating) on a mesh of several regions: the
/// surfaces between them have no smooth rule yet.
pub(super) fn refine(
    mesh: &TetMesh,
    history: &History,
    selected: &[bool],
    options: &Options,
) -> Result<Refined, MeshError> {
    if options.boundary != Boundary::Fixed && mesh.region_names().len() > 1 {
        let message = "smooth boundaries have no rule for the surfaces between regions: use boundary \"fixed\"";
        return Err(MeshError::Generator(message.to_owned()));
    }
    let asked = selected.iter().filter(|s| **s).count();
    let selected = closure::close(mesh, history, selected);
    let old = OldMesh::new(mesh, history, &selected);
    let mut solid = Solid::new(mesh);
    solid.watch(options.frames);
    let start = solid.tick();
    let mut improver = Improver::new(&options.optimise);

    split_cells(&mut solid, &selected);
    solid.note_stage("1-4 splits");
    let mut faces = flip::flip_faces(&mut solid, &old);
    solid.note_stage("2-3 flips");
    let (mut edges, centres) = match options.boundary {
        Boundary::Fixed => (surface::halve_edges(&mut solid, &old), Vec::new()),
        _ => surface::subdivide(&mut solid, &old, &mut improver.filling),
    };
    improver.improve(&mut solid, start, before_smoothing(&options.optimise));
    let targets = match options.boundary {
        Boundary::Fixed => Vec::new(),
        Boundary::Approximating => surface::approximating_targets(&old),
        Boundary::Interpolating => surface::interpolating_targets(&old, &centres),
    };
    let rejected = surface::smooth(&mut solid, targets, &mut improver, options.optimise.passes.min(1));
    let now = solid.tick();
    flip::retry_faces(&mut solid, &mut faces);
    surface::retry_edges(&mut solid, &mut edges, &mut improver.filling);
    solid.note_stage("flips that had to wait");
    if options.optimise.ends_in_quality() {
        optimise_quality(&mut solid, start, &options.optimise);
        solid.note_stage("optimisation");
    } else {
        improver.improve(&mut solid, now, options.optimise.passes);
        if options.optimise.ends_in_error() {
            // The error-driven stage keeps the worst angle but does not raise it: without repair angles sink and valences
            // grow from step to step.
            optimise_quality(
                &mut solid,
                start,
                &Optimise { target_angle: REPAIR_ANGLE, passes: 1, ..options.optimise },
            );
            solid.note_stage("repair");
        }
    }

    let creases = match options.boundary {
        // Creases that are halved have no parity.
        Boundary::Fixed => (Vec::new(), Vec::new()),
        Boundary::Approximating | Boundary::Interpolating => surface::crease_parities(history, &old),
    };
    let history = next_history(&solid, history, creases, &faces, &edges);
    let info = Info {
        asked,
        split: selected.iter().filter(|s| **s).count(),
        flipped: faces.done + edges.done,
        rejected: rejected + faces.refused.len() + edges.refused.len(),
        pending: history.pending_faces.len() + history.pending_edges.len(),
        worst_sine: solid.worst_sine_of_all(),
    };
    let (transfer, frames) = (solid.take_transfer(), solid.take_frames()?);
    Ok(Refined { mesh: solid.finish()?, transfer, history, info, frames })
}

/// Passes of the paper's operations before boundary vertices move.
fn before_smoothing(optimise: &Optimise) -> usize {
    if optimise.ends_in_quality() { optimise.passes.min(1) } else { optimise.passes }
}

/// Flips of one kind: how many were done, which were refused, which lack a refined cell on one side.
struct Flips<const N: usize> {
    done: usize,
    refused: Vec<[u32; N]>,
    one_sided: Vec<[u32; N]>,
}

/// What a step has to know of the mesh it starts from.
struct OldMesh<'a> {
    mesh: &'a TetMesh,
    /// Interior faces with a selected cell on both sides, sorted.
    inner_faces: Vec<[u32; 3]>,
    /// Interior faces with a selected cell on one side only.
    border_faces: Vec<[u32; 3]>,
    /// Faces between two regions with a selected cell, sorted.
    interfaces: Vec<[u32; 3]>,
    /// For each boundary face whether its cell is selected.
    refined: Vec<bool>,
    /// Creases with odd parity at a selected cell, sorted: they are trisected in this step.
    listed: Vec<[u32; 2]>,
}

impl<'a> OldMesh<'a> {
    fn new(mesh: &'a TetMesh, history: &History, selected: &[bool]) -> Self {
        let tets = mesh.tets();
        let (mut inner_faces, mut border_faces, mut interfaces) = (Vec::new(), Vec::new(), Vec::new());
        for (t, around) in topology::face_neighbours(tets).into_iter().enumerate() {
            for (i, u) in around.into_iter().enumerate().filter_map(|(i, u)| Some((i, u? as usize))) {
                let face = topology::sorted3(topology::tet_faces(tets[t])[i]);
                if !selected[t] {
                    continue;
                }
                // Flips never cross a border between regions.
                if mesh.regions()[t] != mesh.regions()[u] {
                    interfaces.push(face);
                } else if !selected[u] {
                    border_faces.push(face);
                } else if t < u {
                    inner_faces.push(face);
                }
            }
        }
        inner_faces.sort_unstable();
        border_faces.sort_unstable();
        interfaces.sort_unstable();
        interfaces.dedup();
        let refined = topology::boundary_cells(tets).into_iter().map(|t| selected[t as usize]).collect();
        let mut touched: Vec<[u32; 2]> =
            (0..tets.len()).filter(|&t| selected[t]).flat_map(|t| topology::tet_edges(tets[t])).collect();
        touched.sort_unstable();
        let is_touched = |e: &&[u32; 2]| touched.binary_search(e).is_ok();
        let listed = history.odd_creases.iter().filter(is_touched).copied().collect();
        Self { mesh, inner_faces, border_faces, interfaces, refined, listed }
    }

    /// True if the crease is trisected in this step.
    fn is_listed(&self, edge: [u32; 2]) -> bool {
        self.listed.binary_search(&topology::sorted2(edge)).is_ok()
    }
}

/// 1-4 splits of the selected cells at their barycentres.
fn split_cells(solid: &mut Solid, selected: &[bool]) {
    for t in (0..selected.len()).filter(|&t| selected[t]) {
        let t = t as u32;
        let tet = solid.tet(t);
        let m = solid.add_vertex(Stencil::mean(&tet));
        let child = |i: usize| {
            let mut child = tet;
            child[i] = m;
            child
        };
        solid.split_cell(t, [child(0), child(1), child(2), child(3)], true);
    }
}

/// Collects what the next step has to know, of what still exists. `creases` are the odd ones and those with one refined
/// face.
fn next_history(
    solid: &Solid,
    before: &History,
    creases: (Vec<[u32; 2]>, Vec<[u32; 2]>),
    faces: &Flips<3>,
    edges: &Flips<2>,
) -> History {
    let (odd, half) = creases;
    let mut pending_faces = [&before.pending_faces[..], &faces.refused, &faces.one_sided].concat();
    pending_faces.retain(|&f| solid.cells_at_face(f).len() == 2);
    let mut pending_edges = [&before.pending_edges[..], &edges.refused, &edges.one_sided].concat();
    pending_edges.retain(|&e| !solid.is_crease(e) && solid.is_surface_edge(e));
    pending_edges.extend(half);
    pending_faces.sort_unstable();
    pending_faces.dedup();
    pending_edges.sort_unstable();
    pending_edges.dedup();
    History { pending_faces, pending_edges, odd_creases: odd }
}
