//! One hexahedral mesh analysed: solved, its stress recovered, its error estimated.

use super::super::simulate::timed;
use super::resolve::ResolvedHexes;
use super::simulate::Loop;
use crate::error::Error;
use crate::fem::hexes::{
    HexErrors, HexLocator, HexSolution, HexSpace, HexState, RecoveredStress, assemble_hexes, recover_hexes,
};
use crate::fem::options::Field;
use crate::fem::{self, Cells, Extent, QuantityKind, Spectrum};
use crate::mesh::hex::HexMesh;
use crate::output::report::{ErrorRecord, MeshCounts, PhaseSeconds, QuantityRecord, SolverRecord, StepRecord};
use glam::DVec3;

/// The solution on a mesh and its estimated error.
pub(super) struct Analysed<'m> {
    pub space: HexSpace<'m>,
    pub solution: HexSolution,
    pub recovered: RecoveredStress,
    pub errors: HexErrors,
    dofs: usize,
    free_dofs: usize,
    spectrum: Option<Spectrum>,
}

/// What a comparison of elements wants to know besides the record of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub spectrum: Spectrum,
    pub compliance: f64,
    pub tables: usize,
}

/// What was not measured.
const UNKNOWN: Spectrum =
    Spectrum { condition: f64::NAN, iterations: 0, scaled_condition: f64::NAN, scaled_iterations: 0, nonzeros: 0 };

/// Assembles, solves (from a guess of the coefficients), recovers, estimates, and adds the times to `seconds`.
///
/// # Errors
/// [`Error::Fem`]: the model is ill-posed, or the solver failed.
pub(super) fn analyse<'m>(
    (index, mesh): (usize, &'m HexMesh),
    problem: &ResolvedHexes,
    plan: &Loop<'_>,
    guess: Option<&[DVec3]>,
    seconds: &mut PhaseSeconds,
) -> Result<Analysed<'m>, Error> {
    let phase = plan.progress.phase(format!("step {index}: assemble {} cells", mesh.cells().len()));
    let (space, system) = timed(&mut seconds.assemble, || {
        let space = problem.space(mesh);
        let mut system = assemble_hexes(&space, &problem.model)?;
        if let Some(exact) = &problem.exact {
            exact.add_loads_on_hexes(&space, &mut system)?;
        }
        Ok::<_, fem::FemError>((space, system))
    })?;
    phase.say(format!("step {index}: solve {} equations", system.free_dofs()));
    let solved = timed(&mut seconds.solve, || fem::solve(&system, &plan.scenario.solver, guess))?;
    phase.say(format!("step {index}: estimate the error"));
    let (solution, recovered, errors) = timed(&mut seconds.estimate, || {
        let solution = recover_hexes(&space, &problem.model, &system, &solved);
        let recovered = RecoveredStress::new(&space, &problem.model, &solution);
        let errors = HexErrors::estimate(&space, &problem.model, &solution, &recovered);
        (solution, recovered, errors)
    });
    let (dofs, free_dofs) = (system.dofs(), system.free_dofs());
    let spectrum = plan.measure.then(|| Spectrum::of(&system));
    Ok(Analysed { space, solution, recovered, errors, dofs, free_dofs, spectrum })
}

impl Analysed<'_> {
    pub(super) fn relative_error(&self) -> f64 {
        self.errors.relative(self.solution.strain_energy)
    }

    /// The largest estimated error of a cell, in the energy norm.
    pub(super) fn largest_error(&self) -> f64 {
        self.errors.squared.iter().copied().fold(0.0, f64::max).sqrt()
    }

    pub(super) fn measured(&self) -> Measured {
        let spectrum = self.spectrum.unwrap_or(UNKNOWN);
        Measured { spectrum, compliance: self.solution.compliance, tables: self.space.classes() }
    }

    pub(super) fn state<'a>(&'a self, problem: &'a ResolvedHexes) -> HexState<'a> {
        HexState { space: &self.space, model: &problem.model, solution: &self.solution, recovered: &self.recovered }
    }

    /// What is recorded of it; `unit` is the largest error of a cell at step 0.
    pub(super) fn record(&self, problem: &ResolvedHexes, index: usize, unit: f64) -> StepRecord {
        let (mesh, info) = (self.space.mesh(), &self.solution.info);
        let supports = problem.model.supports.iter().zip(&self.solution.reactions);
        let (state, locator) = (self.state(problem), HexLocator::new(&self.space));
        let value = |q: &fem::Quantity| {
            let value = state.value(q.kind, &locator);
            (q.name.clone(), QuantityRecord { value, error: None, computed: None })
        };
        let everywhere = QuantityKind::Maximum(Field::Displacement, Extent::Cells(Cells::default()));
        let volume = QuantityKind::Total(fem::options::Total::Volume, Cells::default());
        StepRecord {
            step: index,
            mesh: MeshCounts { volume: state.value(volume, &locator), ..MeshCounts::of_hexes(mesh) },
            dofs: self.dofs,
            free_dofs: self.free_dofs,
            selected: 0,
            strain_energy: self.solution.strain_energy,
            max_displacement: state.value(everywhere, &locator),
            error: self.error_record(problem, unit),
            quality: crate::output::report::QualityRecord::of_hexes(mesh),
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
            quantities: problem.quantities.iter().map(value).collect(),
        }
    }

    fn error_record(&self, problem: &ResolvedHexes, unit: f64) -> ErrorRecord {
        let exact = problem.exact.map(|e| e.error_on_hexes(&self.space, &problem.model, &self.solution));
        let [normalised_mean, normalised_mean_square] = ErrorRecord::normalised(&self.errors.squared, unit);
        ErrorRecord {
            energy: self.errors.energy(),
            relative: self.relative_error(),
            data: 0.0,
            straight_edges: 0.0,
            normalised_mean,
            normalised_mean_square,
            true_energy: exact.map(|e| e.energy),
            true_relative: exact.map(|e| e.relative),
            effectivity: exact.map(|e| self.errors.energy() / e.energy),
        }
    }
}
