//! The command line: exit codes, what is printed where, and that a failure leaves nothing behind.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use std::path::Path;

/// Runs `subsolid` in a folder; gives its exit code, standard output and standard error.
fn subsolid(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::cargo_bin("subsolid")
        .unwrap()
        .args(arguments)
        .current_dir(folder)
        .env_remove("SUBSOLID_DATA")
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// A folder with scenarios that fail in known ways.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("lost.toml", "[mesh]\nfile = \"lost.msh\"\n"),
        ("typo.toml", "[mesh]\nfiel = \"lost.msh\"\n"),
        ("broken.msh", "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0\n"),
        ("broken.toml", "[mesh]\nfile = \"broken.msh\"\n"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn failures_have_their_codes_and_leave_nothing_behind() {
    let folder = folder();
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for (arguments, code, word) in [
        (&["run"][..], 2, "SCENARIO"),
        (&["solve", "lost.toml"], 2, "solve"),
        (&["compare", "lost.toml", "--repeat", "0"], 2, "--repeat"),
        (&["run", "lost.toml", "--threads", "0"], 2, "--threads"),
        (&["subdivide", "broken.msh", "-o", "a.vtu", "--feature-angle", "200"], 2, "180"),
        (&["run", "lost.toml", "sub/lost.toml"], 2, "called lost: their results would share a folder"),
        (&["run", "lost.toml", "typo.toml", "--json", "a.json"], 2, "--json"),
        (&["run", "absent.toml"], 3, "absent.toml"),
        (&["check", "broken.msh"], 3, "is a GiD mesh, not a scenario"),
        (&["run", "typo.toml", "--json", "a.json"], 3, "typo.toml:2:1"),
        (&["check", "lost.toml", "--set", "refine.steps=-1"], 3, "--set refine.steps=-1"),
        (&["run", "lost.toml"], 4, "SUBSOLID_DATA"),
        (&["compare", "broken.toml", "--json", "a.json"], 4, "broken"),
        (&["inspect", "broken.msh", "--json", "a.json"], 4, "broken.msh"),
        (&["check", "lost.toml"], 4, "lost.msh"),
    ] {
        let (status, stdout, stderr) = subsolid(folder.path(), arguments);
        assert_eq!(status, Some(code), "{arguments:?}\n{stderr}");
        assert!(stdout.is_empty() && stderr.contains(word), "{arguments:?}\n{stdout}\n{stderr}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before, "{arguments:?}");
    }
}

#[test]
fn several_scenarios_are_all_read_before_one_runs() {
    let folder = folder();
    let (status, stdout, stderr) = subsolid(folder.path(), &["run", "lost.toml", "typo.toml"]);
    assert_eq!((status, stdout.as_str()), (Some(3), ""));
    assert!(!stderr.contains("cannot read mesh") && stderr.contains("`mesh.fiel`"), "{stderr}");
    let (status, _, stderr) = subsolid(folder.path(), &["run", "lost.toml", "broken.toml"]);
    assert!(status == Some(4) && stderr.contains("lost.msh") && stderr.contains("broken.msh"), "{stderr}");
}

#[test]
fn help_version_and_completions_are_on_standard_output() {
    let folder = folder();
    for (arguments, word) in [
        (&["--help"][..], "Exit codes"),
        (&["--version"], env!("CARGO_PKG_VERSION")),
        (&["completions", "bash"], "subdivide"),
    ] {
        let (status, stdout, _) = subsolid(folder.path(), arguments);
        assert!(status == Some(0) && stdout.contains(word), "{stdout}");
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_failure() {
    use std::process::{Command as Process, Stdio};
    // The script is longer than a pipe holds, so writing it to nobody fails unless the program lets it.
    let mut child = Process::new(assert_cmd::cargo::cargo_bin("subsolid"))
        .args(["completions", "zsh"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}
