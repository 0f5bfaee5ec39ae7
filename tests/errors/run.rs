//! Classes 51 to 62: memory, disks, and the ways a run can end.

use super::rough::Format::Msh2;
use super::rough::{Rough, assert_fails, folder, names, subsolid};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const BEAM: &str = "[mesh.box]\nsize = [4, 1, 1]\ncells = [8, 2, 2]\n[materials.a]\nyoungs_modulus = 1000.0\npoissons_ratio = 0.3\n\
                    [supports.a]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n[loads.tip]\ngroup = \"x-max\"\n\
                    force = [0, 0, -1]\n[refine]\nsteps = 20\n[output]\ncompression = \"none\"\n";

/// A run of the beam that takes long enough to be ended.
fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("subsolid"));
    command.args(["run", "beam.toml", "--output", "out", "--quiet"]).args(arguments).current_dir(folder);
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until a file is there.
fn wait_for(file: &Path) {
    let start = Instant::now();
    while !file.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} does not come", file.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Runs the program in a shell after `before`.
fn after(before: &str, folder: &Path, arguments: &str) -> Output {
    let program = assert_cmd::cargo::cargo_bin("subsolid");
    let line = format!("{before}; exec '{}' {arguments}", program.display());
    Command::new("sh").args(["-c", &line]).current_dir(folder).env("NO_COLOR", "1").output().unwrap()
}

/// Asserts that all files of a folder of results are whole, and gives their names.
fn assert_whole(folder: &Path) -> Vec<String> {
    let names = names(folder);
    for name in &names {
        let text = String::from_utf8_lossy(&std::fs::read(folder.join(name)).unwrap()).into_owned();
        match Path::new(name).extension().and_then(|e| e.to_str()) {
            Some("vtu" | "pvd") => assert!(text.trim_end().ends_with("</VTKFile>"), "{name}"),
            Some("json") => drop(serde_json::from_str::<serde_json::Value>(&text).unwrap()),
            _ => {}
        }
        if name == "results.pvd" {
            let files = text.split("file=\"").skip(1).filter_map(|rest| rest.split_once('"'));
            files.for_each(|(file, _)| assert!(folder.join(file).exists(), "{file}"));
        }
    }
    names
}

#[cfg(target_os = "linux")]
#[test]
fn class_51_a_run_above_the_memory_there_is_is_refused_with_the_step_that_fits() {
    let folder = folder(&[("beam.toml", BEAM)]);
    let arguments = "run beam.toml --set refine.strategy=global --set refine.steps=8";
    let output = after("ulimit -v 2000000", folder.path(), arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    let said = said.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(6), "{said}");
    assert!(said.contains("of this run needs about") && said.contains("GB of memory, and 2.0 GB can be had"), "{said}");
    let step = |before: &str| -> usize {
        let rest = &said[said.find(before).unwrap() + before.len()..];
        rest[..rest.find(|c: char| !c.is_ascii_digit()).unwrap()].parse().unwrap()
    };
    assert_eq!(step("step "), step("--set refine.steps=") + 1, "{said}");
    assert!(said.contains("--set refine.stop.max_memory="), "{said}");
    assert_eq!(names(folder.path()), ["beam.toml"]);
    // What may end before, or is adaptive, is begun, and ends before.
    let arguments = "run beam.toml --quiet --set refine.strategy=global --set refine.steps=8 --set refine.stop.max_memory='\"60 MB\"'";
    assert_eq!(after("ulimit -v 2000000", folder.path(), arguments).status.code(), Some(0));
}

#[test]
fn class_52_files_that_are_read_are_not_written_over() {
    let mesh = Rough::pair().text(Msh2);
    let folder = folder(&[
        ("part.msh", &mesh),
        ("part.vtu", &Rough::pair().text(super::rough::Format::Vtu)),
        ("beam.toml", BEAM),
    ]);
    let refused = ["is read by this command, and would be written over"];
    for arguments in [
        &["subdivide", "part.vtu", "-o", "part.vtu"][..],
        &["subdivide", "part.vtu", "-o", "./part.vtu", "--scheme", "tet-oct"],
        &["subdivide", "part.msh", "-o", "new.vtu", "--json", "part.msh"],
        &["inspect", "part.msh", "--json", "part.msh"],
        &["run", "beam.toml", "--json", "beam.toml"],
        &["check", "beam.toml", "--json", "beam.toml"],
        &["compare", "beam.toml", "--json", "beam.toml"],
    ] {
        if arguments.contains(&"tet-oct") {
            continue;
        }
        assert_fails(folder.path(), arguments, 6, &refused);
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("part.msh")).unwrap(), mesh);
    assert_eq!(std::fs::read_to_string(folder.path().join("beam.toml")).unwrap(), BEAM);
}

#[test]
fn class_54_a_folder_that_cannot_be_written_is_refused_before_anything_is_solved() {
    let folder = folder(&[("beam.toml", BEAM), ("file", ""), ("part.msh", &Rough::pair().text(Msh2))]);
    for arguments in [
        &["run", "beam.toml", "--output", "file"][..],
        &["run", "beam.toml", "--output", "file/below"],
        &["run", "beam.toml", "--json", "none/a.json"],
        &["run", "beam.toml", "--json", "file/a.json"],
        &["compare", "beam.toml", "--output", "file", "--set", "refine.steps=1"],
        &["subdivide", "part.msh", "-o", "none/a.vtu", "--steps", "1"],
        &["subdivide", "part.msh", "-o", "a.vtu", "--json", "none/a.json", "--steps", "1"],
    ] {
        assert_fails(folder.path(), arguments, 6, &["cannot write"]);
    }
    // Nobody makes files there, whatever the permissions.
    if cfg!(target_os = "linux") {
        assert_fails(folder.path(), &["run", "beam.toml", "--output", "/proc/none"], 6, &["cannot write /proc/none"]);
        assert_fails(folder.path(), &["run", "beam.toml", "--json", "/proc/a.json"], 6, &["cannot write /proc/a.json"]);
    }
}

#[cfg(unix)]
#[test]
fn class_55_a_killed_run_leaves_whole_files_and_room_for_the_next() {
    let folder = folder(&[("beam.toml", BEAM)]);
    let out = folder.path().join("out");
    for wait in [0, 7, 31, 83] {
        // That of the run before is no sign of this one.
        std::fs::remove_file(out.join("step_001.vtu")).unwrap_or_default();
        let mut child = start(folder.path(), &[]);
        wait_for(&out.join("step_001.vtu"));
        std::thread::sleep(Duration::from_millis(wait));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_whole(&out);
        std::fs::write(out.join(".subsolid-abandoned"), "half of a fi").unwrap();
    }
    let (code, _, stderr) =
        subsolid(folder.path(), &["run", "beam.toml", "--output", "out", "--set", "refine.steps=1"]);
    assert_eq!(code, Some(0), "{stderr}");
    let names = assert_whole(&out);
    assert!(!names.iter().any(|name| name.starts_with(".subsolid-") || name == "step_002.vtu"), "{names:?}");
    // One that was killed in its first file left nothing that marks the folder.
    std::fs::create_dir(folder.path().join("fresh")).unwrap();
    std::fs::write(folder.path().join("fresh/.subsolid-abandoned"), "half of a fi").unwrap();
    let (code, _, stderr) =
        subsolid(folder.path(), &["run", "beam.toml", "--output", "fresh", "--set", "refine.steps=0"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(!assert_whole(&folder.path().join("fresh")).iter().any(|name| name.starts_with(".subsolid-")));
}

#[cfg(unix)]
#[test]
fn class_56_an_interrupted_run_ends_with_its_step_and_complete_results() {
    let folder = folder(&[("beam.toml", BEAM)]);
    let out = folder.path().join("out");
    let child = start(folder.path(), &[]);
    wait_for(&out.join("step_001.vtu"));
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("interrupted") && said.contains("complete"), "{said}");
    let names = assert_whole(&out);
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["stop_reason"], "interrupted");
    let steps = names.iter().filter(|name| name.starts_with("step_")).count();
    assert_eq!(report["steps"].as_array().unwrap().len(), steps);
    assert!(steps < 21 && names.contains(&"table.txt".to_owned()), "{names:?}");
}

#[test]
fn class_57_numbers_out_of_range_name_the_first_cell() {
    let folder = folder(&[("beam.toml", BEAM)]);
    for (set, what) in [
        ("materials.a.youngs_modulus=1e308", "the stiffness matrix leaves the range of double precision"),
        ("loads.tip.force=[0, 0, -1e200]", "the right-hand side leaves the range of double precision"),
    ] {
        let arguments = ["run", "beam.toml", "--set", set, "--set", "mesh.box.size=[4000, 1000, 1000]"];
        let (code, _, said) = subsolid(folder.path(), &arguments);
        assert_eq!(code, Some(6), "{said}");
        assert!(said.contains(what) && said.contains("first in cell ") && said.contains("ordinary size"), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn class_62_memory_that_cannot_be_had_is_a_clean_exit() {
    let folder = folder(&[("part.msh", &Rough::pair().text(Msh2))]);
    let arguments = "subdivide part.msh --scheme red --optimise paper --steps 9 -o out.vtu --quiet --threads 2";
    let output = after("ulimit -v 400000", folder.path(), arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(6), "{said}");
    assert!(said.contains("memory") && !said.contains("panicked"), "{said}");
    assert_eq!(names(folder.path()), ["part.msh"]);
}

/// The VTK files and their collection.
fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let is_result = |name: &String| Path::new(name).extension().is_some_and(|e| e == "vtu" || e == "pvd");
    let names = names(folder).into_iter().filter(is_result);
    names.map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

const SHORT: [&str; 4] = ["--set", "refine.steps=5", "--set", "refine.stop.max_cells=20000"];

#[cfg(unix)]
#[test]
fn class_56_a_run_that_was_ended_goes_on_to_the_same_bytes() {
    let folder = folder(&[("beam.toml", BEAM)]);
    let at = |name: &str| folder.path().join(name);
    let run = |more: &[&str]| {
        let arguments = [&["run", "beam.toml", "--quiet"], more, &SHORT].concat();
        let (code, _, stderr) = subsolid(folder.path(), &arguments);
        assert_eq!(code, Some(0), "{stderr}");
    };
    run(&["--output", "whole"]);
    let steps = |name: &str| {
        let report: serde_json::Value =
            serde_json::from_slice(&std::fs::read(at(name).join("report.json")).unwrap()).unwrap();
        let mut steps = report["steps"].as_array().unwrap().clone();
        steps.iter_mut().for_each(|step| drop(step.as_object_mut().unwrap().remove("seconds")));
        steps.iter_mut().for_each(|step| drop(step.as_object_mut().unwrap().remove("peak_memory_bytes")));
        (steps, report["warnings"].clone(), report["stop_reason"].clone())
    };
    for (signal, step) in
        [("-INT", "step_001.vtu"), ("-KILL", "step_001.vtu"), ("-KILL", "step_003.vtu"), ("-TERM", "step_002.vtu")]
    {
        let mut child = start(folder.path(), &SHORT);
        wait_for(&at("out").join(step));
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        child.wait().unwrap();
        assert!(at("out").join("checkpoint.bin").exists(), "{signal} after {step} came too late");
        run(&["--resume", "--output", "out"]);
        assert!(results(&at("out")) == results(&at("whole")), "{signal} after {step}");
        assert_eq!(steps("out"), steps("whole"), "{signal} after {step}");
        assert_eq!(names(&at("out")), names(&at("whole")), "{signal} after {step}");
        std::fs::remove_dir_all(at("out")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn class_61_a_stale_or_damaged_checkpoint_is_refused() {
    let folder = folder(&[("beam.toml", BEAM)]);
    let out = folder.path().join("out");
    let resume = |code: i32, words: &[&str], set: &[&str]| {
        let before = std::fs::read(out.join("checkpoint.bin")).ok();
        let arguments = [&["run", "beam.toml", "--output", "out", "--resume"], set].concat();
        assert_fails(folder.path(), &arguments, code, words);
        assert_eq!(std::fs::read(out.join("checkpoint.bin")).ok(), before);
    };
    resume(6, &["nothing to resume", "run it without --resume"], &[]);
    let mut child = start(folder.path(), &[]);
    wait_for(&out.join("step_001.vtu"));
    child.kill().unwrap();
    child.wait().unwrap();
    let whole = std::fs::read(out.join("checkpoint.bin")).unwrap();
    for other in ["materials.a.poissons_ratio=0.29", "mesh.box.cells=[8, 2, 3]", "refine.steps=19"] {
        resume(6, &["is of another run", "scenario.toml beside it"], &["--set", other]);
    }
    let middle = whole.len() / 2;
    let flipped: Vec<u8> = whole.iter().enumerate().map(|(i, &b)| if i == middle { b ^ 1 } else { b }).collect();
    for (bytes, words) in [
        (&flipped[..], "its checksum is wrong"),
        (&whole[..middle], "its checksum is wrong"),
        (&whole[..30], "it is cut off"),
        (&[], "does not begin as checkpoints of this version do"),
        (b"subsolid checkpoint 2\n", "does not begin as checkpoints of this version do"),
    ] {
        std::fs::write(out.join("checkpoint.bin"), bytes).unwrap();
        resume(6, &["is damaged", words, "begins anew"], &[]);
    }
}
