//! Files that an earlier run or comparison left in a folder of results: removed by name, and nothing else.

use crate::output::OutputError;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The files that runs and comparisons write, but for those of the steps.
const FILES: [&str; 11] = [
    "results.pvd",
    "view.py",
    "report.json",
    "table.txt",
    "scenario.toml",
    "compare.json",
    "compare.txt",
    "error_dofs.svg",
    "error_seconds.svg",
    "dihedral_angles.svg",
    "cell_errors.svg",
];

/// The folders of a comparison.
const FOLDERS: [&str; 2] = ["global", "adaptive"];

/// Removes our files from a folder, and a comparison's folders if they hold nothing but our files. Whatever its name, the
/// file `keep` stays: the scenario that is run may lie in the folder.
///
/// # Errors
/// [`OutputError::Write`] names what cannot be removed.
pub(super) fn remove(folder: &Path, keep: &Path) -> Result<(), OutputError> {
    for file in ours(folder)?.0 {
        if !is_same(&file, keep) {
            fs::remove_file(&file).map_err(|e| OutputError::write(&file, e))?;
        }
    }
    for folder in FOLDERS.map(|name| folder.join(name)) {
        if !folder.is_dir() || folder.is_symlink() {
            continue;
        }
        let (files, others) = ours(&folder)?;
        if others == 0 && !files.iter().any(|file| is_same(file, keep)) {
            fs::remove_dir_all(&folder).map_err(|e| OutputError::write(&folder, e))?;
        }
    }
    Ok(())
}

/// Whether two paths lead to one file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Our files in a folder, and the number of its other entries.
fn ours(folder: &Path) -> Result<(Vec<PathBuf>, usize), OutputError> {
    let entries: io::Result<Vec<fs::DirEntry>> = fs::read_dir(folder).and_then(Iterator::collect);
    let mut files = Vec::new();
    let entries = entries.map_err(|e| OutputError::write(folder, e))?;
    for entry in &entries {
        let file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if file && entry.file_name().to_str().is_some_and(is_our_name) {
            files.push(entry.path());
        }
    }
    let others = entries.len() - files.len();
    Ok((files, others))
}

fn is_our_name(name: &str) -> bool {
    let number = name.strip_prefix("step_").and_then(|rest| rest.strip_suffix(".vtu"));
    let is_step = |n: &str| n.len() >= 3 && n.bytes().all(|b| b.is_ascii_digit());
    let is_probe = name.starts_with("probe_") && name.ends_with(".csv");
    FILES.contains(&name) || is_probe || number.is_some_and(is_step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_our_files_and_folders_of_nothing_else_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let at = |file: &str| root.path().join(file);
        let ours =
            ["step_000.vtu", "step_1234.vtu", "report.json", "probe_axis.csv", "global/step_001.vtu", "global/view.py"];
        let theirs = [
            "step_.vtu",
            "step_00.vtu",
            "step_abc.vtu",
            "notes.txt",
            "other.svg",
            "adaptive/report.json",
            "adaptive/mine.txt",
            "more/report.json",
            "scenario.toml",
        ];
        ["global", "adaptive", "more", "table.txt"].iter().for_each(|f| fs::create_dir(at(f)).unwrap());
        ours.iter().chain(&theirs).for_each(|f| fs::write(at(f), "").unwrap());
        remove(root.path(), &at("scenario.toml")).unwrap();
        assert!(ours.iter().all(|f| !at(f).exists()) && !at("global").exists());
        assert!(theirs.iter().all(|f| at(f).is_file()) && at("table.txt").is_dir());
    }
}
