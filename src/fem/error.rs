//! Why a model cannot be solved.

use super::{Space, System};
use crate::field::Field;
use glam::DVec3;

/// Why a model cannot be solved: the first variants blame the model (see [`FemError::is_model`]), the rest the solver.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FemError {
    /// A material constant is missing or out of range.
    #[error("material of region {region:?}: {problem}")]
    #[diagnostic(help("Young's modulus must be positive, Poisson's ratio in (-1, 1/2), the density not negative"))]
    Material {
        /// Name of the region.
        region: String,
        /// What is wrong, with the value.
        problem: String,
    },
    /// Gravity acts on a region without mass.
    #[error("load {load:?} is gravity, but the material of region {region:?} has no density")]
    #[diagnostic(help("give the material a density, or remove the load"))]
    NoDensity {
        /// Name of the load.
        load: String,
        /// Name of the region.
        region: String,
    },
    /// A support or load acts on nothing.
    #[error("{what} {name:?} acts on no boundary face")]
    #[diagnostic(help("its selector matches nothing on this mesh: check its position and tolerance"))]
    EmptyGroup {
        /// "support" or "load".
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// A value is NaN or infinite.
    #[error("{what} {name:?}: {value} is not a finite value")]
    NotFinite {
        /// "support" or "load".
        what: &'static str,
        /// Its name.
        name: String,
        /// The value.
        value: f64,
    },
    /// An elastic foundation that pushes the wrong way.
    #[error("support {support:?}: a foundation of negative stiffness, {stiffness}")]
    #[diagnostic(help("a stiffness per area is positive, or zero where there is none"))]
    NegativeStiffness {
        /// Name of the support.
        support: String,
        /// Stiffness in x, y, z.
        stiffness: DVec3,
    },
    /// An expression has no finite value where it is needed.
    #[error("{what} {name:?}: \"{field}\" is {value} at ({}, {}, {})", position.x, position.y, position.z)]
    #[diagnostic(help("change the expression, or select only faces where it is defined"))]
    NotFiniteAt {
        /// "support" or "load".
        what: &'static str,
        /// Its name.
        name: String,
        /// The expression.
        field: String,
        /// Its value there.
        value: f64,
        /// Where.
        position: DVec3,
    },
    /// Two supports prescribe different values of one displacement.
    #[error(
        "supports {first:?} and {second:?} prescribe {axis}-displacements {} and {} of vertex {vertex} at ({}, {}, {})",
        values[0], values[1], position.x, position.y, position.z
    )]
    #[diagnostic(help("the two supports share this vertex: give them the same value there, or move them apart"))]
    ConflictingSupports {
        /// The support named first in the model.
        first: String,
        /// The other support.
        second: String,
        /// "x", "y" or "z".
        axis: &'static str,
        /// The two values.
        values: [f64; 2],
        /// Vertex index.
        vertex: usize,
        /// Its position.
        position: DVec3,
    },
    /// The supports leave a rigid motion free.
    #[error("the supports do not hold the solid: {}", motions.join("; "))]
    #[diagnostic(help("add or extend a support so that no part can translate or rotate freely"))]
    FreeMotion {
        /// One sentence for each part that can move.
        motions: Vec<String>,
        /// The supports that hold these parts, as far as they are held, by index; ascending.
        supports: Vec<usize>,
    },
    /// A cell of a curved geometry is turned inside out.
    #[error(
        "cell {cell} is folded near ({:.4}, {:.4}, {:.4}): its Jacobian is {determinant:.3e} there", at.x, at.y, at.z
    )]
    #[diagnostic(help(
        "move its control points or nodes apart; near sharp edges tag creases, so that they are not rounded off; a solid that goes \
         through its vertices (analysis.interpolate) folds where cells of very different size meet: take them for control points"
    ))]
    Folded {
        /// Cell index.
        cell: usize,
        /// Where.
        at: DVec3,
        /// The Jacobian determinant.
        determinant: f64,
    },
    /// Numbers that overflow, or are lost in underflow.
    #[error("the {what} leaves the range of double precision (about 1e-154 to 1e154 where squares are taken){near}")]
    #[diagnostic(help(
        "a load, a prescribed displacement, a material constant or the size of the mesh is far too large or too small: \
         choose units in which they are of ordinary size"
    ))]
    OutOfRange {
        /// "stiffness matrix", "right-hand side" or "solution".
        what: &'static str,
        /// The first cell where it does, if that is known, in words that follow.
        near: String,
    },
    /// The stiffness matrix is not positive definite.
    #[error("the stiffness matrix is not positive definite ({detail})")]
    #[diagnostic(help("a part can still move, or cells are nearly flat: check the supports and the mesh quality"))]
    NotPositiveDefinite {
        /// Where it showed.
        detail: String,
    },
    /// The preconditioner is not positive definite, though the matrix shows nothing wrong.
    #[error("conjugate gradients: their multigrid is not positive definite ({detail})")]
    #[diagnostic(help(
        "rounding destroys it, as where stiffnesses differ by very many orders of magnitude or cells are nearly flat: use method \
         \"direct\""
    ))]
    Multigrid {
        /// Where it showed.
        detail: String,
    },
    /// The residual stays above the tolerance.
    #[error("{method}: residual {residual:.3e} after {iterations} iterations, asked for {tolerance:.1e}")]
    #[diagnostic(help("{help}"))]
    NotConverged {
        /// Method of solution.
        method: &'static str,
        /// Iterations, or steps of refinement.
        iterations: usize,
        /// The true residual |b - K u| / |b|.
        residual: f64,
        /// The residual asked for.
        tolerance: f64,
        /// What to do.
        help: &'static str,
    },
    /// There is not enough memory for the factor.
    #[error("the Cholesky factor needs {bytes} bytes, which cannot be had")]
    #[diagnostic(help("use method \"amg-cg\", or \"auto\" with a limit on the memory of the direct method"))]
    OutOfMemory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// The ordering or the symbolic factorisation failed.
    #[error("the direct method cannot order the matrix: {0}")]
    #[diagnostic(help("use method \"amg-cg\""))]
    Ordering(String),
}

impl FemError {
    /// The error of numbers that leave their range, of which no place is known yet.
    pub(super) fn out_of_range(what: &'static str) -> Self {
        Self::OutOfRange { what, near: String::new() }
    }

    /// The error, of numbers that leave their range with the first cell where they do.
    #[must_use]
    pub fn with_cell(self, space: &Space<'_>, system: &System) -> Self {
        let Self::OutOfRange { what, .. } = self else { return self };
        let node = system.extreme_node() as u32;
        let cells = 0..space.mesh().tets().len();
        let Some(cell) = { cells }.find(|&t| space.cell(t).any(|v| v == node)) else { return self };
        let at = space.mesh().cell_points(cell).iter().sum::<DVec3>() / 4.0;
        Self::OutOfRange {
            what,
            near: format!(": first in cell {cell}, near ({:.4e}, {:.4e}, {:.4e})", at.x, at.y, at.z),
        }
    }

    /// The error of a field of a support or load that is not finite at `position`.
    pub(super) fn not_finite_at(what: &'static str, name: &str, field: &Field, position: DVec3) -> Self {
        let (name, value) = (name.to_owned(), field.at(position));
        Self::NotFiniteAt { what, name, field: field.to_string(), value, position }
    }

    /// True if the model is at fault, false if the solver is.
    #[must_use]
    pub fn is_model(&self) -> bool {
        match self {
            Self::Material { .. }
            | Self::NoDensity { .. }
            | Self::EmptyGroup { .. }
            | Self::NotFinite { .. }
            | Self::NotFiniteAt { .. }
            | Self::NegativeStiffness { .. }
            | Self::ConflictingSupports { .. }
            | Self::Folded { .. }
            | Self::FreeMotion { .. } => true,
            Self::OutOfRange { .. }
            | Self::NotPositiveDefinite { .. }
            | Self::Multigrid { .. }
            | Self::NotConverged { .. }
            | Self::OutOfMemory { .. }
            | Self::Ordering(_) => false,
        }
    }
}
