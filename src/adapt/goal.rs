//! The error of a quantity, from those of the problem and of its dual problem.
//!
//! The error `J(u) - J(u_h)` of a quantity is `a(e, e*)` ([`Goal`](crate::fem::Goal) tells why, and what adds where a prescribed
//! displacement is missed between the nodes). With the errors d and d* of the stresses that recovery finds it is estimated by
//!
//! ```text
//! E = sum of E_K,  E_K = int_K d : C^-1 : d* + what d makes of the part of the goal that the elements do not see
//! ```
//!
//! which is a quarter of the difference of the recovered energies of the errors of `s u + z / s` and `s u - z / s` (the
//! parallelogram identity), as recovery is linear. It is added to the quantity (Pierce and Giles 2000), which is more
//! accurate for it. The error bar of the sum takes each share to be between once and twice what recovery finds, whatever its
//! sign, as effectivities from 0.7 to 1 mean it for squares: `|E| / 2 + sum |E_K| / 2`. Added are bounds of what recovery does
//! not see, `unseen_K eta*_K` and its like. All is multiplied by `1 + 3 (6 / n)^(1/3)`, with `n = (sum |E_K|)^2 / sum E_K^2` cells
//! that hold the error: as many fill a cube of `(n / 6)^(1/3)` cells across, and the relative error of recovery is taken to be of
//! the order of their size. Where cells lock, `|E_K|` times what that raised both errors by is added. The bar is an estimate all the same: none holds on meshes that do not show the solution at all.
//!
//! The residual estimator knows no signs. With it nothing is added, and the bar is the sum of the products `eta_K eta*_K`, and
//! of what is missed of prescribed displacements.
//!
//! Marking takes `|E_K|` for the squared error of a cell, and a fifth of `eta_K eta*_K`, lest a cell whose d and d* are
//! orthogonal by chance is passed over; refinement is worth its price where the error of the displacement is large and matters
//! (Becker and Rannacher 2001).

use super::estimate::{CellErrors, mass};
use super::options::Estimator;
use crate::fem::{Data, Stress, SymTensor, double_contraction, traction};
use crate::mesh::quality::EDGES;
use crate::mesh::{Face, topology};
use glam::DVec3;
use rayon::prelude::*;

/// What the product of both errors of a cell counts for beside their integral.
const CHANCE: f64 = 0.2;

/// A problem, what solved it, and its estimated errors.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// The data of the problem.
    pub data: &'a Data<'a>,
    /// Displacement of each node.
    pub displacement: &'a [DVec3],
    /// The stress of the elements.
    pub stress: &'a Stress,
    /// Estimated errors.
    pub errors: &'a CellErrors,
}

/// The estimated error of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct GoalError {
    /// Estimate of J(u) - J(u_h), to be added to J(u_h).
    pub correction: f64,
    /// Error bar of the sum; NaN where the error of a cell is not known.
    pub bar: f64,
    /// What marking takes for the squared error of each cell.
    pub cells: Vec<f64>,
}

/// Estimates the error of the quantity whose dual problem is `dual`.
#[must_use]
pub fn goal_error(primal: Side<'_>, dual: Side<'_>, estimator: Estimator) -> GoalError {
    let count = primal.stress.cells();
    let shares = (0..count).into_par_iter().map(|t| product(primal, dual, t) + cut(primal, dual, t));
    let mut shares: Vec<f64> = shares.collect();
    let missed = at_supports(primal, dual);
    let size = |t: usize| (primal.errors.squared[t] * dual.errors.squared[t]).sqrt();
    if estimator == Estimator::Residual {
        let mut cells: Vec<f64> = (0..count).map(size).collect();
        missed.into_iter().for_each(|(t, value)| cells[t] += value.abs());
        return GoalError { correction: 0.0, bar: cells.iter().sum(), cells };
    }
    missed.into_iter().for_each(|(t, value)| shares[t] += value);
    let cells = (0..count).map(|t| shares[t].abs() + CHANCE * size(t)).collect();
    if !(primal.errors.unestimated.is_empty() && dual.errors.unestimated.is_empty()) {
        return GoalError { correction: 0.0, bar: f64::NAN, cells };
    }
    let correction: f64 = shares.iter().sum();
    let sizes: f64 = shares.iter().map(|share| share.abs()).sum();
    let squares: f64 = shares.iter().map(|share| share * share).sum();
    let holders = if squares > 0.0 { sizes * sizes / squares } else { 1.0 };
    let coarse = 1.0 + 3.0 * (6.0 / holders).cbrt();
    let sizes = sizes + 2.0 * locked(primal, dual, &shares);
    GoalError { correction, bar: coarse * (0.5 * (correction.abs() + sizes) + unseen(primal, dual)), cells }
}

/// What locking may add to the shares, by how much it raised both errors.
fn locked(primal: Side<'_>, dual: Side<'_>, shares: &[f64]) -> f64 {
    let regions = primal.data.space.mesh().regions().iter().map(|r| r.0 as usize);
    let raised = |r: usize| primal.errors.raised[r] * dual.errors.raised[r] - 1.0;
    regions.zip(shares).map(|(r, share)| raised(r) * share.abs()).sum()
}

/// What data that the elements do not see may make of the quantity; but for that of a stress in cells, which [`cut`] finds.
fn unseen(primal: Side<'_>, dual: Side<'_>) -> f64 {
    let sum = |side: Side<'_>, other: Side<'_>| {
        let pairs = side.errors.unseen.iter().zip(&other.errors.squared);
        pairs.map(|(unseen, squared)| (unseen * squared).sqrt()).sum::<f64>()
    };
    let of_stress = dual.data.in_cells().is_some_and(|goal| goal.weight != [0.0; 6]);
    sum(primal, dual) + if of_stress { 0.0 } else { sum(dual, primal) }
}

/// The integral of `d : C^-1 : d*` over cell `t`.
fn product(primal: Side<'_>, dual: Side<'_>, t: usize) -> f64 {
    let (d, z) = (differences(primal, t), differences(dual, t));
    let material = primal.data.material(t);
    let mut sum = 0.0;
    for (a, d) in d.iter().enumerate() {
        let mut weighted = [0.0; 6];
        for (b, other) in z.iter().enumerate() {
            let mass = mass(z.len(), a, b);
            weighted.iter_mut().zip(other).for_each(|(w, z)| *w += mass * z);
        }
        sum += double_contraction(material.strain(*d), weighted);
    }
    primal.data.space.mesh().cell_volume(t) * sum
}

/// The recovered stress less that of the elements at the nodes of cell `t`.
fn differences(side: Side<'_>, t: usize) -> Vec<SymTensor> {
    let at = |a: usize| {
        let ends = if a < 4 { [a, a] } else { EDGES[a - 4] };
        let mut l = [0.0; 4];
        ends.iter().for_each(|&i| l[i] += 0.5);
        side.stress.at(t, l)
    };
    let difference = |(a, s): (usize, SymTensor)| {
        let own = at(a);
        std::array::from_fn(|i| s[i] - own[i])
    };
    side.errors.recovered.of_cell(t).enumerate().map(difference).collect()
}

/// What the part of a goal's stress that the elements do not see in cell `t` adds.
fn cut(primal: Side<'_>, dual: Side<'_>, t: usize) -> f64 {
    let Some(goal) = dual.data.in_cells() else { return 0.0 };
    let space = primal.data.space;
    let share = goal.share(space, t);
    if share.rest == 0.0 || goal.weight == [0.0; 6] {
        return 0.0;
    }
    let differences = differences(primal, t);
    let at = |l: [f64; 4]| {
        let mut sum = [0.0; 6];
        for (d, n) in differences.iter().zip(space.shape(l)) {
            sum.iter_mut().zip(d).for_each(|(s, d)| *s += n * d);
        }
        double_contraction(goal.weight, sum)
    };
    let inside: f64 = share.points.iter().map(|(l, w)| w * at(*l)).sum();
    let linear = |l: [f64; 4]| share.corners.iter().zip(l).map(|(c, l)| c * l).sum::<f64>();
    let seen: f64 = space.cell_rule(t).into_iter().map(|(l, _, w)| w * linear(l) * at(l)).sum();
    inside - seen
}

/// What is missed of prescribed displacements between the nodes, with the cells it happens at.
fn at_supports(primal: Side<'_>, dual: Side<'_>) -> Vec<(usize, f64)> {
    let mesh = primal.data.space.mesh();
    let varies = |face: &Face| primal.data.held(face).iter().flatten().any(|f| f.constant().is_none());
    if !mesh.faces().iter().any(varies) {
        return Vec::new();
    }
    let cells = topology::boundary_cells(mesh.tets());
    let faces = mesh.faces().par_iter().zip(cells).filter(|(face, _)| varies(face));
    faces.map(|(face, t)| (t as usize, at_support(primal, dual, face, t as usize))).collect()
}

/// `- int (u_D - u_h) . s(z) n dA` over a face of cell `t` in the components held, with the recovered stress of z.
fn at_support(primal: Side<'_>, dual: Side<'_>, face: &Face, t: usize) -> f64 {
    let space = primal.data.space;
    let held = primal.data.held(face);
    let corners = space.mesh().tets()[t].map(|v| face.vertices.iter().position(|&w| w == v));
    let recovered: Vec<SymTensor> = dual.errors.recovered.of_cell(t).collect();
    let mut sum = 0.0;
    for (l, x, area) in space.face_rule(face) {
        let in_cell = corners.map(|k| k.map_or(0.0, |k| l[k]));
        let u = space.interpolate(primal.displacement, t, in_cell);
        let mut stress = [0.0; 6];
        for (s, n) in recovered.iter().zip(space.shape(in_cell)) {
            stress.iter_mut().zip(s).for_each(|(sum, s)| *sum += n * s);
        }
        let force = traction(stress, area);
        for (c, field) in held.iter().enumerate() {
            sum -= field.map_or(0.0, |field| (field.at(x) - u[c]) * force[c]);
        }
    }
    sum
}
