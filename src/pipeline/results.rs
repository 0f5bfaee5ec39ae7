//! The folder of a run: a VTK file each step and their collection, the report, tables, plots, the scenario's copy.

use super::simulate::Step;
use crate::error::Error;
use crate::fem;
use crate::mesh::quality;
use crate::output::atomic::{ensure_writable_dir, write_atomic};
use crate::output::plot::{dihedral_histogram, error_histogram};
use crate::output::report::{Report, write_json};
use crate::output::vtk::{Fields, Values, write_vtu};
use crate::output::{OutputError, pvd, table};
use crate::scenario::Scenario;
use std::path::{Path, PathBuf};

/// Writes what a run gives, step by step.
pub(super) struct Results<'a> {
    folder: PathBuf,
    scenario: &'a Scenario,
    /// Time and name of each VTK file so far.
    files: Vec<(f64, String)>,
    /// Minimum dihedral angles and errors of the cells of each step, for the histograms.
    angles: Vec<(String, Vec<f64>)>,
    errors: Vec<(String, Vec<f64>)>,
}

impl<'a> Results<'a> {
    /// Makes the folder, puts the scenario into it and removes the step files that an earlier run left there: beside
    /// fewer new ones they would be taken for results of this run.
    ///
    /// # Errors
    /// [`Error::Output`] if the folder cannot be written.
    pub(super) fn begin(folder: PathBuf, scenario: &'a Scenario) -> Result<Self, Error> {
        ensure_writable_dir(&folder)?;
        remove_old_steps(&folder)?;
        let results = Self { folder, scenario, files: Vec::new(), angles: Vec::new(), errors: Vec::new() };
        write_atomic(&results.path("scenario.toml"), |w| {
            w.write_all(scenario.text.as_bytes())?;
            scenario.overrides.iter().try_for_each(|o| writeln!(w, "# run with --set {o}"))
        })?;
        Ok(results)
    }

    pub(super) fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Writes a step.
    pub(super) fn step(&mut self, step: &Step<'_>) -> Result<(), Error> {
        let label = format!("step {}: {} cells", step.index, step.mesh.tets().len());
        let indicator: Vec<f64> = step.analysed.errors.squared.iter().map(|e| e.sqrt()).collect();
        let angles = (0..step.mesh.tets().len()).map(|t| quality::min_dihedral(step.mesh.cell_points(t))).collect();
        if self.scenario.output.vtk {
            self.vtk(step, &indicator)?;
        }
        self.angles.push((label.clone(), angles));
        self.errors.push((label, indicator));
        Ok(())
    }

    fn vtk(&mut self, step: &Step<'_>, indicator: &[f64]) -> Result<(), Error> {
        let solution = &step.analysed.solution;
        let von_mises: Vec<f64> = solution.stress.iter().map(|&s| fem::von_mises(s)).collect();
        let fields = Fields {
            time: step.index as f64,
            points: vec![
                ("displacement", Values::Vectors(&solution.displacement)),
                ("stress", Values::Tensors(&step.analysed.errors.nodal_stress)),
            ],
            cells: vec![
                ("von_mises", Values::Scalars(&von_mises)),
                ("stress", Values::Tensors(&solution.stress)),
                ("error_indicator", Values::Scalars(indicator)),
                ("marked", Values::Flags(step.selected)),
            ],
        };
        let name = format!("step_{:03}.vtu", step.index);
        write_vtu(&self.path(&name), step.mesh, &fields, self.scenario.output.compression)?;
        self.files.push((fields.time, name));
        Ok(pvd::write_pvd(&self.path("results.pvd"), &self.files)?)
    }

    /// Writes what is known only at the end of the run.
    pub(super) fn finish(self, report: &Report) -> Result<(), Error> {
        if self.scenario.output.report {
            write_json(&self.path("report.json"), report)?;
            write_text(&self.path("table.txt"), &table::steps(&report.steps))?;
            dihedral_histogram(&self.path("dihedral_angles.svg"), &self.angles)?;
            error_histogram(&self.path("cell_errors.svg"), &self.errors)?;
        }
        Ok(())
    }
}

/// Writes a text file.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    Ok(write_atomic(path, |w| w.write_all(text.as_bytes()))?)
}

fn remove_old_steps(folder: &Path) -> Result<(), OutputError> {
    let failed = |source| OutputError::Write { path: folder.to_owned(), source };
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let number = name.strip_prefix("step_").and_then(|rest| rest.strip_suffix(".vtu"));
        if number.is_some_and(|n| n.len() >= 3 && n.bytes().all(|b| b.is_ascii_digit())) {
            std::fs::remove_file(entry.path()).map_err(failed)?;
        }
    }
    Ok(())
}
