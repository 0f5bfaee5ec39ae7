//! Solving `K u = f` under prescribed displacements.

mod amg;
mod cg;
mod cholesky;
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

/// Units of rounding that a residual at the limit of double precision may hold for each term `|K||u| + |f|` of its sums.
/// A backward stable solution has about one; nodal forces have at most some dozens of terms.
const ROUNDING_UNITS: f64 = 32.0;

/// Those within which iterations end as well as the direct method does.
const FEW_UNITS: f64 = 4.0;

/// Largest relative residual that counts as rounding. The error of the solution is of its order: above, the solution says
/// nothing about its load, as where a mechanism is left free and the matrix is singular.
const LARGEST_ROUNDING: f64 = 1e-5;

/// How a system was solved.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverInfo {
    /// "direct", "amg-cg", or "none" where nothing was to be solved.
    pub method: &'static str,
    /// Why this method, and whether its residual is at the limit of double precision instead of the tolerance.
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

/// Solves for the displacements, from a first guess of them at the nodes if there is one. The same bytes result on any number
/// of threads.
///
/// # Errors
/// [`FemError`] if numbers leave the range of double precision, the matrix is not positive definite, memory does not
/// suffice, or the true residual stays above the tolerance and above what rounding explains: there is never a result above
/// both. On slender bodies `|K||u|` exceeds `|b|` by far, and with it the residual of the best solution that can be
/// represented; [`SolverInfo::reason`] says where that was accepted.
pub fn solve(system: &System, options: &SolverOptions, start: Option<&[DVec3]>) -> Result<Solved, FemError> {
    solve_keeping(system, options, start, &mut Kept::default())
}

/// What solving makes of a matrix: its factor, or a preconditioner.
#[derive(Default)]
pub struct Kept {
    factor: Option<cholesky::Factor>,
    hierarchy: Option<amg::Hierarchy<f32>>,
}

/// Solves as [`solve`] does, with the factor or preconditioner that an earlier solution kept, and keeps its own. What is kept
/// holds for one matrix and one set of unknowns; loads and prescribed values may change.
///
/// # Errors
/// As [`solve`].
pub fn solve_keeping(
    system: &System,
    options: &SolverOptions,
    start: Option<&[DVec3]>,
    kept: &mut Kept,
) -> Result<Solved, FemError> {
    let problem = Problem::new(system, options.tolerance)?;
    if problem.scale == 0.0 {
        return Ok(problem.nothing_to_solve());
    }
    if let Some(factor) = &kept.factor {
        return direct::solve(&problem, factor, "factor at hand".to_owned());
    }
    match options.method {
        Method::AmgCg => cg::Run::new(&problem, start).solve("asked for".to_owned(), kept),
        Method::Direct => factorise(&problem, direct::analyse(system)?, "asked for".to_owned(), kept),
        Method::Auto => solve_auto(&problem, start, options.direct_memory_limit, kept),
    }
}

/// Factorises, solves, and keeps the factor.
fn factorise(
    problem: &Problem,
    analysis: cholesky::Analysis,
    reason: String,
    kept: &mut Kept,
) -> Result<Solved, FemError> {
    let factor = kept.factor.insert(analysis.factorise()?);
    direct::solve(problem, factor, reason)
}

/// Direct for small systems; else conjugate gradients, and direct if they converge slowly or end above the tolerance, and memory
/// suffices. Of two solutions above the tolerance the better one.
fn solve_auto(problem: &Problem, start: Option<&[DVec3]>, limit: u64, kept: &mut Kept) -> Result<Solved, FemError> {
    let unknowns = problem.system.free_dofs();
    let mut reason = format!("{unknowns} unknowns");
    let mut run = cg::Run::new(problem, start);
    if unknowns > SMALL {
        reason += &format!(", more than {SMALL}");
        let end = match run.for_a_while(&mut reason, kept) {
            Ok(()) if run.is_done(FEW_UNITS) => return run.finish(reason),
            Ok(()) => "",
            Err(FemError::Multigrid { .. } | FemError::NotPositiveDefinite { .. }) => ", where they broke down",
            Err(error) => return Err(error),
        };
        let (residual, iterations) = (run.relative, run.iterations);
        reason += &format!(", conjugate gradients at residual {residual:.1e} after {iterations} iterations{end}");
    }
    let analysis = direct::analyse(problem.system)?;
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    let (bytes, most) = (megabytes(analysis.factor_bytes()), megabytes(limit));
    reason += &format!("; the factor takes {bytes:.3} MB, the limit is {most:.3} MB");
    if analysis.factor_bytes() > limit {
        drop(analysis);
        return if run.is_done(ROUNDING_UNITS) { run.finish(reason) } else { run.solve(reason, kept) };
    }
    kept.hierarchy = None;
    match factorise(problem, analysis, reason.clone(), kept) {
        Ok(direct) if direct.info.residual <= problem.tolerance.max(run.relative) => Ok(direct),
        direct if !run.is_done(ROUNDING_UNITS) => direct,
        _ => run.finish(reason + "; the direct method did no better"),
    }
}

/// Numbers that the Cholesky factor of a system holds, for the direct method: found by ordering the unknowns, without factorising.
///
/// # Errors
/// [`FemError::Ordering`].
pub fn factor_numbers(system: &System) -> Result<usize, FemError> {
    Ok(direct::analyse(system)?.nonzeros())
}

/// The multigrid that conjugate gradients are preconditioned by, by itself: for measurements.
pub struct Multigrid(amg::Hierarchy<f32>);

impl Multigrid {
    /// Sets it up.
    ///
    /// # Errors
    /// [`FemError::Multigrid`], and those of the factorisation on its last level.
    pub fn new(system: &System) -> Result<Self, FemError> {
        amg::Hierarchy::of(system, None).map(Self)
    }

    /// One cycle: `z`, about the displacement of the nodal forces `r`, which are zero where displacements are prescribed.
    ///
    /// # Errors
    /// As the factorisation's.
    pub fn cycle(&mut self, r: &[DVec3], z: &mut [DVec3]) -> Result<(), FemError> {
        self.0.apply(r, norm(r), z)
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
    /// # Errors
    /// [`FemError::OutOfRange`].
    fn new(system: &'a System, tolerance: f64) -> Result<Self, FemError> {
        let lifting = system.numbering.lifting();
        let rhs = residual(system, &lifting);
        let scale = norm(&rhs);
        let out_of_range = |what| Err(FemError::out_of_range(what));
        if !system.stiffness.blocks.par_iter().with_min_len(super::block_matrix::CHUNK).all(glam::DMat3::is_finite) {
            return out_of_range("stiffness matrix");
        }
        if !scale.is_finite() || (scale == 0.0 && rhs.iter().any(|f| *f != DVec3::ZERO)) {
            return out_of_range("right-hand side");
        }
        Ok(Self { system, scale, lifting, rhs, tolerance })
    }

    /// Displacement and residual to begin with: those of the guess, unless it is worse than none.
    ///
    /// Conjugate gradients lower the energy `d.K d / 2 - b.d = -d.(b + r) / 2` of the unknown part d with its residual r.
    /// A guess from a coarser mesh has a low energy and yet a large residual, for it has kinks in the wrong places.
    fn start(&self, guess: Option<&[DVec3]>) -> (Vec<DVec3>, Vec<DVec3>) {
        if let Some(guess) = guess.filter(|guess| guess.len() == self.lifting.len()) {
            let mask = self.system.numbering.mask();
            let u: Vec<DVec3> = (0..guess.len()).map(|i| self.lifting[i] + mask[i] * guess[i]).collect();
            let remainder = residual(self.system, &u);
            let gain = |i: usize| (u[i] - self.lifting[i]).dot(self.rhs[i] + remainder[i]);
            // Refuses NaN too.
            if (0..u.len()).map(gain).sum::<f64>() > 0.0 {
                return (u, remainder);
            }
        }
        (self.lifting.clone(), self.rhs.clone())
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

    /// True if the relative residual of `u` is no more than rounding makes of it: `|r|` is within `units`
    /// eps `| |K||u| + |f| |`, taken over the unknowns and by components.
    fn is_rounding(&self, residual: f64, u: &[DVec3], units: f64) -> bool {
        let system = self.system;
        let terms = |i: usize| {
            let products = system.stiffness.row(i).map(|(j, block)| block.abs() * u[j].abs());
            system.numbering.mask()[i] * (products.sum::<DVec3>() + system.loads[i].abs())
        };
        let sizes: Vec<DVec3> =
            (0..u.len()).into_par_iter().with_min_len(super::block_matrix::CHUNK).map(terms).collect();
        let attainable = units * f64::EPSILON * norm(&sizes) / self.scale;
        !self.tolerance.is_nan() && residual <= attainable.min(LARGEST_ROUNDING)
    }
}

/// What [`SolverInfo::reason`] adds where the tolerance cannot be met in double precision.
fn at_the_limit(reason: &str, residual: f64) -> String {
    format!("{reason}; residual {residual:.1e} is at the limit of double precision")
}

/// The error for a residual above the tolerance that is no rounding.
fn not_converged(
    problem: &Problem,
    method: &'static str,
    iterations: usize,
    residual: f64,
    help: &'static str,
) -> FemError {
    if !residual.is_finite() {
        return FemError::out_of_range("solution");
    }
    FemError::NotConverged { method, iterations, residual, tolerance: problem.tolerance, help }
}

/// `f - K u` at the unknowns, zero elsewhere.
pub(super) fn residual(system: &System, u: &[DVec3]) -> Vec<DVec3> {
    let mask = system.numbering.mask();
    let at = |i: usize| mask[i] * (system.loads[i] - system.stiffness.row_times(i, u));
    (0..u.len()).into_par_iter().with_min_len(super::block_matrix::CHUNK).map(at).collect()
}
