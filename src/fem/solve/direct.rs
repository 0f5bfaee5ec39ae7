//! The direct method: Cholesky factorisation of the matrix of the unknowns, and iterative refinement.

use super::cholesky::{Analysis, Factor, Lower};
use super::ordering::Graph;
use super::{Problem, ROUNDING_UNITS, Solved, SolverInfo, at_the_limit, not_converged, residual};
use crate::fem::block_matrix::norm;
use crate::fem::{FemError, System};

/// Steps of iterative refinement before giving up.
const MAX_REFINEMENTS: usize = 3;

/// What to do where they do not help.
const HELP: &str = "the matrix is nearly singular: check supports, nearly flat cells and Poisson's ratio near 1/2";

/// Orders the unknowns and finds the structure of the factor.
///
/// # Errors
/// [`FemError::Ordering`].
pub(super) fn analyse(system: &System) -> Result<Analysis, FemError> {
    let unknowns: Vec<(usize, usize)> = system.numbering.unknowns().collect();
    let mut nodes: Vec<usize> = unknowns.iter().map(|u| u.0).collect();
    nodes.dedup();
    let mut first_unknown = Vec::with_capacity(nodes.len() + 1);
    first_unknown.extend((0..unknowns.len()).filter(|&k| k == 0 || unknowns[k - 1].0 != unknowns[k].0));
    first_unknown.push(unknowns.len());
    Analysis::new(lower_triangle(system, &unknowns), &mut node_graph(system, &nodes)?, &first_unknown)
}

/// The graph of the nodes listed (ascending), numbered by their place in the list.
fn node_graph(system: &System, nodes: &[usize]) -> Result<Graph, FemError> {
    let too_large = |_| FemError::Ordering("too many couplings for METIS's 32-bit indices".to_owned());
    let mut place = vec![-1_i32; system.stiffness.rows()];
    for (k, &node) in nodes.iter().enumerate() {
        place[node] = i32::try_from(k).map_err(too_large)?;
    }
    let (mut starts, mut neighbours) = (vec![0], Vec::with_capacity(system.stiffness.columns.len()));
    for &node in nodes {
        let others = system.stiffness.row(node).filter(|(j, _)| *j != node);
        neighbours.extend(others.map(|(j, _)| place[j]).filter(|&k| k >= 0));
        starts.push(i32::try_from(neighbours.len()).map_err(too_large)?);
    }
    Ok(Graph { starts, neighbours })
}

/// The lower triangle of the matrix of the unknowns; `unknowns[k]` is the node and component of number k, both ascend.
fn lower_triangle(system: &System, unknowns: &[(usize, usize)]) -> Lower {
    const PRESCRIBED: usize = usize::MAX;
    let mut number = vec![[PRESCRIBED; 3]; system.stiffness.rows()];
    for (k, &(i, c)) in unknowns.iter().enumerate() {
        number[i][c] = k;
    }
    let bound = 9 * (system.stiffness.blocks.len() + system.stiffness.rows()) / 2;
    let mut lower = Lower { starts: vec![0], rows: Vec::with_capacity(bound), values: Vec::with_capacity(bound) };
    for (k, &(i, c)) in unknowns.iter().enumerate() {
        // The matrix is symmetric: column k of the lower triangle is row k from the diagonal on.
        for (j, block) in system.stiffness.row(i).filter(|(j, _)| *j >= i) {
            let below = |row: &usize| (k..PRESCRIBED).contains(row);
            for (d, &row) in number[j].iter().enumerate().filter(|(_, row)| below(row)) {
                lower.rows.push(row);
                lower.values.push(block.col(d)[c]);
            }
        }
        lower.starts.push(lower.rows.len());
    }
    lower
}

/// Solves with a factor; refines while the true residual is above the tolerance. What refinement cannot lower is
/// accepted if it is rounding.
///
/// # Errors
/// [`FemError::OutOfMemory`], [`FemError::NotConverged`].
pub(super) fn solve(problem: &Problem, factor: &Factor, reason: String) -> Result<Solved, FemError> {
    let nonzeros = factor.nonzeros();
    let unknowns = || problem.system.numbering.unknowns();
    let mut displacement = problem.lifting.clone();
    let (mut remainder, mut relative) = (problem.rhs.clone(), 1.0);
    let found = |displacement, reason, iterations, residual| {
        let info = SolverInfo { method: "direct", reason, iterations, residual, nonzeros };
        Ok(Solved { displacement, info })
    };
    for iterations in 0..=MAX_REFINEMENTS {
        let mut correction: Vec<f64> = unknowns().map(|(i, c)| remainder[i][c]).collect();
        factor.solve(&mut correction)?;
        for ((i, c), du) in unknowns().zip(correction) {
            displacement[i][c] += du;
        }
        remainder = residual(problem.system, &displacement);
        relative = norm(&remainder) / problem.scale;
        if problem.accepts(relative) {
            return found(displacement, reason, iterations, relative);
        }
    }
    if problem.is_rounding(relative, &displacement, ROUNDING_UNITS) {
        return found(displacement, at_the_limit(&reason, relative), MAX_REFINEMENTS, relative);
    }
    Err(not_converged(problem, "sparse Cholesky", MAX_REFINEMENTS, relative, HELP))
}
