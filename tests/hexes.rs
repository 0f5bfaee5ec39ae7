//! Scenarios on hexahedra, as a user runs them.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn subsolid(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.current_dir(ROOT).args(arguments);
    command
}

/// The report of a run, whose results go to a folder that is thrown away.
fn report(scenario: &str, set: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results");
    let mut command = subsolid(&["run", scenario, "--json", "-", "--quiet", "--output", path.to_str().unwrap()]);
    for key in set {
        command.args(["--set", key]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn last(report: &Value) -> &Value {
    report["steps"].as_array().unwrap().last().unwrap()
}

/// Lame's tube: displacement 143/75 inside, energy 143 pi/600. Reactions balance the pressure on the two planes, 1/2 each.
#[test]
fn a_tube_widens_as_lame_says() {
    for (element, within) in [("catmull-clark", 0.003), ("catmull-clark+", 3e-4), ("hex27", 0.01), ("hex20", 0.02)] {
        let report = report("scenarios/tube.toml", &[&format!("analysis.element=\"{element}\"")]);
        let step = last(&report);
        let widening = step["quantities"]["widening"]["value"].as_f64().unwrap();
        assert!((widening * 75.0 / 143.0 - 1.0).abs() < within, "{element}: {widening}");
        let energy = step["strain_energy"].as_f64().unwrap();
        assert!((energy / 0.748746249106 - 1.0).abs() < 2.0 * within, "{element}: {energy}");
    }
}

/// The functions of vertices sum to one, so that reactions sum to the loads whatever the bubbles.
#[test]
fn reactions_balance_the_loads() {
    for element in ["hex8", "hex20", "hex27", "catmull-clark", "catmull-clark+"] {
        let set = [&*format!("analysis.element=\"{element}\""), "refine.steps=0"];
        let report = report("scenarios/bent_bracket.toml", &set);
        let bolt: Vec<f64> =
            last(&report)["reactions"]["bolt"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        assert!((bolt[0] + 500.0).abs() < 1e-4 && bolt[1].abs() < 1e-4 && bolt[2].abs() < 1e-4, "{element}: {bolt:?}");
    }
}

/// Refinement of a Catmull-Clark solid leaves it as it is, and nested spaces only get richer: the energy of a loaded body grows.
#[test]
fn energy_grows_as_spaces_are_refined() {
    for element in ["hex8", "hex27", "catmull-clark"] {
        let set = [&*format!("analysis.element=\"{element}\""), "refine.steps=2", "mesh.box.cells=[4, 1, 1]"];
        let report = report("scenarios/bridge.toml", &set);
        let energies: Vec<f64> =
            report["steps"].as_array().unwrap().iter().map(|s| s["strain_energy"].as_f64().unwrap()).collect();
        assert!(energies.windows(2).all(|w| w[0] < w[1]) && energies[2] < 33.4 / 2.0, "{element}: {energies:?}");
    }
}

/// A step has eight times the cells: it is not begun where that cannot fit.
#[test]
fn a_step_above_the_memory_allowed_is_not_made() {
    let report = report("scenarios/bridge.toml", &["refine.steps=3", "refine.stop.max_memory=\"1 MiB\""]);
    assert_eq!((report["steps"].as_array().unwrap().len(), &report["stop_reason"]), (1, &Value::from("max_memory")));
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: &str| {
        let path = folder.path().join(threads);
        let out = path.to_str().unwrap();
        subsolid(&["run", "scenarios/bent_bracket.toml", "--quiet", "--threads", threads, "--output", out])
            .assert()
            .success();
        ["step_000.vtu", "step_001.vtu"].map(|file| std::fs::read(Path::new(&path).join(file)).unwrap())
    };
    let one = run("1");
    assert!(one == run("2") && one == run("5"));
}

#[test]
fn what_hexahedra_cannot_do_is_refused() {
    let hex = "analysis.element=\"hex8\"";
    let cases: [(&str, &[&str], i32, &str); 5] = [
        ("scenarios/bridge.toml", &["refine.strategy=\"adaptive\""], 3, "refined globally"),
        ("scenarios/bridge.toml", &["refine.scheme=\"sqrt3\""], 3, "is for tetrahedra"),
        ("scenarios/bridge.toml", &["analysis={ element = \"tet10\", splits = 1 }"], 3, "Catmull-Clark"),
        ("scenarios/fichera.toml", &[hex, "refine={}", "quantities={}", "expect={}", "adapt={}"], 4, "tetrahedra only"),
        ("scenarios/bracket.toml", &[hex, "refine={}", "adapt={}"], 4, "hexahedra"),
    ];
    for (scenario, set, code, said) in cases {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("results");
        let mut command = subsolid(&["run", scenario, "--output", out.to_str().unwrap()]);
        for key in set {
            command.args(["--set", key]);
        }
        let output = command.output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(code), "{scenario} {set:?}: {text}");
        assert!(text.replace("│ ", "").contains(said) && !out.exists(), "{scenario} {set:?}: {text}");
    }
}
