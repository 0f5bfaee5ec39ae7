//! Recovered stress. Of quadratic elements, from patches (`patches.rs`). Of others, in each cell the stress of the elements is fitted by the cell's functions in the mean square, and the
//! coefficients that cells find for a function are averaged (Bezier projection, Thomas, Scott, Evans, Tew and Evans 2015; on
//! trilinear cells extrapolation to the nodes and averaging there). Regions are kept apart, since stress may jump between them.

use super::super::{Model, SymTensor};
use super::rule::Quadrature;
use super::shared::Shared;
use super::stress::{material, strain};
use super::{AtPoint, HexSolution, HexSpace, patches};
use crate::limit::Table;
use crate::mesh::RegionId;
use nalgebra::{DMatrix, SymmetricEigen};

/// Cells that are worked off at a time.
const BATCH: usize = 4096;

/// Relative size of an eigenvalue of a cell's mass matrix, scaled to a unit diagonal, that counts as zero.
const ZERO: f64 = 1e-11;

/// The recovered stress by coefficients of the functions, for each region.
#[derive(Debug, Clone)]
pub struct RecoveredStress {
    regions: Vec<Vec<SymTensor>>,
}

/// What a cell finds for some of its functions: the coefficient and its weight.
type Found = Vec<(u32, SymTensor, f64)>;

/// How the stress is projected onto the functions of a class of cells.
#[derive(Debug, Clone)]
struct Projection {
    /// Those of the class's functions that are found.
    found: Vec<usize>,
    /// Their values: row by row at the points.
    values: DMatrix<f64>,
    /// Makes of values at the points the coefficients.
    fit: DMatrix<f64>,
}

impl RecoveredStress {
    /// Recovers the stress of a solution.
    #[must_use]
    pub fn new(space: &HexSpace<'_>, model: &Model, solution: &HexSolution) -> Self {
        if space.element().has_edge_nodes() {
            let regions = (0..space.mesh().region_names().len()).map(|r| RegionId(r as u16));
            let nodal = |region| patches::nodal(space, model, solution, region);
            return Self { regions: regions.map(nodal).collect() };
        }
        // Halved where functions are no polynomials: there may be more of them than points otherwise.
        let quadrature = Quadrature::of_stiffness(space, 3, 1);
        let fits = Shared::new(space);
        let count = space.points().len();
        let mut sums = vec![vec![([0.0; 6], 0.0); count]; space.mesh().region_names().len()];
        for first in (0..space.mesh().cells().len()).step_by(BATCH) {
            let batch = first..space.mesh().cells().len().min(first + BATCH);
            let of = |t| of_cell(space, model, solution, t, (&quadrature, &fits));
            let found: Vec<Found> = space.of_some_cells(batch.clone(), of);
            for (t, found) in batch.zip(found) {
                let own = &mut sums[space.mesh().regions()[t].0 as usize];
                for (v, stress, weight) in found {
                    let (sum, total) = &mut own[v as usize];
                    sum.iter_mut().zip(stress).for_each(|(sum, s)| *sum += weight * s);
                    *total += weight;
                }
            }
        }
        let mean = |(sum, total): (SymTensor, f64)| if total > 0.0 { sum.map(|s| s / total) } else { sum };
        let coefficients = |own: Vec<(SymTensor, f64)>| space.lowered(own.into_iter().map(mean).collect());
        Self { regions: sums.into_iter().map(coefficients).collect() }
    }

    /// The recovered stress at point `q` of a table of cell `t`.
    #[must_use]
    pub fn at(&self, space: &HexSpace<'_>, t: usize, table: &Table, q: usize) -> SymTensor {
        let own = &self.regions[space.mesh().regions()[t].0 as usize];
        let mut stress = [0.0; 6];
        for (&v, n) in space.cell(t).iter().zip(table.values_at(q)) {
            stress.iter_mut().zip(own[v as usize]).for_each(|(sum, s)| *sum += n * s);
        }
        stress
    }
}

/// The coefficients that a cell finds, weighted by the square of the functions in it.
fn of_cell(
    space: &HexSpace<'_>,
    model: &Model,
    solution: &HexSolution,
    t: usize,
    (quadrature, projections): (&Quadrature, &Shared<Projection>),
) -> Found {
    let (weights, table) = quadrature.of(space, t);
    let class = space.class(t);
    let projection =
        projections.of(space, class, || Projection::new(weights, &table, &space.lifted(class, table.functions)));
    let (material, mut at) = (material(space, model, t), AtPoint::default());
    let mut found: Found = projection.found.iter().map(|&a| (space.cell(t)[a], [0.0; 6], 0.0)).collect();
    for (q, weight) in weights.iter().enumerate() {
        space.at_point(t, &table, q, &mut at);
        let stress = material.stress(strain(space, &solution.displacement, t, &at));
        for (a, (_, coefficient, total)) in found.iter_mut().enumerate() {
            coefficient.iter_mut().zip(stress).for_each(|(sum, s)| *sum += projection.fit[(a, q)] * s);
            *total += weight * at.determinant * projection.values[(a, q)].powi(2);
        }
    }
    found
}

impl Projection {
    /// The matrix that makes of values at points the coefficients of the nearest combination of the functions, and the smallest
    /// such where there are several.
    fn new(weights: &[f64], table: &Table, lifted: &[Option<Vec<(usize, f64)>>]) -> Self {
        let found: Vec<usize> = (0..lifted.len()).filter(|a| lifted[*a].is_some()).collect();
        let terms: Vec<&Vec<(usize, f64)>> = lifted.iter().flatten().collect();
        let value = |a: usize, q: usize| terms[a].iter().map(|(b, scale)| scale * table.values_at(q)[*b]).sum();
        let values: DMatrix<f64> = DMatrix::from_fn(found.len(), weights.len(), value);
        let scaled = DMatrix::from_fn(found.len(), weights.len(), |a, q| weights[q].sqrt() * values[(a, q)]);
        let sizes: Vec<f64> = scaled.row_iter().map(|row| row.norm()).collect();
        let inverse = |size: f64| if size > 0.0 { 1.0 / size } else { 0.0 };
        let unit = DMatrix::from_fn(found.len(), weights.len(), |a, q| scaled[(a, q)] * inverse(sizes[a]));
        let eigen = SymmetricEigen::new(&unit * unit.transpose());
        let bound = ZERO * eigen.eigenvalues.amax();
        let reciprocals = eigen.eigenvalues.map(|x| if x > bound { 1.0 / x } else { 0.0 });
        let pseudo = &eigen.eigenvectors * DMatrix::from_diagonal(&reciprocals) * eigen.eigenvectors.transpose();
        let mut fit = pseudo * unit;
        for (a, mut row) in fit.row_iter_mut().enumerate() {
            row *= inverse(sizes[a]);
        }
        for (q, mut column) in fit.column_iter_mut().enumerate() {
            column *= weights[q].sqrt();
        }
        Self { found, values, fit }
    }
}
