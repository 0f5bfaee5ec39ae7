//! At a vertex of the control mesh.

use super::map::{CharacteristicMap, extended};
use super::reference::{Place, Reference, UNITS};
use super::spheres::Sphere;
use glam::DVec3;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// What was found at a vertex.
#[derive(Debug, Clone)]
pub struct VertexAnalysis {
    /// Eigenvalues of the matrix of the vertex and its neighbours, which are real, by descending absolute value; the first is 1.
    pub eigenvalues: Vec<f64>,
    /// How far this matrix is from the symmetric one that it is similar to.
    pub asymmetry: f64,
    /// The map of the eigenvectors 1 to 3.
    pub map: CharacteristicMap,
}

impl VertexAnalysis {
    /// By how much the third eigenvalue after the first exceeds the fourth.
    #[must_use]
    pub fn gap(&self) -> f64 {
        self.eigenvalues[3].abs() - self.eigenvalues[4].abs()
    }

    /// Whether the eigenvalues are in the order 1 > lambda1 >= lambda2 >= lambda3 > lambda4, and the map inverts no cell.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.eigenvalues[1] < 1.0 && self.eigenvalues[3] > 0.0 && self.gap() > 1e-12 && self.map.is_regular()
    }
}

/// Analyses the vertex whose tetrahedra are the cones over the triangles of a sphere.
#[must_use]
pub fn analyse_vertex(link: &Sphere) -> VertexAnalysis {
    let count = link.vertices();
    let tets = link.triangles().into_iter().map(|t| t.map(|v| 1 + u32::from(v)));
    let reference = Reference::new(1 + count, tets.map(|[a, b, c]| [0, a, b, c]).collect());
    let centre: Place = [vec![UNITS], vec![0; count]].concat();
    let middle = reference.at(&centre);
    let ring = reference.around(&[middle], 1);
    let matrix = reference.matrix(&ring, &centre);
    let scales = symmetrising(&matrix, ring.binary_search(&middle).unwrap_or(0));
    let symmetric = DMatrix::from_fn(ring.len(), ring.len(), |i, j| matrix[(i, j)] * scales[i] / scales[j]);
    let asymmetry = (&symmetric - symmetric.transpose()).amax();
    let eigen = SymmetricEigen::new(symmetric);
    let mut order: Vec<usize> = (0..ring.len()).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].abs().total_cmp(&eigen.eigenvalues[i].abs()));
    let eigenvalues: Vec<f64> = order.iter().map(|&i| eigen.eigenvalues[i]).collect();

    let wide = reference.around(&[middle], 3);
    let wide_matrix = reference.matrix(&wide, &centre);
    let inner: Vec<usize> = ring.iter().filter_map(|v| wide.binary_search(v).ok()).collect();
    let coordinates = [1, 2, 3].map(|k| {
        let vector: DVector<f64> = eigen.eigenvectors.column(order[k]).into_owned();
        let values: Vec<f64> = vector.iter().zip(&scales).map(|(x, scale)| x / scale).collect();
        extended(&wide_matrix, &inner, &values, eigenvalues[k])
    });
    let values = rounded(&coordinates);
    let map = CharacteristicMap::new(&reference, &wide, &values);
    VertexAnalysis { eigenvalues, asymmetry, map }
}

/// The numbers d with d_i m_ij / d_j symmetric, if there are any: from the middle, which is a neighbour of all.
fn symmetrising(matrix: &DMatrix<f64>, middle: usize) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| (matrix[(middle, i)] / matrix[(i, middle)]).sqrt()).collect()
}

/// Coordinates scaled to the same mean square, which changes the shapes of cells but not whether they are inverted.
fn rounded(coordinates: &[Vec<f64>; 3]) -> Vec<DVec3> {
    let scale = coordinates.each_ref().map(|x| x.iter().map(|x| x * x).sum::<f64>().sqrt());
    let point = |i: usize| DVec3::from_array([0, 1, 2].map(|k| coordinates[k][i] / scale[k]));
    (0..coordinates[0].len()).map(point).collect()
}
