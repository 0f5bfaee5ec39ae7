//! Elastic foundations: force per area `-k u` on the faces of a support, k diagonal.

use super::block_matrix::BlockMatrix;
use super::{Model, Support};
use crate::mesh::features::face_normal;
use crate::mesh::{Face, TetMesh};
use glam::{DMat3, DVec3};

/// Adds `int N_i N_j k dA` to the stiffness; `int N_i N_j dA` is A / 12, twice that for i = j.
pub(super) fn add(mesh: &TetMesh, model: &Model, stiffness: &mut BlockMatrix) {
    for support in model.supports.iter().filter(|s| s.stiffness != DVec3::ZERO) {
        for face in mesh.group_faces(support.group) {
            let twelfth = DMat3::from_diagonal(area(mesh, face) / 12.0 * support.stiffness);
            for i in face.vertices {
                for j in face.vertices {
                    if let Some(block) = stiffness.block_mut(i, j) {
                        *block += if i == j { 2.0 * twelfth } else { twelfth };
                    }
                }
            }
        }
    }
}

/// The force that the foundation of a support exerts on the solid.
pub(super) fn reaction(mesh: &TetMesh, support: &Support, u: &[DVec3]) -> DVec3 {
    if support.stiffness == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let mut force = DVec3::ZERO;
    for face in mesh.group_faces(support.group) {
        let sum: DVec3 = face.vertices.iter().map(|&v| u[v as usize]).sum();
        force -= area(mesh, face) / 3.0 * support.stiffness * sum;
    }
    force
}

fn area(mesh: &TetMesh, face: &Face) -> f64 {
    0.5 * face_normal(mesh.points(), face.vertices).length()
}
