//! Recovery of the stress of quadratic elements from patches (Zienkiewicz and Zhu 1992): a quadratic polynomial is fitted to the
//! stress at the 2 x 2 x 2 Gauss points of the cells around each vertex, where it is most accurate. The mean of what cells say at
//! a node would not do: the errors of both sides are equal there.

use super::super::{Model, SymTensor};
use super::rule::Rule;
use super::{HexSolution, HexSpace};
use crate::mesh::RegionId;
use glam::{DMat3, DVec3};

/// Monomials of degree two at most.
const TERMS: usize = 10;

/// Gauss points a direction.
const POINTS: usize = 2;

/// Cells from which on a patch is not extended: at the boundary there are fewer, which cannot tell all second derivatives.
const ENOUGH: usize = 4;

/// Share of a monomial that those before it do not explain, below which the samples cannot tell it.
const DEPENDENT: f64 = 0.1;

/// A polynomial of the position, fitted to samples of the stress.
struct Fit {
    centre: DVec3,
    /// Takes the distance from the centre to coordinates in which the samples' covariance is one.
    unit: DMat3,
    coefficients: [SymTensor; TERMS],
}

/// The recovered stress at the nodes of quadratic elements, in one region; zero at nodes of others.
pub(super) fn nodal(space: &HexSpace<'_>, model: &Model, solution: &HexSolution, region: RegionId) -> Vec<SymTensor> {
    let mesh = space.mesh();
    let inside = |t: usize| mesh.regions()[t] == region;
    let tables = space.tables(Rule::cube(POINTS).points);
    let samples: Vec<Vec<(DVec3, SymTensor)>> = space.of_cells(|t| {
        let table = tables.of(space, t);
        let sample = |q| (space.frame(t, &table, q).0, solution.stress(space, model, t, &table, q));
        if inside(t) { (0..POINTS.pow(3)).map(sample).collect() } else { Vec::new() }
    });
    let topology = mesh.topology();
    let around = |cells: &[u32]| -> Vec<u32> {
        let mut all: Vec<u32> = cells
            .iter()
            .flat_map(|&t| mesh.cells()[t as usize])
            .flat_map(|v| topology.vertex_cells(v))
            .copied()
            .collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|t| inside(*t as usize));
        all
    };
    let fits: Vec<Option<Fit>> = space.of_some_cells(0..mesh.points().len(), |v| {
        let mut patch: Vec<u32> =
            topology.vertex_cells(v as u32).iter().copied().filter(|t| inside(*t as usize)).collect();
        if patch.is_empty() {
            return None;
        }
        if patch.len() < ENOUGH {
            patch = around(&patch);
        }
        Some(Fit::new(patch.iter().flat_map(|t| &samples[*t as usize]).copied().collect()))
    });
    let mut sums = vec![([0.0; 6], 0.0); space.points().len()];
    for t in (0..mesh.cells().len()).filter(|t| inside(*t)) {
        let corners = mesh.cells()[t];
        // A node's stress is the mean of what the polynomials of the vertices of its edge, face or cell say there.
        let share = |places: &[usize], node: u32, sums: &mut Vec<(SymTensor, f64)>| {
            let at = space.points()[node as usize];
            for fit in places.iter().filter_map(|c| fits[corners[*c] as usize].as_ref()) {
                let (sum, count) = &mut sums[node as usize];
                sum.iter_mut().zip(fit.at(at)).for_each(|(sum, s)| *sum += s);
                *count += 1.0;
            }
        };
        for (place, &node) in space.cell(t).iter().enumerate() {
            share(&corners_of_node(place), node, &mut sums);
        }
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum.map(|s| s / count) } else { sum }).collect()
}

/// The corners of the edge, face or cell that a node of a cell is in the middle of.
fn corners_of_node(place: usize) -> Vec<usize> {
    let place = super::lagrange::PLACES[place];
    let fits = |c: usize| (0..3).all(|axis| place[axis] == 1 || usize::from(place[axis] / 2) == c >> axis & 1);
    (0..8).filter(|c| fits(*c)).collect()
}

impl Fit {
    fn new(samples: Vec<(DVec3, SymTensor)>) -> Self {
        let count = samples.len() as f64;
        let centre = samples.iter().map(|s| s.0).sum::<DVec3>() / count;
        let mut covariance = DMat3::ZERO;
        for (x, _) in &samples {
            let d = *x - centre;
            covariance += DMat3::from_cols(d.x * d, d.y * d, d.z * d) * (1.0 / count);
        }
        let mut fit = Self { centre, unit: whitening(covariance), coefficients: [[0.0; 6]; TERMS] };
        // Gram-Schmidt on the monomials, lowest degree first; what the samples cannot tell is left out.
        let columns: Vec<[f64; TERMS]> = samples.iter().map(|(x, _)| fit.monomials(*x)).collect();
        let mut basis: Vec<(Vec<f64>, [f64; TERMS])> = Vec::new();
        for term in 0..TERMS {
            let mut column: Vec<f64> = columns.iter().map(|c| c[term]).collect();
            let mut of_monomials = [0.0; TERMS];
            of_monomials[term] = 1.0;
            let before = norm(&column);
            for (other, others) in &basis {
                let part = dot(&column, other);
                column.iter_mut().zip(other).for_each(|(x, o)| *x -= part * o);
                of_monomials.iter_mut().zip(others).for_each(|(x, o)| *x -= part * o);
            }
            let left = norm(&column);
            if left > DEPENDENT * before {
                column.iter_mut().for_each(|x| *x /= left);
                of_monomials.iter_mut().for_each(|x| *x /= left);
                basis.push((column, of_monomials));
            }
        }
        for (column, of_monomials) in &basis {
            for c in 0..6 {
                let part: f64 = column.iter().zip(&samples).map(|(x, (_, s))| x * s[c]).sum();
                fit.coefficients.iter_mut().zip(of_monomials).for_each(|(sum, m)| sum[c] += part * m);
            }
        }
        fit
    }

    fn monomials(&self, x: DVec3) -> [f64; TERMS] {
        let DVec3 { x, y, z } = self.unit * (x - self.centre);
        [1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
    }

    fn at(&self, x: DVec3) -> SymTensor {
        let mut stress = [0.0; 6];
        for (m, coefficient) in self.monomials(x).iter().zip(&self.coefficients) {
            stress.iter_mut().zip(coefficient).for_each(|(sum, c)| *sum += m * c);
        }
        stress
    }
}

/// The inverse of the Cholesky factor of a covariance.
fn whitening(covariance: DMat3) -> DMat3 {
    let a = |i: usize, j: usize| covariance.col(j)[i];
    let root = |x: f64, of: f64| x.max(1e-24 * of).max(f64::MIN_POSITIVE).sqrt();
    let trace = a(0, 0) + a(1, 1) + a(2, 2);
    let l00 = root(a(0, 0), trace);
    let (l10, l20) = (a(1, 0) / l00, a(2, 0) / l00);
    let l11 = root(a(1, 1) - l10 * l10, trace);
    let l21 = (a(2, 1) - l20 * l10) / l11;
    let l22 = root(a(2, 2) - l20 * l20 - l21 * l21, trace);
    DMat3::from_cols(DVec3::new(l00, l10, l20), DVec3::new(0.0, l11, l21), DVec3::new(0.0, 0.0, l22)).inverse()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
