//! One mesh analysed: solved, its stress recovered, its error estimated.

use super::look_ahead::Seen;
use super::quantities;
use super::resolve::Resolved;
use super::richer;
use super::simulate::{Plan, timed};
use super::straight::Straight;
use super::subspace;
use super::tolerance::Aim;
use crate::adapt::{self, CellErrors, GoalError, Side};
use crate::error::Error;
use crate::fem::options::{Method, SolverOptions};
use crate::fem::{self, Data, FemError, Goal, Kept, Solution, Space, System};
use crate::mesh::weights::WeightRows;
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
    /// What is to be known of its dual solution.
    pub dual: Dual,
    /// What straight edges add to the errors.
    straight: Option<Straight>,
    dofs: usize,
    free_dofs: usize,
}

/// The control points that are the unknowns of an analysis on a smooth solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Control<'a> {
    pub mesh: &'a TetMesh,
    /// The nodes as their combinations.
    pub basis: &'a WeightRows,
}

/// Assembles, solves (from a guess of the displacement), recovers, estimates, and adds the times to `seconds`.
///
/// # Errors
/// [`Error::Fem`]: the model is ill-posed, or the solver failed.
pub(super) fn analyse<'m>(
    index: usize,
    (mesh, control): (&'m TetMesh, Option<Control<'_>>),
    problem: &Resolved,
    plan: &Plan<'_>,
    guess: Option<&[DVec3]>,
    seconds: &mut PhaseSeconds,
) -> Result<Analysed<'m>, Error> {
    // Refinement makes edges straight.
    let midsides = if index == 0 { &problem.midsides[..] } else { &[] };
    let space = timed(&mut seconds.assemble, || Space::new(mesh, plan.scenario.element, midsides));
    let name = &format!("step {index}");
    let (mut analysed, system, kept) = solved((space, control), name, problem, plan, guess, seconds)?;
    if control.is_some() {
        let _phase = plan.progress.phase(format!("{name}: solve {} equations of all nodes", system.free_dofs()));
        subspace::compare(&mut analysed, &system, problem, plan, seconds)?;
    }
    let mut richer = if analysed.errors.unresolved.is_empty() {
        None
    } else {
        richer::compare(&mut analysed, name, problem, plan, seconds)?
    };
    if let Some(goal) = problem.goal {
        let _phase =
            plan.progress.phase(format!("{name}: solve the dual problem of `{}`", problem.quantities[goal].name));
        if let Some((mut error, mut dual)) = goal_error(&analysed, problem, plan, (system, kept), seconds)? {
            // Either solution may be one that the cells do not show: a sheet that is pulled is fine, and cannot be bent.
            if dual.unresolved && richer.is_none() {
                richer = richer::compare(&mut analysed, name, problem, plan, seconds)?;
            }
            let found = quantities::value(problem, &analysed, goal) + error.correction;
            let beyond = match &richer {
                Some(richer) => richer.beyond(found),
                None if dual.unresolved => f64::NAN,
                None => 0.0,
            };
            // On coarse meshes ten-node cells mostly confirm the bar.
            dual.unresolved &= beyond.is_nan() || beyond > error.bar;
            error.bar += beyond;
            (analysed.goal, analysed.dual) = (Some(error), dual);
        }
    }
    Ok(analysed)
}

/// The solution on a mesh with its nodes, without the error of a goal; with the system and what solving it left behind.
pub(super) fn solved<'m>(
    (space, control): (Space<'m>, Option<Control<'_>>),
    name: &str,
    problem: &Resolved,
    plan: &Plan<'_>,
    guess: Option<&[DVec3]>,
    seconds: &mut PhaseSeconds,
) -> Result<(Analysed<'m>, System, Kept), Error> {
    let phase = plan.progress.phase(format!("{name}: assemble {} cells", space.mesh().tets().len()));
    let system = timed(&mut seconds.assemble, || {
        let mut system = fem::assemble(&space, &problem.model)?;
        if let Some(exact) = &problem.exact {
            exact.add_loads(&space, &mut system);
        }
        Ok::<_, fem::FemError>(system)
    })?;
    let restricted = timed(&mut seconds.assemble, || {
        control.map(|c| fem::restrict(&system, c.basis, c.mesh, &problem.model)).transpose()
    })?;
    let unknown = restricted.as_ref().unwrap_or(&system);
    phase.say(format!("{name}: solve {} equations", unknown.free_dofs()));
    let mut kept = Kept::default();
    let options = &plan.scenario.solver;
    let solved = timed(&mut seconds.solve, || fem::solve_keeping(unknown, options, guess, &mut kept));
    let solved = solved.map_err(|error| if control.is_none() { error.with_cell(&space, unknown) } else { error })?;
    let kept = if problem.goal.is_some() { kept } else { Kept::default() };
    phase.say(format!("{name}: estimate the error"));
    let estimator = plan.scenario.adapt.estimator;
    let (solution, errors) = timed(&mut seconds.estimate, || {
        let model = &problem.model;
        let solution = match (control, &restricted) {
            (Some(control), Some(restricted)) => {
                fem::recover_restricted(&space, model, (&system, restricted), (control.basis, &solved))
            }
            _ => fem::recover(&space, model, &system, &solved),
        };
        let data = Data::new(&space, model, problem.exact.as_ref());
        let errors = adapt::estimate_solved(&data, &solution.displacement, &solution.stress, estimator);
        (solution, errors)
    });
    let (dofs, free_dofs) = (unknown.dofs(), unknown.free_dofs());
    Ok((
        Analysed { space, solution, errors, goal: None, dual: Dual::default(), straight: None, dofs, free_dofs },
        system,
        kept,
    ))
}

/// What is to be known of a dual solution.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Dual {
    strain_energy: f64,
    /// Whether the cells do not show it, and the quantity is not what they make of it.
    pub unresolved: bool,
}

/// The error of the quantity that the scenario aims at, by its dual problem, and what is to be known of that one's solution.
fn goal_error(
    analysed: &Analysed<'_>,
    problem: &Resolved,
    plan: &Plan<'_>,
    (system, mut kept): (System, Kept),
    seconds: &mut PhaseSeconds,
) -> Result<Option<(GoalError, Dual)>, FemError> {
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
        Some((error, Dual { strain_energy: dual.strain_energy, unresolved: !errors.unresolved.is_empty() }))
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
        let eta = self.energy_error();
        let whole = (2.0 * self.solution.strain_energy + eta * eta).sqrt();
        if whole == 0.0 { 0.0 } else { eta / whole }
    }

    /// That error itself.
    fn energy_error(&self) -> f64 {
        self.errors.energy().hypot(self.straight_edges())
    }

    /// The part of it that straight edges make.
    fn straight_edges(&self) -> f64 {
        self.straight.map_or(0.0, |straight| straight.squared.sqrt())
    }

    /// Adds what straight edges make to the errors.
    pub(super) fn add(&mut self, straight: Straight) {
        if let Some(goal) = &mut self.goal {
            goal.bar += straight.goal;
        }
        self.straight = Some(straight);
    }

    /// Whether nothing moves, though there are loads.
    pub(super) fn is_idle(&self, problem: &Resolved) -> bool {
        self.solution.displacement.iter().all(|u| *u == DVec3::ZERO) && !problem.model.loads.is_empty()
    }

    /// The quantity aimed at.
    pub(super) fn aim(&self, problem: &Resolved) -> Option<Aim> {
        let goal = self.goal.as_ref()?;
        let value = quantities::value(problem, self, problem.goal?) + goal.correction;
        let scale = (2.0 * self.solution.strain_energy * 2.0 * self.dual.strain_energy).sqrt();
        Some(Aim { value, bar: goal.bar, scale })
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
        let [normalised_mean, normalised_mean_square] = ErrorRecord::normalised(&self.errors.squared, unit);
        ErrorRecord {
            energy: self.energy_error(),
            relative: self.relative_error(),
            data: self.errors.unseen(),
            straight_edges: self.straight_edges(),
            normalised_mean,
            normalised_mean_square,
            true_energy: exact.map(|e| e.energy),
            true_relative: exact.map(|e| e.relative),
            effectivity: exact.map(|e| self.energy_error() / e.energy),
        }
    }
}
