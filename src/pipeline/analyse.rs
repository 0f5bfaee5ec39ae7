//! One mesh analysed: solved, its stress recovered, its error estimated.

use super::look_ahead::Seen;
use super::quantities;
use super::resolve::Resolved;
use super::simulate::{Plan, timed};
use crate::adapt::{self, CellErrors};
use crate::error::Error;
use crate::fem::options::{Method, SolverOptions};
use crate::fem::{self, Solution, Space};
use crate::mesh::{TetMesh, quality};
use crate::output::report::{ErrorRecord, MeshCounts, PhaseSeconds, SolverRecord, StepRecord};
use glam::DVec3;

/// The solution on a mesh and its estimated error.
pub(super) struct Analysed<'m> {
    pub space: Space<'m>,
    pub solution: Solution,
    pub errors: CellErrors,
    dofs: usize,
    free_dofs: usize,
}

/// Assembles, solves (from a guess of the displacement), recovers, estimates, and adds the times to `seconds`.
///
/// # Errors
/// [`Error::Fem`]: the model is ill-posed, or the solver failed.
pub(super) fn analyse<'m>(
    index: usize,
    mesh: &'m TetMesh,
    problem: &Resolved,
    plan: &Plan<'_>,
    guess: Option<&[DVec3]>,
    seconds: &mut PhaseSeconds,
) -> Result<Analysed<'m>, Error> {
    let phase = plan.progress.phase(format!("step {index}: assemble {} cells", mesh.tets().len()));
    let (space, system) = timed(&mut seconds.assemble, || {
        // Refinement makes edges straight.
        let midsides = if index == 0 { &problem.midsides[..] } else { &[] };
        let space = Space::new(mesh, plan.scenario.element, midsides);
        let mut system = fem::assemble(&space, &problem.model)?;
        if let Some(exact) = &problem.exact {
            exact.add_loads(&space, &mut system);
        }
        Ok::<_, fem::FemError>((space, system))
    })?;
    phase.say(format!("step {index}: solve {} equations", system.free_dofs()));
    let solved = timed(&mut seconds.solve, || fem::solve(&system, &plan.scenario.solver, guess))?;
    phase.say(format!("step {index}: estimate the error"));
    let estimator = plan.scenario.adapt.estimator;
    let (solution, errors) = timed(&mut seconds.estimate, || {
        let solution = fem::recover(&space, &problem.model, &system, &solved);
        let errors = adapt::estimate(&space, &problem.model.materials, &solution.stress, estimator);
        (solution, errors)
    });
    Ok(Analysed { space, solution, errors, dofs: system.dofs(), free_dofs: system.free_dofs() })
}

impl Analysed<'_> {
    /// What the solution says of the displacement at the nodes of a refined mesh; nothing where no solver wants to know.
    pub(super) fn guess(&self, refined: &TetMesh, solver: &SolverOptions) -> Option<Vec<DVec3>> {
        if solver.method == Method::Direct {
            return None;
        }
        let space = Space::new(refined, self.space.element(), &[]);
        Some(self.space.at_places(&self.solution.displacement, space.points()))
    }

    /// Estimated error of the displacement in the energy norm, relative to the norm of the displacement.
    pub(super) fn relative_error(&self) -> f64 {
        self.errors.relative(self.solution.strain_energy)
    }

    /// Largest estimated error of a cell, in the energy norm; NaN if no cell has an estimate other than zero and some have
    /// none.
    pub(super) fn largest_error(&self) -> f64 {
        let largest = self.errors.squared.iter().copied().fold(0.0, f64::max).sqrt();
        if largest == 0.0 && !self.errors.unestimated.is_empty() { f64::NAN } else { largest }
    }

    /// What looking ahead needs of it.
    pub(super) fn seen(&self) -> Seen {
        let cells = self.space.mesh().tets().len() as f64;
        Seen { cells, dofs: self.dofs as f64, error: self.relative_error(), selected: 0.0 }
    }

    /// What is recorded of it; `unit` is the largest error of a cell at step 0.
    pub(super) fn record(&self, problem: &Resolved, unit: f64) -> StepRecord {
        let mesh = self.space.mesh();
        let info = &self.solution.info;
        let supports = problem.model.supports.iter().zip(&self.solution.reactions);
        StepRecord {
            step: 0,
            mesh: MeshCounts::of(mesh),
            dofs: self.dofs,
            free_dofs: self.free_dofs,
            selected: 0,
            strain_energy: self.solution.strain_energy,
            max_displacement: self.solution.displacement.iter().copied().map(DVec3::length).fold(0.0, f64::max),
            error: self.error_record(problem, unit),
            quality: quality::quality(mesh).into(),
            solver: SolverRecord {
                method: info.method.to_owned(),
                reason: info.reason.clone(),
                iterations: info.iterations,
                residual: info.residual,
                nonzeros: info.nonzeros,
            },
            seconds: PhaseSeconds::default(),
            peak_memory_bytes: 0,
            reactions: supports.map(|(s, r)| (s.name.clone(), r.to_array())).collect(),
            quantities: quantities::values(problem, self),
        }
    }

    fn error_record(&self, problem: &Resolved, unit: f64) -> ErrorRecord {
        let exact = problem.exact.map(|e| e.error(&self.space, &problem.model, &self.solution));
        let squared = &self.errors.squared;
        // Where nothing has an error, the normalised error is zero too.
        let mean = |sum: f64, unit: f64| if unit == 0.0 { 0.0 } else { sum / squared.len() as f64 / unit };
        ErrorRecord {
            energy: self.errors.energy(),
            relative: self.relative_error(),
            normalised_mean: mean(squared.iter().map(|e| e.sqrt()).sum(), unit),
            normalised_mean_square: mean(squared.iter().sum(), unit * unit),
            true_energy: exact.map(|e| e.energy),
            true_relative: exact.map(|e| e.relative),
            effectivity: exact.map(|e| self.errors.energy() / e.energy),
        }
    }
}
