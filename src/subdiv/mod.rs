//! Subdivision: a mesh and a selection of its cells in, a finer mesh out. Knows no physics.

pub mod catmull_clark;
mod improve;
mod longest_edge;
pub mod options;
mod red;
mod solid;
mod sqrt3;
pub mod tet_oct;

use crate::mesh::{MeshError, TetMesh, quality};
use options::{Optimise, Options, Scheme};
use solid::Solid;

pub use improve::error::{Directions, Weights, cost as cell_cost};
pub use sqrt3::History;

/// What refinement made.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The finer mesh.
    pub mesh: TetMesh,
    /// How fields at vertices are carried over: the vertices of the old mesh keep their numbers, and each new vertex has
    /// one entry here, in order.
    pub transfer: Vec<Stencil>,
    /// What the next step of the same scheme has to know; hand it back with `mesh`.
    pub history: History,
    /// What was done.
    pub info: Info,
    /// The mesh after each stage, in order; none unless [`Options::frames`] asks for them.
    pub frames: Vec<Frame>,
}

/// The mesh after a stage of a refinement step. Vertices keep their numbers from frame to frame.
#[derive(Debug, Clone)]
pub struct Frame {
    /// What was done last.
    pub stage: &'static str,
    /// What it made.
    pub mesh: TetMesh,
}

impl Refined {
    /// What a step makes that refines nothing.
    fn unchanged(mesh: &TetMesh, history: &History) -> Self {
        let worst = |worst: f64, t| quality::min_sine(mesh.cell_points(t)).min(worst);
        let worst_sine = (0..mesh.tets().len()).fold(f64::INFINITY, worst);
        let pending = history.pending();
        let info = Info { pending, worst_sine, ..Info::default() };
        Self { mesh: mesh.clone(), transfer: Vec::new(), history: history.clone(), info, frames: Vec::new() }
    }
}

/// A vertex as an affine combination of vertices with smaller numbers, by the topology of the split that made it (where
/// smoothing moved it to does not matter). Unused entries have weight zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil {
    /// Up to four vertices.
    pub vertices: [u32; 4],
    /// Their weights; the sum is one.
    pub weights: [f64; 4],
}

impl Stencil {
    /// Equal weights on one to four vertices.
    pub(crate) fn mean(vertices: &[u32]) -> Self {
        let share = 1.0 / vertices.len() as f64;
        let entry = |i: usize| vertices.get(i).map_or((vertices[0], 0.0), |v| (*v, share));
        let entries = [entry(0), entry(1), entry(2), entry(3)];
        Self { vertices: entries.map(|e| e.0), weights: entries.map(|e| e.1) }
    }

    /// The point that divides the edge from a to b at `share`.
    pub(crate) fn between(a: u32, b: u32, share: f64) -> Self {
        Self { vertices: [a, b, a, a], weights: [1.0 - share, share, 0.0, 0.0] }
    }

    /// The combination of values given by vertex.
    pub(crate) fn combine<T>(&self, value: impl Fn(u32) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
    {
        let term = |i: usize| value(self.vertices[i]) * self.weights[i];
        term(0) + term(1) + term(2) + term(3)
    }
}

/// Carries a field at the vertices of the old mesh over to the refined one.
#[must_use]
pub fn carry_over(field: &[f64], transfer: &[Stencil]) -> Vec<f64> {
    let mut values = field.to_vec();
    for stencil in transfer {
        values.push(stencil.combine(|v| values[v as usize]));
    }
    values
}

/// Counts of one refinement step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Info {
    /// Cells the caller selected.
    pub asked: usize,
    /// Cells refined: those selected and those the scheme added to keep the mesh sound.
    pub split: usize,
    /// Old faces and surface edges flipped.
    pub flipped: usize,
    /// Flips and moves refused because they would have spoiled a cell.
    pub rejected: usize,
    /// Old faces and surface edges that wait for a later step.
    pub pending: usize,
    /// Smallest minimum sine of the dihedral angles of the new mesh.
    pub worst_sine: f64,
}

/// Optimises a whole mesh for its dihedral angles ([`options::Objective::Quality`]), whatever made it. Vertices keep
/// their numbers; the solid, its regions, groups and creases stay.
///
/// # Errors
/// [`MeshError`] if the result would not be a valid mesh.
pub fn optimise_quality(mesh: &TetMesh, options: &Optimise) -> Result<TetMesh, MeshError> {
    let mut solid = Solid::new(mesh);
    improve::optimise_quality(&mut solid, 0, options);
    solid.finish()
}

/// Refines the selected cells (`selected[t]` for each cell of `mesh`) by one step of `options.scheme`. `history` is
/// [`History::default`] for a mesh that was read or generated, and what the step before gave otherwise.
///
/// # Errors
/// [`MeshError`] if the result would not be a valid mesh, or if the scheme cannot refine this mesh (it says why).
pub fn refine(mesh: &TetMesh, history: &History, selected: &[bool], options: &Options) -> Result<Refined, MeshError> {
    if selected.len() != mesh.tets().len() {
        let (got, want) = (selected.len(), mesh.tets().len());
        return Err(MeshError::Inconsistent(format!("{got} selection flags for {want} cells")));
    }
    if !selected.contains(&true) {
        return Ok(Refined::unchanged(mesh, history));
    }
    let mut refined = match options.scheme {
        // Its stages are interleaved with the optimiser.
        Scheme::Sqrt3 => return sqrt3::refine(mesh, history, selected, options),
        Scheme::Red => red::refine(mesh, selected)?,
        Scheme::LongestEdge => longest_edge::refine(mesh, selected)?,
    };
    if options.frames {
        refined.frames.push(Frame { stage: "splits", mesh: refined.mesh.clone() });
    }
    if let Some(run) = options.optimise.quality_run(|| typical_angle(mesh)) {
        let mut solid = Solid::new(&refined.mesh);
        solid.watch(options.frames);
        improve::optimise_quality(&mut solid, 0, &run);
        solid.note_stage("optimisation");
        refined.frames.extend(solid.take_frames()?);
        refined.transfer.extend(solid.take_transfer());
        refined.info.worst_sine = solid.worst_sine_of_all();
        refined.mesh = solid.finish()?;
    }
    Ok(refined)
}

/// The median of the smallest dihedral angles of the cells, in degrees.
fn typical_angle(mesh: &TetMesh) -> f64 {
    let mut angles = quality::min_dihedrals(mesh);
    let middle = angles.len() / 2;
    *angles.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// A mesh optimised for analysis.
#[derive(Debug, Clone)]
pub struct Optimised {
    /// The mesh.
    pub mesh: TetMesh,
    /// The number that each of its vertices had before. The order is kept: numbers only close up where vertices are gone.
    pub kept: Vec<u32>,
}

impl Optimised {
    /// Carries a field at the vertices over.
    #[must_use]
    pub fn carry_over<T: Copy>(&self, field: &[T]) -> Vec<T> {
        self.kept.iter().map(|&v| field[v as usize]).collect()
    }
}

/// Optimises a mesh for analysis, by weighted interpolation error (see [`options::Objective::Error`]). `weights` has an
/// entry for each vertex, such as [`Weights::directions`] gives; equal entries where nothing is known of an ungraded mesh.
/// The vertices before number `first` stay; later ones in the interior go where they are not worth their price. The price
/// is one for the whole mesh, so equal weights on a graded mesh would undo its grading: give its number of vertices for
/// `first` then.
///
/// # Errors
/// [`MeshError::Inconsistent`] if there is not one weight a vertex, or one is negative or not finite.
pub fn optimise_error(mesh: &TetMesh, weights: &Weights, passes: usize, first: usize) -> Result<Optimised, MeshError> {
    let first = u32::try_from(first).unwrap_or(u32::MAX);
    let mut solid = Solid::new(mesh);
    improve::error::optimise_error(&mut solid, weights, passes, first)?;
    let kept = solid.drop_unused(first);
    Ok(Optimised { mesh: solid.finish()?, kept })
}
