//! The folder of a run: a VTK file each step and their collection, the report, tables, plots, the scenario's copy.

use super::checkpoint;
use super::leftovers;
use super::load::find;
use super::page::{self, PAGE};
use super::quantities::write_probes;
use super::resolve::Resolved;
use super::simulate::{Observe, State, Step};
use crate::error::Error;
use crate::fem;
use crate::mesh::quality;
use crate::output::atomic::{ensure_writable_dir, write_atomic};
use crate::output::options::FieldName;
use crate::output::page::{Shown, Solved, Steps};
use crate::output::plot::{dihedral_histogram, error_histogram};
use crate::output::report::{Report, StopReason, write_json};
use crate::output::vtk::{Fields, Values, write_vtu};
use crate::output::{OutputError, pvd, table};
use crate::scenario::{MeshSource, Scenario, Strategy};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The folder of a run of any kind of cells.
pub(super) struct Folder<'a> {
    folder: PathBuf,
    pub scenario: &'a Scenario,
    /// Time and name of each VTK file so far.
    files: Vec<(f64, String)>,
}

impl<'a> Folder<'a> {
    /// Makes the folder and writes the scenario so that it runs again. What an earlier run or comparison left there is to be
    /// gone: beside fewer new files the old ones would be taken for results of this run.
    ///
    /// # Errors
    /// [`Error::Output`] if the folder cannot be written.
    pub(super) fn begin(folder: PathBuf, scenario: &'a Scenario, strategy: Strategy) -> Result<Self, Error> {
        ensure_writable_dir(&folder)?;
        let results = Self { folder, scenario, files: Vec::new() };
        let copy = results.path("scenario.toml");
        if !leftovers::is_same(&copy, &scenario.path) {
            let mesh = match &scenario.mesh {
                MeshSource::File(file) => Some(relative(&find(file, &scenario.directory)?, &results.folder)),
                MeshSource::Box { .. } | MeshSource::Shape(_) => None,
            };
            let text = scenario.to_run_again(strategy, mesh.as_deref());
            let text = text.map_err(|e| OutputError::write(&copy, std::io::Error::other(e)))?;
            write_text(&copy, &text)?;
        }
        Ok(results)
    }

    pub(super) fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// The fields that the scenario wants.
    pub(super) fn chosen<'v>(&self, fields: Vec<(FieldName, &'v str, Values<'v>)>) -> Vec<(&'v str, Values<'v>)> {
        let chosen = fields.into_iter().filter(|(field, ..)| self.scenario.output.fields.contains(field));
        chosen.map(|(_, name, values)| (name, values)).collect()
    }

    /// Adds a VTK file to the collection.
    pub(super) fn add(&mut self, time: f64, name: String) -> Result<(), Error> {
        self.files.push((time, name));
        Ok(pvd::write_pvd(&self.path("results.pvd"), &self.files)?)
    }

    /// Writes the report, its table, and the script that shows the results.
    pub(super) fn finish(&self, report: &Report) -> Result<(), Error> {
        let output = &self.scenario.output;
        let shown = [FieldName::Displacement, FieldName::VonMises].iter().all(|field| output.fields.contains(field));
        if output.vtk && shown {
            pvd::write_view(&self.path("view.py"))?;
        }
        if output.report {
            write_json(&self.path("report.json"), report)?;
            let text = table::units(&report.units) + &table::steps(&report.steps);
            write_text(&self.path("table.txt"), &text)?;
        }
        Ok(())
    }
}

/// Writes what a run on tetrahedra gives, step by step.
pub(super) struct Results<'a> {
    folder: Folder<'a>,
    problem: &'a Resolved,
    kept: Kept,
    /// Of a run that may be resumed.
    identity: Option<[u8; blake3::OUT_LEN]>,
}

/// Minimum dihedral angles and errors of the cells of each step, for the histograms.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Kept {
    angles: Vec<(String, Vec<f64>)>,
    errors: Vec<(String, Vec<f64>)>,
    page: Option<Steps>,
}

impl Observe for Results<'_> {
    fn before(&mut self, state: &State) -> Result<(), Error> {
        match &self.identity {
            Some(identity) => Ok(checkpoint::write(&self.folder.path(checkpoint::FILE), identity, state, &self.kept)?),
            None => Ok(()),
        }
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), Error> {
        self.write(step)
    }
}

impl<'a> Results<'a> {
    /// Makes the folder, as [`Folder::begin`].
    ///
    /// # Errors
    /// [`Error::Output`] if the folder cannot be written.
    pub(super) fn begin(
        folder: PathBuf,
        scenario: &'a Scenario,
        problem: &'a Resolved,
        strategy: Strategy,
    ) -> Result<Self, Error> {
        let folder = Folder::begin(folder, scenario, strategy)?;
        let kept = Kept { page: page::begin(scenario, &problem.model), ..Kept::default() };
        Ok(Self { folder, problem, kept, identity: None })
    }

    /// As [`Results::begin`], with a checkpoint before each step.
    ///
    /// # Errors
    /// As [`Results::begin`].
    pub(super) fn begin_resumable(
        folder: PathBuf,
        scenario: &'a Scenario,
        problem: &'a Resolved,
    ) -> Result<Self, Error> {
        let identity = Some(checkpoint::identity(scenario, problem));
        Ok(Self { identity, ..Self::begin(folder, scenario, problem, scenario.refine.strategy)? })
    }

    /// Goes on with the folder of a run that was interrupted; gives the state that it left.
    ///
    /// # Errors
    /// [`Error::Resume`] if there is none, or it is of another run.
    pub(super) fn resume(
        folder: PathBuf,
        scenario: &'a Scenario,
        problem: &'a Resolved,
    ) -> Result<(Self, State), Error> {
        let identity = checkpoint::identity(scenario, problem);
        let (state, mut kept) = checkpoint::read(&folder.join(checkpoint::FILE), &identity)?;
        kept.page = page::begin(scenario, &problem.model).zip(kept.page).map(|(page, earlier)| page.after(earlier));
        leftovers::remove_abandoned(&folder)?;
        let steps = if scenario.output.vtk { state.steps.len() } else { 0 };
        let files = (0..steps).map(|i| (i as f64, step_file(i))).collect();
        let folder = Folder { folder, scenario, files };
        Ok((Self { folder, problem, kept, identity: Some(identity) }, state))
    }

    /// Writes a step.
    pub(super) fn write(&mut self, step: &Step<'_>) -> Result<(), Error> {
        let label = format!("step {}: {} cells", step.index, step.mesh.tets().len());
        let indicator: Vec<f64> = step.analysed.errors.squared.iter().map(|e| e.sqrt()).collect();
        let angles = quality::min_dihedrals(step.mesh);
        let scenario = self.folder.scenario;
        if scenario.output.vtk {
            self.vtk(step, &indicator)?;
        }
        // Those of the last step stay.
        write_probes(&self.folder.folder, &scenario.probes, self.problem, step.analysed)?;
        if let Some(page) = &mut self.kept.page {
            let solved = Solved {
                displacement: &step.analysed.solution.displacement,
                stress: &step.analysed.errors.nodal_stress,
                error: &indicator,
                quality: &angles,
                level: step.mesh.levels(),
            };
            page.add(&self.folder.path(PAGE), &Shown::tetrahedra(&step.analysed.space), &solved)?;
        }
        self.kept.angles.push((label.clone(), angles));
        self.kept.errors.push((label, indicator));
        Ok(())
    }

    fn vtk(&mut self, step: &Step<'_>, indicator: &[f64]) -> Result<(), Error> {
        let solution = &step.analysed.solution;
        let stress = solution.stress.means();
        let von_mises: Vec<f64> = stress.iter().map(|&s| fem::von_mises(s)).collect();
        let scenario = self.folder.scenario;
        let fields = Fields {
            time: step.index as f64,
            units: scenario.units.clone(),
            points: self.folder.chosen(vec![
                (FieldName::Displacement, "displacement", Values::Vectors(&solution.displacement)),
                (FieldName::Stress, "stress", Values::Tensors(&step.analysed.errors.nodal_stress)),
            ]),
            cells: self.folder.chosen(vec![
                (FieldName::VonMises, "von_mises", Values::Scalars(&von_mises)),
                (FieldName::Stress, "stress", Values::Tensors(&stress)),
                (FieldName::ErrorIndicator, "error_indicator", Values::Scalars(indicator)),
                (FieldName::Marked, "marked", Values::Flags(step.selected)),
            ]),
        };
        let name = step_file(step.index);
        write_vtu(&self.folder.path(&name), &step.analysed.space, &fields, scenario.output.compression)?;
        self.folder.add(fields.time, name)
    }

    /// Writes what is known only at the end of the run; gives what a page shows of it.
    pub(super) fn finish(self, report: &Report) -> Result<Option<Steps>, Error> {
        self.folder.finish(report)?;
        let scenario = self.folder.scenario;
        if scenario.output.report {
            dihedral_histogram(&self.folder.path("dihedral_angles.svg"), &self.kept.angles)?;
            error_histogram(&self.folder.path("cell_errors.svg"), &self.kept.errors, scenario.units.energy.as_deref())?;
        }
        let checkpoint = self.folder.path(checkpoint::FILE);
        if self.identity.is_some() && report.stop_reason != StopReason::Interrupted {
            fs::remove_file(&checkpoint).map_err(|e| OutputError::write(&checkpoint, e))?;
        }
        Ok(self.kept.page)
    }
}

/// The name of a step's file.
pub(super) fn step_file(step: usize) -> String {
    format!("step_{step:03}.vtu")
}

/// Writes a text file.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    Ok(write_atomic(path, |w| w.write_all(text.as_bytes()))?)
}

/// The way from a folder to a file: relative if they have more in common than the root, else absolute.
pub(super) fn relative(file: &Path, folder: &Path) -> PathBuf {
    let (Ok(file), Ok(folder)) = (file.canonicalize(), folder.canonicalize()) else { return file.to_owned() };
    let common = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if common < 2 {
        return file;
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_the_mesh_leads_to_it() {
        let root = tempfile::tempdir().unwrap();
        let [near, far] = ["a/b/c", "a/d"].map(|f| root.path().join(f));
        [&near, &far].iter().for_each(|f| std::fs::create_dir_all(f).unwrap());
        let mesh = far.join("part.msh");
        std::fs::write(&mesh, "").unwrap();
        assert_eq!(relative(&mesh, &near), Path::new("../../d/part.msh"));
        assert_eq!(near.join(relative(&mesh, &near)).canonicalize().unwrap(), mesh.canonicalize().unwrap());
        assert_eq!(relative(&mesh, &far), Path::new("part.msh"));
    }
}
