//! Elastic foundations: force per area `-k u` on the faces of a support, k diagonal.

use super::block_matrix::BlockMatrix;
use super::{Model, Space, Support, quadrature};
use crate::mesh::features::face_normal;
use glam::{DMat3, DVec3};

/// Adds `int N_i N_j k dA` to the stiffness.
pub(super) fn add(space: &Space<'_>, model: &Model, stiffness: &mut BlockMatrix) {
    let mesh = space.mesh();
    let products = shape_products(space);
    for support in model.supports.iter().filter(|s| s.stiffness != DVec3::ZERO) {
        for face in mesh.group_faces(support.group) {
            let area = 0.5 * face_normal(mesh.points(), face.vertices).length();
            for (i, row) in space.face(face).zip(products) {
                for (j, product) in space.face(face).zip(row) {
                    if let Some(block) = stiffness.block_mut(i, j) {
                        *block += DMat3::from_diagonal(area * product * support.stiffness);
                    }
                }
            }
        }
    }
}

/// Means of `N_i N_j` over a face.
fn shape_products(space: &Space<'_>) -> [[f64; 6]; 6] {
    let mut products = [[0.0; 6]; 6];
    for (l, weight, _) in quadrature::triangle([DVec3::ZERO; 3]) {
        let shape = space.face_shape(l);
        for (row, a) in products.iter_mut().zip(shape) {
            row.iter_mut().zip(shape).for_each(|(product, b)| *product += weight * (a * b));
        }
    }
    products
}

/// The force that the foundation of a support exerts on the solid.
pub(super) fn reaction(space: &Space<'_>, support: &Support, u: &[DVec3]) -> DVec3 {
    if support.stiffness == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let (mesh, means) = (space.mesh(), space.face_means());
    let mut force = DVec3::ZERO;
    for face in mesh.group_faces(support.group) {
        let area = 0.5 * face_normal(mesh.points(), face.vertices).length();
        let mean: DVec3 = space.face(face).zip(means).map(|(v, n)| n * u[v as usize]).sum();
        force -= area * support.stiffness * mean;
    }
    force
}
