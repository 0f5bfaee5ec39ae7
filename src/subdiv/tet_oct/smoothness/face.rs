//! Across a face of the control mesh.

use super::reference::{Place, Reference, UNITS};
use super::spectrum::{eigenvalues, largest_product, quotients};
use glam::DVec3;
use nalgebra::DMatrix;

/// What was found across a face.
#[derive(Debug, Clone)]
pub struct FaceAnalysis {
    /// Eigenvalues of the matrix of the 19 vertices around one on the face, by descending absolute value.
    pub eigenvalues: Vec<f64>,
    /// Largest imaginary part of them.
    pub imaginary: f64,
    /// The values on a patch of the face.
    pub on: Patch,
    /// Those in the cells that have it for faces: what derivatives across the face are, too.
    pub at: Patch,
}

/// What was found for a patch of the face.
#[derive(Debug, Clone)]
pub struct Patch {
    /// Vertices that the values depend on.
    pub support: usize,
    /// How far the four matrices of the patch are from mapping quadratic polynomials to quadratic polynomials.
    pub quadratics: f64,
    /// Bounds on the joint spectral radius of what is left without quadratic polynomials, from products of 1, 2, ... matrices in
    /// the infinity norm.
    pub bounds: Vec<f64>,
}

impl Patch {
    /// The least number of factors whose bound is below 1/4: the limit is twice continuously differentiable then.
    #[must_use]
    pub fn factors(&self) -> Option<usize> {
        self.bounds.iter().position(|b| *b < 0.25).map(|k| k + 1)
    }
}

/// Two regular tetrahedra with a common face.
const CORNERS: [[f64; 3]; 5] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0], [5.0 / 3.0, 5.0 / 3.0, -5.0 / 3.0]];

/// Analyses two tetrahedra with a common face, with products of at most `on` matrices for the values on the face, and of `at` for
/// those in the cells at it.
///
/// The patch is a parallelogram of two triangles of the split face, one between tetrahedra and one between octahedra. The
/// matrices S1 to S4 take the values it depends on to those of each of its quarters. With Q an orthonormal basis of the complement
/// of the quadratic polynomials, `Y_i = Q^T S_i Q` is what is left without them.
#[must_use]
pub fn analyse_face(on: usize, at: usize) -> FaceAnalysis {
    let reference = Reference::new(5, vec![[0, 1, 2, 3], [0, 2, 1, 4]]);
    let on_face = |a: i32, b: i32| -> Place { vec![a, b, UNITS - a - b, 0, 0] };
    let centre = on_face(3, 3);
    let ring = reference.around(&[reference.at(&centre)], 1);
    let mut values = eigenvalues(&reference.matrix(&ring, &centre));
    values.sort_by(|a, b| b.norm().total_cmp(&a.norm()));

    let corners = [[2, 3], [3, 2], [3, 3], [4, 2]].map(|[a, b]| on_face(a, b));
    let on_patch = corners.each_ref().map(|place| reference.at(place));
    let patch = |of: &[u32], factors: usize| {
        let support = reference.around(of, 1);
        let matrices = corners.each_ref().map(|corner| reference.matrix(&support, corner));
        let (rest, quadratics) = quotients(&matrices, &polynomials(&reference, &support));
        let bounds = (1..=factors).map(|k| largest_product(&rest, k).powf(1.0 / k as f64)).collect();
        Patch { support: support.len(), quadratics, bounds }
    };
    FaceAnalysis {
        eigenvalues: values.iter().map(|x| x.re).collect(),
        imaginary: values.iter().map(|x| x.im.abs()).fold(0.0, f64::max),
        on: patch(&on_patch, on),
        at: patch(&reference.of_cells_at(&on_patch, 3), at),
    }
}

/// The ten quadratic monomials of the linear places around the middle of the patch, in columns.
fn polynomials(reference: &Reference, support: &[u32]) -> DMatrix<f64> {
    let place = |v: u32| -> DVec3 {
        let numerators = reference.places[v as usize].iter().map(|x| f64::from(*x));
        numerators.zip(CORNERS).map(|(x, corner)| x * DVec3::from_array(corner)).sum()
    };
    let middle = support.iter().map(|&v| place(v)).sum::<DVec3>() / support.len() as f64;
    DMatrix::from_fn(support.len(), 10, |i, j| {
        let p = place(support[i]) - middle;
        [1.0, p.x, p.y, p.z, p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.y * p.z, p.z * p.x][j]
    })
}
