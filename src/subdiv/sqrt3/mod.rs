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
use super::options::{Boundary, Mode, Optimise, Options};
use super::solid::Solid;
use super::{Info, Refined, Stencil, typical_angle};
use crate::mesh::surface::{SurfaceFace, surface_edges, surface_faces};
use crate::mesh::{MeshError, TetMesh, topology};
use serde::{Deserialize, Serialize};

/// What one step leaves for the next: operations that wait for their other side, and the parity of creases. All lists
/// are sorted; vertices are sorted within each entry.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct History {
    /// Old interior faces that could not be flipped yet.
    pending_faces: Vec<[u32; 3]>,
    /// Old surface edges, and creases with a refined face, that wait for their other sides.
    pending_edges: Vec<[u32; 2]>,
    /// Creases all of whose faces were split once: the next step trisects them.
    odd_creases: Vec<[u32; 2]>,
}

impl History {
    /// Number of old faces and edges that wait.
    pub(super) fn pending(&self) -> usize {
        self.pending_faces.len() + self.pending_edges.len()
    }

    /// The history after the mesh was changed so that vertex i is what `kept[i]` was.
    #[must_use]
    pub fn renumbered(&self, kept: &[u32]) -> Self {
        Self {
            pending_faces: renumbered(&self.pending_faces, kept),
            pending_edges: renumbered(&self.pending_edges, kept),
            odd_creases: renumbered(&self.odd_creases, kept),
        }
    }
}

/// Those entries all of whose vertices were kept, with their new numbers.
fn renumbered<const N: usize>(entries: &[[u32; N]], kept: &[u32]) -> Vec<[u32; N]> {
    let number = |v: u32| kept.binary_search(&v).ok();
    let whole = entries.iter().filter(|e| e.iter().all(|&v| number(v).is_some()));
    whole.map(|e| e.map(|v| number(v).map_or(v, |n| n as u32))).collect()
}

/// Refines the selected cells.
///
/// # Errors
/// [`MeshError`] if the result would not be a valid mesh.
pub(super) fn refine(
    mesh: &TetMesh,
    history: &History,
    selected: &[bool],
    options: &Options,
) -> Result<Refined, MeshError> {
    let asked = selected.iter().filter(|s| **s).count();
    let selected = closure::close(mesh, history, selected, options.boundary);
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
    match options.optimise.quality_run(|| typical_angle(mesh)) {
        Some(run) => {
            optimise_quality(&mut solid, start, &run);
            solid.note_stage("optimisation");
        }
        None => improver.improve(&mut solid, now, options.optimise.passes),
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
        pending: history.pending(),
        worst_sine: solid.worst_sine_of_all(),
    };
    let (transfer, frames) = (solid.take_transfer(), solid.take_frames()?);
    Ok(Refined { mesh: solid.finish()?, transfer, history, info, frames })
}

/// Passes of the paper's operations before boundary vertices move.
fn before_smoothing(optimise: &Optimise) -> usize {
    match optimise.mode {
        Mode::Paper => optimise.passes,
        Mode::Best => optimise.passes.min(1),
    }
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
    /// The boundary and the interfaces between regions.
    surface: Vec<SurfaceFace>,
    /// The edges of the surface, sorted, with the indices of the faces at each.
    surface_edges: Vec<([u32; 2], Vec<usize>)>,
    /// For each surface face whether a cell at it is selected.
    refined: Vec<bool>,
    /// Creases inside a region, sorted, with the selection flags of the cells around.
    inner_creases: Vec<([u32; 2], Vec<bool>)>,
    /// Creases with odd parity at a selected cell, sorted: they are trisected in this step.
    listed: Vec<[u32; 2]>,
}

impl<'a> OldMesh<'a> {
    fn new(mesh: &'a TetMesh, history: &History, selected: &[bool]) -> Self {
        let tets = mesh.tets();
        let (mut inner_faces, mut border_faces) = (Vec::new(), Vec::new());
        for (t, around) in topology::face_neighbours(tets).into_iter().enumerate() {
            for (i, u) in around.into_iter().enumerate().filter_map(|(i, u)| Some((i, u? as usize))) {
                let face = topology::sorted3(topology::tet_faces(tets[t])[i]);
                // Flips never cross a border between regions.
                if !selected[t] || mesh.regions()[t] != mesh.regions()[u] {
                    continue;
                }
                if !selected[u] {
                    border_faces.push(face);
                } else if t < u {
                    inner_faces.push(face);
                }
            }
        }
        inner_faces.sort_unstable();
        border_faces.sort_unstable();
        let surface = surface_faces(mesh);
        let surface_edges = surface_edges(&surface);
        let refined = surface.iter().map(|f| f.cells().any(|t| selected[t as usize])).collect();
        let inner_creases = inner_creases(mesh, &surface_edges, selected);
        let mut touched: Vec<[u32; 2]> =
            (0..tets.len()).filter(|&t| selected[t]).flat_map(|t| topology::tet_edges(tets[t])).collect();
        touched.sort_unstable();
        let is_touched = |e: &&[u32; 2]| touched.binary_search(e).is_ok();
        let listed = history.odd_creases.iter().filter(is_touched).copied().collect();
        Self { mesh, inner_faces, border_faces, surface, surface_edges, refined, inner_creases, listed }
    }

    /// True if the crease is trisected in this step.
    fn is_listed(&self, edge: [u32; 2]) -> bool {
        self.listed.binary_search(&topology::sorted2(edge)).is_ok()
    }
}

/// The creases that are not on a surface, with the selection flags of the cells around.
fn inner_creases(
    mesh: &TetMesh,
    surface_edges: &[([u32; 2], Vec<usize>)],
    selected: &[bool],
) -> Vec<([u32; 2], Vec<bool>)> {
    let inside = |e: &[u32; 2]| surface_edges.binary_search_by_key(e, |(key, _)| *key).is_err();
    let edges: Vec<[u32; 2]> = mesh.creases().iter().map(|c| c.vertices).filter(inside).collect();
    if edges.is_empty() {
        return Vec::new();
    }
    let mut flags = vec![Vec::new(); edges.len()];
    for (tet, selected) in mesh.tets().iter().zip(selected) {
        for i in topology::tet_edges(*tet).iter().filter_map(|e| edges.binary_search(e).ok()) {
            flags[i].push(*selected);
        }
    }
    edges.into_iter().zip(flags).collect()
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
