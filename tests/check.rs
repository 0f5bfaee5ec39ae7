//! What `subsolid check` forecasts, beside what runs make; and that it fits a terminal.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The bundled scenarios whose meshes are here.
fn scenarios() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let here = |p: &PathBuf| std::env::var_os("SUBSOLID_DATA").is_some() || !p.ends_with("tripod.toml");
    let mut paths: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "toml")).filter(here).collect();
    paths.sort();
    paths
}

/// Standard output of a command on a scenario.
fn subsolid(command: &[&str], scenario: &Path, settings: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut subsolid = Command::cargo_bin("subsolid").unwrap();
    subsolid.args(command).arg(scenario).current_dir(folder.path());
    settings.iter().for_each(|s| {
        subsolid.args(["--set", s]);
    });
    let output = subsolid.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(command: &str, scenario: &Path, settings: &[&str]) -> Value {
    serde_json::from_str(&subsolid(&[command, "--json", "-"], scenario, settings)).unwrap()
}

/// The forecast and the report of a bundled scenario, with settings.
fn both(scenario: &str, settings: &[&str]) -> (Value, Value) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario);
    (json("check", &path, settings)["forecast"].clone(), json("run", &path, settings))
}

/// The largest factor between what was forecast of the steps and what was made.
fn worst(forecast: &Value, report: &Value, key: &str) -> f64 {
    let (steps, made) = (forecast["steps"].as_array().unwrap(), report["steps"].as_array().unwrap());
    assert!(steps.len() <= made.len(), "{steps:?}");
    let value = |s: &Value| s[key].as_f64().unwrap();
    steps.iter().zip(made).map(|(s, m)| (value(s) / value(m)).ln().abs()).fold(0.0, f64::max).exp()
}

#[test]
fn red_refinement_is_forecast_exactly() {
    let settings = ["refine.scheme=red", "refine.strategy=global", "refine.steps=2", "refine.optimise.mode=paper"];
    let (forecast, report) = both("cantilever.toml", &settings);
    assert_eq!(forecast["steps"].as_array().unwrap().len(), 3);
    for (f, made) in forecast["steps"].as_array().unwrap().iter().zip(report["steps"].as_array().unwrap()) {
        assert_eq!(f["exact"], true);
        for key in ["cells", "nodes", "dofs"] {
            assert_eq!(f[key], made[key], "{key} of step {}", f["step"]);
        }
    }
}

#[test]
fn other_runs_are_forecast_within_a_small_factor() {
    let sqrt3: &[&str] = &["refine.strategy=global", "refine.steps=2", "refine.stop.max_cells=1000000"];
    // With quadratic elements the first few steps see little but the clamped edges, and mark fewer cells than most.
    let linear = ["analysis.element=tet4", "refine.steps=4"];
    let bisection = ["analysis.element=tet4", "refine.scheme=longest-edge", "refine.steps=4"];
    let fraction = ["adapt.marking={ fraction = 0.1 }", "adapt.grow=1", "refine.steps=3"];
    for (scenario, settings, factor) in [
        ("cantilever.toml", sqrt3, 1.25),
        ("bracket.toml", &["refine.strategy=global", "refine.steps=1"], 1.25),
        ("cantilever.toml", &linear, 2.0),
        ("bracket.toml", &["refine.steps=4"], 2.0),
        // One corner and three edges: the least cells of all, by five steps.
        ("fichera.toml", &[], 2.5),
        ("cantilever.toml", &bisection, 2.0),
        ("bracket.toml", &fraction, 2.0),
    ] {
        let (forecast, report) = both(scenario, settings);
        for key in ["cells", "nodes", "dofs"] {
            let worst = worst(&forecast, &report, key);
            assert!(worst < factor, "{scenario} {settings:?}: {key} by {worst}\n{forecast:#}");
        }
        let bytes = forecast["steps"].as_array().unwrap().last().unwrap()["bytes"].as_f64().unwrap();
        let ratio = bytes / report["peak_memory_bytes"].as_f64().unwrap();
        assert!((0.3..3.0).contains(&ratio), "{scenario} {settings:?}: memory {ratio} of what was needed");
    }
}

#[test]
fn the_forecast_ends_by_the_rules_of_the_scenario() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/cantilever.toml");
    for (settings, steps, end) in [
        (&["refine.steps=3"][..], 4, "steps = 3"),
        (&["refine.steps=20", "refine.stop.max_cells=1152"], 1, "max_cells = 1152"),
        (&["refine.steps=20", "refine.stop.max_memory=\"1 MB\""], 1, "max_memory"),
        (&["refine.strategy=none"], 1, "none"),
        (&["refine.steps=20", "adapt.marking={ threshold = 1e-3 }"], 1, "threshold"),
    ] {
        let forecast = &json("check", &path, settings)["forecast"];
        assert_eq!(forecast["steps"].as_array().unwrap().len(), steps, "{settings:?}: {forecast:#}");
        assert!(forecast["end"].as_str().unwrap().contains(end), "{forecast:#}");
    }
    // Red refinement of a thousand cells, ten times: more than any machine has.
    let huge = ["refine.scheme=red", "refine.strategy=global", "refine.steps=10"];
    let text = subsolid(&["check"], &path, &huge);
    assert!(!cfg!(target_os = "linux") || text.contains("more than is free"), "{text}");
}

#[test]
fn quantities_and_probes_are_told_with_what_they_are_taken_over() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/fichera.toml");
    let told = json("check", &path, &["probes.edge.from=[2, 0, 0]"]);
    let of = |name: &str| told["quantities"].as_array().unwrap().iter().find(|q| q["name"] == name).unwrap();
    assert!((of("top")["area"].as_f64().unwrap() - 3.0).abs() < 1e-12 && of("top")["faces"] == 24);
    assert!((of("energy")["volume"].as_f64().unwrap() - 7.0).abs() < 1e-12);
    // 21 points from x = 2 to x = 0, of which those up to x = 1 are in the part.
    assert_eq!(told["probes"][0]["inside"], 11);
}

/// Numbers of every size stand whole in their lines.
#[test]
fn tables_break_no_number() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/cantilever.toml");
    let name = "loads.the-wind-on-the-mast-of-the-crane";
    let told = json("check", &path, &[]);
    let group = told["groups"][0]["name"].as_str().unwrap();
    for force in ["[-2853.29, 1.23456e-7, -8.76543e-9]", "[1.23456e12, -12345.6, 0.0123456]"] {
        let settings = [
            format!("{name}.group={group}"),
            format!("{name}.force={force}"),
            "supports.s.spring=1.23456e-7".into(),
            format!("supports.s.group={group}"),
        ];
        let text = subsolid(&["check"], &path, &settings.each_ref().map(String::as_str));
        for number in force.trim_matches(['[', ']']).split(", ") {
            assert!(text.split(|c: char| c.is_whitespace() || c == ',').any(|word| word == number), "{number}\n{text}");
            let total = format!("{:.4e}", number.parse::<f64>().unwrap()).parse::<f64>().unwrap();
            let is_total = |word: &str| word != number && word.parse() == Ok(total);
            assert!(text.split_whitespace().any(is_total), "{total}\n{text}");
        }
        assert!(
            text.lines().all(|line| line.trim_end().chars().count() <= 80 || line.starts_with("results")),
            "{text}"
        );
    }
}

#[test]
fn every_bundled_scenario_is_told_in_eighty_columns() {
    for path in scenarios() {
        for line in subsolid(&["check"], &path, &[]).lines() {
            // The folder of the results is the user's.
            assert!(line.trim_end().chars().count() <= 80 || line.starts_with("results"), "{}: {line}", path.display());
        }
    }
}
