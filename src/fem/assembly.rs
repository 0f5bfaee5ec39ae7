//! The linear system: stiffness, nodal forces, and which displacements are prescribed.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::gather::gather;
use super::numbering::{Dofs, Prescribed};
use super::options::Element;
use super::solve::residual;
use super::{FemError, Model, Space, check, loads, quadratic, springs, tet4, tet10};
use crate::mesh::topology::NodeCells;
use crate::mesh::{TetMesh, quality};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// The linear system `K u = f` of all nodes, with the displacements that are prescribed.
#[derive(Debug, Clone)]
pub struct System {
    /// Stiffness between all nodes, prescribed ones included: reactions and energy need it.
    pub(super) stiffness: BlockMatrix,
    /// Force of the loads at each node.
    pub(super) loads: Vec<DVec3>,
    pub(super) numbering: Dofs,
    /// Positions of the nodes: the rigid motions that the iterative solver builds on depend on them.
    pub(super) points: Vec<DVec3>,
    /// Of ten-node cells, what their vertices are.
    pub(super) linear: Option<Linear>,
}

/// The vertices of elements of higher order: the first nodes, before those on edges or others.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// Stiffness of the four-node cells between the vertices. Where edges are straight it is `P^T K P`, with `P` that gives
    /// the middle of an edge the mean of its ends.
    pub stiffness: BlockMatrix,
    /// The vertices that each further node lies between; `u32::MAX` where a function is none of vertices' (a bubble).
    pub ends: Vec<[u32; 2]>,
}

impl System {
    /// Degrees of freedom: three a node.
    #[must_use]
    pub fn dofs(&self) -> usize {
        3 * self.loads.len()
    }

    /// Unknown degrees of freedom: those that no support prescribes.
    #[must_use]
    pub fn free_dofs(&self) -> usize {
        self.numbering.free()
    }

    /// `K u`, three entries a node, prescribed ones included: the forces that hold the displacement `u`. For measurements,
    /// whose unit is the cost of this product.
    pub fn times(&self, u: &[DVec3], forces: &mut [DVec3]) {
        let row = |(i, f): (usize, &mut DVec3)| *f = self.stiffness.row_times(i, u);
        forces.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(row);
    }

    /// Sum of all loads.
    #[must_use]
    pub fn total_load(&self) -> DVec3 {
        self.loads.iter().sum()
    }

    /// What a displacement leaves unbalanced: `f - K u` at the unknowns, zero elsewhere.
    #[must_use]
    pub fn unbalanced(&self, u: &[DVec3]) -> Vec<DVec3> {
        residual(self, u)
    }

    /// The first node whose stiffness or force is no finite number; else the one of the largest force.
    pub(super) fn extreme_node(&self) -> usize {
        let is_finite =
            |i: &usize| self.loads[*i].is_finite() && self.stiffness.row(*i).all(|(_, block)| block.is_finite());
        let size = |i: &usize| self.loads[*i].abs().max_element();
        let largest = || (0..self.loads.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        (0..self.loads.len()).find(|i| !is_finite(i)).or_else(largest).unwrap_or_default()
    }

    /// The same matrix under other nodal forces, and other values of what is prescribed.
    pub(super) fn with_loads(self, loads: Vec<DVec3>, value: impl Fn(&Prescribed) -> f64) -> Self {
        Self { loads, numbering: self.numbering.with_values(value), ..self }
    }
}

/// Assembles stiffness, loads and supports of a model on the elements of a mesh.
///
/// It does not ask whether the supports hold the solid: see [`super::check_constraints`], which is needed once only, as
/// refinement inherits the supports.
///
/// # Errors
/// A material, support or load that makes no sense on this mesh; see [`FemError`].
pub fn assemble(space: &Space<'_>, model: &Model) -> Result<System, FemError> {
    check::check(space.mesh(), model)?;
    let numbering = Dofs::new(space, model)?;
    let loads = loads::nodal_forces(space, model)?;
    let (mut stiffness, linear) = match space.element() {
        Element::Tet4 => (stiffness(space.mesh(), model), None),
        Element::Tet10 => (quadratic::stiffness(space, model), Some(linear(space, model))),
    };
    springs::add(space, model, &mut stiffness);
    Ok(System { stiffness, loads, numbering, points: space.points().to_vec(), linear })
}

/// The stiffness between the vertices as nodes of four-node cells.
fn stiffness(mesh: &TetMesh, model: &Model) -> BlockMatrix {
    let cells = NodeCells::new(mesh.points().len(), mesh.tets());
    let lame: Vec<[f64; 2]> = model.materials.iter().map(|m| [m.lambda(), m.mu()]).collect();
    let nodes = |t: u32| mesh.tets()[t as usize].into_iter();
    gather(&cells, mesh.points().len(), nodes, |i, places, blocks| {
        gather_row(mesh, &lame, i, cells.at(i), places, blocks);
    })
}

/// Adds the blocks of node `i` from its cells; `places` says where the block of each of its neighbours is.
fn gather_row(mesh: &TetMesh, lame: &[[f64; 2]], i: u32, cells: &[u32], places: &[u32], blocks: &mut [DMat3]) {
    let region = |t: &u32| mesh.regions()[*t as usize].0 as usize;
    let one = cells.first().map(region).filter(|&one| cells.iter().all(|t| region(t) == one));
    for &t in cells {
        let tet = mesh.tets()[t as usize];
        let p = mesh.cell_points(t as usize);
        let n = quality::face_normals(p);
        // With grad N_i = -n_i / (6 V), `V grad N_i grad N_j^T` is this times `n_i n_j^T`.
        let weight = 1.0 / (36.0 * quality::volume(p));
        // Node i belongs to its cells.
        let own = weight * tet.iter().position(|&v| v == i).map_or(DVec3::ZERO, |a| n[a]);
        for (v, n) in tet.into_iter().zip(n) {
            let block = &mut blocks[places[v as usize] as usize];
            if one.is_some() {
                // In one material the products are summed up first.
                *block += tet10::outer(own, n);
            } else {
                let [lambda, mu] = lame[region(&t)];
                *block += tet4::stiffness_block(lambda, mu, own, n);
            }
        }
    }
    if let Some([lambda, mu]) = one.map(|region| lame[region]) {
        blocks.iter_mut().for_each(|block| *block = tet10::stiffness_block(lambda, mu, *block));
    }
}

/// What the vertices of ten-node cells are.
fn linear(space: &Space<'_>, model: &Model) -> Linear {
    let mut stiffness = stiffness(space.mesh(), model);
    springs::add(&Space::linear(space.mesh()), model, &mut stiffness);
    Linear { stiffness, ends: space.midside().to_vec() }
}
