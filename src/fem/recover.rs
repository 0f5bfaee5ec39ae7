//! Stress, energy and reactions of a solved system.

use super::block_matrix::dot;
use super::{Model, Solved, SolverInfo, SymTensor, System, springs, tet4};
use crate::mesh::TetMesh;
use glam::DVec3;
use rayon::prelude::*;

/// What a linear-elastic analysis gives.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Displacement of each node.
    pub displacement: Vec<DVec3>,
    /// Stress in each cell, constant there.
    pub stress: Vec<SymTensor>,
    /// Energy stored in the solid: `u . K u / 2`; without the energy of elastic foundations.
    pub strain_energy: f64,
    /// Force that each support exerts on the solid. A component of a node that several supports prescribe is counted
    /// once, for the first of them in the model's order.
    pub reactions: Vec<DVec3>,
    /// How the system was solved.
    pub info: SolverInfo,
}

/// Recovers stress, strain energy and reactions.
#[must_use]
pub fn recover(mesh: &TetMesh, model: &Model, system: &System, solved: &Solved) -> Solution {
    let u = &solved.displacement;
    let internal = system.stiffness.times(u);
    let stress: Vec<SymTensor> = (0..mesh.tets().len())
        .into_par_iter()
        .map(|t| {
            let (_, gradients) = tet4::gradients(mesh.cell_points(t));
            let strain = tet4::strain(gradients, mesh.tets()[t].map(|v| u[v as usize]));
            model.materials[mesh.regions()[t].0 as usize].stress(strain)
        })
        .collect();
    let mut reactions = reactions(model, system, &internal);
    for (support, reaction) in model.supports.iter().zip(&mut reactions) {
        *reaction += springs::reaction(mesh, support, u);
    }
    let has_springs = model.supports.iter().any(|s| s.stiffness != DVec3::ZERO);
    Solution {
        strain_energy: if has_springs { energy(mesh, model, &stress) } else { 0.5 * dot(u, &internal) },
        stress,
        reactions,
        displacement: u.clone(),
        info: solved.info.clone(),
    }
}

/// `int s : C^-1 : s dV / 2`, in the order of the cells.
fn energy(mesh: &TetMesh, model: &Model, stress: &[SymTensor]) -> f64 {
    let cell = |(t, s): (usize, &SymTensor)| {
        0.5 * mesh.cell_volume(t) * model.materials[mesh.regions()[t].0 as usize].compliance_energy(*s)
    };
    stress.iter().enumerate().map(cell).sum()
}

/// `K u - f` at the prescribed components, by support.
fn reactions(model: &Model, system: &System, internal: &[DVec3]) -> Vec<DVec3> {
    let mut reactions = vec![DVec3::ZERO; model.supports.len()];
    for p in system.numbering.prescribed() {
        let (node, c) = (p.node as usize, p.component as usize);
        reactions[p.support as usize][c] += internal[node][c] - system.loads[node][c];
    }
    reactions
}

/// Sum of all loads and reactions: zero but for rounding and the residual of the solver.
#[must_use]
pub fn global_balance(system: &System, solution: &Solution) -> DVec3 {
    system.total_load() + solution.reactions.iter().sum::<DVec3>()
}
