//! What adaptive refinement reaches on the L-prism, whose solution is known: rates, accuracy for as many unknowns as plain
//! bisection has, and the shortest way to a tolerance.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;

const PRISM: &str = include_str!("scenarios/l-prism.toml");

/// A finished step.
#[derive(Debug, Clone, Copy)]
struct Step {
    dofs: f64,
    /// True relative error.
    error: f64,
}

/// The steps of a run with settings.
fn run(settings: &[&str]) -> Vec<Step> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("prism.toml"), PRISM).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(["run", "prism.toml", "--json", "-"]).current_dir(folder.path());
    settings.iter().for_each(|s| {
        command.args(["--set", s]);
    });
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let step =
        |s: &Value| Step { dofs: s["dofs"].as_f64().unwrap(), error: s["error"]["true_relative"].as_f64().unwrap() };
    report["steps"].as_array().unwrap().iter().map(step).collect()
}

/// The error at so many unknowns, on the straight line between the logarithms of the steps before and after.
fn error_at(steps: &[Step], dofs: f64) -> f64 {
    let after = steps.iter().position(|s| s.dofs >= dofs).unwrap();
    let (a, b) = (steps[after - 1], steps[after]);
    let part = (dofs / a.dofs).ln() / (b.dofs / a.dofs).ln();
    (a.error.ln() * (1.0 - part) + b.error.ln() * part).exp()
}

/// Slope of the straight line nearest to the logarithms of the steps from so many unknowns on.
fn slope(steps: &[Step], from: f64) -> f64 {
    let points: Vec<[f64; 2]> = steps.iter().filter(|s| s.dofs >= from).map(|s| [s.dofs.ln(), s.error.ln()]).collect();
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let [xy, xx] = points.iter().fold([0.0; 2], |[xy, xx], p| [xy + (p[0] - x) * (p[1] - y), xx + (p[0] - x).powi(2)]);
    xy / xx
}

/// Uniform refinement has the rates 0.18 here whatever the degree. The best of graded meshes of isotropic cells would be
/// 1/3 and 0.544: the singular edge bounds the second.
#[test]
fn the_error_falls_at_the_rate_of_the_element_and_below_that_of_plain_bisection() {
    let plain = ["refine.scheme=longest-edge", "refine.optimise.mode=paper"];
    for (element, cells, from, rate) in [("tet4", 10_000, 900.0, -0.32), ("tet10", 3000, 1900.0, -0.48)] {
        let common = [format!("analysis.element={element}"), format!("refine.stop.max_cells={cells}")];
        let common = common.each_ref().map(String::as_str);
        let bisected = run(&[&common[..], &plain].concat());
        for settings in [&[][..], &["refine.scheme=longest-edge"]] {
            let steps = run(&[&common[..], settings].concat());
            let fall = slope(&steps, from);
            assert!(fall < rate, "{element} {settings:?}: slope {fall} of {steps:?}");
            let dofs = 0.95 * steps.last().unwrap().dofs.min(bisected.last().unwrap().dofs);
            let (ours, theirs) = (error_at(&steps, dofs), error_at(&bisected, dofs));
            assert!(ours < 0.85 * theirs, "{element} {settings:?}: {ours} against {theirs} at {dofs}");
        }
    }
}

#[test]
fn directions_lower_the_error_where_the_solution_has_them() {
    let cells = "refine.stop.max_cells=4000";
    let [with, without] = [true, false].map(|d| run(&[cells, &format!("refine.optimise.directions={d}")]));
    let dofs = 0.95 * with.last().unwrap().dofs.min(without.last().unwrap().dofs);
    let [with, without] = [with, without].map(|steps| error_at(&steps, dofs));
    assert!(with < 0.85 * without, "{with}, without directions {without}");
}

/// To look ahead is to reach the tolerance with less work, the sum of the unknowns of all meshes. A single tolerance may lie
/// just where a fixed marking gets by chance, so there are several.
#[test]
fn looking_ahead_reaches_tolerances_with_less_work() {
    for (element, tolerances) in [("tet4", [0.14, 0.12, 0.1]), ("tet10", [0.06, 0.05, 0.04])] {
        let [mut ahead, mut fixed] = [0.0; 2];
        for tolerance in tolerances {
            let common = [format!("analysis.element={element}"), format!("refine.stop.relative_error={tolerance}")];
            let common = common.each_ref().map(String::as_str);
            let work = |steps: &[Step]| steps.iter().map(|s| s.dofs).sum::<f64>();
            let steps = run(&common);
            assert!(steps.last().unwrap().error < 1.15 * tolerance, "{element} {tolerance}: {steps:?}");
            ahead += work(&steps);
            fixed += work(&run(&[&common[..], &["adapt.marking={ doerfler = 0.5 }"]].concat()));
        }
        assert!(ahead < fixed, "{element}: {ahead} against {fixed}");
    }
}
