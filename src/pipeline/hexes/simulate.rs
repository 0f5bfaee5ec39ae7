//! The loop on hexahedra: solve, estimate, record, stop?, refine all cells.

use super::super::MemoryProbe;
use super::super::quantities::expectations;
use super::super::simulate::{ROUNDING, timed};
use super::super::tolerance;
use super::super::{forecast, interrupt};
use super::analyse::{Analysed, Measured, analyse};
use super::resolve::ResolvedHexes;
use crate::error::Error;
use crate::mesh::hex::HexMesh;
use crate::output::elements::ElementRow;
use crate::output::progress::Progress;
use crate::output::report::{PROGRAM, PhaseSeconds, Report, SCHEMA, StepRecord, StopReason};
use crate::scenario::{Scenario, Strategy};
use crate::subdiv::catmull_clark::{self, RefinedSolid};
use glam::DVec3;
use std::time::Instant;

/// How often more cells, and with them memory, the next step has.
const GROWTH: f64 = 8.0;

/// A mesh with its solution, for whoever writes files of it.
pub(super) struct Step<'a> {
    pub index: usize,
    pub analysed: &'a Analysed<'a>,
    pub relative_errors: Vec<f64>,
}

/// What the loop needs besides the problem.
pub(super) struct Loop<'a> {
    pub scenario: &'a Scenario,
    pub memory: MemoryProbe,
    pub progress: Progress,
    /// Whether to measure how hard the systems are for conjugate gradients.
    pub measure: bool,
}

/// Runs the loop. `observe` sees each step before the next mesh is made; its time counts as writing.
///
/// # Errors
/// What the solver or the scheme cannot do, and what `observe` returns.
pub(super) fn simulate(
    problem: &ResolvedHexes,
    plan: &Loop<'_>,
    observe: &mut dyn FnMut(&Step<'_>) -> Result<(), Error>,
) -> Result<Report, Error> {
    let &Loop { scenario, memory, progress, .. } = plan;
    (memory.reset)();
    let start = Instant::now();
    let mut mesh = problem.mesh.clone();
    let mut steps: Vec<StepRecord> = Vec::new();
    let (mut refine_seconds, mut unit, mut guess) = (0.0, None, None);
    let stop_reason = loop {
        let index = steps.len();
        if index > 0 && interrupt::is_asked() {
            break StopReason::Interrupted;
        }
        let mut seconds = PhaseSeconds { refine: refine_seconds, ..PhaseSeconds::default() };
        let guessed: Option<&Vec<DVec3>> = guess.as_ref();
        let analysed = analyse((index, &mesh), problem, plan, guessed.map(|g| &g[..]), &mut seconds)?;
        let unit = *unit.get_or_insert_with(|| analysed.largest_error());
        let relative_errors = analysed.errors.squared.iter().map(|e| e.sqrt()).collect();
        timed(&mut seconds.write, || observe(&Step { index, analysed: &analysed, relative_errors }))?;
        seconds.total = seconds.computing() + seconds.write;
        let peak_memory_bytes = (memory.peak)() as u64;
        steps.push(StepRecord { seconds, peak_memory_bytes, ..analysed.record(problem, index, unit) });
        if let Some(reason) = reason_to_stop(scenario, index, &analysed, (start, (memory.peak)())) {
            break reason;
        }
        let _phase = progress.phase(format!("step {}: refine", index + 1));
        refine_seconds = 0.0;
        let refined = timed(&mut refine_seconds, || refine(problem, &mesh))?;
        guess = carried_over(problem, &analysed, &refined);
        mesh = refined.mesh;
    };
    let expectations = steps.last().map(|last| expectations(scenario, last)).unwrap_or_default();
    Ok(Report {
        expectations,
        schema: SCHEMA,
        program: PROGRAM.to_owned(),
        scenario: scenario.path.display().to_string(),
        units: scenario.units.clone(),
        selections: problem.selections.clone(),
        threads: rayon::current_num_threads(),
        stop_reason,
        warnings: scenario.warnings.iter().chain(&problem.warnings).cloned().collect(),
        steps,
        seconds_total: start.elapsed().as_secs_f64(),
        peak_memory_bytes: (memory.peak)() as u64,
    })
}

fn refine(problem: &ResolvedHexes, mesh: &HexMesh) -> Result<RefinedSolid, Error> {
    Ok(if problem.hexes.element.is_smooth() {
        catmull_clark::refine(mesh, problem.hexes.options.masks)?
    } else {
        catmull_clark::split_linearly(mesh)?
    })
}

/// The displacement on the refined mesh: exactly the same where spaces are nested. Bubbles, and nodes between vertices, start
/// from zero.
fn carried_over(problem: &ResolvedHexes, analysed: &Analysed<'_>, refined: &RefinedSolid) -> Option<Vec<DVec3>> {
    let vertices = analysed.space.mesh().points().len();
    let smooth = problem.hexes.element.is_smooth();
    let has_own = smooth || analysed.space.points().len() == vertices;
    has_own.then(|| {
        let mut guess = refined.stencils.apply(&analysed.solution.displacement[..vertices]);
        guess.resize(problem.space(&refined.mesh).points().len(), DVec3::ZERO);
        guess
    })
}

/// What the next step needs at its peak.
fn next_bytes(peak: usize, analysed: &Analysed<'_>) -> f64 {
    forecast::next_bytes(peak, GROWTH, analysed.solution.info.method)
}

/// The stop rule that is met.
fn reason_to_stop(
    scenario: &Scenario,
    index: usize,
    analysed: &Analysed<'_>,
    (start, peak): (Instant, usize),
) -> Option<StopReason> {
    let stop = &scenario.refine.stop;
    if let Some(reason) = tolerance::reached(stop, analysed.relative_error(), None) {
        Some(reason)
    } else if scenario.refine.strategy == Strategy::None || index >= scenario.refine.steps {
        Some(StopReason::Steps)
    } else if analysed.relative_error() <= ROUNDING {
        Some(StopReason::Exact)
    } else if stop.max_cells.is_some_and(|most| analysed.space.mesh().cells().len() >= most) {
        Some(StopReason::MaxCells)
    } else if stop.seconds.is_some_and(|most| start.elapsed().as_secs_f64() >= most) {
        Some(StopReason::Seconds)
    } else if stop.max_memory.is_some_and(|most| next_bytes(peak, analysed) > most as f64)
        || forecast::available(peak as u64).is_some_and(|most| next_bytes(peak, analysed) > most as f64)
    {
        // What is not there cannot be used; without a word the system would end the run.
        Some(StopReason::MaxMemory)
    } else {
        interrupt::is_asked().then_some(StopReason::Interrupted)
    }
}

/// The row of a step in a comparison of elements.
pub(super) fn row(step: &StepRecord, measured: Measured) -> ElementRow {
    let Measured { spectrum, compliance, tables } = measured;
    ElementRow {
        element: String::new(),
        step: step.step,
        cells: step.mesh.cells,
        free_dofs: step.free_dofs,
        nonzeros: spectrum.nonzeros,
        tables,
        max_displacement: step.max_displacement,
        compliance,
        relative_error: step.error.relative,
        true_relative_error: step.error.true_relative,
        condition: spectrum.condition,
        scaled_condition: spectrum.scaled_condition,
        iterations: spectrum.iterations,
        scaled_iterations: spectrum.scaled_iterations,
        assemble_seconds: step.seconds.assemble,
        solve_seconds: step.seconds.solve,
        seconds: step.seconds.computing(),
        quantities: step.quantities.iter().map(|(name, q)| (name.clone(), q.value)).collect(),
    }
}
