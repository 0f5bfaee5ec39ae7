//! Consistent nodal forces of the loads.

use super::{FemError, Load, LoadKind, Model, Space, tet4};
use crate::field::{Field, VectorField};
use crate::mesh::{GroupId, TetMesh};
use glam::DVec3;

/// Takes a quadrature point of a face: the functions there with their values, place, and outward area vector.
pub type OnFace<'a> = dyn FnMut(&[(u32, f64)], DVec3, DVec3) -> Result<(), FemError> + 'a;

/// Takes a quadrature point of a cell: cell, the functions there with their values, place, and volume.
pub type InCell<'a> = dyn FnMut(usize, &[(u32, f64)], DVec3, f64) -> Result<(), FemError> + 'a;

/// What loads need of the elements of a mesh, whatever their cells: integrals over boundary faces and cells by quadrature.
pub trait Integrals {
    /// Number of functions: nodes.
    fn functions(&self) -> usize;
    /// Region of a cell.
    fn region(&self, cell: usize) -> usize;
    /// Visits quadrature points of a group's faces.
    ///
    /// # Errors
    /// The visitor's.
    fn on_faces(&self, group: GroupId, visit: &mut OnFace<'_>) -> Result<(), FemError>;
    /// Visits quadrature points of all cells.
    ///
    /// # Errors
    /// The visitor's.
    fn in_cells(&self, visit: &mut InCell<'_>) -> Result<(), FemError>;
    /// The functions at a place in the body, or at its point nearest to it.
    fn at_place(&self, x: DVec3) -> Vec<(u32, f64)>;
}

impl Integrals for Space<'_> {
    fn functions(&self) -> usize {
        self.points().len()
    }

    fn region(&self, cell: usize) -> usize {
        self.mesh().regions()[cell].0 as usize
    }

    fn on_faces(&self, group: GroupId, visit: &mut OnFace<'_>) -> Result<(), FemError> {
        let mut functions = Vec::new();
        for face in self.mesh().group_faces(group) {
            for (l, x, area) in self.face_rule(face) {
                functions.clear();
                functions.extend(self.face(face).zip(self.face_shape(l)));
                visit(&functions, x, area)?;
            }
        }
        Ok(())
    }

    fn in_cells(&self, visit: &mut InCell<'_>) -> Result<(), FemError> {
        let mut functions = Vec::new();
        for t in 0..self.mesh().tets().len() {
            for (l, x, volume) in self.cell_rule(t) {
                functions.clear();
                functions.extend(self.cell(t).zip(self.shape(l)));
                visit(t, &functions, x, volume)?;
            }
        }
        Ok(())
    }

    fn at_place(&self, x: DVec3) -> Vec<(u32, f64)> {
        let host = host(self.mesh(), x);
        self.cell(host.cell).zip(self.shape(host.weights)).collect()
    }
}

/// The force at each node, `f_i = int N_i t dA + int N_i b dV`, summed in the order of the model.
pub(super) fn nodal_forces(space: &impl Integrals, model: &Model) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; space.functions()];
    model.loads.iter().try_for_each(|load| add(space, model, load, &mut forces))?;
    Ok(forces)
}

/// The force of one load of a model at each node.
///
/// # Errors
/// [`FemError::NotFiniteAt`] names the point where an expression has no finite value.
pub fn load_forces(space: &impl Integrals, model: &Model, load: &Load) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; space.functions()];
    add(space, model, load, &mut forces)?;
    Ok(forces)
}

fn add(space: &impl Integrals, model: &Model, load: &Load, forces: &mut [DVec3]) -> Result<(), FemError> {
    match &load.kind {
        LoadKind::Traction(group, field) => {
            integrate_faces(space, *group, forces, |area, x| Ok(area.length() * vector(field, x, load)?))?;
        }
        LoadKind::Pressure(group, field) => {
            integrate_faces(space, *group, forces, |area, x| Ok(-scalar(field, x, load)? * area))?;
        }
        LoadKind::Force(group, force) => {
            let traction = *force / group_area(space, *group);
            integrate_faces(space, *group, forces, |area, _| Ok(area.length() * traction))?;
        }
        LoadKind::PointForce(x, force) => {
            space.at_place(*x).into_iter().for_each(|(v, n)| forces[v as usize] += n * *force);
        }
        LoadKind::BodyForce(field) => integrate_cells(space, forces, |_, x| vector(field, x, load))?,
        LoadKind::Gravity(acceleration) => {
            let density = |t: usize| model.materials[space.region(t)].density;
            integrate_cells(space, forces, |t, _| Ok(density(t) * *acceleration))?;
        }
    }
    Ok(())
}

/// Integrates `N_i` times a force, a function of the outward area vector and of the place.
pub(super) fn integrate_faces(
    space: &impl Integrals,
    group: GroupId,
    forces: &mut [DVec3],
    force: impl Fn(DVec3, DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    space.on_faces(group, &mut |functions, x, area| {
        let force = force(area, x)?;
        functions.iter().for_each(|(v, n)| forces[*v as usize] += *n * force);
        Ok(())
    })
}

/// Integrates `N_i` times a force per volume, a function of the cell and of the place.
pub(super) fn integrate_cells(
    space: &impl Integrals,
    forces: &mut [DVec3],
    density: impl Fn(usize, DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    space.in_cells(&mut |t, functions, x, volume| {
        let force = volume * density(t, x)?;
        functions.iter().for_each(|(v, n)| forces[*v as usize] += *n * force);
        Ok(())
    })
}

/// The area of the faces of a group.
pub(super) fn group_area(space: &impl Integrals, group: GroupId) -> f64 {
    let mut sum = 0.0;
    // The visitor has no errors.
    let _ = space.on_faces(group, &mut |_, _, area| {
        sum += area.length();
        Ok(())
    });
    sum
}

/// The value of a load's field.
fn scalar(field: &Field, x: DVec3, load: &Load) -> Result<f64, FemError> {
    let value = field.at(x);
    if value.is_finite() { Ok(value) } else { Err(FemError::not_finite_at("load", &load.name, field, x)) }
}

fn vector(field: &VectorField, x: DVec3, load: &Load) -> Result<DVec3, FemError> {
    let [fx, fy, fz] = &field.0;
    Ok(DVec3::new(scalar(fx, x, load)?, scalar(fy, x, load)?, scalar(fz, x, load)?))
}

/// The cell that holds a point, or the nearest to holding it.
struct Host {
    cell: usize,
    /// Shape functions there; not negative, with sum one.
    weights: [f64; 4],
    /// How far the point lies outside the planes of the cell's faces; zero inside.
    outside: f64,
}

/// How far a point lies outside the mesh: outside the planes of the faces of its nearest cell.
#[must_use]
pub fn distance_outside(mesh: &TetMesh, x: DVec3) -> f64 {
    host(mesh, x).outside
}

/// Finds the cell that holds a point; the first of several. A point that refinement has left outside a moved boundary
/// counts for the nearest cell.
fn host(mesh: &TetMesh, x: DVec3) -> Host {
    let mut best = Host { cell: 0, weights: [0.25; 4], outside: f64::INFINITY };
    for t in 0..mesh.tets().len() {
        let points = mesh.cell_points(t);
        let (_, gradients) = tet4::gradients(points);
        let n: [f64; 4] = std::array::from_fn(|i| 1.0 + gradients[i].dot(x - points[i]));
        let outside = (0..4).map(|i| -n[i] / gradients[i].length()).fold(0.0, f64::max);
        if outside < best.outside {
            let weights = n.map(|n| n.max(0.0));
            let sum: f64 = weights.iter().sum();
            best = Host { cell: t, weights: weights.map(|w| w / sum), outside };
        }
        if best.outside == 0.0 {
            break;
        }
    }
    best
}
