//! Estimates of the error in the energy and in a quantity, against solutions that are known.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::f64::consts::PI;

/// The L-prism with its singular solution.
const L_PRISM: &str = concat!(
    include_str!("scenarios/l-prism.toml"),
    r#"
[quantities.syy]
average = "syy"
within = { min = [0.5, 0.5, 0.25], max = [0.75, 0.75, 0.75] }
"#
);

/// The mean of the L-prism's stress YY over the box, by Gauss quadrature of its closed form.
const L_PRISM_SYY: f64 = 2.121_208_893_068_185;

const CUBE: &str = r#"
[mesh.box]
size = [1.0, 1.0, 1.0]
cells = [3, 3, 3]
[materials.m]
youngs_modulus = 1.0
poissons_ratio = 0.3
[exact]
solution = "smooth-cube"
[supports.x]
any = [{ group = "x-min" }, { group = "x-max" }]
fix = ["x"]
[supports.y]
any = [{ group = "y-min" }, { group = "y-max" }]
fix = ["y"]
[supports.z]
any = [{ group = "z-max" }, { group = "z-min" }]
fix = ["z"]
[quantities.ux]
average = "ux"
within = { min = [0.0, 0.0, 0.0], max = [0.5, 0.5, 0.5] }
[output]
vtk = false
[refine]
steps = 20
"#;

/// A bar that is held at one end so that it can contract, and moved at the other.
const STRETCHED: &str = r#"
[mesh.box]
size = [2.0, 1.0, 1.0]
cells = [3, 2, 2]
[materials.m]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.x]
group = "x-min"
fix = ["x"]
[supports.y]
group = "y-min"
fix = ["y"]
[supports.z]
group = "z-min"
fix = ["z"]
[supports.die]
group = "x-max"
displacement = { x = 0.004 }
[quantities.force]
reaction = "die"
component = "x"
[quantities.most]
maximum = "von-mises"
[quantities.corner]
value = "ux"
point = [2.0, 1.0, 1.0]
[quantities.stored]
total = "strain-energy"
[quantities.skin]
average = "sxx"
group = "z-max"
[quantities.mises]
average = "von-mises"
[output]
vtk = false
"#;

/// Runs a scenario; gives exit code, report, standard output and standard error.
fn run(text: &str, settings: &[&str]) -> (Option<i32>, Value, String, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(["run", "case.toml", "--output", "results"]).current_dir(folder.path());
    settings.iter().for_each(|s| {
        command.args(if s.starts_with("--") { s.split(' ').collect() } else { vec!["--set", *s] });
    });
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    let report = std::fs::read_to_string(folder.path().join("results/report.json"));
    let report = report.map_or(Value::Null, |json| serde_json::from_str(&json).unwrap());
    (output.status.code(), report, text(output.stdout), text(output.stderr))
}

fn steps(text: &str, settings: &[&str]) -> Vec<Value> {
    let (code, report, _, stderr) = run(text, settings);
    assert_eq!(code, Some(0), "{stderr}");
    report["steps"].as_array().unwrap().clone()
}

/// Effectivities of recovery and of the residual, on uniform and on adapted meshes of both elements.
#[test]
fn both_estimates_are_near_the_true_error() {
    for (text, name) in [(CUBE, "cube"), (L_PRISM, "L-prism")] {
        for (element, cells) in [("tet4", 3000), ("tet10", 1200)] {
            for (estimator, bounds) in [("spr", [0.75, 1.2]), ("residual", [1.5, 4.0])] {
                for scheme in ["sqrt3", "longest-edge"] {
                    let settings = [
                        format!("analysis.element={element}"),
                        format!("adapt.estimator={estimator}"),
                        format!("refine.scheme={scheme}"),
                        format!("refine.stop.max_cells={cells}"),
                    ];
                    let steps = steps(text, &settings.each_ref().map(String::as_str));
                    let last = steps.last().unwrap();
                    let effectivity = last["error"]["effectivity"].as_f64().unwrap();
                    let is_near = (bounds[0]..=bounds[1]).contains(&effectivity);
                    assert!(is_near, "{name}, {element}, {estimator}, {scheme}: {effectivity}");
                }
            }
        }
    }
}

/// The quadratic patch test: on all sides the displacement is prescribed, inside acts its body force. Ten-node cells have it
/// exactly, and neither estimate sees an error; four-node cells have not.
#[test]
fn there_is_no_error_where_the_elements_have_the_solution() {
    let patch = r#"
[mesh.box]
size = [1.0, 1.0, 1.0]
cells = [2, 2, 2]
[materials.m]
youngs_modulus = 1.0
poissons_ratio = 0.25
[supports.all]
any = [{ group = "x-min" }, { group = "x-max" }, { group = "y-min" }, { group = "y-max" }, { group = "z-min" }]
displacement = { x = "x^2 + 2*x*y - z^2", y = "y^2 - x*z + 3*y*z", z = "z^2 + x*y - 2*x^2" }
[loads.inside]
body_force = [-1.6, -4.0, -3.2]
[loads.top]
group = "z-max"
traction = ["0.4*(y - 4*x - 2*z)", "1.2*y", "0.4*(2*x + 4*y + 9*z)"]
"#;
    // On z = 1, with both Lame constants 0.4: 0.4 (ux_z + uz_x, uy_z + uz_y, div u + 2 uz_z).
    for estimator in ["spr", "residual"] {
        let of = |element: &str| {
            let settings = [format!("adapt.estimator={estimator}"), format!("analysis.element={element}")];
            let steps = steps(patch, &settings.each_ref().map(String::as_str));
            steps[0]["error"]["relative"].as_f64().unwrap()
        };
        assert!(of("tet10") < 1e-6, "{estimator}: {}", of("tet10"));
        assert!(of("tet4") > 0.05, "{estimator}: {}", of("tet4"));
    }
}

/// The error bar holds the true error of a mean stress beside a singularity and of a mean displacement, at every step, on adapted
/// and on uniform meshes; and it says something: it falls, to no more than some times the error before correction.
#[test]
fn error_bars_hold_the_true_error() {
    for (text, goal, exact) in [(L_PRISM, "syy", L_PRISM_SYY), (CUBE, "ux", 8.0 / PI.powi(3))] {
        for (element, cells) in [("tet4", 4000), ("tet10", 1500)] {
            for strategy in ["adaptive", "global"] {
                let settings = [
                    format!("analysis.element={element}"),
                    format!("adapt.goal={goal}"),
                    format!("refine.strategy={strategy}"),
                    format!("refine.stop.max_cells={cells}"),
                ];
                let steps = steps(text, &settings.each_ref().map(String::as_str));
                let mut bars = Vec::new();
                for step in &steps {
                    let found = &step["quantities"][goal];
                    let [value, bar, computed] = ["value", "error", "computed"].map(|key| found[key].as_f64().unwrap());
                    let what = format!("{goal}, {element}, {strategy}, step {}", step["step"]);
                    assert!((value - exact).abs() <= bar, "{what}: {value} +- {bar}, not {exact}");
                    bars.push((bar, (computed - exact).abs()));
                }
                let (first, last) = (bars[0], bars[bars.len() - 1]);
                let says = last.0 < 0.3 * first.0 && last.0 < 15.0 * last.1;
                assert!(says, "{goal}, {element}, {strategy}: {bars:?}");
            }
        }
    }
}

/// With the residual estimator the bar is larger, and holds what is computed.
#[test]
fn error_bars_of_the_residual_hold() {
    for element in ["tet4", "tet10"] {
        let element = format!("analysis.element={element}");
        let settings = [&element, "adapt.goal=syy", "adapt.estimator=residual", "refine.stop.max_cells=1500"];
        for step in steps(L_PRISM, &settings) {
            let found = &step["quantities"]["syy"];
            let [value, bar] = ["value", "error"].map(|key| found[key].as_f64().unwrap());
            assert!((value - L_PRISM_SYY).abs() <= bar, "{element}: {value} +- {bar}");
        }
    }
}

/// The reaction of a prescribed displacement: E A u / L, which the elements have exactly.
#[test]
fn a_reaction_without_error_has_no_bar() {
    for element in ["tet4", "tet10"] {
        let element = format!("analysis.element={element}");
        let steps = steps(STRETCHED, &[&element, "adapt.goal=force", "refine.steps=3"]);
        assert_eq!(steps.len(), 1, "refined for nothing");
        let [value, bar] = ["value", "error"].map(|key| steps[0]["quantities"]["force"][key].as_f64().unwrap());
        assert!((value - 2.0).abs() < 1e-6 && bar < 1e-6, "{value} +- {bar}");
    }
}

#[test]
fn a_reaction_that_supports_share_is_doubted() {
    let (_, _, stdout, _) = run(STRETCHED, &["adapt.goal=force"]);
    assert!(!stdout.contains("both prescribe"), "{stdout}");
    let beside = "supports.y={ group = \"y-min\", displacement = { x = \"0.002*x\", y = 0.0 } }";
    let (_, _, stdout, _) = run(STRETCHED, &["adapt.goal=force", beside]);
    assert!(stdout.contains("supports `die` and `y` both prescribe x where they meet"), "{stdout}");
}

#[test]
fn a_run_ends_when_the_quantity_is_exact_enough() {
    let settings =
        ["analysis.element=tet10", "adapt.goal=syy", "refine.stop.quantity_error=0.01", "refine.stop.max_cells=9000"];
    let (code, report, stdout, stderr) = run(L_PRISM, &settings);
    assert_eq!((code, &report["stop_reason"]), (Some(0), &Value::from("quantity")), "{stderr}");
    assert!(stdout.contains("exact enough") && stdout.contains("+-"), "{stdout}");
    let found = &report["steps"].as_array().unwrap().last().unwrap()["quantities"]["syy"];
    assert!(found["error"].as_f64().unwrap() <= 0.01 * found["value"].as_f64().unwrap(), "{found}");
}

#[test]
fn asked_tolerances_that_are_missed_end_with_7_and_complete_results() {
    let goal = ["adapt.goal=syy", "refine.stop.quantity_error={ absolute = 1e-3 }", "refine.steps=1"];
    let both =
        ["adapt.goal=syy", "refine.stop.quantity_error=0.9", "refine.stop.relative_error=0.01", "refine.steps=1"];
    let cells = ["refine.stop.relative_error=0.01", "refine.stop.max_cells=100"];
    for (settings, words) in [
        (&goal[..], &["syy is", "+-", "0.001 was asked for", "steps = 1 reached", "refine.steps"][..]),
        (&both, &["the estimated relative error is", "1.00 % was asked for", "steps = 1"]),
        (&cells, &["1.00 % was asked for", "max_cells = 100 reached", "allow more: refine.stop.max_cells"]),
    ] {
        let (code, report, _, stderr) = run(L_PRISM, settings);
        assert_eq!(code, Some(7), "{stderr}");
        assert!(words.iter().all(|w| stderr.contains(w)), "{stderr}");
        assert!(!report["steps"].as_array().unwrap().is_empty());
    }
}

#[test]
fn what_has_no_dual_problem_is_refused_by_name_and_reason() {
    for (setting, words) in [
        ("adapt.goal=most", &["\"most\"", "a maximum", "average over a small box"][..]),
        ("adapt.goal=corner", &["\"corner\"", "at a point", "small box"]),
        ("adapt.goal=stored", &["\"stored\"", "an energy", "relative_error"]),
        ("adapt.goal=skin", &["\"skin\"", "a stress on faces", "layer of cells"]),
        ("adapt.goal=mises", &["\"mises\"", "not linear", "component"]),
        ("adapt.goal=forse", &["not a quantity", "did you mean `force`?"]),
        ("refine.stop.quantity_error=0.01", &["adapt.goal"]),
    ] {
        let (code, _, _, stderr) = run(STRETCHED, &[setting]);
        assert_eq!(code, Some(3), "{setting}: {stderr}");
        assert!(words.iter().all(|w| stderr.contains(w)), "{setting}: {stderr}");
    }
    for (bound, word) in [("2.0", "above 0 and below 1"), ("{ absolute = 1.0, relative = 0.1 }", "one bound")] {
        let settings = ["adapt.goal=force", &format!("refine.stop.quantity_error={bound}")];
        let (code, _, _, stderr) = run(STRETCHED, &settings);
        assert!(code == Some(3) && stderr.contains(word), "{stderr}");
    }
}

#[test]
fn the_number_of_threads_changes_no_digit() {
    let of = |threads: &str| {
        let settings = ["adapt.goal=syy", "refine.stop.max_cells=2500", "adapt.estimator=residual", threads];
        let steps = steps(L_PRISM, &settings);
        steps.iter().map(|s| (s["cells"].clone(), s["quantities"].clone(), s["error"].clone())).collect::<Vec<_>>()
    };
    assert_eq!(of("--threads 1"), of("--threads 3"));
}
