//! Loads that do less than they seem to.

use crate::fem::{self, FemError, Integrals, Load, Model, Prescribed, Quantity, QuantityKind, Space, Support};
use glam::DVec3;

/// Part of a load's largest nodal force below which a component is rounding.
const ROUNDING: f64 = 1e-12;

/// Loads that are zero, act on fixed nodes only, or cancel out; a model that nothing loads.
///
/// # Errors
/// [`FemError`]: an expression of a load has no finite value where it acts.
pub(super) fn warnings(
    space: &impl Integrals,
    model: &Model,
    prescribed: &[Prescribed],
) -> Result<Vec<String>, FemError> {
    let mut warnings = Vec::new();
    let (mut total, mut size) = (DVec3::ZERO, 0.0);
    for load in &model.loads {
        let forces = fem::load_forces(space, model, load)?;
        let magnitude: f64 = forces.iter().map(|f| f.length()).sum();
        total += forces.iter().sum::<DVec3>();
        size += magnitude;
        if magnitude == 0.0 {
            warnings.push(format!("load `{}` is zero", load.name));
        } else if only_fixed(&forces, prescribed) {
            warnings.push(format!("load `{}` acts on fixed nodes only: supports take it", load.name));
        }
    }
    let moved = prescribed.iter().any(|p| p.value != 0.0);
    if size == 0.0 && !moved {
        warnings.push("nothing loads the model: the displacement will be zero everywhere".to_owned());
    } else if size > 0.0 && total.length() <= 1e-9 * size {
        warnings.push("the loads cancel out: their total force is zero".to_owned());
    }
    Ok(warnings)
}

/// Supports that prescribe nothing: others, named before them, prescribe the same.
pub(super) fn idle_supports(model: &Model, prescribed: &[Prescribed]) -> Vec<String> {
    let mut busy = vec![false; model.supports.len()];
    prescribed.iter().for_each(|p| busy[p.support as usize] = true);
    let idle =
        model.supports.iter().zip(busy).filter(|(s, busy)| !busy && s.weakly.is_none() && s.stiffness == DVec3::ZERO);
    idle.map(|(s, _)| format!("support `{}` holds nothing that others do not hold already", s.name)).collect()
}

/// A warning where the reaction aimed at depends on how nodes are shared: another support prescribes the same component at
/// their border, where the force is concentrated.
pub(super) fn shared_reaction(space: &Space<'_>, model: &Model, goal: &Quantity) -> Option<String> {
    let QuantityKind::Reaction(own, component) = goal.kind else { return None };
    let support = &model.supports[own];
    support.displacement[component].as_ref()?;
    let nodes = support.nodes(space);
    let shares = |other: &&Support| {
        other.displacement[component].is_some() && other.nodes(space).iter().any(|v| nodes.binary_search(v).is_ok())
    };
    let others = model.supports.iter().enumerate().filter(|(i, _)| *i != own).map(|(_, s)| s);
    let other = { others }.find(shares)?;
    Some(format!(
        "adapt.goal = {:?}: supports `{}` and `{}` both prescribe {} where they meet; how they share the force there depends on \
         the mesh, which no error bar tells",
        goal.name,
        support.name,
        other.name,
        ["x", "y", "z"][component]
    ))
}

/// The total force of a load.
///
/// # Errors
/// As [`fem::load_forces`].
pub(super) fn total(space: &Space<'_>, model: &Model, load: &Load) -> Result<DVec3, FemError> {
    Ok(fem::load_forces(space, model, load)?.iter().sum())
}

/// Whether forces act only where the displacement is prescribed.
fn only_fixed(forces: &[DVec3], prescribed: &[Prescribed]) -> bool {
    let mut free = forces.to_vec();
    for p in prescribed {
        free[p.node as usize][p.component as usize] = 0.0;
    }
    let largest = |forces: &[DVec3]| forces.iter().map(|f| f.abs().max_element()).fold(0.0, f64::max);
    largest(&free) <= ROUNDING * largest(forces)
}
