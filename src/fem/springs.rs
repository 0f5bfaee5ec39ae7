//! Elastic foundations: force per area `-k u` on the faces of a support, k diagonal.

use super::block_matrix::BlockMatrix;
use super::{Model, Space, Support};
use crate::mesh::Face;
use glam::{DMat3, DVec3};

/// Adds `int N_i N_j k dA` to the stiffness.
pub(super) fn add(space: &Space<'_>, model: &Model, stiffness: &mut BlockMatrix) {
    for support in model.supports.iter().filter(|s| s.stiffness != DVec3::ZERO) {
        for face in space.mesh().group_faces(support.group) {
            for (i, row) in space.face(face).zip(shape_products(space, face)) {
                for (j, product) in space.face(face).zip(row) {
                    if let Some(block) = stiffness.block_mut(i, j) {
                        *block += DMat3::from_diagonal(product * support.stiffness);
                    }
                }
            }
        }
    }
}

/// Integrals of `N_i N_j` over a face.
fn shape_products(space: &Space<'_>, face: &Face) -> [[f64; 6]; 6] {
    let mut products = [[0.0; 6]; 6];
    for (l, _, area) in space.face_rule(face) {
        let (shape, weight) = (space.face_shape(l), area.length());
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
    let mut force = DVec3::ZERO;
    for face in space.mesh().group_faces(support.group) {
        for (l, _, area) in space.face_rule(face) {
            let moved: DVec3 = space.face(face).zip(space.face_shape(l)).map(|(v, n)| n * u[v as usize]).sum();
            force -= area.length() * support.stiffness * moved;
        }
    }
    force
}
