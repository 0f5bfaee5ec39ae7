//! Quantities that are linear in the displacement, as the loads of a dual problem.
//!
//! The error e of the displacement makes the error `J(u) - J(u_h)` of a quantity J. With the dual solution z, which solves
//! `a(v, z) = J(v)` for all v that vanish where displacements are prescribed, and its own error e*, it is `a(e, e*)`, as e is
//! orthogonal to all displacements of the elements; where the prescribed displacement is not one of the elements', minus
//! `int (u_D - u_h) . s(z) n dA` over the faces that are held.
//!
//! The reaction of a support along c is `J(u) = a(u, w) - f(w) - int k_c u_c dA` with any w that is the unit vector of c where
//! the support prescribes this component, and zero at what others prescribe. Its dual solution is prescribed as -w, under the
//! load of the foundation alone.

use super::clip::Weights;
use super::options::Field;
use super::quantity::{Cells, Extent, QuantityKind};
use super::{FemError, Load, LoadKind, Material, Model, Space, SymTensor, System, loads, tet10, traction};
use crate::field::{self, VectorField};
use glam::DVec3;

/// The dual problem of a quantity on a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// Its materials, supports and loads; those in cells apart.
    pub(super) model: Model,
    pub(super) in_cells: Option<InCells>,
    /// The support and component whose reaction it is.
    reaction: Option<(usize, usize)>,
}

/// A mean over cells: of `force . u + weight : s(u)` over those parts of cells that belong to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InCells {
    cells: Cells,
    /// The unit vector of a displacement over the volume, else zero.
    pub force: DVec3,
    /// The unit tensor of a stress over the volume, else zero.
    pub weight: SymTensor,
}

/// How a cell belongs to a goal: the indicator function of what belongs to it, and its best linear (or constant) approximation.
#[derive(Debug, Clone, PartialEq)]
pub struct Share {
    /// Points with their volumes, for integrals over what belongs to the goal.
    pub points: Vec<(Weights, f64)>,
    /// Values of the approximation at the vertices.
    pub corners: [f64; 4],
    /// Integral of the squared difference.
    pub rest: f64,
}

impl Goal {
    /// The dual problem of a quantity; `None` if it is not linear in the displacement, or not bounded in the energy norm: a
    /// maximum, an equivalent stress, a value at a point, a stress on faces, the reaction of an edge.
    #[must_use]
    pub fn new(space: &Space<'_>, model: &Model, kind: QuantityKind) -> Option<Self> {
        let mut goal = Self { model: Model { loads: Vec::new(), ..model.clone() }, in_cells: None, reaction: None };
        for fixed in goal.model.supports.iter_mut().flat_map(|s| &mut s.displacement).flatten() {
            *fixed = field::Field::ZERO;
        }
        let load = |kind| Load { name: "goal".to_owned(), kind };
        match kind {
            QuantityKind::Average(field, Extent::Faces(group)) => {
                goal.model.loads.push(load(LoadKind::Force(group, direction(field)?)));
            }
            QuantityKind::Average(field, Extent::Cells(cells)) => {
                let per_volume = 1.0 / cells.points_volume(space);
                let (force, weight) = match direction(field) {
                    Some(direction) => (per_volume * direction, [0.0; 6]),
                    None => (DVec3::ZERO, unit_tensor(field)?.map(|w| w * per_volume)),
                };
                goal.in_cells = Some(InCells { cells, force, weight });
            }
            QuantityKind::Reaction(support, component) => {
                let support_of = &mut goal.model.supports[support];
                if support_of.meets.is_some() {
                    return None;
                }
                if let Some(fixed) = &mut support_of.displacement[component] {
                    *fixed = field::Field::Constant(-1.0);
                }
                let spring = -support_of.stiffness[component] * DVec3::AXES[component];
                if spring != DVec3::ZERO {
                    goal.model.loads.push(load(LoadKind::Traction(support_of.group, VectorField::from(spring))));
                }
                goal.reaction = Some((support, component));
            }
            QuantityKind::Maximum(..) | QuantityKind::Value(..) | QuantityKind::Total(..) => return None,
        }
        Some(goal)
    }

    /// The model of the dual problem; the loads in cells apart.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Makes the system of the dual problem of that of the problem itself: the matrix is the same.
    ///
    /// # Errors
    /// None that the system itself did not have.
    pub fn system(&self, space: &Space<'_>, system: System) -> Result<System, FemError> {
        let mut forces = loads::nodal_forces(space, &self.model)?;
        if let Some(in_cells) = &self.in_cells {
            in_cells.add(space, &self.model, &mut forces);
        }
        let value = |support, component| if self.reaction == Some((support, component)) { -1.0 } else { 0.0 };
        Ok(system.with_loads(forces, |p| value(p.support as usize, p.component as usize)))
    }
}

impl InCells {
    /// Adds the nodal forces.
    fn add(&self, space: &Space<'_>, model: &Model, forces: &mut [DVec3]) {
        for t in 0..space.mesh().tets().len() {
            let material = &model.materials[space.mesh().regions()[t].0 as usize];
            for (l, volume) in self.cells.points(space, t) {
                if self.force != DVec3::ZERO {
                    let force = volume * self.force;
                    space.cell(t).zip(space.shape(l)).for_each(|(v, n)| forces[v as usize] += n * force);
                    continue;
                }
                let stress = self.stress(material).map(|s| volume * s);
                let (_, frame) = space.frame(t, l);
                let mut gradients = [DVec3::ZERO; 10];
                if space.midside().is_empty() {
                    gradients[..4].copy_from_slice(&frame);
                } else {
                    gradients = tet10::gradients(frame, l);
                }
                space.cell(t).zip(gradients).for_each(|(v, g)| forces[v as usize] += traction(stress, g));
            }
        }
    }

    /// The stress G by which `weight : s(u) = G : e(u)`.
    #[must_use]
    pub fn stress(&self, material: &Material) -> SymTensor {
        material.stress(self.weight)
    }

    /// How cell `t` belongs to it. Elements see of a force its linear part, of a stress that of the degree of their own.
    #[must_use]
    pub fn share(&self, space: &Space<'_>, t: usize) -> Share {
        let points = self.cells.points(space, t);
        let volume = space.mesh().cell_volume(t);
        let mut moments = [0.0; 4];
        for (l, weight) in &points {
            moments.iter_mut().zip(l).for_each(|(m, l)| *m += weight * l);
        }
        let inside: f64 = moments.iter().sum();
        let linear = self.force != DVec3::ZERO || !space.midside().is_empty();
        // The mass matrix V / 20 (I + 1 1^T) has the inverse 20 / V (I - 1 1^T / 5).
        let corner = |m: f64| if linear { 20.0 / volume * (m - inside / 5.0) } else { inside / volume };
        let corners = moments.map(corner);
        let approximated: f64 = corners.iter().zip(moments).map(|(c, m)| c * m).sum();
        let rest = inside - approximated;
        // Rounding, where all of the cell belongs to it or nothing.
        Share { points, corners, rest: if rest > 1e-12 * volume { rest } else { 0.0 } }
    }
}

/// The direction of a displacement.
fn direction(field: Field) -> Option<DVec3> {
    match field {
        Field::Ux => Some(DVec3::X),
        Field::Uy => Some(DVec3::Y),
        Field::Uz => Some(DVec3::Z),
        _ => None,
    }
}

/// The tensor whose double contraction with a stress is this component.
fn unit_tensor(field: Field) -> Option<SymTensor> {
    let component = [Field::Sxx, Field::Syy, Field::Szz, Field::Sxy, Field::Syz, Field::Sxz];
    let place = component.iter().position(|c| *c == field)?;
    let mut tensor = [0.0; 6];
    tensor[place] = if place < 3 { 1.0 } else { 0.5 };
    Some(tensor)
}
