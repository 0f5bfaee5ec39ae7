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

#[cfg(test)]
mod tests {
    use super::super::options::{Element, Method, SolverOptions};
    use super::super::{Data, Kept, State, Support, assemble, load_forces, recover, solve_keeping};
    use super::*;
    use crate::mesh::generate::box_tets;
    use crate::mesh::locate::Locator;
    use crate::mesh::{GroupId, RegionId, TetMesh};

    /// A box of two materials that meet at x = 1.
    fn two_materials() -> TetMesh {
        let mut parts = box_tets([2.0, 1.0, 1.0], [4, 2, 3]).unwrap().into_parts();
        let middle = |tet: &[u32; 4]| tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        parts.regions = parts.tets.iter().map(|t| RegionId(u16::from(middle(t) > 1.0))).collect();
        parts.region_names = vec!["hard".to_owned(), "soft".to_owned()];
        TetMesh::new(parts).unwrap()
    }

    fn group(mesh: &TetMesh, name: &str) -> GroupId {
        mesh.group(name).unwrap()
    }

    fn model(mesh: &TetMesh) -> Model {
        let hard = Material { youngs_modulus: 9.0, poissons_ratio: 0.2, density: 0.0 };
        let soft = Material { youngs_modulus: 2.0, poissons_ratio: 0.4, ..hard };
        let bed =
            Support { stiffness: DVec3::new(0.5, 0.0, 2.0), ..Support::new("bed", group(mesh, "z-min"), [None; 3]) };
        let clamp = Support::new("clamp", group(mesh, "x-min"), [Some(0.0); 3]);
        let load = |kind| Load { name: "load".to_owned(), kind };
        let loads = vec![
            load(LoadKind::Traction(group(mesh, "x-max"), VectorField::from(DVec3::new(0.3, 0.1, -0.4)))),
            load(LoadKind::BodyForce(VectorField::from(DVec3::new(0.0, 0.2, -0.1)))),
        ];
        Model { materials: vec![hard, soft], supports: vec![clamp, bed], loads }
    }

    /// Betti's theorem: where nothing is moved, a quantity is the work of the loads on its dual solution.
    #[test]
    fn a_quantity_is_the_work_of_the_loads_on_its_dual_solution() {
        let mesh = two_materials();
        let model = model(&mesh);
        let within = Some([DVec3::new(0.4, 0.1, 0.2), DVec3::new(1.3, 0.8, 0.9)]);
        let kinds = [
            QuantityKind::Average(Field::Uy, Extent::Faces(group(&mesh, "x-max"))),
            QuantityKind::Average(Field::Uz, Extent::Cells(Cells { region: None, within })),
            QuantityKind::Average(Field::Sxy, Extent::Cells(Cells { region: None, within })),
            QuantityKind::Average(Field::Szz, Extent::Cells(Cells { region: Some(RegionId(1)), within: None })),
            QuantityKind::Reaction(0, 0),
            QuantityKind::Reaction(0, 2),
            QuantityKind::Reaction(1, 2),
        ];
        for (element, method) in [(Element::Tet4, Method::Direct), (Element::Tet10, Method::AmgCg)] {
            let space = Space::new(&mesh, element, &[]);
            let options = SolverOptions { method, tolerance: 1e-12, ..SolverOptions::default() };
            let mut kept = Kept::default();
            let mut system = assemble(&space, &model).unwrap();
            let solved = solve_keeping(&system, &options, None, &mut kept).unwrap();
            let solution = recover(&space, &model, &system, &solved);
            let state = State { space: &space, model: &model, solution: &solution, recovered: &|_| [[0.0; 6]; 10] };
            let locator = Locator::new(&mesh);
            for kind in kinds {
                let goal = Goal::new(&space, &model, kind).unwrap();
                system = goal.system(&space, system).unwrap();
                let dual = solve_keeping(&system, &options, None, &mut kept).unwrap().displacement;
                let mut work = 0.0;
                for load in &model.loads {
                    let forces = load_forces(&space, &model, load).unwrap();
                    work += forces.iter().zip(&dual).map(|(f, z)| f.dot(*z)).sum::<f64>();
                }
                let value = state.value(kind, &|p| locator.nearest(p));
                assert!((work - value).abs() < 1e-9 * value.abs().max(0.1), "{element:?} {kind:?}: {work} {value}");
            }
        }
    }

    /// The indicator of a box is approximated best: its rest is orthogonal to what the elements see, and vanishes inside and
    /// outside.
    #[test]
    fn shares_add_up_to_the_box() {
        let mesh = two_materials();
        let within = Some([DVec3::new(0.4, 0.1, 0.2), DVec3::new(1.3, 0.8, 0.9)]);
        let kind = |field| QuantityKind::Average(field, Extent::Cells(Cells { region: None, within }));
        for (element, field) in [(Element::Tet4, Field::Sxx), (Element::Tet4, Field::Ux), (Element::Tet10, Field::Sxx)]
        {
            let space = Space::new(&mesh, element, &[]);
            let goal = Goal::new(&space, &model(&mesh), kind(field)).unwrap();
            let data = Data::of_goal(&space, &goal);
            let (mut volume, mut cut) = (0.0, 0);
            for t in 0..mesh.tets().len() {
                let share = data.in_cells().unwrap().share(&space, t);
                volume += mesh.cell_volume(t) * share.corners.iter().sum::<f64>() / 4.0;
                let inside: f64 = share.points.iter().map(|(_, w)| w).sum();
                let is_cut = inside > 1e-9 && inside < mesh.cell_volume(t) - 1e-9;
                assert_eq!(share.rest > 0.0, is_cut, "cell {t}");
                cut += usize::from(is_cut);
            }
            assert!((volume - 0.9 * 0.7 * 0.7).abs() < 1e-12 && cut > 20, "{volume} {cut}");
        }
    }
}
