//! Superconvergent patch recovery (Zienkiewicz and Zhu 1992, part 1): around each vertex a linear polynomial is fitted
//! by least squares to the stresses at the centroids of the cells, and evaluated at the vertex.
//!
//! With p = (1, (x - v) / h), v the vertex and h the largest distance of a centroid, the coefficients a of a stress
//! component solve (sum p p^T) a = sum p s; the value at the vertex is a_0. Small patches (corners, edges, some faces)
//! would extrapolate wildly, they are averaged instead.

use super::{Field, averaging};
use crate::fem::SymTensor;
use glam::DVec3;
use nalgebra::{Matrix4, Matrix4x6, SMatrix, Vector4};

/// Fewest cells that a polynomial is fitted to.
const MIN_CELLS: usize = 10;

/// Smallest ratio of the extreme eigenvalues of the normal matrix at which the fit is trusted. It is 0.04 to 0.18 around
/// inner vertices and 0.01 to 0.09 around boundary vertices of ordinary meshes; far below, the centroids lie near a plane.
const MIN_RATIO: f64 = 1e-3;

/// Recovers the stress at a vertex from the cells of one region around it.
pub(super) fn recover(field: &Field, vertex: u32, cells: &[u32]) -> SymTensor {
    let fitted = if cells.len() < MIN_CELLS { None } else { fit(field, vertex, cells) };
    fitted.unwrap_or_else(|| averaging::recover(field, cells))
}

/// The fitted polynomial's value at the vertex; `None` if the centroids do not determine it.
fn fit(field: &Field, vertex: u32, cells: &[u32]) -> Option<SymTensor> {
    let mesh = field.space.mesh();
    let origin = mesh.points()[vertex as usize];
    let centroid = |t: u32| mesh.cell_points(t as usize).into_iter().sum::<DVec3>() / 4.0 - origin;
    let size = cells.iter().map(|&t| centroid(t).length()).fold(0.0, f64::max);
    let (mut normal, mut right) = (Matrix4::zeros(), Matrix4x6::zeros());
    for &t in cells {
        let x = centroid(t) / size;
        let p = Vector4::new(1.0, x.x, x.y, x.z);
        let stress = SMatrix::<f64, 1, 6>::from_row_slice(&field.stress.mean(t as usize));
        normal += p * p.transpose();
        right += p * stress;
    }
    let eigenvalues = normal.symmetric_eigenvalues();
    let determined = eigenvalues.min() > MIN_RATIO * eigenvalues.max();
    if !determined {
        return None;
    }
    let coefficients = normal.cholesky()?.solve(&right);
    Some(std::array::from_fn(|i| coefficients[(0, i)]))
}
