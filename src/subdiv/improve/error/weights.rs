//! Weights of the error-driven optimiser from an error estimate.

use super::cost::{Shape, cost};
use super::weight::Directions;
use crate::mesh::TetMesh;
use crate::subdiv::Stencil;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Part of the second moments of Hessians that is taken to have no direction: recovered ones are rough, and where they
/// vanish along a line the best cells would be endlessly long.
const ISOTROPIC: f64 = 0.1;

/// What the error-driven optimiser is told of the error: an entry a vertex.
#[derive(Debug, Clone, PartialEq)]
pub enum Weights {
    /// Factors of a cost that prefers no direction; not negative.
    Factors(Vec<f64>),
    /// Second derivatives with preferred directions.
    Directions(Vec<Directions>),
}

impl Weights {
    /// Factors from a squared error in each cell of `mesh`: at a vertex the error of the cells around it over their cost.
    /// Where the error is spread as the cost would have it, all are equal.
    #[must_use]
    pub fn factors(mesh: &TetMesh, squared_errors: &[f64]) -> Self {
        let cost = |t: usize| [cost(mesh.cell_points(t)); 4];
        Self::Factors(errors_over_costs(mesh, squared_errors, cost))
    }

    /// Directions from a squared error in each cell of `mesh` and, at each vertex, the second moments `sum_c H_c H_c` of
    /// the Hessians of the components of what is interpolated, by their entries XX YY ZZ XY YZ XZ. Only their shape
    /// counts: they are scaled so that the cost of the cells around a vertex is their error.
    #[must_use]
    pub fn directions(mesh: &TetMesh, moments: &[[f64; 6]], squared_errors: &[f64]) -> Self {
        let matrices: Vec<[f64; 6]> = moments.par_iter().map(|s| matrix(*s)).collect();
        let cost = |t: usize| {
            let shape = Shape::of(mesh.cell_points(t));
            mesh.tets()[t].map(|v| shape.cost_along(matrices[v as usize]))
        };
        let factors = errors_over_costs(mesh, squared_errors, cost);
        Self::Directions(matrices.into_iter().zip(factors).map(|(m, factor)| Directions(m) * factor.sqrt()).collect())
    }

    /// Carries them over to a refined mesh.
    #[must_use]
    pub fn carried_over(self, transfer: &[Stencil]) -> Self {
        match self {
            Self::Factors(weights) => Self::Factors(carried(weights, transfer)),
            Self::Directions(weights) => Self::Directions(carried(weights, transfer)),
        }
    }
}

fn carried<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>>(
    mut weights: Vec<T>,
    transfer: &[Stencil],
) -> Vec<T> {
    for stencil in transfer {
        weights.push(stencil.combine(|v| weights[v as usize]));
    }
    weights
}

/// At each vertex the squared errors of the cells around it over their costs; a cell has one cost for each of its vertices.
fn errors_over_costs(
    mesh: &TetMesh,
    squared_errors: &[f64],
    costs: impl Fn(usize) -> [f64; 4] + Send + Sync,
) -> Vec<f64> {
    let costs: Vec<[f64; 4]> = (0..mesh.tets().len()).into_par_iter().map(costs).collect();
    let mut sums = vec![(0.0, 0.0); mesh.points().len()];
    for ((tet, costs), squared_error) in mesh.tets().iter().zip(costs).zip(squared_errors) {
        for (v, cost) in tet.iter().zip(costs) {
            let (error, total) = &mut sums[*v as usize];
            *error += squared_error;
            *total += cost;
        }
    }
    sums.into_iter().map(|(error, total)| if total > 0.0 { error / total } else { 0.0 }).collect()
}

/// The matrix M with `M M + tr(M) M` the second moments S, but for their size and an isotropic part.
///
/// M has the eigenvectors of S, and eigenvalues `m = (sqrt(t^2 + 4 s) - t) / 2` whose sum is t.
fn matrix(moments: [f64; 6]) -> [f64; 6] {
    let trace = moments[0] + moments[1] + moments[2];
    let [xx, yy, zz, xy, yz, xz] = moments.map(|x| x / trace);
    // No second derivatives, or none that are numbers.
    if !(trace > 0.0 && [xx, yy, zz, xy, yz, xz].iter().all(|x| x.is_finite())) {
        return [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    }
    let eigen = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigen();
    let squares = eigen.eigenvalues.map(|x| (1.0 - ISOTROPIC) * x.max(0.0) + ISOTROPIC / 3.0);
    let values = |t: f64| squares.map(|s| 0.5 * ((t * t + 4.0 * s).sqrt() - t));
    // Newton's method on a convex falling function, from its left: few steps do.
    let mut t = 0.0;
    for _ in 0..8 {
        let slope: f64 = squares.map(|s| 0.5 * (t / (t * t + 4.0 * s).sqrt() - 1.0)).sum() - 1.0;
        t -= (values(t).sum() - t) / slope;
    }
    let m = eigen.eigenvectors * Matrix3::from_diagonal(&values(t)) * eigen.eigenvectors.transpose();
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(0, 2)]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;

    fn dense([xx, yy, zz, xy, yz, xz]: [f64; 6]) -> Matrix3<f64> {
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    #[test]
    fn the_matrix_has_the_moments_it_is_made_of() {
        for s in [[2.0, 1.0, 3.0, 0.4, -0.7, 0.1], [1e-9, 1e-9, 0.0, 1e-9, 0.0, 0.0], [0.0, 0.0, 5e8, 0.0, 0.0, 0.0]] {
            let m = dense(matrix(s));
            let trace = s[0] + s[1] + s[2];
            let expected = dense(s) * ((1.0 - ISOTROPIC) / trace) + Matrix3::identity() * (ISOTROPIC / 3.0);
            assert!((m * m + m * m.trace() - expected).norm() < 1e-14, "{m}");
        }
        for nothing in [[0.0; 6], [f64::NAN; 6]] {
            assert_eq!(matrix(nothing), [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        }
    }

    /// On each star of a vertex the weighted cost is the error: for any mesh where it is the same at all vertices.
    #[test]
    fn weights_are_scaled_to_the_error() {
        let mesh = box_tets([1.0, 2.0, 1.5], [2, 3, 2]).unwrap();
        let moments = vec![[2.0, 1.0, 3.0, 0.4, -0.7, 0.1]; mesh.points().len()];
        let m = matrix(moments[0]).map(|x| 3.0 * x);
        let squared: Vec<f64> = (0..mesh.tets().len()).map(|t| Shape::of(mesh.cell_points(t)).cost_along(m)).collect();
        let Weights::Directions(weights) = Weights::directions(&mesh, &moments, &squared) else { panic!() };
        assert!(weights.iter().all(|w| w.0.iter().zip(m).all(|(a, b)| (a - b).abs() < 1e-13)));
        let squared: Vec<f64> = (0..mesh.tets().len()).map(|t| 7.0 * cost(mesh.cell_points(t))).collect();
        let Weights::Factors(weights) = Weights::factors(&mesh, &squared) else { panic!() };
        assert!(weights.iter().all(|w| (w - 7.0).abs() < 1e-13));
    }
}
