//! Solving `K u = f` under prescribed displacements.

mod cg;
mod cholesky;
mod coarse;
mod direct;
mod ordering;

use super::block_matrix::norm;
use super::options::{Method, SolverOptions};
use super::{FemError, System};
use glam::DVec3;
use rayon::prelude::*;

/// Unknowns up to which [`Method::Auto`] starts with the direct method: below, neither takes more than some hundredths of
/// a second.
const SMALL: usize = 5_000;

/// Iterations after which [`Method::Auto`] doubts conjugate gradients: five times as many as well-shaped meshes need.
const FEW_ITERATIONS: usize = 300;

/// How a system was solved.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverInfo {
    /// "direct", "cg", or "none" where nothing was to be solved.
    pub method: &'static str,
    /// Why this method.
    pub reason: String,
    /// Iterations of conjugate gradients; steps of iterative refinement after a direct solve.
    pub iterations: usize,
    /// The true residual `|b - K u| / |b|` over the unknowns, where b holds loads and prescribed displacements.
    pub residual: f64,
    /// Numbers stored in the Cholesky factor, or in the matrix for conjugate gradients.
    pub nonzeros: usize,
}

/// The displacement of each node, and how it was found.
#[derive(Debug, Clone)]
pub struct Solved {
    /// Displacement of each node.
    pub displacement: Vec<DVec3>,
    /// How it was found.
    pub info: SolverInfo,
}

/// Solves for the displacements. The same bytes result on any number of threads.
///
/// # Errors
/// [`FemError`] if the matrix is not positive definite, memory does not suffice, or the true residual stays above the
/// tolerance: there is never a result above it.
pub fn solve(system: &System, options: &SolverOptions) -> Result<Solved, FemError> {
    let problem = Problem::new(system, options.tolerance);
    if problem.scale == 0.0 {
        return Ok(problem.nothing_to_solve());
    }
    match options.method {
        Method::Cg => cg::solve(&problem, "asked for".to_owned(), cg::MAX_ITERATIONS),
        Method::Direct => direct::solve(&problem, direct::analyse(system)?, "asked for".to_owned()),
        Method::Auto => solve_auto(&problem, options.direct_memory_limit),
    }
}

/// Direct for small systems; else conjugate gradients, and direct if they converge slowly and memory suffices.
fn solve_auto(problem: &Problem, limit: u64) -> Result<Solved, FemError> {
    let unknowns = problem.system.free_dofs();
    let mut reason = format!("{unknowns} unknowns");
    if unknowns > SMALL {
        match cg::solve(problem, format!("{reason}, more than {SMALL}"), FEW_ITERATIONS) {
            Err(FemError::NotConverged { .. }) => reason += &format!(", more than {FEW_ITERATIONS} iterations"),
            done => return done,
        }
    }
    let analysis = direct::analyse(problem.system)?;
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    let (bytes, most) = (megabytes(analysis.factor_bytes()), megabytes(limit));
    reason += &format!("; the factor takes {bytes:.3} MB, the limit is {most:.3} MB");
    if analysis.factor_bytes() <= limit {
        direct::solve(problem, analysis, reason)
    } else {
        drop(analysis);
        cg::solve(problem, reason, cg::MAX_ITERATIONS)
    }
}

/// The system reduced to its unknowns: vectors keep one entry a node, and are zero where displacements are prescribed.
struct Problem<'a> {
    system: &'a System,
    /// Displacement as prescribed, zero where unknown.
    lifting: Vec<DVec3>,
    /// The right-hand side, loads minus the forces of the prescribed displacements.
    rhs: Vec<DVec3>,
    /// Its norm.
    scale: f64,
    tolerance: f64,
}

impl<'a> Problem<'a> {
    fn new(system: &'a System, tolerance: f64) -> Self {
        let lifting = system.numbering.lifting();
        let rhs = residual(system, &lifting);
        Self { system, scale: norm(&rhs), lifting, rhs, tolerance }
    }

    fn nothing_to_solve(self) -> Solved {
        let reason = "no load and no prescribed displacement acts on an unknown".to_owned();
        let info = SolverInfo { method: "none", reason, iterations: 0, residual: 0.0, nonzeros: 0 };
        Solved { displacement: self.lifting, info }
    }

    /// True if a relative residual is small enough; false for NaN.
    fn accepts(&self, residual: f64) -> bool {
        residual <= self.tolerance
    }
}

/// `f - K u` at the unknowns, zero elsewhere.
fn residual(system: &System, u: &[DVec3]) -> Vec<DVec3> {
    let mask = system.numbering.mask();
    let at = |i: usize| mask[i] * (system.loads[i] - system.stiffness.row_times(i, u));
    (0..u.len()).into_par_iter().with_min_len(super::block_matrix::CHUNK).map(at).collect()
}
