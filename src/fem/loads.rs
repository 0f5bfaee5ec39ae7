//! Consistent nodal forces of the loads.

use super::{FemError, Load, LoadKind, Model, quadrature, tet4};
use crate::field::{Field, VectorField};
use crate::mesh::features::face_normal;
use crate::mesh::{Face, GroupId, TetMesh};
use glam::DVec3;

/// The force at each node, `f_i = int N_i t dA + int N_i b dV`, summed in the order of the model.
pub(super) fn nodal_forces(mesh: &TetMesh, model: &Model) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; mesh.points().len()];
    model.loads.iter().try_for_each(|load| add(mesh, model, load, &mut forces))?;
    Ok(forces)
}

/// The force of one load of a model at each node.
///
/// # Errors
/// [`FemError::NotFiniteAt`] names the point where an expression has no finite value.
pub fn load_forces(mesh: &TetMesh, model: &Model, load: &Load) -> Result<Vec<DVec3>, FemError> {
    let mut forces = vec![DVec3::ZERO; mesh.points().len()];
    add(mesh, model, load, &mut forces)?;
    Ok(forces)
}

fn add(mesh: &TetMesh, model: &Model, load: &Load, forces: &mut [DVec3]) -> Result<(), FemError> {
    match &load.kind {
        LoadKind::Traction(group, field) => match field.constant() {
            Some(t) => add_to_faces(mesh, *group, forces, |normal| 0.5 * normal.length() * t),
            None => {
                integrate_faces(mesh, *group, forces, |normal, x| Ok(0.5 * normal.length() * vector(field, x, load)?))?;
            }
        },
        LoadKind::Pressure(group, field) => match field.constant() {
            Some(p) => add_to_faces(mesh, *group, forces, |normal| -0.5 * p * normal),
            None => integrate_faces(mesh, *group, forces, |normal, x| Ok(-0.5 * scalar(field, x, load)? * normal))?,
        },
        LoadKind::Force(group, force) => {
            let traction = *force / group_area(mesh, *group);
            add_to_faces(mesh, *group, forces, |normal| 0.5 * normal.length() * traction);
        }
        LoadKind::PointForce(x, force) => {
            let host = host(mesh, *x);
            for (v, weight) in mesh.tets()[host.cell].into_iter().zip(host.weights) {
                forces[v as usize] += weight * *force;
            }
        }
        LoadKind::BodyForce(field) => match field.constant() {
            Some(b) => add_to_cells(mesh, forces, |_| b),
            None => integrate_cells(mesh, forces, |x| vector(field, x, load))?,
        },
        LoadKind::Gravity(acceleration) => {
            let density = |t: usize| model.materials[mesh.regions()[t].0 as usize].density;
            add_to_cells(mesh, forces, |t| density(t) * *acceleration);
        }
    }
    Ok(())
}

/// Gives each corner of a face a third of the face's force, which is a function of its normal (twice the area long).
fn add_to_faces(mesh: &TetMesh, group: GroupId, forces: &mut [DVec3], force: impl Fn(DVec3) -> DVec3) {
    for face in mesh.group_faces(group) {
        let third = force(face_normal(mesh.points(), face.vertices)) / 3.0;
        for v in face.vertices {
            forces[v as usize] += third;
        }
    }
}

/// Integrates `N_i` times a force, a function of the face's normal and of the place.
fn integrate_faces(
    mesh: &TetMesh,
    group: GroupId,
    forces: &mut [DVec3],
    force: impl Fn(DVec3, DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    for face in mesh.group_faces(group) {
        let normal = face_normal(mesh.points(), face.vertices);
        for (shape, weight, x) in quadrature::triangle(corners(mesh, face)) {
            let force = weight * force(normal, x)?;
            for (v, n) in face.vertices.into_iter().zip(shape) {
                forces[v as usize] += n * force;
            }
        }
    }
    Ok(())
}

/// Gives each vertex of a cell a quarter of its force; `density` is its force per volume.
fn add_to_cells(mesh: &TetMesh, forces: &mut [DVec3], density: impl Fn(usize) -> DVec3) {
    for (t, tet) in mesh.tets().iter().enumerate() {
        let quarter = 0.25 * mesh.cell_volume(t) * density(t);
        for &v in tet {
            forces[v as usize] += quarter;
        }
    }
}

/// Integrates `N_i` times a force per volume.
fn integrate_cells(
    mesh: &TetMesh,
    forces: &mut [DVec3],
    density: impl Fn(DVec3) -> Result<DVec3, FemError>,
) -> Result<(), FemError> {
    for (t, tet) in mesh.tets().iter().enumerate() {
        let volume = mesh.cell_volume(t);
        for (shape, weight, x) in quadrature::tetrahedron(mesh.cell_points(t)) {
            let force = weight * volume * density(x)?;
            for (&v, n) in tet.iter().zip(shape) {
                forces[v as usize] += n * force;
            }
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
