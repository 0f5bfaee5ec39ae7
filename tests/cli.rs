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
        ("inline.toml", "mesh = { file = \"lost.msh\" }\n"),
        ("flat.toml", "mesh.box = { size = [1, 1, 1e-14], cells = [1, 1, 1] }\n"),
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
        (&["check", "inline.toml"], 4, "lost.msh"),
        (&["run", "typo.toml", "--json", "a.json"], 3, "typo.toml:2:1"),
        (&["check", "lost.toml", "--set", "refine.steps=-1"], 3, "--set refine.steps=-1"),
        (&["run", "lost.toml"], 4, "SUBSOLID_DATA"),
        (&["compare", "broken.toml", "--json", "a.json"], 4, "broken"),
        (&["inspect", "broken.msh", "--json", "a.json"], 4, "broken.msh"),
        (&["check", "lost.toml"], 4, "lost.msh"),
        (&["check", "flat.toml"], 4, "`mesh.box`"),
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

/// A folder with a tetrahedron and lists of its cells, edges and vertices, good and bad.
fn tetrahedron() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        (
            "one.msh",
            "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n\
             End Coordinates\nElements\n1 1 2 3 4\nEnd Elements\n",
        ),
        ("cells.txt", "0\n"),
        ("no-cell.txt", "0\n\n1\n"),
        ("empty.txt", "\n"),
        ("word.txt", "0\nall\n"),
        ("edges.txt", "2 1\n"),
        ("no-edge.txt", "0 1\n0 4\n"),
        ("corners.txt", "3\n"),
        ("no-corner.txt", "4\n"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn subdivide_refines_what_is_chosen() {
    let folder = tetrahedron();
    for (arguments, words) in [
        (&["--scheme", "longest-edge", "--select", "cells.txt", "--steps", "3"][..], "8 cells, 10 nodes"),
        (&["--scheme", "longest-edge", "--select", "boundary"], "2 cells, 5 nodes"),
        (&["--scheme", "longest-edge", "--select", "curvature"], "0 cells refined"),
        (
            &["--scheme", "longest-edge", "--select", "curvature", "--feature-angle", "180"],
            "2 cells, 5 nodes, 0 feature",
        ),
        (&["--scheme", "red", "--edges", "edges.txt", "--feature-angle", "180"], "8 cells, 10 nodes, 2 feature edges"),
        (&["--boundary", "interpolating", "--corners", "corners.txt"], "nodes, 6 feature edges"),
    ] {
        let command = [&["subdivide", "one.msh", "-o", "out.vtu", "--optimise", "paper"], arguments].concat();
        let (status, stdout, stderr) = subsolid(folder.path(), &command);
        assert!(status == Some(0) && stdout.contains(words), "{arguments:?}\n{stdout}\n{stderr}");
    }
}

#[test]
fn lists_that_do_not_fit_the_mesh_are_refused_with_their_line() {
    let folder = tetrahedron();
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for (arguments, code, word) in [
        (["--select", "no-cell.txt"], 4, "no-cell.txt:3: cell 1 does not exist"),
        (["--select", "empty.txt"], 4, "empty.txt:1"),
        (["--select", "word.txt"], 4, "word.txt:2: column 1"),
        (["--select", "absent.txt"], 4, "absent.txt"),
        (["--select", "edges.txt"], 4, "edges.txt:1: unexpected"),
        (["--edges", "no-edge.txt"], 4, "no-edge.txt:2: [0, 4] is not an edge"),
        (["--edges", "cells.txt"], 4, "cells.txt:1: expected"),
        (["--corners", "no-corner.txt"], 4, "no-corner.txt:1: vertex 4"),
        (["--select", ""], 2, "--select"),
        (["--scheme", "green"], 2, "longest-edge"),
    ] {
        let command = [&["subdivide", "one.msh", "-o", "out.vtu"][..], &arguments].concat();
        let (status, stdout, stderr) = subsolid(folder.path(), &command);
        assert_eq!(status, Some(code), "{arguments:?}\n{stderr}");
        assert!(stdout.is_empty() && stderr.contains(word), "{arguments:?}\n{stderr}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before, "{arguments:?}");
    }
    let measure = ["subdivide", "one.msh", "-o", "out.vtu", "--optimise", "best", "--measure", "edge-ratio"];
    let (status, _, stderr) = subsolid(folder.path(), &measure);
    assert!(status == Some(2) && stderr.contains("--optimise paper"), "{stderr}");
    let red = ["subdivide", "one.msh", "-o", "out.vtu", "--scheme", "red", "--select", "cells.txt"];
    let (status, _, stderr) = subsolid(folder.path(), &red);
    assert!(status == Some(2) && stderr.contains("--select"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn class_63_a_closed_pipe_is_no_failure() {
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
