//! Linear elasticity: a mesh and a model in, displacement, stress, energy and reactions out.
//!
//! Small strains, isotropic materials, tetrahedra of four nodes or ten. Tensors are ordered XX YY ZZ XY YZ XZ; shear strains in
//! this order are the tensor's own components (not the engineering shear), stresses likewise.

mod assembly;
mod block_matrix;
mod check;
mod clip;
mod constraints;
mod data;
mod error;
mod exact;
mod galerkin;
mod gather;
mod goal;
pub mod hexes;
mod loads;
mod material;
mod numbering;
pub mod options;
mod quadratic;
mod quadrature;
mod quantity;
mod recover;
mod solve;
mod space;
mod spectrum;
mod springs;
mod stress;
#[cfg(test)]
mod tests;
mod tet10;
mod tet4;

pub use assembly::{System, assemble};
pub use constraints::check_constraints;
pub use data::Data;
pub use error::FemError;
pub use exact::{Exact, TrueError};
pub use galerkin::{recover_restricted, restrict};
pub use goal::{Goal, InCells, Share};
pub use loads::{InCell, Integrals, OnFace, distance_outside, load_forces};
pub use material::{double_contraction, traction, von_mises};
pub use numbering::{Prescribed, prescribed};
pub use quadrature::FOUR_POINTS;
pub use quantity::{Cells, Extent, Quantity, QuantityKind, State};
pub use recover::{Solution, global_balance, recover};
pub use solve::{Kept, Multigrid, Solved, SolverInfo, factor_numbers, solve, solve_keeping};
pub use space::Space;
pub use spectrum::Spectrum;
pub use stress::Stress;

use crate::field::{Field, VectorField};
use crate::mesh::GroupId;
use glam::DVec3;

/// A symmetric tensor, XX YY ZZ XY YZ XZ.
pub type SymTensor = [f64; 6];

/// An isotropic linear-elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus, force per area.
    pub youngs_modulus: f64,
    /// Poisson's ratio, in (-1, 1/2).
    pub poissons_ratio: f64,
    /// Mass per volume; needed for gravity only.
    pub density: f64,
}

/// What a support holds in the mean over its faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weakly {
    /// The components that it prescribes.
    Components,
    /// The displacement normal to the faces, which is zero.
    Normal,
}

/// What holds a group of boundary faces: prescribed displacement, an elastic foundation, or both.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Name in the scenario.
    pub name: String,
    /// Where.
    pub group: GroupId,
    /// If given, only the edges and vertices where faces of `group` meet faces of this group are held; there is no
    /// foundation then.
    pub meets: Option<GroupId>,
    /// Prescribed displacement in x, y, z; `None` where free.
    pub displacement: [Option<Field>; 3],
    /// Whether it holds in the mean over its faces instead of at nodes; for hexahedra only.
    pub weakly: Option<Weakly>,
    /// Stiffness of the foundation in x, y, z, force per area and displacement; zero where there is none.
    pub stiffness: DVec3,
}

impl Support {
    /// A support that prescribes constant displacements, without a foundation.
    #[must_use]
    pub fn new(name: &str, group: GroupId, displacement: [Option<f64>; 3]) -> Self {
        let displacement = displacement.map(|u| u.map(Field::Constant));
        Self { name: name.to_owned(), group, meets: None, displacement, weakly: None, stiffness: DVec3::ZERO }
    }

    /// The nodes whose displacement it prescribes, ascending. Borders between groups are creases, so that on every
    /// refinement those of an edge lie on that edge.
    #[must_use]
    pub fn nodes(&self, space: &Space<'_>) -> Vec<u32> {
        let of = |group| {
            let mut nodes: Vec<u32> = space.mesh().group_faces(group).flat_map(|f| space.face(f)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let mut nodes = of(self.group);
        if let Some(other) = self.meets.map(of) {
            nodes.retain(|v| other.binary_search(v).is_ok());
        }
        nodes
    }
}

/// A load.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Name in the scenario.
    pub name: String,
    /// What acts where.
    pub kind: LoadKind,
}

/// What acts where.
#[derive(Debug, Clone, PartialEq)]
pub enum LoadKind {
    /// Force per area on a group.
    Traction(GroupId, VectorField),
    /// Force per area against the outward normal of a group.
    Pressure(GroupId, Field),
    /// Total force, spread evenly over the area of a group.
    Force(GroupId, DVec3),
    /// Force (second) at a point (first), given to the nodes of the cell there by its shape functions: that keeps force and
    /// moment, and holds on every refinement.
    PointForce(DVec3, DVec3),
    /// Force per volume on all cells.
    BodyForce(VectorField),
    /// Acceleration times density on all cells.
    Gravity(DVec3),
}

/// What is solved, in terms of regions and groups, so that it holds on every refinement of the mesh it was made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// One material a region.
    pub materials: Vec<Material>,
    /// Supports.
    pub supports: Vec<Support>,
    /// Loads.
    pub loads: Vec<Load>,
}
