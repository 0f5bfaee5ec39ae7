//! Superconvergent patch recovery (Zienkiewicz and Zhu 1992, part 1): around each vertex a linear polynomial is fitted
//! by least squares to the stresses at the centroids of the cells, and evaluated at the vertex.
//!
//! With p = (1, (x - v) / h), v the vertex and h the largest distance of a centroid, the coefficients a of a stress
//! component solve (sum p p^T) a = sum p s; the value at the vertex is a_0. Small patches (corners, edges, some faces)
//! would extrapolate wildly, they are averaged instead.

use super::{Field, add_scaled, averaging};
use crate::fem::SymTensor;
use glam::DVec3;
use nalgebra::{Cholesky, Matrix4, U4, Vector4};

/// Fewest cells that a polynomial is fitted to.
const MIN_CELLS: usize = 10;

/// Smallest ratio of the extreme eigenvalues of the normal matrix at which the fit is trusted. It is 0.04 to 0.18 around
/// inner vertices and 0.01 to 0.09 around boundary vertices of ordinary meshes; far below, the centroids lie near a plane.
const MIN_RATIO: f64 = 1e-3;

/// Recovers the stress at a vertex from the cells of one region around it.
pub(super) fn recover(field: &Field, centroids: &[DVec3], vertex: u32, cells: &[u32]) -> SymTensor {
    let fitted = if cells.len() < MIN_CELLS { None } else { fit(field, centroids, vertex, cells) };
    fitted.unwrap_or_else(|| averaging::recover(field, cells))
}

/// The fitted polynomial's value at the vertex; `None` if the centroids do not determine it.
fn fit(field: &Field, centroids: &[DVec3], vertex: u32, cells: &[u32]) -> Option<SymTensor> {
    let origin = field.space.mesh().points()[vertex as usize];
    let centroid = |t: u32| centroids[t as usize] - origin;
    let size = cells.iter().map(|&t| centroid(t).length_squared()).fold(0.0, f64::max).sqrt();
    let monomials = |t: u32| {
        let x = centroid(t) / size;
        Vector4::new(1.0, x.x, x.y, x.z)
    };
    let mut normal = Matrix4::zeros();
    for p in cells.iter().map(|&t| monomials(t)) {
        normal += p * p.transpose();
    }
    let factor = normal.cholesky()?;
    if !(surely_determined(&normal, &factor) || is_determined(&normal)) {
        return None;
    }
    // a_0 is the first row of the inverse times sum p s: one weight a cell.
    let row = factor.solve(&Vector4::x());
    let mut value = [0.0; 6];
    for &t in cells {
        add_scaled(&mut value, row.dot(&monomials(t)), &field.stress.mean(t as usize));
    }
    Some(value)
}

/// Whether the extreme eigenvalues of a normal matrix are near enough.
fn is_determined(normal: &Matrix4<f64>) -> bool {
    let eigenvalues = normal.symmetric_eigenvalues();
    eigenvalues.min() > MIN_RATIO * eigenvalues.max()
}

/// Whether the determinant alone says that they are: with the trace T, the largest eigenvalue is at most T and the product of
/// the three others at most `(T / 3)^3`, so the smallest is at least `27 det / T^3`. It does so for nearly all patches, at a
/// tenth of the cost of the eigenvalues.
fn surely_determined(normal: &Matrix4<f64>, factor: &Cholesky<f64, U4>) -> bool {
    factor.determinant() * 27.0 > MIN_RATIO * normal.trace().powi(4)
}
