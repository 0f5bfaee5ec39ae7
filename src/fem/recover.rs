//! Stress, energy and reactions of a solved system.

use super::{Model, Solved, SolverInfo, Space, Stress, System, springs};
use glam::DVec3;

/// What a linear-elastic analysis gives.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Displacement of each node.
    pub displacement: Vec<DVec3>,
    /// Stress of the elements.
    pub stress: Stress,
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
pub fn recover(space: &Space<'_>, model: &Model, system: &System, solved: &Solved) -> Solution {
    let u = &solved.displacement;
    let internal = system.stiffness.times(u);
    let stress = Stress::of(space, model, u);
    let mut reactions = reactions(model, system, &internal);
    for (support, reaction) in model.supports.iter().zip(&mut reactions) {
        *reaction += springs::reaction(space, support, u);
    }
    Solution {
        // By the strains, not as u.K u / 2, which has no digits left where the body moves far more than it deforms.
        strain_energy: stress.energies(space, model, u).iter().sum(),
        stress,
        reactions,
        displacement: u.clone(),
        info: solved.info.clone(),
    }
}

/// `K u - f` at the prescribed components, by support.
pub(super) fn reactions(model: &Model, system: &System, internal: &[DVec3]) -> Vec<DVec3> {
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
