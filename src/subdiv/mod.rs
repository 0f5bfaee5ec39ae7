//! Subdivision: a mesh and a selection of its cells in, a finer mesh out. Knows no physics.

mod improve;
pub mod options;
mod red;
mod solid;
mod sqrt3;

use crate::mesh::{MeshError, TetMesh};
use options::{Optimise, Options, Scheme};

pub use sqrt3::History;

/// What refinement made.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The finer mesh.
    pub mesh: TetMesh,
    /// What the next step of the same scheme has to know; hand it back with `mesh`.
    pub history: History,
    /// What was done.
    pub info: Info,
}

/// Counts of one refinement step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Info {
    /// Cells the caller selected.
    pub asked: usize,
    /// Cells refined: those selected and those the scheme added to keep the mesh sound.
    pub split: usize,
    /// Old faces and boundary edges flipped.
    pub flipped: usize,
    /// Flips and moves refused because they would have spoiled a cell.
    pub rejected: usize,
    /// Old faces and boundary edges that wait for a later step.
    pub pending: usize,
    /// Smallest minimum sine of the dihedral angles of the new mesh.
    pub worst_sine: f64,
}

/// Optimises a whole mesh for its dihedral angles ([`options::Objective::Quality`]), whatever made it. Vertices keep
/// their numbers; the solid, its regions, groups and creases stay.
///
/// # Errors
/// [`MeshError`] if the result would not be a valid mesh.
pub fn optimise(mesh: &TetMesh, options: &Optimise) -> Result<TetMesh, MeshError> {
    let mut solid = solid::Solid::new(mesh);
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
    match options.scheme {
        Scheme::Red => red::refine(mesh, selected),
        Scheme::Sqrt3 => sqrt3::refine(mesh, history, selected, options),
    }
}
