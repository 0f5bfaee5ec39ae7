//! The four-node tetrahedron with linear shape functions N_i: gradients, stiffness, strain.

use super::SymTensor;
use crate::mesh::quality;
use glam::{DMat3, DVec3};

/// Volume and gradients of the four shape functions of a positive tetrahedron.
///
/// With `n_i` the outward normal of the face opposite to vertex i, twice its area long, `grad N_i = -n_i / (6 V)`.
#[must_use]
pub fn gradients(p: [DVec3; 4]) -> (f64, [DVec3; 4]) {
    let volume = quality::volume(p);
    let scale = -1.0 / (6.0 * volume);
    (volume, quality::face_normals(p).map(|n| scale * n))
}

/// The 3x3 block of the element stiffness between nodes i and j,
/// `K_ij = V (lambda g_i g_j^T + mu g_j g_i^T + mu (g_i . g_j) I)`, given `V lambda`, `V mu` and the gradients.
///
/// Every product is formed so that `K_ji` is the transpose of `K_ij` to the last bit.
#[must_use]
pub fn stiffness_block(lambda: f64, mu: f64, gi: DVec3, gj: DVec3) -> DMat3 {
    let shear = mu * gi.dot(gj);
    let column = |b: usize, unit: DVec3| lambda * (gi * gj[b]) + mu * (gi[b] * gj) + shear * unit;
    DMat3::from_cols(column(0, DVec3::X), column(1, DVec3::Y), column(2, DVec3::Z))
}

/// The strain of nodal displacements, `e = sum_i sym(u_i g_i^T)`, from pairs of gradient and displacement.
#[must_use]
pub fn strain(nodes: impl Iterator<Item = (DVec3, DVec3)>) -> SymTensor {
    let mut e = [0.0; 6];
    for (g, u) in nodes {
        e[0] += u.x * g.x;
        e[1] += u.y * g.y;
        e[2] += u.z * g.z;
        e[3] += 0.5 * (u.x * g.y + u.y * g.x);
        e[4] += 0.5 * (u.y * g.z + u.z * g.y);
        e[5] += 0.5 * (u.x * g.z + u.z * g.x);
    }
    e
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Material;
    use nalgebra::{Matrix6, SMatrix, SymmetricEigen};
    use proptest::prelude::*;

    const RUBBER: Material = Material { youngs_modulus: 2.0, poissons_ratio: 0.4, density: 1.0 };

    /// The 12x12 stiffness from the blocks.
    fn stiffness(p: [DVec3; 4]) -> SMatrix<f64, 12, 12> {
        let (volume, g) = gradients(p);
        let block = |i: usize, j: usize| stiffness_block(volume * RUBBER.lambda(), volume * RUBBER.mu(), g[i], g[j]);
        SMatrix::from_fn(|r, c| block(r / 3, c / 3).col(c % 3)[r % 3])
    }

    /// The same from V B^T D B with Voigt's engineering shears; gradients from the inverse of the matrix [1 x y z].
    fn stiffness_by_voigt(p: [DVec3; 4]) -> SMatrix<f64, 12, 12> {
        let vandermonde = nalgebra::Matrix4::from_fn(|i, j| if j == 0 { 1.0 } else { p[i][j - 1] });
        let inverse = vandermonde.try_inverse().unwrap();
        let g = |node: usize, axis: usize| inverse[(axis + 1, node)];
        let mut b = SMatrix::<f64, 6, 12>::zeros();
        for i in 0..4 {
            for a in 0..3 {
                b[(a, 3 * i + a)] = g(i, a);
            }
            for (row, [a, c]) in [(3, [0, 1]), (4, [1, 2]), (5, [0, 2])] {
                b[(row, 3 * i + a)] = g(i, c);
                b[(row, 3 * i + c)] = g(i, a);
            }
        }
        let (lambda, mu) = (RUBBER.lambda(), RUBBER.mu());
        let d = Matrix6::from_fn(|r, c| {
            let volumetric = if r < 3 && c < 3 { lambda } else { 0.0 };
            let own = if r == c { if r < 3 { 2.0 * mu } else { mu } } else { 0.0 };
            volumetric + own
        });
        vandermonde.determinant() / 6.0 * b.transpose() * d * b
    }

    /// Random tetrahedra of positive, not tiny, volume.
    fn tets() -> impl Strategy<Value = [DVec3; 4]> {
        proptest::array::uniform12(-1.0..1.0_f64).prop_filter_map("too flat", |x| {
            let mut p: [DVec3; 4] = std::array::from_fn(|i| DVec3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2]));
            if quality::volume(p) < 0.0 {
                p.swap(2, 3);
            }
            (quality::volume(p) > 0.02).then_some(p)
        })
    }

    proptest! {
        #[test]
        fn stiffness_is_the_integral_of_bt_c_b(p in tets()) {
            let (k, oracle) = (stiffness(p), stiffness_by_voigt(p));
            prop_assert!((k - oracle).norm() < 1e-11 * oracle.norm());
            prop_assert_eq!(k, k.transpose());
        }

        #[test]
        fn kernel_is_the_six_rigid_modes(p in tets()) {
            let k = stiffness(p);
            for mode in 0..6 {
                let motion = |x: DVec3| if mode < 3 { DVec3::AXES[mode] } else { DVec3::AXES[mode - 3].cross(x) };
                let u = SMatrix::<f64, 12, 1>::from_fn(|r, _| motion(p[r / 3])[r % 3]);
                prop_assert!((u.transpose() * k * u)[0].abs() < 1e-12 * k.norm());
            }
            let mut values: Vec<f64> = SymmetricEigen::new(k).eigenvalues.iter().copied().collect();
            values.sort_by(f64::total_cmp);
            prop_assert!(values[5].abs() < 1e-10 * values[11] && values[6] > 1e-6 * values[11]);
        }

        #[test]
        fn strain_of_an_affine_field_is_its_symmetric_gradient(p in tets(), a in proptest::array::uniform9(-1.0..1.0_f64)) {
            let m = DMat3::from_cols_array(&a);
            let e = strain(gradients(p).1.into_iter().zip(p.map(|x| m * x + DVec3::ONE)));
            let s = (m + m.transpose()) * 0.5;
            let expected = [s.x_axis.x, s.y_axis.y, s.z_axis.z, s.x_axis.y, s.y_axis.z, s.x_axis.z];
            for i in 0..6 {
                prop_assert!((e[i] - expected[i]).abs() < 1e-12 / gradients(p).0);
            }
        }
    }
}
