//! Recovered stress: the stress of the elements projected onto their functions in the mean square, region by region (the
//! continuous L2 recovery of Kumar, Kvamsdal and Johannessen 2017; for trilinear cells that of Zienkiewicz and Zhu 1987).

use super::super::{Model, SymTensor};
use super::matrix::conjugate_gradients;
use super::rule::Quadrature;
use super::stress::{material, strain};
use super::{AtPoint, HexSolution, HexSpace};
use crate::limit::Table;
use glam::DVec3;
use rayon::prelude::*;

/// Relative residual of the projection.
const TOLERANCE: f64 = 1e-10;

/// Cells that are worked off at a time.
const BATCH: usize = 4096;

/// Normal and shear components of a stress.
type Halves = [DVec3; 2];

/// The recovered stress by coefficients of the functions, for each region.
#[derive(Debug, Clone)]
pub struct RecoveredStress {
    regions: Vec<Vec<Halves>>,
}

impl RecoveredStress {
    /// Projects the stress of a solution.
    #[must_use]
    pub fn new(space: &HexSpace<'_>, model: &Model, solution: &HexSolution) -> Self {
        let of_region = |region| Projection::new(space, region).stress(model, solution);
        Self { regions: (0..space.mesh().region_names().len()).map(of_region).collect() }
    }

    /// The recovered stress at point `q` of a table of cell `t`.
    #[must_use]
    pub fn at(&self, space: &HexSpace<'_>, t: usize, table: &Table, q: usize) -> SymTensor {
        let own = &self.regions[space.mesh().regions()[t].0 as usize];
        let mut halves = [DVec3::ZERO; 2];
        for (&v, n) in space.cell(t).iter().zip(table.values_at(q)) {
            (0..2).for_each(|h| halves[h] += *n * own[v as usize][h]);
        }
        joined(halves)
    }
}

/// The projection over the cells of a region.
struct Projection<'a, 'm> {
    space: &'a HexSpace<'m>,
    cells: Vec<usize>,
    quadrature: Quadrature,
    /// Weights times Jacobian determinants at the points of each cell.
    volumes: Vec<Vec<f64>>,
}

impl<'a, 'm> Projection<'a, 'm> {
    fn new(space: &'a HexSpace<'m>, region: usize) -> Self {
        let cells: Vec<usize> =
            (0..space.mesh().cells().len()).filter(|&t| space.mesh().regions()[t].0 as usize == region).collect();
        // One point more than stiffness needs: the products of functions have a higher degree.
        let quadrature = Quadrature::new(space, space.gauss_points().max(3));
        let volumes = |t: &usize| -> Vec<f64> {
            let (weights, table) = quadrature.of(space, *t);
            let volume = |(q, w): (usize, &f64)| w * space.frame(*t, table, q).1.determinant();
            weights.iter().enumerate().map(volume).collect()
        };
        let volumes = cells.par_iter().map(volumes).collect();
        Self { space, cells, quadrature, volumes }
    }

    fn table(&self, t: usize) -> &Table {
        self.quadrature.of(self.space, t).1
    }

    /// `sum over cells int N_i g` for a field g given at the points of a cell.
    fn integrals<T: Send + Copy>(
        &self,
        zero: T,
        of: impl Fn(usize, usize) -> Vec<T> + Sync,
        add: impl Fn(&mut T, T),
    ) -> Vec<T> {
        let mut sums = vec![zero; self.space.points().len()];
        for first in (0..self.cells.len()).step_by(BATCH) {
            let batch = first..self.cells.len().min(first + BATCH);
            let parts: Vec<Vec<T>> = batch.clone().into_par_iter().map(|i| of(i, self.cells[i])).collect();
            for (i, part) in batch.zip(parts) {
                let functions = self.space.cell(self.cells[i]);
                functions.iter().zip(part).for_each(|(&v, x)| add(&mut sums[v as usize], x));
            }
        }
        sums
    }

    /// The mass matrix times a field.
    fn mass(&self, x: &[DVec3]) -> Vec<DVec3> {
        let of = |i: usize, t: usize| {
            let (table, functions) = (self.table(t), self.space.cell(t));
            let mut sums = vec![DVec3::ZERO; functions.len()];
            for (q, volume) in self.volumes[i].iter().enumerate() {
                let values = table.values_at(q);
                let here: DVec3 = functions.iter().zip(values).map(|(&v, n)| *n * x[v as usize]).sum();
                sums.iter_mut().zip(values).for_each(|(sum, n)| *sum += volume * n * here);
            }
            sums
        };
        self.integrals(DVec3::ZERO, of, |sum, x| *sum += x)
    }

    fn diagonal(&self) -> Vec<f64> {
        let of = |i: usize, t: usize| {
            let table = self.table(t);
            let mut sums = vec![0.0; table.functions];
            for (q, volume) in self.volumes[i].iter().enumerate() {
                sums.iter_mut().zip(table.values_at(q)).for_each(|(sum, n)| *sum += volume * n * n);
            }
            sums
        };
        self.integrals(0.0, of, |sum, x| *sum += x)
    }

    fn stress(&self, model: &Model, solution: &HexSolution) -> Vec<Halves> {
        let of = |i: usize, t: usize| {
            let (table, material) = (self.table(t), material(self.space, model, t));
            let (mut sums, mut at) = (vec![[DVec3::ZERO; 2]; table.functions], AtPoint::default());
            for (q, volume) in self.volumes[i].iter().enumerate() {
                self.space.at_point(t, table, q, &mut at);
                let halves = halves(material.stress(strain(self.space, &solution.displacement, t, &at)));
                for (sum, n) in sums.iter_mut().zip(table.values_at(q)) {
                    (0..2).for_each(|h| sum[h] += volume * n * halves[h]);
                }
            }
            sums
        };
        let right = self.integrals([DVec3::ZERO; 2], of, |sum, x| (0..2).for_each(|h| sum[h] += x[h]));
        let diagonal = self.diagonal();
        let [normal, shear] = [0, 1].map(|h| {
            let right: Vec<DVec3> = right.iter().map(|r| r[h]).collect();
            conjugate_gradients(|x| self.mass(x), &diagonal, &right, TOLERANCE)
        });
        normal.into_iter().zip(shear).map(|(n, s)| [n, s]).collect()
    }
}

fn halves(s: SymTensor) -> Halves {
    [DVec3::new(s[0], s[1], s[2]), DVec3::new(s[3], s[4], s[5])]
}

fn joined([n, s]: Halves) -> SymTensor {
    [n.x, n.y, n.z, s.x, s.y, s.z]
}
