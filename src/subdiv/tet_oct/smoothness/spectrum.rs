//! Eigenvalues, and bounds on what products of several matrices can do.

use faer::Mat;
use nalgebra::{Complex, ComplexField, DMatrix, DVector};
use rayon::prelude::*;

/// Matrices of either kind.
pub(super) trait Scalar: ComplexField<RealField = f64> + Copy {}
impl Scalar for f64 {}
impl Scalar for Complex<f64> {}

/// Absolute values of the eigenvalues, descending.
pub(super) fn moduli<T: Scalar>(matrix: &DMatrix<T>) -> Vec<f64> {
    let mut moduli: Vec<f64> = eigenvalues(matrix).iter().map(|x| x.norm()).collect();
    moduli.sort_by(|a, b| b.total_cmp(a));
    moduli
}

/// All eigenvalues.
pub(super) fn eigenvalues<T: Scalar>(matrix: &DMatrix<T>) -> Vec<Complex<f64>> {
    let entry = |i, j| Complex::new(matrix[(i, j)].real(), matrix[(i, j)].imaginary());
    let values = Mat::from_fn(matrix.nrows(), matrix.ncols(), entry).eigenvalues();
    // Fails on numbers that are not finite alone.
    values.unwrap_or_else(|_| vec![Complex::new(f64::NAN, 0.0); matrix.nrows()])
}

/// An orthonormal basis of the complement of the space that the columns, which are independent, span.
pub(super) fn complement<T: Scalar>(space: &DMatrix<T>) -> DMatrix<T> {
    let (rows, rank) = space.shape();
    // Gram-Schmidt twice against the space and what is there already, unit vector after unit vector.
    let mut basis: Vec<DVector<T>> = Vec::with_capacity(rows);
    let candidates = space.column_iter().map(|c| c.into_owned()).chain((0..rows).map(|i| {
        let mut unit = DVector::zeros(rows);
        unit[i] = T::one();
        unit
    }));
    for mut v in candidates {
        let before = v.norm();
        for _ in 0..2 {
            for b in &basis {
                let part = b.dotc(&v);
                v.axpy(-part, b, T::one());
            }
        }
        let after = v.norm();
        if after > 1e-9 * before && basis.len() < rows {
            basis.push(v.unscale(after));
        }
    }
    DMatrix::from_columns(&basis).columns(rank, rows - rank).into_owned()
}

/// The matrices on the complement of a space that all of them map into itself, and how far they are from doing so.
pub(super) fn quotients<T: Scalar>(matrices: &[DMatrix<T>], space: &DMatrix<T>) -> (Vec<DMatrix<T>>, f64) {
    let q = complement(space);
    let adjoint = q.adjoint();
    let leak = |m: &DMatrix<T>| (&adjoint * m * space).norm() / space.norm();
    let residual = matrices.iter().map(leak).fold(0.0, f64::max);
    (matrices.iter().map(|m| &adjoint * m * &q).collect(), residual)
}

/// The largest infinity norm of the products of `length` of the matrices.
pub(super) fn largest_product<T: Scalar>(matrices: &[DMatrix<T>], length: usize) -> f64 {
    if matrices.first().is_none_or(DMatrix::is_empty) {
        return 0.0;
    }
    matrices.par_iter().map(|m| grow(matrices, m, length - 1)).collect::<Vec<f64>>().into_iter().fold(0.0, f64::max)
}

fn grow<T: Scalar>(matrices: &[DMatrix<T>], product: &DMatrix<T>, more: usize) -> f64 {
    if more == 0 {
        return infinity_norm(product);
    }
    matrices.iter().map(|m| grow(matrices, &(m * product), more - 1)).fold(0.0, f64::max)
}

fn infinity_norm<T: Scalar>(matrix: &DMatrix<T>) -> f64 {
    matrix.row_iter().map(|row| row.iter().map(|x| x.modulus()).sum()).fold(0.0, f64::max)
}

/// A bound from below on the joint spectral radius: the largest spectral radius of products of at most `length` of the
/// matrices, to the power of one over the number of factors.
pub(super) fn from_below<T: Scalar>(matrices: &[DMatrix<T>], length: usize) -> f64 {
    let mut products = matrices.to_vec();
    let mut largest = 0.0_f64;
    for k in 1..=length {
        let radius = |m: &DMatrix<T>| moduli(m).first().copied().unwrap_or(0.0);
        let radii: Vec<f64> = products.par_iter().map(radius).collect();
        largest = radii.into_iter().map(|r| r.powf(1.0 / k as f64)).fold(largest, f64::max);
        if k < length {
            products = products.iter().flat_map(|p| matrices.iter().map(move |m| m * p)).collect();
        }
    }
    largest
}

/// A null vector of `matrix - eigenvalue`, of norm one: that of the smallest singular value.
pub(super) fn eigenvector<T: Scalar>(matrix: &DMatrix<T>, eigenvalue: T) -> DVector<T> {
    let shifted = matrix - DMatrix::from_diagonal_element(matrix.nrows(), matrix.nrows(), eigenvalue);
    let rows = shifted.svd(false, true).v_t;
    rows.map_or_else(|| DVector::zeros(matrix.nrows()), |v_t| v_t.row(v_t.nrows() - 1).adjoint())
}
