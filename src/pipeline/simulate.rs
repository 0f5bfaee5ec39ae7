//! The loop: solve, estimate, record, stop?, mark, grow, refine.

use super::MemoryProbe;
use super::analyse::{Analysed, Control, analyse};
use super::doubts;
use super::forecast;
use super::interrupt;
use super::look_ahead::{self, Seen};
use super::quantities;
use super::resolve::Resolved;
use super::smooth::smoothed;
use super::straight::{self, Straight};
use super::tolerance;
use crate::adapt;
use crate::adapt::options::Marking;
use crate::error::Error;
use crate::mesh::TetMesh;
use crate::output::progress::Progress;
use crate::output::report::{PROGRAM, PhaseSeconds, Report, SCHEMA, StepRecord, StopReason};
use crate::scenario::{Scenario, Strategy};
use crate::subdiv::options::{Mode, Optimise, Options};
use crate::subdiv::{self, History, Weights};
use glam::DVec3;
use std::time::Instant;

/// What the loop needs besides the problem.
pub(super) struct Plan<'a> {
    pub scenario: &'a Scenario,
    pub strategy: Strategy,
    pub memory: MemoryProbe,
    pub progress: Progress,
}

/// A mesh with its solution, for whoever writes files of it.
pub(super) struct Step<'a> {
    pub index: usize,
    pub mesh: &'a TetMesh,
    pub analysed: &'a Analysed<'a>,
    /// The cells selected on this mesh for the next step.
    pub selected: &'a [bool],
    /// Whether nothing moves, though there are loads.
    pub idle: bool,
}

/// Relative error below which an estimate is rounding.
pub(super) const ROUNDING: f64 = 1e-12;

/// Error bar of a quantity, relative to its scale, below which it is the solver's tolerance that it shows: as where a reaction
/// follows from balance.
const GOAL_ROUNDING: f64 = 1e-7;

/// What the loop knows before a step.
pub(super) struct State {
    pub mesh: TetMesh,
    pub history: History,
    /// The steps before.
    pub steps: Vec<StepRecord>,
    pub warnings: Vec<String>,
    /// What making the mesh took.
    pub refine_seconds: f64,
    /// Largest error of a cell at step 0.
    pub largest_error: Option<f64>,
    /// What the step before says of the displacement.
    pub guess: Option<Vec<DVec3>>,
    pub straight: Option<Straight>,
    /// Most bytes held in a process before this one.
    pub peak: usize,
    /// Seconds spent in processes before this one, and when this one began.
    pub seconds: f64,
    pub start: Instant,
}

impl State {
    /// The state before the first step of a problem.
    pub(super) fn first(problem: &Resolved) -> Self {
        Self::of(problem.mesh.clone(), 0.0)
    }

    /// A state of nothing but a mesh, of a run on which `seconds` were spent before.
    pub(super) fn of(mesh: TetMesh, seconds: f64) -> Self {
        Self {
            mesh,
            history: History::default(),
            steps: Vec::new(),
            warnings: Vec::new(),
            refine_seconds: 0.0,
            largest_error: None,
            guess: None,
            straight: None,
            peak: 0,
            seconds,
            start: Instant::now(),
        }
    }

    /// Seconds since the run began, but for those between processes.
    pub(super) fn spent(&self) -> f64 {
        self.seconds + self.start.elapsed().as_secs_f64()
    }
}

/// Who sees a run.
pub(super) trait Observe {
    /// What is before a step.
    ///
    /// # Errors
    /// These end the run.
    fn before(&mut self, state: &State) -> Result<(), Error>;

    /// A step, before the next mesh is made; the time this takes counts as writing.
    ///
    /// # Errors
    /// These end the run.
    fn step(&mut self, step: &Step<'_>) -> Result<(), Error>;
}

/// Sees the steps only.
struct Steps<'a>(&'a mut dyn FnMut(&Step<'_>) -> Result<(), Error>);

impl Observe for Steps<'_> {
    fn before(&mut self, _: &State) -> Result<(), Error> {
        Ok(())
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), Error> {
        (self.0)(step)
    }
}

/// Runs the loop on the resolved problem. `observe` sees each step before the next mesh is made; its time counts as
/// writing.
///
/// # Errors
/// What the solver or the scheme cannot do, and what `observe` returns.
pub(super) fn simulate(
    problem: &Resolved,
    plan: &Plan<'_>,
    observe: &mut dyn FnMut(&Step<'_>) -> Result<(), Error>,
) -> Result<Report, Error> {
    simulate_from(State::first(problem), problem, plan, &mut Steps(observe))
}

/// As [`simulate`], from any state of a run on.
///
/// # Errors
/// As [`simulate`].
pub(super) fn simulate_from(
    mut state: State,
    problem: &Resolved,
    plan: &Plan<'_>,
    observer: &mut dyn Observe,
) -> Result<Report, Error> {
    (plan.memory.reset)();
    let stop_reason = loop {
        let index = state.steps.len();
        observer.before(&state)?;
        if index > 0 && interrupt::is_asked() {
            break StopReason::Interrupted;
        }
        if let Some(reason) = step(&mut state, problem, plan, observer)? {
            break reason;
        }
    };
    let (seconds_total, peak) = (state.spent(), state.peak.max((plan.memory.peak)()));
    let State { steps, mut warnings, .. } = state;
    let expectations = steps.last().map(|last| quantities::expectations(plan.scenario, last));
    // What was said before the run holds for its results too.
    warnings.extend(problem.said(plan.scenario).cloned());
    Ok(Report {
        expectations: expectations.unwrap_or_default(),
        schema: SCHEMA,
        program: PROGRAM.to_owned(),
        scenario: plan.scenario.path.display().to_string(),
        units: plan.scenario.units.clone(),
        selections: problem.selections.clone(),
        threads: rayon::current_num_threads(),
        stop_reason,
        warnings,
        steps,
        seconds_total,
        peak_memory_bytes: peak as u64,
    })
}

/// One pass of the loop: makes the state before the next step of it, unless the run ends here, and why.
fn step(
    state: &mut State,
    problem: &Resolved,
    plan: &Plan<'_>,
    observer: &mut dyn Observe,
) -> Result<Option<StopReason>, Error> {
    let index = state.steps.len();
    let mut seconds = PhaseSeconds { refine: state.refine_seconds, ..PhaseSeconds::default() };
    let mesh = &state.mesh;
    let smooth = timed(&mut seconds.refine, || plan.scenario.smooth.map(|s| smoothed(mesh, s)).transpose())?;
    let shown = smooth.as_ref().map_or(mesh, |smooth| &smooth.mesh);
    if index == 0 && problem.exact.is_some() && smooth.is_some() {
        state.warnings.extend(other_solid(mesh.volume(), shown.volume()));
    }
    let basis = smooth.as_ref().and_then(|smooth| smooth.basis.as_ref());
    let control = basis.map(|basis| Control { mesh, basis });
    let mut analysed = analyse(index, (shown, control), problem, plan, state.guess.as_deref(), &mut seconds)?;
    if index == 0 {
        state.straight = straight::compare(&analysed, problem, plan, &mut seconds)?;
    } else if let Some(straight) = state.straight {
        analysed.add(straight);
    }
    let unit = *state.largest_error.get_or_insert_with(|| analysed.largest_error());

    let spent = state.seconds + state.start.elapsed().as_secs_f64();
    let reached = reason_to_stop(plan, index, problem, &analysed, spent);
    let vain = index == 0 && state.straight.is_some_and(|s| s.exceeds(&plan.scenario.refine.stop, &analysed, problem));
    let reached = reached.or(vain.then_some(StopReason::StraightEdges));
    let before = state.steps.last();
    let selected = timed(&mut seconds.mark, || select(shown, &analysed, plan, reached, before))?;
    let peak = state.peak.max((plan.memory.peak)());
    let stop = reached.or_else(|| reason_not_to_refine(plan, peak, &selected, &analysed, &mut state.warnings));

    let idle = analysed.is_idle(problem);
    let step = Step { index, mesh: shown, analysed: &analysed, selected: &selected, idle };
    timed(&mut seconds.write, || observer.step(&step))?;
    let peak_memory_bytes = state.peak.max((plan.memory.peak)()) as u64;
    let record = StepRecord { peak_memory_bytes, ..record(&step, problem, seconds, unit) };
    state.warnings.extend(doubts::about(&step, state.steps.last(), &record));
    state.steps.push(record);
    if stop.is_some() {
        return Ok(stop);
    }
    let _phase = plan.progress.phase(format!("step {}: refine", index + 1));
    let mut refine_seconds = 0.0;
    let input = problem.mesh.points().len();
    let next = timed(&mut refine_seconds, || match smooth {
        // All cells of the control mesh, which has no errors of its own to optimise it for.
        Some(_) => refine_control(mesh, &state.history, plan),
        None => refine(&step, &state.history, plan, input),
    })?;
    let guess = timed(&mut refine_seconds, || analysed.guess(&next.0, &plan.scenario.solver));
    (state.mesh, state.history) = next;
    (state.guess, state.refine_seconds) = (guess, refine_seconds);
    Ok(None)
}

/// Relative difference of the volumes of one body.
const SAME_VOLUME: f64 = 1e-6;

/// Part of the error above which data that the elements do not see count as most of it.
const MOSTLY: f64 = 0.5;

/// The next mesh and its history: refined, and optimised for analysis where the scenario says so, with weights from the
/// error estimate. The first `input` vertices are those of the mesh that was read.
fn refine(step: &Step<'_>, history: &History, plan: &Plan<'_>, input: usize) -> Result<(TetMesh, History), Error> {
    let options = &plan.scenario.refine.options;
    let refined = subdiv::refine(step.mesh, history, step.selected, options)?;
    let errors = &step.analysed.errors;
    // Of loads that elements do not see the displacement says nothing: cells that refinement makes for them are not worth their
    // price by its derivatives, and would be taken away again.
    if !options.optimise.ends_in_error() || errors.unseen() > MOSTLY * errors.energy() {
        return Ok((refined.mesh, refined.history));
    }
    let (space, solution, indicators) = (&step.analysed.space, &step.analysed.solution, step.analysed.indicators());
    let weights = if options.optimise.directions {
        let moments = step.analysed.errors.second_moments(space, &solution.displacement);
        Weights::directions(step.mesh, &moments, indicators)
    } else {
        Weights::factors(step.mesh, indicators)
    };
    let weights = weights.carried_over(&refined.transfer);
    // What global refinement added stays, worth its price or not: it is asked for everywhere.
    let first = if plan.strategy == Strategy::Global { refined.mesh.points().len() } else { input };
    let optimised = subdiv::optimise_error(&refined.mesh, &weights, options.optimise.passes, first)?;
    Ok((optimised.mesh, refined.history.renumbered(&optimised.kept)))
}

/// What is to be said if a smooth solid is another one than that of its mesh, for which a solution is known.
fn other_solid(mesh: f64, smooth: f64) -> Option<String> {
    ((smooth / mesh - 1.0).abs() > SAME_VOLUME).then(|| {
        format!(
            "[exact]: the smooth solid has the volume {smooth:.6}, its mesh {mesh:.6}: errors against the known solution are those of another body"
        )
    })
}

/// The next control mesh of a smooth solid.
fn refine_control(mesh: &TetMesh, history: &History, plan: &Plan<'_>) -> Result<(TetMesh, History), Error> {
    let optimise = Optimise { mode: Mode::Paper, ..plan.scenario.refine.options.optimise };
    let options = Options { optimise, ..plan.scenario.refine.options };
    let refined = subdiv::refine(mesh, history, &vec![true; mesh.tets().len()], &options)?;
    Ok((refined.mesh, refined.history))
}

/// Runs `work` and adds its wall time to `seconds`.
pub(super) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *seconds += start.elapsed().as_secs_f64();
    result
}

/// The stop rule that is met by what is known before marking.
fn reason_to_stop(
    plan: &Plan<'_>,
    index: usize,
    problem: &Resolved,
    analysed: &Analysed<'_>,
    spent: f64,
) -> Option<StopReason> {
    let stop = &plan.scenario.refine.stop;
    let goal = analysed.aim(problem);
    let cells = analysed.space.mesh().tets().len();
    if let Some(reason) = tolerance::reached(stop, analysed.relative_error(), goal) {
        Some(reason)
    } else if plan.strategy == Strategy::None || index >= plan.scenario.refine.steps {
        Some(StopReason::Steps)
    } else if analysed.relative_error() <= ROUNDING
        || goal.is_some_and(|goal| goal.bar <= GOAL_ROUNDING * goal.scale.max(goal.value.abs()))
    {
        Some(StopReason::Exact)
    } else if goal.is_some_and(|goal| tolerance::is_zero(stop, goal)) {
        Some(StopReason::Zero)
    } else if stop.max_cells.is_some_and(|most| cells >= most) {
        Some(StopReason::MaxCells)
    } else if stop.seconds.is_some_and(|most| spent >= most) {
        Some(StopReason::Seconds)
    } else {
        interrupt::is_asked().then_some(StopReason::Interrupted)
    }
}

/// The stop rule that is met by the selection: nothing to refine, or a next step above the memory limit.
fn reason_not_to_refine(
    plan: &Plan<'_>,
    peak: usize,
    selected: &[bool],
    analysed: &Analysed<'_>,
    warnings: &mut Vec<String>,
) -> Option<StopReason> {
    let count = selected.iter().filter(|s| **s).count();
    if count == 0 {
        warnings.push(doubts::NOTHING_MARKED.to_owned());
        return Some(StopReason::Steps);
    }
    let (cells, scheme) = (selected.len() as f64, plan.scenario.refine.options.scheme);
    let growth = forecast::cells_after(scheme, plan.strategy, cells, count as f64) / cells;
    // The system of control points is small beside the mesh that it is made on.
    let method = if plan.scenario.smooth.is_some() { "" } else { analysed.solution.info.method };
    let forecast = forecast::next_bytes(peak, growth, method);
    let above = |most: u64| forecast > most as f64;
    // What is not there cannot be used; without a word the system would end the run.
    let is_too_large =
        plan.scenario.refine.stop.max_memory.is_some_and(above) || forecast::available(peak as u64).is_some_and(above);
    is_too_large.then_some(StopReason::MaxMemory)
}

/// The cells to refine; none if the run stops here.
fn select(
    mesh: &TetMesh,
    analysed: &Analysed<'_>,
    plan: &Plan<'_>,
    reached: Option<StopReason>,
    before: Option<&StepRecord>,
) -> Result<Vec<bool>, Error> {
    let count = mesh.tets().len();
    match plan.strategy {
        _ if reached.is_some() => Ok(vec![false; count]),
        Strategy::None => Ok(vec![false; count]),
        Strategy::Global => Ok(vec![true; count]),
        Strategy::Adaptive => {
            let (indicators, unknown) = (analysed.indicators(), &analysed.errors.unestimated);
            let marked = adapt::mark(indicators, unknown, plan.scenario.adapt.marking)?;
            let marked = match (plan.scenario.adapt.marking, plan.scenario.refine.stop.relative_error) {
                (Marking::LookAhead(_), Some(tolerance)) => {
                    let most = marked.iter().filter(|m| **m).count() as f64;
                    let now = analysed.seen();
                    let fewer = look_ahead::marking(plan.scenario, tolerance, most, now, before.map(seen));
                    adapt::mark(indicators, unknown, fewer)?
                }
                _ => marked,
            };
            Ok(adapt::grow(mesh, marked, plan.scenario.adapt.grow))
        }
    }
}

/// What looking ahead needs of a step.
fn seen(step: &StepRecord) -> Seen {
    Seen {
        cells: step.mesh.cells as f64,
        dofs: step.dofs as f64,
        error: step.error.relative,
        selected: step.selected as f64,
    }
}

/// The record of a finished step; `unit` is the largest error of a cell at step 0.
fn record(step: &Step<'_>, problem: &Resolved, mut seconds: PhaseSeconds, unit: f64) -> StepRecord {
    seconds.total = seconds.computing() + seconds.write;
    let selected = step.selected.iter().filter(|s| **s).count();
    StepRecord { step: step.index, selected, seconds, ..step.analysed.record(problem, unit) }
}
