//! Stress, energy and reactions of hexahedral elements.

use super::super::assembly::System;
use super::super::recover::reactions;
use super::super::{Material, Model, Solved, SolverInfo, SymTensor, tet4};
use super::rule::Quadrature;
use super::{AtPoint, HexSpace, loads, nitsche};
use crate::limit::Table;
use glam::DVec3;

/// What a linear-elastic analysis on hexahedra gives.
#[derive(Debug, Clone)]
pub struct HexSolution {
    /// Coefficients of the displacement.
    pub displacement: Vec<DVec3>,
    /// Energy stored in the solid.
    pub strain_energy: f64,
    /// Work of the loads, `f . u`: twice the energy where supports prescribe nothing but zero.
    pub compliance: f64,
    /// Force that each support exerts on the solid.
    pub reactions: Vec<DVec3>,
    /// How the system was solved.
    pub info: SolverInfo,
}

/// Recovers energy and reactions.
#[must_use]
pub fn recover_hexes(space: &HexSpace<'_>, model: &Model, system: &System, solved: &Solved) -> HexSolution {
    let u = &solved.displacement;
    let mut internal = system.stiffness.times(u);
    // A rigid motion has no bubbles: what holds these is no part of the force.
    internal.iter_mut().zip(&system.loads).skip(space.placed()).for_each(|(inner, load)| *inner = *load);
    let mut reactions = reactions(model, system, &internal);
    for (support, reaction) in model.supports.iter().zip(&mut reactions) {
        if support.stiffness != DVec3::ZERO {
            // The visitor has no errors.
            let _ = loads::on_faces(space, support.group, &mut |functions, _, area| {
                let moved: DVec3 = functions.iter().map(|(v, n)| *n * u[*v as usize]).sum();
                *reaction -= area.length() * support.stiffness * moved;
                Ok(())
            });
        }
    }
    if model.supports.iter().any(|s| s.weakly.is_some()) {
        nitsche::add_reactions(space, model, u, &mut reactions);
    }
    HexSolution {
        strain_energy: strain_energy(space, model, u),
        compliance: system.loads.iter().zip(u).map(|(f, u)| f.dot(*u)).sum(),
        reactions,
        displacement: u.clone(),
        info: solved.info.clone(),
    }
}

/// By the strains, not as `u.K u / 2`, which has no digits left where the body moves far more than it deforms.
fn strain_energy(space: &HexSpace<'_>, model: &Model, u: &[DVec3]) -> f64 {
    let quadrature = Quadrature::of_stiffness(space, 0, 0);
    let energies = space.of_cells(|t| {
        let ((weights, table), material, mut at) =
            (quadrature.of(space, t), material(space, model, t), AtPoint::default());
        let point = |(q, weight): (usize, &f64)| {
            space.at_point(t, &table, q, &mut at);
            let stress = material.stress(strain(space, u, t, &at));
            0.5 * weight * at.determinant * material.compliance_energy(stress)
        };
        weights.iter().enumerate().map(point).sum::<f64>()
    });
    energies.iter().sum()
}

/// The material of a cell.
pub(super) fn material<'a>(space: &HexSpace<'_>, model: &'a Model, t: usize) -> &'a Material {
    &model.materials[space.mesh().regions()[t].0 as usize]
}

/// The strain of a displacement where the functions of cell `t` have these gradients.
pub(super) fn strain(space: &HexSpace<'_>, u: &[DVec3], t: usize, at: &AtPoint) -> SymTensor {
    let own = space.cell(t).iter().map(|&v| u[v as usize]);
    tet4::strain(at.gradients.iter().copied().zip(own))
}

impl HexSolution {
    /// The stress of the elements at point `q` of a table of cell `t`.
    #[must_use]
    pub fn stress(&self, space: &HexSpace<'_>, model: &Model, t: usize, table: &Table, q: usize) -> SymTensor {
        let mut at = AtPoint::default();
        space.at_point(t, table, q, &mut at);
        material(space, model, t).stress(strain(space, &self.displacement, t, &at))
    }
}
