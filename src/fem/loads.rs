//! Consistent nodal forces of the loads.

use super::{LoadKind, Model};
use crate::mesh::features::face_normal;
use crate::mesh::{GroupId, TetMesh};
use glam::DVec3;

/// The force at each node, `f_i = int N_i t dA + int N_i rho g dV`, summed in the order of the model.
pub(super) fn nodal_forces(mesh: &TetMesh, model: &Model) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; mesh.points().len()];
    for load in &model.loads {
        match load.kind {
            LoadKind::Traction(group, traction) => {
                add_to_faces(mesh, group, &mut forces, |normal| 0.5 * normal.length() * traction);
            }
            LoadKind::Pressure(group, pressure) => {
                add_to_faces(mesh, group, &mut forces, |normal| -0.5 * pressure * normal);
            }
            LoadKind::Force(group, force) => {
                let traction = force / group_area(mesh, group);
                add_to_faces(mesh, group, &mut forces, |normal| 0.5 * normal.length() * traction);
            }
            LoadKind::Gravity(acceleration) => add_gravity(mesh, model, acceleration, &mut forces),
        }
    }
    forces
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

fn group_area(mesh: &TetMesh, group: GroupId) -> f64 {
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), f.vertices).length()).sum()
}

/// Gives each vertex of a cell a quarter of the cell's weight.
fn add_gravity(mesh: &TetMesh, model: &Model, acceleration: DVec3, forces: &mut [DVec3]) {
    for (t, (tet, region)) in mesh.tets().iter().zip(mesh.regions()).enumerate() {
        let mass = model.materials[region.0 as usize].density * mesh.cell_volume(t);
        for &v in tet {
            forces[v as usize] += 0.25 * mass * acceleration;
        }
    }
}
