//! The data of a problem point by point: what acts in its cells and on its faces, and what holds these.
//!
//! Assembly knows nodal forces only; estimates compare the stress with the forces that are to be balanced.

use super::goal::{Goal, InCells};
use super::loads::group_area;
use super::{Exact, Load, LoadKind, Material, Model, Space, traction};
use crate::field::{Field, VectorField};
use crate::mesh::{Face, GroupId};
use glam::DVec3;

/// The data of a problem on a mesh. Forces at points, which no stress balances, are not among them.
pub struct Data<'a> {
    /// The mesh and its nodes.
    pub space: &'a Space<'a>,
    /// Materials, supports and loads.
    pub model: &'a Model,
    exact: Option<&'a Exact>,
    in_cells: Option<&'a InCells>,
    /// What acts on and holds the faces of each patch.
    patches: Vec<OnPatch<'a>>,
}

/// What acts on and holds the faces of a patch.
#[derive(Default)]
struct OnPatch<'a> {
    tractions: Vec<Traction<'a>>,
    held: [Option<&'a Field>; 3],
    stiffness: DVec3,
}

/// A force per area.
enum Traction<'a> {
    Constant(DVec3),
    Field(&'a VectorField),
    Pressure(&'a Field),
    Exact(&'a Exact),
}

impl<'a> Data<'a> {
    /// The data of a model; a known solution brings its own loads.
    #[must_use]
    pub fn new(space: &'a Space<'a>, model: &'a Model, exact: Option<&'a Exact>) -> Self {
        let areas: Vec<f64> = model.loads.iter().map(|load| spread_over(space, load)).collect();
        let of_patch = |groups: &Vec<GroupId>| on_patch(model, exact, groups, &areas);
        let patches = space.mesh().patch_groups().iter().map(of_patch).collect();
        Self { space, model, exact, in_cells: None, patches }
    }

    /// The data of the dual problem of a goal.
    #[must_use]
    pub fn of_goal(space: &'a Space<'a>, goal: &'a Goal) -> Self {
        Self { in_cells: goal.in_cells.as_ref(), ..Self::new(space, &goal.model, None) }
    }

    /// The material of cell `t`.
    #[must_use]
    pub fn material(&self, t: usize) -> &'a Material {
        &self.model.materials[self.space.mesh().regions()[t].0 as usize]
    }

    /// The means that a goal takes over cells.
    #[must_use]
    pub fn in_cells(&self) -> Option<&'a InCells> {
        self.in_cells
    }

    /// Force per volume at a point of cell `t`.
    #[must_use]
    pub fn body_force(&self, t: usize, x: DVec3) -> DVec3 {
        let of_load = |load: &Load| match &load.kind {
            LoadKind::BodyForce(field) => field.at(x),
            LoadKind::Gravity(acceleration) => self.material(t).density * *acceleration,
            _ => DVec3::ZERO,
        };
        let exact = self.exact.map_or(DVec3::ZERO, |e| e.body_force(x));
        self.model.loads.iter().map(of_load).sum::<DVec3>() + exact
    }

    /// Whether the force per volume may vary within a cell.
    #[must_use]
    pub fn body_force_varies(&self) -> bool {
        let varies = |load: &Load| matches!(&load.kind, LoadKind::BodyForce(field) if field.constant().is_none());
        self.exact.is_some() || self.model.loads.iter().any(varies)
    }

    /// Force per area of the loads at a point of a boundary face with this outward unit normal.
    #[must_use]
    pub fn traction(&self, face: &Face, x: DVec3, normal: DVec3) -> DVec3 {
        let one = |t: &Traction<'_>| match t {
            Traction::Constant(t) => *t,
            Traction::Field(field) => field.at(x),
            Traction::Pressure(field) => -field.at(x) * normal,
            Traction::Exact(exact) => traction(exact.stress(x), normal),
        };
        self.on(face).tractions.iter().map(one).sum()
    }

    /// Whether the force per area may vary within a face.
    #[must_use]
    pub fn traction_varies(&self, face: &Face) -> bool {
        self.on(face).tractions.iter().any(|t| match t {
            Traction::Constant(_) => false,
            Traction::Field(field) => field.constant().is_none(),
            Traction::Pressure(field) => field.constant().is_none(),
            Traction::Exact(_) => true,
        })
    }

    /// The displacement prescribed on a boundary face, by components.
    #[must_use]
    pub fn held(&self, face: &Face) -> [Option<&'a Field>; 3] {
        self.on(face).held
    }

    /// Stiffness of the elastic foundations of a boundary face, force per area and displacement.
    #[must_use]
    pub fn stiffness(&self, face: &Face) -> DVec3 {
        self.on(face).stiffness
    }

    fn on(&self, face: &Face) -> &OnPatch<'a> {
        &self.patches[face.patch.0 as usize]
    }
}

/// The area that a total force is spread over.
fn spread_over(space: &Space<'_>, load: &Load) -> f64 {
    if let LoadKind::Force(group, _) = load.kind { group_area(space, group) } else { 0.0 }
}

fn on_patch<'a>(model: &'a Model, exact: Option<&'a Exact>, groups: &[GroupId], areas: &[f64]) -> OnPatch<'a> {
    let mut patch = OnPatch::default();
    for (load, area) in model.loads.iter().zip(areas) {
        let (group, traction) = match &load.kind {
            LoadKind::Traction(group, field) => (group, Traction::Field(field)),
            LoadKind::Pressure(group, field) => (group, Traction::Pressure(field)),
            LoadKind::Force(group, force) => (group, Traction::Constant(*force / *area)),
            LoadKind::PointForce(..) | LoadKind::BodyForce(_) | LoadKind::Gravity(_) => continue,
        };
        if groups.contains(group) {
            patch.tractions.push(traction);
        }
    }
    let known = exact.filter(|e| e.tractions.is_some_and(|group| groups.contains(&group)));
    patch.tractions.extend(known.map(Traction::Exact));
    // Supports of edges hold no face.
    for support in model.supports.iter().filter(|s| s.meets.is_none() && groups.contains(&s.group)) {
        patch.stiffness += support.stiffness;
        for (held, field) in patch.held.iter_mut().zip(&support.displacement) {
            *held = held.or(field.as_ref());
        }
    }
    patch
}
