//! The folder of a run on hexahedra.

use super::super::page::{self, PAGE};
use super::super::quantities::{OUTSIDE, write_lines};
use super::super::results::{Folder, step_file};
use super::resolve::ResolvedHexes;
use super::simulate::Step;
use crate::error::Error;
use crate::fem::hexes::{HexLocator, Lattice};
use crate::fem::{self, SymTensor};
use crate::mesh::hex::min_dihedral;
use crate::output::hex_vtk::write_hexes;
use crate::output::options::FieldName;
use crate::output::page::{Shown, Solved, Steps};
use crate::output::plot::error_histogram;
use crate::output::report::Report;
use crate::output::vtk::{Fields, Values};
use crate::scenario::Scenario;
use glam::DVec3;
use std::path::PathBuf;

/// Writes what a run gives, step by step.
pub(super) struct HexResults<'a> {
    folder: Folder<'a>,
    problem: &'a ResolvedHexes,
    errors: Vec<(String, Vec<f64>)>,
    page: Option<Steps>,
}

/// What is shown of a step: points and the fields there.
struct Fine {
    lattice: Lattice,
    displacement: Vec<DVec3>,
    stress: Vec<SymTensor>,
}

impl<'a> HexResults<'a> {
    /// Makes the folder and writes the scenario so that it runs again.
    ///
    /// # Errors
    /// [`Error::Output`] if the folder cannot be written.
    pub(super) fn begin(folder: PathBuf, scenario: &'a Scenario, problem: &'a ResolvedHexes) -> Result<Self, Error> {
        let folder = Folder::begin(folder, scenario, scenario.refine.strategy)?;
        let page = page::begin(scenario, &problem.model);
        Ok(Self { folder, problem, errors: Vec::new(), page })
    }

    /// Writes a step.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub(super) fn step(&mut self, step: &Step<'_>) -> Result<(), Error> {
        if self.folder.scenario.output.vtk || self.page.is_some() {
            let fine = Fine::new(step);
            if self.folder.scenario.output.vtk {
                self.vtk(step, &fine)?;
            }
            self.show(step, &fine)?;
        }
        self.probes(step)?;
        let label = format!("step {}: {} cells", step.index, step.relative_errors.len());
        self.errors.push((label, step.relative_errors.clone()));
        Ok(())
    }

    /// Writes the probes; those of the last step stay.
    fn probes(&self, step: &Step<'_>) -> Result<(), Error> {
        let probes = &self.folder.scenario.probes;
        if probes.is_empty() {
            return Ok(());
        }
        let (space, state) = (&step.analysed.space, step.analysed.state(self.problem));
        let (locator, outside) = (HexLocator::new(space), OUTSIDE * space.mesh().diagonal());
        write_lines(&self.folder.path(""), probes, &|p| {
            let found = locator.nearest(p);
            let table = space.table(space.class(found.cell), &[found.at]);
            let values = || (state.displacement(found.cell, &table, 0), state.stress(found.cell, &table, 0));
            (found.distance <= outside).then(values)
        })
    }

    /// Adds a step to the page.
    fn show(&mut self, step: &Step<'_>, fine: &Fine) -> Result<(), Error> {
        let Some(page) = &mut self.page else { return Ok(()) };
        let mesh = step.analysed.space.mesh();
        let cells = 0..mesh.cells().len();
        let quality: Vec<f64> = cells.clone().map(|t| min_dihedral(&mesh.cell_points(t))).collect();
        let level: Vec<u8> = cells.map(|_| level(step)).collect();
        let solved = Solved {
            displacement: &fine.displacement,
            stress: &fine.stress,
            error: &step.relative_errors,
            quality: &quality,
            level: &level,
        };
        let shown = Shown::hexahedra(&step.analysed.space, &fine.lattice);
        Ok(page.add(&self.folder.path(PAGE), &shown, &solved)?)
    }

    fn vtk(&mut self, step: &Step<'_>, fine: &Fine) -> Result<(), Error> {
        let (space, solution) = (&step.analysed.space, &step.analysed.solution);
        let Fine { lattice, displacement, stress } = fine;
        let at_points: Vec<f64> = stress.iter().map(|&s| fem::von_mises(s)).collect();
        let middle = space.tables(vec![DVec3::splat(0.5)]);
        let cells = 0..space.mesh().cells().len();
        let stresses: Vec<_> =
            cells.map(|t| solution.stress(space, &self.problem.model, t, &middle.of(space, t), 0)).collect();
        let von_mises: Vec<f64> = stresses.iter().map(|&s| fem::von_mises(s)).collect();
        let output = &self.folder.scenario.output;
        let fields = Fields {
            time: step.index as f64,
            units: self.folder.scenario.units.clone(),
            points: self.folder.chosen(vec![
                (FieldName::Displacement, "displacement", Values::Vectors(displacement)),
                (FieldName::Stress, "stress", Values::Tensors(stress)),
                (FieldName::VonMises, "von_mises", Values::Scalars(&at_points)),
            ]),
            cells: self.folder.chosen(vec![
                (FieldName::VonMises, "von_mises", Values::Scalars(&von_mises)),
                (FieldName::Stress, "stress", Values::Tensors(&stresses)),
                (FieldName::ErrorIndicator, "error_indicator", Values::Scalars(&step.relative_errors)),
            ]),
        };
        let name = step_file(step.index);
        let path = self.folder.path(&name);
        write_hexes(&path, space, lattice, &fields, (level(step), output.hexahedra, output.compression))?;
        self.folder.add(fields.time, name)
    }

    /// Writes what is known only at the end of the run; gives what a page shows of it.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub(super) fn finish(self, report: &Report) -> Result<Option<Steps>, Error> {
        self.folder.finish(report)?;
        if self.folder.scenario.output.report {
            let unit = self.folder.scenario.units.energy.as_deref();
            error_histogram(&self.folder.path("cell_errors.svg"), &self.errors, unit)?;
        }
        Ok(self.page)
    }
}

impl Fine {
    fn new(step: &Step<'_>) -> Self {
        let (space, solution) = (&step.analysed.space, &step.analysed.solution);
        let lattice = Lattice::new(space, space.degree());
        let displacement = lattice.values(space, &solution.displacement);
        let stress = lattice.each(space, |t, table, q| step.analysed.recovered.at(space, t, table, q));
        Self { lattice, displacement, stress }
    }
}

/// How often the cells of a step were refined: all alike.
fn level(step: &Step<'_>) -> u8 {
    u8::try_from(step.index).unwrap_or(u8::MAX)
}
