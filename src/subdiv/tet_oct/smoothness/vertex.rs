//! At a vertex of the control mesh.

use super::map::{CharacteristicMap, extended};
use super::reference::{Place, Reference, UNITS};
use super::spectrum::moduli;
use super::spheres::Sphere;
use glam::DVec3;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// What was found at a vertex.
#[derive(Debug, Clone)]
pub struct VertexAnalysis {
    /// Eigenvalues of the matrix of the vertex and its neighbours, which are real, by descending absolute value; the first is 1.
    pub eigenvalues: Vec<f64>,
    /// The largest absolute value of the other eigenvalues of the matrix that has the next ring of vertices too. Those of rings
    /// farther out are zero: what is three or more steps away depends on what is nearer alone.
    pub next_ring: f64,
    /// How far this matrix is from the symmetric one that it is similar to.
    pub asymmetry: f64,
    /// The map of the eigenvectors 1 to 3.
    pub map: CharacteristicMap,
}

impl VertexAnalysis {
    /// The fourth eigenvalue after the first, of both rings.
    #[must_use]
    pub fn lambda4(&self) -> f64 {
        self.eigenvalues[4].abs().max(self.next_ring)
    }

    /// By how much the third eigenvalue after the first exceeds the fourth.
    #[must_use]
    pub fn gap(&self) -> f64 {
        self.eigenvalues[3].abs() - self.lambda4()
    }

    /// Whether 1 > lambda1 >= lambda2 >= lambda3 > lambda4: whether there are three leading eigenvectors, and no more.
    #[must_use]
    pub fn has_map(&self) -> bool {
        self.eigenvalues[1] < 1.0 && self.eigenvalues[3] > 0.0 && self.gap() > 1e-12
    }

    /// Whether there is a map, and it inverts no cell.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.has_map() && self.map.is_regular()
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

    let two = reference.around(&ring, 1);
    let outer = outside(&reference.matrix(&two, &centre), &places_in(&two, &ring));
    let next_ring = moduli(&outer).first().copied().unwrap_or(0.0);

    let wide = reference.around(&[middle], 3);
    let wide_matrix = reference.matrix(&wide, &centre);
    let inner = places_in(&wide, &ring);
    let coordinates = [1, 2, 3].map(|k| {
        let vector: DVector<f64> = eigen.eigenvectors.column(order[k]).into_owned();
        let values: Vec<f64> = vector.iter().zip(&scales).map(|(x, scale)| x / scale).collect();
        extended(&wide_matrix, &inner, &values, eigenvalues[k])
    });
    let values = rounded(&coordinates);
    let map = CharacteristicMap::new(&reference, middle, &wide, &values);
    VertexAnalysis { eigenvalues, next_ring, asymmetry, map }
}

/// Where some of the vertices of an ascending list are in it.
fn places_in(all: &[u32], some: &[u32]) -> Vec<usize> {
    some.iter().filter_map(|v| all.binary_search(v).ok()).collect()
}

/// A matrix without some rows and columns.
fn outside(matrix: &DMatrix<f64>, without: &[usize]) -> DMatrix<f64> {
    matrix.clone().remove_rows_at(without).remove_columns_at(without)
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
