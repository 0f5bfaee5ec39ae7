//! Recovery for ten-node cells, whose stress is linear: a quadratic stress between values at their ten nodes.
//!
//! SPR (Zienkiewicz and Zhu 1992, part 1): around each vertex a quadratic polynomial is fitted by least squares to the
//! stresses at four points a cell. At the vertex it gives the value, at the middle of an edge the mean of both ends'
//! polynomials does. Averaging takes the mean of the stresses of the cells around a node, weighted by volume.

use super::patches::Patches;
use super::{Estimate, Field, add_scaled, minus};
use crate::adapt::options::Estimator;
use crate::fem::{FOUR_POINTS, Material, SymTensor};
use crate::mesh::quality::EDGES;
use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};
use rayon::prelude::*;

/// Fewest cells that a quadratic polynomial is fitted to; around fewer, cells that touch them are taken as well.
const MIN_CELLS: usize = 10;

/// Smallest ratio of the squared pivots of the normal matrix at which a fit is trusted.
const MIN_RATIO: f64 = 1e-6;

/// Largest variance of the value that a fit gives at its vertex, in those of the samples. It is below 10 in sound patches, and
/// beyond all bounds where a quadric passes through all samples: as where all cells of the vertex share an edge, and all their
/// other corners and the other end of that edge lie in a plane.
const MAX_VARIANCE: f64 = 100.0;

/// The estimate for a stress that is linear in each cell.
pub(super) fn estimate<'a>(
    field: &Field<'_>,
    patches: &Patches,
    material: impl Fn(usize) -> &'a Material + Sync,
    estimator: Estimator,
) -> Estimate {
    let fits: Vec<Polynomial> = (0..patches.len())
        .into_par_iter()
        .map(|p| match estimator {
            Estimator::Spr | Estimator::Residual => Polynomial::recover(field, patches, p),
            Estimator::Averaging => Polynomial::mean(field, patches, p),
        })
        .collect();
    let recovered = Recovered { field, patches, fits: &fits, estimator };
    let of_cells: Vec<(f64, [SymTensor; 6])> = (0..field.stress.cells())
        .into_par_iter()
        .map(|t| {
            let values = recovered.values(t);
            let squared = if patches.is_isolated(t) { 0.0 } else { recovered.squared_error(t, material(t), &values) };
            (squared, std::array::from_fn(|e| values[4 + e]))
        })
        .collect();
    let (squared, between): (Vec<f64>, Vec<[SymTensor; 6]>) = of_cells.into_iter().unzip();
    let at_vertices: Vec<SymTensor> = fits.iter().map(|f| f.coefficients[0]).collect();
    let mut nodal_stress = super::at_vertices(field, patches, &at_vertices);
    nodal_stress.extend(between_vertices(field, &between));
    Estimate { squared, nodal_stress, at_vertices, between }
}

/// One stress a midside node: the mean of those of its cells, weighted by volume.
fn between_vertices(field: &Field, of_cells: &[[SymTensor; 6]]) -> Vec<SymTensor> {
    let vertices = field.space.mesh().points().len();
    let mut sums = vec![([0.0; 6], 0.0); field.space.midside().len()];
    for (t, values) in of_cells.iter().enumerate() {
        for (node, value) in field.space.cell(t).skip(4).zip(values) {
            let (sum, weight) = &mut sums[node as usize - vertices];
            add_scaled(sum, field.volumes[t], value);
            *weight += field.volumes[t];
        }
    }
    sums.into_iter().map(|(sum, weight)| sum.map(|x| x / weight)).collect()
}

/// The stress that is recovered from patches.
struct Recovered<'a> {
    field: &'a Field<'a>,
    patches: &'a Patches,
    fits: &'a [Polynomial],
    estimator: Estimator,
}

impl Recovered<'_> {
    /// The recovered stress at the ten nodes of cell `t`.
    fn values(&self, t: usize) -> [SymTensor; 10] {
        let patches = self.patches.of_cell(t);
        let x = self.field.space.mesh().cell_points(t);
        std::array::from_fn(|a| {
            if a < 4 {
                return self.fits[patches[a] as usize].coefficients[0];
            }
            let [i, j] = EDGES[a - 4];
            match self.estimator {
                Estimator::Spr | Estimator::Residual => {
                    let middle = x[i].midpoint(x[j]);
                    let [p, q] = [i, j].map(|k| self.fits[patches[k] as usize].at(middle));
                    std::array::from_fn(|c| 0.5 * (p[c] + q[c]))
                }
                Estimator::Averaging => self.mean_around_edge(patches[i] as usize, patches[j] as usize),
            }
        })
    }

    /// The mean stress at the middle of an edge over the cells that two patches share.
    fn mean_around_edge(&self, p: usize, q: usize) -> SymTensor {
        let (field, other) = (self.field, self.patches.cells(q));
        let ends = [self.patches.vertex(p), self.patches.vertex(q)];
        let (mut sum, mut weight) = ([0.0; 6], 0.0);
        for t in self.patches.cells(p).iter().filter(|t| other.binary_search(t).is_ok()).map(|&t| t as usize) {
            let tet = field.space.mesh().tets()[t];
            let middle = tet.map(|v| if ends.contains(&v) { 0.5 } else { 0.0 });
            add_scaled(&mut sum, field.volumes[t], &field.stress.at(t, middle));
            weight += field.volumes[t];
        }
        sum.map(|x| x / weight)
    }

    /// The integral of `d : C^-1 : d` over cell `t`, d the difference of recovered and computed stress.
    fn squared_error(&self, t: usize, material: &Material, values: &[SymTensor; 10]) -> f64 {
        let differences: [SymTensor; 10] = std::array::from_fn(|a| {
            let place = if a < 4 { [a, a] } else { EDGES[a - 4] };
            let mut l = [0.0; 4];
            place.iter().for_each(|&i| l[i] += 0.5);
            minus(&values[a], &self.field.stress.at(t, l))
        });
        let sum: f64 = (0..10)
            .map(|a| {
                let mut weighted = [0.0; 6];
                (0..10).for_each(|b| add_scaled(&mut weighted, shape_product(a, b), &differences[b]));
                crate::fem::double_contraction(weighted, material.strain(differences[a]))
            })
            .sum();
        (self.field.volumes[t] * sum).max(0.0)
    }
}

/// Mean of `N_a N_b` over a cell.
pub(super) fn shape_product(a: usize, b: usize) -> f64 {
    let shared = |e: [usize; 2], f: [usize; 2]| e.iter().filter(|i| f.contains(i)).count();
    let sum = match (a < 4, b < 4) {
        (true, true) => [1, 6][usize::from(a == b)],
        (true, false) => [-6, -4][usize::from(EDGES[b - 4].contains(&a))],
        (false, true) => [-6, -4][usize::from(EDGES[a - 4].contains(&b))],
        (false, false) => [8, 16, 32][shared(EDGES[a - 4], EDGES[b - 4])],
    };
    f64::from(sum) / 420.0
}

/// A stress whose components are quadratic polynomials in local coordinates: 1, x, y, z, xx, yy, zz, xy, yz, xz.
///
/// The coordinates are along the principal axes of the points that were fitted, in units of their spread, so that flat and
/// stretched cells are fitted as well as others.
struct Polynomial {
    origin: DVec3,
    to_local: DMat3,
    coefficients: [SymTensor; 10],
}

impl Polynomial {
    /// Fits the stresses around the vertex of a patch.
    fn recover(field: &Field, patches: &Patches, patch: usize) -> Self {
        let own = patches.cells(patch);
        let fit = if own.len() < MIN_CELLS {
            let around = patches.around(own);
            Self::fit::<10>(field, patches.vertex(patch), &around)
                .or_else(|| Self::fit::<4>(field, patches.vertex(patch), &around))
        } else {
            Self::fit::<10>(field, patches.vertex(patch), own)
                .or_else(|| Self::fit::<4>(field, patches.vertex(patch), own))
        };
        fit.unwrap_or_else(|| Self::mean(field, patches, patch))
    }

    /// The mean of the stresses at the vertex of a patch, constant.
    fn mean(field: &Field, patches: &Patches, patch: usize) -> Self {
        let (mesh, vertex) = (field.space.mesh(), patches.vertex(patch));
        let cells = patches.to_recover_from(patch);
        let mut coefficients = [[0.0; 6]; 10];
        for t in cells.iter().map(|&t| t as usize) {
            // Cells that do not have the vertex count with their mean.
            let corner = mesh.tets()[t].map(|v| f64::from(u8::from(v == vertex)));
            let place = if corner == [0.0; 4] { [0.25; 4] } else { corner };
            add_scaled(&mut coefficients[0], field.volumes[t], &field.stress.at(t, place));
        }
        let volume = field.volume_of(&cells);
        coefficients[0] = coefficients[0].map(|x| x / volume);
        Self { origin: mesh.points()[vertex as usize], to_local: DMat3::IDENTITY, coefficients }
    }

    /// The least-squares polynomial of `N` terms around a vertex; `None` if the cells do not determine it.
    fn fit<const N: usize>(field: &Field, vertex: u32, cells: &[u32]) -> Option<Self> {
        let origin = field.space.mesh().points()[vertex as usize];
        let samples = || cells.iter().flat_map(|&t| FOUR_POINTS.map(|l| (t as usize, l)));
        let places: Vec<DVec3> = samples().map(|(t, l)| field.space.position(t, l) - origin).collect();
        let to_local = principal_axes(&places)?;
        let (mut normal, mut right) = (SMatrix::<f64, N, N>::zeros(), SMatrix::<f64, N, 6>::zeros());
        for ((t, l), place) in samples().zip(&places) {
            let all = monomials(to_local * *place);
            let p = SVector::<f64, N>::from_fn(|i, _| all[i]);
            normal.ger(1.0, &p, &p, 1.0);
            right.ger(1.0, &p, &SVector::<f64, 6>::from(field.stress.at(t, l)), 1.0);
        }
        let factor = normal.cholesky()?;
        let pivots = factor.l_dirty().diagonal();
        if pivots.min().powi(2) < MIN_RATIO * pivots.max().powi(2) {
            return None;
        }
        let at_vertex = SVector::<f64, N>::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 });
        if factor.solve(&at_vertex)[0] > MAX_VARIANCE {
            return None;
        }
        let solution = factor.solve(&right);
        let mut coefficients = [[0.0; 6]; 10];
        for (i, row) in coefficients.iter_mut().enumerate().take(N) {
            *row = std::array::from_fn(|c| solution[(i, c)]);
        }
        Some(Self { origin, to_local, coefficients })
    }

    fn at(&self, x: DVec3) -> SymTensor {
        let mut sum = [0.0; 6];
        for (p, c) in monomials(self.to_local * (x - self.origin)).into_iter().zip(&self.coefficients) {
            add_scaled(&mut sum, p, c);
        }
        sum
    }
}

/// The map to principal axes in units of the spread (root mean square) along each; `None` if the points lie in a plane.
fn principal_axes(points: &[DVec3]) -> Option<DMat3> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut spread = Matrix3::zeros();
    for p in points {
        let d = Vector3::from((*p - mean).to_array());
        spread.ger(1.0 / points.len() as f64, &d, &d, 1.0);
    }
    let eigen = SymmetricEigen::new(spread);
    if eigen.eigenvalues.min() <= f64::EPSILON * eigen.eigenvalues.max() {
        return None;
    }
    let rows: [DVec3; 3] = std::array::from_fn(|k| {
        let axis = eigen.eigenvectors.column(k) / eigen.eigenvalues[k].sqrt();
        DVec3::new(axis[0], axis[1], axis[2])
    });
    Some(DMat3::from_cols(rows[0], rows[1], rows[2]).transpose())
}

fn monomials(x: DVec3) -> [f64; 10] {
    [1.0, x.x, x.y, x.z, x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.x * x.z]
}
