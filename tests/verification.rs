//! The verification book: all of it passes at the rates that theory gives, its page tells what it holds, and what is wrong
//! fails by name.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use subsolid::scenario::{Bound, Scenario};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Runs `subsolid verify` in a folder; gives its exit code, standard output and standard error.
fn verify(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::cargo_bin("subsolid").unwrap();
    let output = command
        .arg("verify")
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .env_remove("SUBSOLID_DATA")
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The scenarios of the book, by name.
fn scenarios() -> Vec<Scenario> {
    let folder = Path::new(ROOT).join("scenarios/verification");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| Scenario::from_file(path, &[]).unwrap()).collect()
}

/// The slope of an entry of the book.
fn slope(book: &Value, file: &str, quantity: &str) -> f64 {
    let problem = book["problems"].as_array().unwrap().iter().find(|p| p["file"] == format!("{file}.toml")).unwrap();
    let entry = problem["entries"].as_array().unwrap().iter().find(|e| e["quantity"] == quantity).unwrap();
    entry["slope"].as_f64().unwrap_or_else(|| panic!("{file}: {quantity} has no slope"))
}

/// Slopes are in the number of unknowns N: h is N^(-1/3), and energies converge twice as fast as energy norms.
#[test]
fn the_book_passes_and_converges_as_theory_says() {
    let (code, stdout, stderr) = verify(Path::new(ROOT), &["--json", "-"]);
    let book: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(code, Some(0), "{stderr}");
    assert!(book["problems"].as_array().unwrap().len() >= 25);
    let error = "true-relative-error";
    for (file, theory) in [
        ("cube-tet4-3", -1.0 / 3.0),
        ("cube-tet10-3", -2.0 / 3.0),
        ("kirsch-3", -2.0 / 3.0),
        ("lame-sphere-3", -2.0 / 3.0),
        // On meshes one cell wide the unknowns grow with h^-2.
        ("timoshenko-3", -1.0),
    ] {
        let found = slope(&book, file, error);
        assert!((found - theory).abs() < 0.1, "{file}: {found}, not {theory}");
        let energy = slope(&book, file, "strain-energy");
        assert!((energy - 2.0 * theory).abs() < 0.25, "{file}: energy {energy}, not {}", 2.0 * theory);
    }
    let uniform = slope(&book, "l-prism-uniform", error);
    assert!((uniform + 0.1815).abs() < 0.02, "{uniform}");
    for (file, at_most) in [("l-prism-tet4", -0.29), ("l-prism-tet10", -0.42)] {
        let found = slope(&book, file, error);
        assert!(found < at_most, "{file}: {found}");
    }
}

/// The file, quantity and reference of each row of the page.
fn rows(page: &str) -> Vec<[String; 3]> {
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|c| c.trim().to_owned()).collect::<Vec<_>>();
    let rows = page.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| scenario")).map(cells);
    rows.map(|c| [c[0].clone(), c[1].clone(), c[2].clone()]).collect()
}

#[test]
fn the_page_has_all_entries_with_their_references_and_sources() {
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/verification.md")).unwrap();
    let mut expected = Vec::new();
    for s in scenarios() {
        for e in &s.expectations {
            let reference = match e.bound {
                Bound::Near(value, _) => format!("{value}"),
                Bound::Between(low, high) => format!("{low} to {high}"),
            };
            expected.push([s.name(), e.subject.name().to_owned(), reference]);
            let source =
                e.source.as_ref().unwrap_or_else(|| panic!("{}: {} has no source", s.name(), e.subject.name()));
            assert!(page.contains(source), "the page lacks a source of {}: write it again", s.name());
        }
        assert!(page.contains(s.description.trim()), "the page lacks the description of {}: write it again", s.name());
        // Defaults may change; what the book verifies does not.
        assert!(s.document["analysis"]["element"].is_str(), "{} names no element", s.name());
    }
    assert_eq!(rows(&page), expected, "write it again: subsolid verify --markdown docs/verification.md");
    assert!(!page.contains("FAIL"));
}

/// A bar of length 2 under the traction 1: it stretches by 2e-3, to 1e-8 of it on any mesh.
const BAR: &str = "title = \"Bar\"\nanalysis.element = \"tet4\"\nmesh.box = { size = [2, 1, 1], cells = [2, 1, 1] }\n\
    materials.m = { youngs_modulus = 1e3, poissons_ratio = 0.25 }\n\
    supports.x = { group = \"x-min\", fix = \"normal\" }\nsupports.y = { group = \"y-min\", fix = \"normal\" }\n\
    supports.z = { group = \"z-min\", fix = \"normal\" }\nloads.pull = { group = \"x-max\", traction = [1, 0, 0] }\n\
    quantities.tip = { average = \"ux\", group = \"x-max\" }\n";

/// A folder with these scenarios.
fn folder(scenarios: &[(&str, String)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in scenarios {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn bar(expect: &str) -> String {
    format!("{BAR}{expect}\n")
}

const RIGHT: &str = "expect.tip = { value = 2e-3, tolerance = { relative = 1e-8 }, source = \"Hooke\" }";

#[test]
fn what_is_wrong_fails_by_name_and_the_rest_still_runs() {
    let folder = folder(&[
        ("a-right.toml", bar(RIGHT)),
        ("b-wrong.toml", bar("expect.tip = { value = 2.1e-3, tolerance = { relative = 0.01 } }")),
        ("c-typo.toml", bar("[refin]\nsteps = 1")),
        (
            "d-lost.toml",
            bar(RIGHT).replace("mesh.box = { size = [2, 1, 1], cells = [2, 1, 1] }", "mesh.file = \"lost.msh\""),
        ),
        ("e-free.toml", bar(RIGHT).replace("supports.x", "supports.w").replace("\"x-min\"", "\"x-mim\"")),
        ("f-empty.toml", bar("")),
        ("g-range.toml", bar("expect.strain-energy = { between = [0.9e-3, 1.1e-3] }")),
        ("h-range.toml", bar("expect.strain-energy = { between = [1.1e-3, 1.2e-3] }")),
        (
            "i-goal.toml",
            bar("expect.tip = { between = [0, 1] }\nrefine = { steps = 1, stop = { relative_error = 1e-3 } }")
                .replace("[1, 0, 0]", "[1, 0, \"y\"]"),
        ),
        ("notes.txt", String::new()),
    ]);
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    let (code, stdout, stderr) = verify(folder.path(), &["."]);
    assert_eq!(code, Some(1), "{stderr}");
    let verdicts = |name: &str, verdict: &str| {
        stdout.lines().any(|line| line.starts_with(name) && line.trim_end().ends_with(verdict))
    };
    for name in ["a-right", "g-range"] {
        assert!(verdicts(name, "pass") && !stderr.contains(name), "{name}\n{stdout}");
    }
    for name in ["b-wrong", "c-typo", "d-lost", "e-free", "f-empty", "h-range", "i-goal"] {
        assert!(verdicts(name, "FAIL") && stderr.contains(name), "{name}\n{stdout}");
    }
    for words in
        ["refine", "SUBSOLID_DATA", "did you mean", "expects nothing", "0.100 % was asked for", "2 of 9 scenarios pass"]
    {
        assert!(stdout.contains(words), "{words}\n{stdout}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before, "left something behind");
}

#[test]
fn a_deviation_that_grows_with_the_mesh_fails_though_it_is_allowed() {
    // Clamped at its end the bar is stiffer; finer cells show more of its stretch, and come closer to one number than another.
    let clamped = |cells: usize, value: f64| {
        let text = bar(&format!("expect.tip = {{ value = {value}, tolerance = {{ relative = 0.2 }} }}"));
        text.replacen("\"normal\"", "[\"x\", \"y\", \"z\"]", 1)
            .replace("cells = [2, 1, 1]", &format!("cells = [{}, {cells}, {cells}]", 2 * cells))
    };
    for (value, code, word) in [(2e-3, Some(0), "pass"), (1.7e-3, Some(1), "FAIL")] {
        let folder = folder(&[("bar-1.toml", clamped(1, value)), ("bar-2.toml", clamped(2, value))]);
        let (status, stdout, _) = verify(folder.path(), &["."]);
        assert!(status == code && stdout.contains(word), "{value}\n{stdout}");
    }
}

/// Files of one name are one problem on finer meshes only if their unknowns grow; they count by number, not by letters.
#[test]
fn the_order_of_files_is_that_of_their_numbers_and_meshes_that_do_not_grow_are_told() {
    let clamped = |cells: usize| {
        let text = bar("expect.tip = { value = 1.7e-3, tolerance = { relative = 0.2 } }");
        text.replacen("\"normal\"", "[\"x\", \"y\", \"z\"]", 1)
            .replace("cells = [2, 1, 1]", &format!("cells = [{}, {cells}, {cells}]", 2 * cells))
    };
    // The deviation from this number grows with the cells, so each finer mesh fails.
    let folder = folder(&[("bar-2.toml", clamped(2)), ("bar-9.toml", clamped(1)), ("bar-10.toml", clamped(3))]);
    let (code, stdout, stderr) = verify(folder.path(), &["."]);
    let told = stdout.replace('\n', " ");
    assert!(told.contains("note: bar-9 has no more unknowns than bar-2"), "{stdout}");
    assert!(code == Some(1) && stderr.contains("bar-10") && !stderr.contains("bar-9"), "{stderr}");
    assert!(stdout.find("bar-9").unwrap() < stdout.find("bar-10").unwrap());
    assert!(stdout.lines().all(|l| l.chars().count() <= 80), "{stdout}");
    assert!(stdout.contains("allowed") && stdout.contains("20 %"), "{stdout}");
}

/// Whoever asks for errors only gets them, and a file that cannot be written is refused before anything is computed.
#[test]
fn quiet_verification_tells_the_faults_and_missing_folders_are_refused_at_once() {
    let folder = folder(&[
        ("a-wrong.toml", bar("expect.tip = { value = 2.1e-3, tolerance = { relative = 0.01 } }")),
        ("b-typo.toml", bar("[refin]\nsteps = 1")),
    ]);
    let (code, stdout, stderr) = verify(folder.path(), &[".", "--quiet"]);
    assert_eq!((code, stdout.as_str()), (Some(1), ""));
    let stderr = stderr.replace(['\n', '│'], " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(stderr.contains("a-wrong: tip is") && stderr.contains("1 % allowed"), "{stderr}");
    assert!(stderr.contains("b-typo: ") && stderr.contains("refin"), "{stderr}");
    for option in ["--markdown", "--json"] {
        let (code, stdout, stderr) = verify(folder.path(), &[".", option, "missing/page"]);
        assert!(code == Some(6) && stdout.is_empty() && stderr.contains("there is no folder missing"), "{stderr}");
    }
}

#[test]
fn pages_figures_and_results_go_where_they_are_asked_for() {
    let folder = folder(&[("one.toml", bar(RIGHT))]);
    std::fs::create_dir(folder.path().join("docs")).unwrap();
    let arguments = [".", "--markdown", "docs/page.md", "--json", "book.json", "--output", "results", "--quiet"];
    let (code, stdout, stderr) = verify(folder.path(), &arguments);
    assert_eq!((code, stdout.as_str()), (Some(0), ""), "{stderr}");
    let page = || std::fs::read_to_string(folder.path().join("docs/page.md")).unwrap();
    let first = page();
    // The words of the bundled book are not those of any folder.
    assert!(first.contains("[..](..)") && !first.contains("scenarios/verification"), "{first}");
    assert_eq!(rows(&first), [["one", "tip", "0.002"].map(str::to_owned)]);
    assert!(
        first.contains("[one](../one.toml)") && first.contains("### Bar") && first.contains("- tip: Hooke"),
        "{first}"
    );
    let book: Value = serde_json::from_slice(&std::fs::read(folder.path().join("book.json")).unwrap()).unwrap();
    assert_eq!(book["problems"][0]["entries"][0]["passed"], true);
    assert!(folder.path().join("results/one/report.json").is_file());
    verify(folder.path(), &arguments);
    assert_eq!(page(), first, "the same book gives the same bytes");
    for nothing in ["docs", "absent"] {
        let (code, _, stderr) = verify(folder.path(), &[nothing]);
        assert!(code == Some(3) && stderr.contains("no scenarios in"), "{stderr}");
    }
}
