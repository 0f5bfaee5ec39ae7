//! Room for new results: what an earlier run or comparison left in a folder is removed, and nothing else.
//!
//! A folder is one of results if a file in it shows that ([`MARKS`]). There the names of [`FILES`] are ours, the steps that
//! `results.pvd` lists and the probes of `scenario.toml`. Everything else is the user's: it is never removed, and nothing
//! is written over it.

use super::checkpoint;
use super::load::find;
use super::quantities::probe_file;
use super::results::step_file;
use crate::output::OutputError;
use crate::output::atomic::TEMPORARY;
use crate::scenario::{MeshSource, Scenario};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The files of a run, but for its steps and probes.
const RUN: [&str; 11] = [
    checkpoint::FILE,
    "view.py",
    "report.html",
    "report.json",
    "table.txt",
    "error_dofs.svg",
    "error_seconds.svg",
    "dihedral_angles.svg",
    "cell_errors.svg",
    "results.pvd",
    "scenario.toml",
];

/// The files of a comparison, but for its two runs.
const COMPARISON: [&str; 10] = [
    "report.html",
    "compare.txt",
    "error_dofs.svg",
    "error_seconds.svg",
    "error_memory.svg",
    "elements_unknowns.svg",
    "elements_cells.svg",
    "elements_nonzeros.svg",
    "elements_seconds.svg",
    "compare.json",
];

/// All names that are ours in a folder of results, those that mark it last: a removal that is cut off can be taken up again.
const FILES: [&str; 18] = [
    checkpoint::FILE,
    "view.py",
    "report.html",
    "table.txt",
    "compare.txt",
    "error_dofs.svg",
    "error_seconds.svg",
    "error_memory.svg",
    "elements_unknowns.svg",
    "elements_cells.svg",
    "elements_nonzeros.svg",
    "elements_seconds.svg",
    "dihedral_angles.svg",
    "cell_errors.svg",
    "report.json",
    "compare.json",
    "results.pvd",
    "scenario.toml",
];

/// The files that show that a folder is one of results, and words that they hold then.
const MARKS: [(&str, &str); 5] = [
    ("results.pvd", "file=\"step_"),
    ("report.json", "\"stop_reason\""),
    ("compare.json", "\"stop_reason\""),
    ("compare.json", "\"scaled_condition\""),
    ("scenario.toml", " as it was run"),
];

/// The folders of a comparison of strategies.
const FOLDERS: [&str; 2] = ["global", "adaptive"];

/// Makes room for a run in a folder: removes the files of an earlier run or comparison, and a comparison's folders if they
/// hold nothing else. The scenario itself, which may lie in the folder, stays.
///
/// # Errors
/// Before anything is removed, [`OutputError::InTheWay`] names a file of the user's that the run would write over, and
/// [`OutputError::Input`] the scenario's mesh if it is among the files to remove; [`OutputError::Write`] names what cannot
/// be removed.
pub(super) fn for_run(folder: &Path, scenario: &Scenario) -> Result<(), OutputError> {
    let mut old = Old::default();
    old.take(folder, &run_files(scenario), scenario)?;
    for name in contestants(folder) {
        old.take_folder(folder.join(name), scenario)?;
    }
    old.remove(scenario)
}

/// Makes room for a comparison and its runs, of these names.
///
/// # Errors
/// As [`for_run`].
pub(super) fn for_comparison(folder: &Path, names: &[&str], scenario: &Scenario) -> Result<(), OutputError> {
    let mut old = Old::default();
    old.take(folder, &COMPARISON.map(str::to_owned), scenario)?;
    for name in names {
        old.take(&folder.join(name), &run_files(scenario), scenario)?;
    }
    for name in contestants(folder).into_iter().filter(|name| !names.contains(&name.as_str())) {
        old.take_folder(folder.join(name), scenario)?;
    }
    old.remove(scenario)
}

/// The folders of the runs of an earlier comparison.
pub(super) fn contestants(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("compare.json")).unwrap_or_default();
    let listed = serde_json::from_str::<serde_json::Value>(&text).ok();
    let of = |list: &'static str, name: &'static str| {
        let entries = listed.iter().filter_map(move |json| json[list].as_array()).flatten();
        entries.filter_map(move |entry| entry[name].as_str())
    };
    let names = of("variants", "name").chain(of("rows", "element")).filter(|name| is_name(name)).map(str::to_owned);
    FOLDERS.into_iter().map(str::to_owned).chain(names).collect()
}

/// Whether a name can be that of a folder of a comparison.
pub(super) fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_+".contains(c);
    !name.is_empty() && name.chars().all(plain)
}

/// Whether two paths lead to one file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// What is to be removed.
#[derive(Default)]
struct Old {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Old {
    /// Takes our files in a folder; refuses if another has one of the names that will be `written`.
    fn take(&mut self, folder: &Path, written: &[String], scenario: &Scenario) -> Result<(), OutputError> {
        let files = ours(folder, scenario)?;
        let is_there = |file: &PathBuf| file.symlink_metadata().is_ok();
        let mut theirs = written.iter().map(|name| folder.join(name)).filter(is_there);
        match theirs.find(|file| !files.contains(file) && !is_same(file, &scenario.path)) {
            Some(path) => Err(OutputError::InTheWay { path }),
            None => {
                self.files.extend(files);
                Ok(())
            }
        }
    }

    /// Takes a folder that holds files of ours and nothing else.
    fn take_folder(&mut self, folder: PathBuf, scenario: &Scenario) -> Result<(), OutputError> {
        let files = ours(&folder, scenario)?;
        if !folder.is_symlink() && !files.is_empty() && entries(&folder)?.len() == files.len() {
            self.files.extend(files);
            self.folders.push(folder);
        }
        Ok(())
    }

    fn remove(mut self, scenario: &Scenario) -> Result<(), OutputError> {
        if let MeshSource::File(file) = &scenario.mesh
            && let Ok(mesh) = find(file, &scenario.directory)
            && let Some(path) = self.files.iter().find(|file| is_same(file, &mesh))
        {
            return Err(OutputError::Input { path: path.clone() });
        }
        self.files.retain(|file| !is_same(file, &scenario.path));
        for file in &self.files {
            fs::remove_file(file).map_err(|e| OutputError::write(file, e))?;
        }
        for folder in &self.folders {
            if entries(folder)?.is_empty() {
                fs::remove_dir(folder).map_err(|e| OutputError::write(folder, e))?;
            }
        }
        Ok(())
    }
}

/// The names of the files that a run may write.
fn run_files(scenario: &Scenario) -> Vec<String> {
    let steps = (0..=scenario.refine.steps).map(step_file);
    let probes = scenario.probes.iter().map(|p| probe_file(&p.name));
    RUN.map(str::to_owned).into_iter().chain(steps).chain(probes).collect()
}

/// The files in a folder that an earlier run or comparison wrote; those it was writing alone if nothing marks it as a folder of results. The
/// scenario to run is no mark: it may be a copy that the user moved.
fn ours(folder: &Path, scenario: &Scenario) -> Result<Vec<PathBuf>, OutputError> {
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap_or_default();
    let marks = |(name, word): (&str, &str)| !is_same(&folder.join(name), &scenario.path) && text(name).contains(word);
    let there = entries(folder)?;
    if !MARKS.into_iter().any(marks) {
        // A run may have been killed before it had written a whole file.
        return Ok(abandoned(&there).into_iter().filter(|file| is_file(file)).collect());
    }
    let mut names = listed_steps(&text("results.pvd"));
    // A killed run may have written a step that it had not listed yet.
    names.push(step_file(names.iter().filter_map(|name| number(name)).max().map_or(0, |last| last + 1)));
    let probes = text("scenario.toml").parse::<toml::Table>().ok().and_then(|mut table| table.remove("probes"));
    names.extend(probes.iter().filter_map(toml::Value::as_table).flat_map(toml::Table::keys).map(|p| probe_file(p)));
    names.extend(FILES.map(str::to_owned));
    let named = names.into_iter().map(|name| folder.join(name)).filter(|file| there.contains(file));
    Ok(named.chain(abandoned(&there)).filter(|file| is_file(file)).collect())
}

/// Files that a killed run was writing.
fn abandoned(files: &[PathBuf]) -> Vec<PathBuf> {
    let is_ours = |file: &&PathBuf| file.file_name().is_some_and(|n| n.to_string_lossy().starts_with(TEMPORARY));
    files.iter().filter(is_ours).cloned().collect()
}

/// Removes what a killed run was writing, before it goes on.
///
/// # Errors
/// [`OutputError::Write`] names what cannot be removed.
pub(super) fn remove_abandoned(folder: &Path) -> Result<(), OutputError> {
    abandoned(&entries(folder)?)
        .iter()
        .try_for_each(|file| fs::remove_file(file).map_err(|e| OutputError::write(file, e)))
}

/// The steps that a collection lists.
pub(super) fn listed_steps(collection: &str) -> Vec<String> {
    let names = collection.split("file=\"").skip(1).filter_map(|rest| rest.split_once('"'));
    let is_step = |name: &&str| number(name).is_some();
    names.map(|(name, _)| name).filter(is_step).map(str::to_owned).collect()
}

/// The number of a step's file.
fn number(name: &str) -> Option<usize> {
    let digits = name.strip_prefix("step_")?.strip_suffix(".vtu")?;
    digits.parse().ok().filter(|_| digits.bytes().all(|b| b.is_ascii_digit()))
}

fn is_file(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|data| data.is_file())
}

/// What a folder holds; nothing if it does not exist.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, OutputError> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries: io::Result<Vec<fs::DirEntry>> = fs::read_dir(folder).and_then(Iterator::collect);
    Ok(entries.map_err(|e| OutputError::write(folder, e))?.iter().map(fs::DirEntry::path).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collection_shows_the_steps_of_its_run_only() {
        let text = "<DataSet file=\"step_000.vtu\"/><DataSet file=\"../step_001.vtu\"/><DataSet file=\"step_x.vtu\"/>";
        assert_eq!(listed_steps(text), ["step_000.vtu"]);
    }

    #[test]
    fn only_our_files_and_folders_of_nothing_else_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let at = |file: &str| root.path().join(file);
        let steps = "file=\"step_000.vtu\" file=\"step_1234.vtu\"";
        let ours = [
            ("step_000.vtu", ""),
            ("step_1234.vtu", ""),
            ("report.json", ""),
            ("results.pvd", steps),
            ("global/step_000.vtu", ""),
            ("global/results.pvd", steps),
            ("global/view.py", ""),
        ];
        let theirs = [
            ("step_005.vtu", ""),
            ("probe_mine.csv", ""),
            ("notes.txt", ""),
            ("other.svg", ""),
            ("adaptive/results.pvd", steps),
            ("adaptive/mine.txt", ""),
            ("more/report.json", ""),
            ("scenario.toml", "# a.toml as it was run\nmesh.box = { size = [1, 1, 1], cells = [1, 1, 1] }\n"),
        ];
        ["global", "adaptive", "more"].iter().for_each(|f| fs::create_dir(at(f)).unwrap());
        ours.iter().chain(&theirs).for_each(|(file, text)| fs::write(at(file), text).unwrap());
        let scenario = Scenario::from_file(&at("scenario.toml"), &[]).unwrap();
        for_run(root.path(), &scenario).unwrap();
        assert!(ours.iter().all(|(file, _)| !at(file).exists()) && !at("global").exists());
        assert!(theirs.iter().all(|(file, _)| at(file).is_file()));

        fs::write(at("step_000.vtu"), "").unwrap();
        let error = for_run(root.path(), &scenario).unwrap_err();
        assert!(matches!(error, OutputError::InTheWay { path } if path == at("step_000.vtu")));
    }
}
