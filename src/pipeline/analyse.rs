//! One mesh analysed: solved, its stress recovered, its error estimated.

use super::look_ahead::Seen;
use super::quantities;
use super::resolve::Resolved;
use super::simulate::{Plan, timed};
use crate::adapt::{self, CellErrors, GoalError, Side};
use crate::error::Error;
use crate::fem::options::{Method, SolverOptions};
use crate::fem::{self, Data, FemError, Goal, Kept, Solution, Space, System};
use crate::mesh::{TetMesh, quality};
use crate::output::report::{ErrorRecord, MeshCounts, PhaseSeconds, SolverRecord, StepRecord};
use glam::DVec3;

/// The solution on a mesh and its estimated error.
pub(super) struct Analysed<'m> {
    pub space: Space<'m>,
    pub solution: Solution,
    pub errors: CellErrors,
    /// The error of the quantity that the scenario aims at.
    pub goal: Option<GoalError>,
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
    let mut kept = Kept::default();
    let options = &plan.scenario.solver;
    let solved = timed(&mut seconds.solve, || fem::solve_keeping(&system, options, guess, &mut kept))?;
    let kept = problem.goal.map(|_| kept);
    phase.say(format!("step {index}: estimate the error"));
    let estimator = plan.scenario.adapt.estimator;
    let (solution, errors) = timed(&mut seconds.estimate, || {
        let solution = fem::recover(&space, &problem.model, &system, &solved);
        let data = Data::new(&space, &problem.model, problem.exact.as_ref());
        let errors = adapt::estimate_solved(&data, &solution.displacement, &solution.stress, estimator);
        (solution, errors)
    });
    let (dofs, free_dofs) = (system.dofs(), system.free_dofs());
    let mut analysed = Analysed { space, solution, errors, goal: None, dofs, free_dofs };
    if let (Some(goal), Some(kept)) = (problem.goal, kept) {
        phase.say(format!("step {index}: solve the dual problem of `{}`", problem.quantities[goal].name));
        analysed.goal = goal_error(&analysed, problem, plan, (system, kept), seconds)?;
    }
    Ok(analysed)
}

/// The error of the quantity that the scenario aims at, by its dual problem.
fn goal_error(
    analysed: &Analysed<'_>,
    problem: &Resolved,
    plan: &Plan<'_>,
    (system, mut kept): (System, Kept),
    seconds: &mut PhaseSeconds,
) -> Result<Option<GoalError>, FemError> {
    let kind = problem.goal.map(|q| problem.quantities[q].kind);
    let Some(goal) = kind.and_then(|kind| Goal::new(&analysed.space, &problem.model, kind)) else { return Ok(None) };
    let (space, estimator) = (&analysed.space, plan.scenario.adapt.estimator);
    let unbalanced = system.unbalanced(&analysed.solution.displacement);
    let system = timed(&mut seconds.assemble, || goal.system(space, system))?;
    let solved = timed(&mut seconds.solve, || fem::solve_keeping(&system, &plan.scenario.solver, None, &mut kept))?;
    Ok(timed(&mut seconds.estimate, || {
        let dual = fem::recover(space, goal.model(), &system, &solved);
        let [data, of_goal] = [Data::new(space, &problem.model, problem.exact.as_ref()), Data::of_goal(space, &goal)];
        let errors = adapt::estimate_solved(&of_goal, &dual.displacement, &dual.stress, estimator);
        let primal = side(&data, &analysed.solution, &analysed.errors);
        let mut error = adapt::goal_error(primal, side(&of_goal, &dual, &errors), estimator);
        // What the solver's residual makes of the quantity: the forces that are not balanced times the dual solution.
        error.bar += unbalanced.iter().zip(&dual.displacement).map(|(f, z)| f.dot(*z)).sum::<f64>().abs();
        Some(error)
    }))
}

fn side<'a>(data: &'a Data<'a>, solution: &'a Solution, errors: &'a CellErrors) -> Side<'a> {
    Side { data, displacement: &solution.displacement, stress: &solution.stress, errors }
}

impl Analysed<'_> {
    /// What refinement is to make small in each cell, in squares: the estimated error, or its share in that of the quantity
    /// aimed at.
    pub(super) fn indicators(&self) -> &[f64] {
        self.goal.as_ref().map_or(&self.errors.squared, |goal| &goal.cells)
    }

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

    /// Value and error bar of the quantity aimed at.
    pub(super) fn goal_value(&self, problem: &Resolved) -> Option<(f64, f64)> {
        let goal = self.goal.as_ref()?;
        Some((quantities::value(problem, self, problem.goal?) + goal.correction, goal.bar))
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
            data: self.errors.unseen(),
            normalised_mean: mean(squared.iter().map(|e| e.sqrt()).sum(), unit),
            normalised_mean_square: mean(squared.iter().sum(), unit * unit),
            true_energy: exact.map(|e| e.energy),
            true_relative: exact.map(|e| e.relative),
            effectivity: exact.map(|e| self.errors.energy() / e.energy),
        }
    }
}
