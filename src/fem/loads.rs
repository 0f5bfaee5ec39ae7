//! Consistent nodal forces of the loads.

use super::{FemError, Load, LoadKind, Model, Space, quadrature, tet4};
use crate::field::{Field, VectorField};
use crate::mesh::features::face_normal;
use crate::mesh::{Face, GroupId, TetMesh};
use glam::DVec3;

/// The force at each node, `f_i = int N_i t dA + int N_i b dV`, summed in the order of the model.
pub(super) fn nodal_forces(space: &Space<'_>, model: &Model) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; space.points().len()];
    model.loads.iter().try_for_each(|load| add(space, model, load, &mut forces))?;
    Ok(forces)
}

/// The force of one load of a model at each node.
///
/// # Errors
/// [`FemError::NotFiniteAt`] names the point where an expression has no finite value.
pub fn load_forces(space: &Space<'_>, model: &Model, load: &Load) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; space.points().len()];
    add(space, model, load, &mut forces)?;
    Ok(forces)
}

fn add(space: &Space<'_>, model: &Model, load: &Load, forces: &mut [DVec3]) -> Result<(), FemError> {
    match &load.kind {
        LoadKind::Traction(group, field) => match field.constant() {
            Some(t) => add_to_faces(space, *group, forces, |normal| 0.5 * normal.length() * t),
            None => {
                integrate_faces(space, *group, forces, |normal, x| {
                    Ok(0.5 * normal.length() * vector(field, x, load)?)
                })?;
            }
        },
        LoadKind::Pressure(group, field) => match field.constant() {
            Some(p) => add_to_faces(space, *group, forces, |normal| -0.5 * p * normal),
            None => integrate_faces(space, *group, forces, |normal, x| Ok(-0.5 * scalar(field, x, load)? * normal))?,
        },
        LoadKind::Force(group, force) => {
            let traction = *force / group_area(space.mesh(), *group);
            add_to_faces(space, *group, forces, |normal| 0.5 * normal.length() * traction);
        }
        LoadKind::PointForce(x, force) => {
            let host = host(space.mesh(), *x);
            let shape = space.shape(host.weights);
            space.cell(host.cell).zip(shape).for_each(|(v, n)| forces[v as usize] += n * *force);
        }
        LoadKind::BodyForce(field) => match field.constant() {
            Some(b) => add_to_cells(space, forces, |_| b),
            None => integrate_cells(space, forces, |x| vector(field, x, load))?,
        },
        LoadKind::Gravity(acceleration) => {
            let density = |t: usize| model.materials[space.mesh().regions()[t].0 as usize].density;
            add_to_cells(space, forces, |t| density(t) * *acceleration);
        }
    }
    Ok(())
}

/// Gives each node of a face its share of the face's force, which is a function of its normal (twice the area long).
fn add_to_faces(space: &Space<'_>, group: GroupId, forces: &mut [DVec3], force: impl Fn(DVec3) -> DVec3) {
    let (mesh, shares) = (space.mesh(), space.face_means());
    for face in mesh.group_faces(group) {
        let force = force(face_normal(mesh.points(), face.vertices));
        space.face(face).zip(shares).for_each(|(v, share)| forces[v as usize] += share * force);
    }
}

/// Integrates `N_i` times a force, a function of the face's normal and of the place.
fn integrate_faces(
    space: &Space<'_>,
    group: GroupId,
    forces: &mut [DVec3],
    force: impl Fn(DVec3, DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    let mesh = space.mesh();
    for face in mesh.group_faces(group) {
        let normal = face_normal(mesh.points(), face.vertices);
        for (l, weight, x) in quadrature::triangle(corners(mesh, face)) {
            let force = weight * force(normal, x)?;
            space.face(face).zip(space.face_shape(l)).for_each(|(v, n)| forces[v as usize] += n * force);
        }
    }
    Ok(())
}

/// Gives each node of a cell its share of the cell's force; `density` is its force per volume.
fn add_to_cells(space: &Space<'_>, forces: &mut [DVec3], density: impl Fn(usize) -> DVec3) {
    let (mesh, shares) = (space.mesh(), space.cell_means());
    for t in 0..mesh.tets().len() {
        let force = mesh.cell_volume(t) * density(t);
        space.cell(t).zip(shares).for_each(|(v, share)| forces[v as usize] += share * force);
    }
}

/// Integrates `N_i` times a force per volume.
fn integrate_cells(
    space: &Space<'_>,
    forces: &mut [DVec3],
    density: impl Fn(DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    let mesh = space.mesh();
    for t in 0..mesh.tets().len() {
        let volume = mesh.cell_volume(t);
        for (l, weight, x) in quadrature::tetrahedron(mesh.cell_points(t)) {
            let force = weight * volume * density(x)?;
            space.cell(t).zip(space.shape(l)).for_each(|(v, n)| forces[v as usize] += n * force);
        }
    }
    Ok(())
}

fn corners(mesh: &TetMesh, face: &Face) -> [DVec3; 3] {
    face.vertices.map(|v| mesh.points()[v as usize])
}

fn group_area(mesh: &TetMesh, group: GroupId) -> f64 {
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), f.vertices).length()).sum()
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
