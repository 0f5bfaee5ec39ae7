//! Errors that the stress of the elements does not show: cells that lock, edges that become straight, loads between the points.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::f64::consts::PI;

/// A plate of side 10 that is clamped at one side and bent by a pressure.
const PLATE: &str = r#"
[mesh.box]
size = [10.0, 10.0, 1.0]
cells = [6, 6, 1]
[materials.m]
youngs_modulus = 1e6
poissons_ratio = 0.3
[supports.s]
group = "x-min"
fix = ["x", "y", "z"]
[loads.p]
group = "z-max"
pressure = 1.0
[quantities.q]
average = "uz"
group = "x-max"
[analysis]
element = "tet4"
[adapt]
goal = "q"
[refine]
strategy = "none"
[output]
vtk = false
"#;

/// A cube that is held below and sheared at a side.
const CUBE: &str = r#"
[mesh.box]
size = [1.0, 1.0, 1.0]
cells = [4, 4, 4]
[materials.m]
youngs_modulus = 1e6
poissons_ratio = 0.3
[supports.s]
group = "z-min"
fix = ["x", "y", "z"]
[loads.p]
group = "x-max"
traction = [0.0, 0.0, 1.0]
[quantities.q]
average = "uz"
group = "x-max"
[analysis]
element = "tet4"
[adapt]
goal = "q"
[refine]
strategy = "none"
[output]
vtk = false
"#;

/// A quarter of Lame's cylinder with curved edges.
const TUBE: &str = r#"
[mesh]
midside = "curved"
[mesh.tube]
radii = [1.0, 2.0]
length = 0.5
cells = [3, 8, 1]
quarter = true
[materials.m]
youngs_modulus = 1.0
poissons_ratio = 0.3
[loads.inside]
group = "inner"
pressure = 1.0
[supports.x]
group = "x-min"
fix = "normal"
[supports.y]
group = "y-min"
fix = "normal"
[supports.z]
any = [{ group = "z-min" }, { group = "z-max" }]
fix = ["z"]
[quantities.inner]
average = "ux"
group = "inner"
[quantities.box]
average = "uy"
within = { min = [0.0, 1.2, 0.1], max = [0.6, 1.6, 0.4] }
[refine]
steps = 3
[output]
vtk = false
"#;

/// Runs a scenario; gives exit code, report and what was printed.
fn run(text: &str, settings: &[&str]) -> (Option<i32>, Value, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(["run", "case.toml", "--output", "results"]).current_dir(folder.path());
    settings.iter().for_each(|s| {
        command.args(["--set", s]);
    });
    let output = command.output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let report = std::fs::read_to_string(folder.path().join("results/report.json"));
    let report = report.map_or(Value::Null, |json| serde_json::from_str(&json).unwrap());
    let words = text.split(|c: char| c.is_whitespace() || c == '│').filter(|w| !w.is_empty());
    (output.status.code(), report, words.collect::<Vec<_>>().join(" "))
}

/// A number of the last step.
fn last(report: &Value, path: &str) -> f64 {
    report["steps"].as_array().unwrap().last().unwrap().pointer(path).unwrap().as_f64().unwrap()
}

/// Whether the words of a run say that its cells lock.
fn accused(words: &str) -> bool {
    words.contains("do not show the solution") || words.contains("near 1/2")
}

/// The true error of four-node cells in bending is that of their energy, `sqrt(2 (U - U_h))` by the principle of minimum
/// potential energy; U is that of ten-node cells, which are within some percent.
#[test]
fn four_node_cells_that_lock_in_bending_know_their_error() {
    for thickness in ["1.0", "0.3333", "0.1"] {
        let size = format!("mesh.box.size=[10.0, 10.0, {thickness}]");
        let fine = ["analysis.element=tet10", "mesh.box.cells=[12, 12, 1]", &size];
        let (_, best, words) = run(PLATE, &fine);
        assert!(!accused(&words), "ten-node cells are accused: {words}");
        let (energy, sinks) = (last(&best, "/strain_energy"), last(&best, "/quantities/q/value"));
        for cells in ["[6, 6, 1]", "[12, 12, 2]", "[6, 6, 4]"] {
            for estimator in ["spr", "residual"] {
                let (cells, estimator) = (format!("mesh.box.cells={cells}"), format!("adapt.estimator={estimator}"));
                let settings = [&size[..], &cells, &estimator];
                let (_, report, words) = run(PLATE, &settings);
                let missed = (1.0 - last(&report, "/strain_energy") / energy).sqrt();
                let found = last(&report, "/error/relative");
                let what = format!("thickness {thickness}, {cells}, {estimator}");
                assert!(accused(&words) && found > 0.98 * missed, "{what}: {found}, true {missed}: {words}");
                assert!(estimator != "spr" || found < 1.05 * missed, "{what}: {found}, true {missed}");
                let [value, bar] = ["value", "error"].map(|key| last(&report, &format!("/quantities/q/{key}")));
                assert!((value - sinks).abs() <= bar, "{what}: {value} +- {bar}, not {sinks}");
            }
        }
    }
}

/// A sheet whose energy is that of a pull in its plane, while the quantity aimed at is how a small pressure bends it.
#[test]
fn a_goal_that_locks_where_the_solution_does_not_is_found() {
    let pulled = [
        "mesh.box={ size = [10.0, 10.0, 0.1], cells = [12, 12, 1] }",
        "loads.pull={ group = \"x-max\", traction = [1e5, 0.0, 0.0] }",
    ];
    let (_, best, words) = run(PLATE, &[&pulled[..], &["analysis.element=tet10"]].concat());
    assert!(!accused(&words), "{words}");
    let (_, report, words) = run(PLATE, &pulled);
    assert!(last(&report, "/error/relative") < 0.2, "{words}");
    assert!(words.contains("what the quantity aimed at depends on"), "{words}");
    let exact = last(&best, "/quantities/q/value");
    let [value, bar] = ["value", "error"].map(|key| last(&report, &format!("/quantities/q/{key}")));
    assert!((value - exact).abs() <= bar, "{value} +- {bar}, not {exact}");
}

#[test]
fn a_tolerance_is_not_met_by_cells_that_lock() {
    let settings = ["mesh.box.size=[10.0, 10.0, 0.1]", "refine.stop.relative_error=0.75"];
    let (code, report, words) = run(PLATE, &settings);
    assert_eq!(code, Some(7), "{words}");
    assert!(last(&report, "/error/relative") > 0.99, "{words}");
}

/// Four cells through the thickness of a beam, a thin sheet in its plane, a cube.
#[test]
fn four_node_cells_that_are_fine_are_not_accused() {
    let bars = ["mesh.box.size=[10.0, 1.0, 1.0]", "mesh.box.cells=[40, 4, 4]"];
    let stretched = ["mesh.box.size=[10.0, 10.0, 0.1]", "loads.p={ group = \"x-max\", traction = [1.0, 0.0, 0.0] }"];
    for (text, settings) in [(PLATE, &bars[..]), (PLATE, &stretched), (CUBE, &[])] {
        let (_, _, words) = run(text, settings);
        assert!(!accused(&words), "{settings:?}: {words}");
    }
}

#[test]
fn four_node_cells_that_lock_near_one_half_know_their_error() {
    for nu in ["0.45", "0.49", "0.499", "0.4999"] {
        let nu = format!("materials.m.poissons_ratio={nu}");
        let (_, best, words) = run(CUBE, &["analysis.element=tet10", "mesh.box.cells=[6, 6, 6]", &nu]);
        assert!(!accused(&words), "ten-node cells are accused: {words}");
        let (energy, moves) = (last(&best, "/strain_energy"), last(&best, "/quantities/q/value"));
        for cells in ["[4, 4, 4]", "[8, 8, 8]"] {
            let (_, report, _) = run(CUBE, &[&nu, &format!("mesh.box.cells={cells}")]);
            let stored = last(&report, "/strain_energy");
            let effectivity = last(&report, "/error/energy") / (2.0 * (energy - stored)).sqrt();
            assert!((0.75..4.0).contains(&effectivity), "{nu}, {cells}: {effectivity}");
            let [value, bar] = ["value", "error"].map(|key| last(&report, &format!("/quantities/q/{key}")));
            assert!((value - moves).abs() <= bar, "{nu}, {cells}: {value} +- {bar}, not {moves}");
        }
    }
}

/// Lame's displacement on the tube that was read, curved and, after refinement, straight.
#[test]
fn straight_edges_are_part_of_the_error() {
    let radial = |r: f64| 1.3 / 3.0 * (0.4 * r + 4.0 / r);
    // The mean over the box by the midpoint rule.
    let n = 400;
    let at = |i: usize, from: f64, to: f64| from + (to - from) * (i as f64 + 0.5) / f64::from(n);
    let mut mean = 0.0;
    for (i, j) in (0..n as usize).flat_map(|i| (0..n as usize).map(move |j| (i, j))) {
        let (x, y) = (at(i, 0.0, 0.6), at(j, 1.2, 1.6));
        mean += radial(x.hypot(y)) * y / x.hypot(y) / f64::from(n).powi(2);
    }
    for (goal, exact) in [("inner", 2.0 / PI * radial(1.0)), ("box", mean)] {
        for cells in ["[3, 4, 1]", "[3, 8, 1]", "[6, 12, 2]"] {
            let (cells, aim) = (format!("mesh.tube.cells={cells}"), format!("adapt.goal={goal}"));
            let settings = [&cells[..], &aim];
            let (_, report, words) = run(TUBE, &settings);
            let steps = report["steps"].as_array().unwrap();
            assert!(steps.len() == 4 && !words.contains("step 1: the estimated relative error grew"), "{words}");
            for step in steps {
                let found = &step["quantities"][goal];
                let [value, bar] = ["value", "error"].map(|key| found[key].as_f64().unwrap());
                let what = format!("{goal}, {cells}, step {}", step["step"]);
                assert!((value - exact).abs() <= bar, "{what}: {value} +- {bar}, not {exact}");
                assert_eq!(step["error"]["straight_edges"].as_f64().unwrap() > 0.0, step["step"] != 0, "{what}");
            }
            // The energy of a straight body is too small by more than its elements miss.
            let energy = PI / 8.0 * radial(1.0);
            let missed = (1.0 - last(&report, "/strain_energy") / energy).sqrt();
            let found = last(&report, "/error/relative");
            assert!(found > missed && found < 2.5 * missed, "{goal}, {cells}: {found}, true {missed}");
        }
    }
}

#[test]
fn refinement_that_straight_edges_make_vain_is_not_begun() {
    let (code, report, words) = run(TUBE, &["adapt.goal=inner", "refine.stop.quantity_error=0.0001"]);
    assert_eq!((code, &report["stop_reason"]), (Some(7), &Value::from("straight_edges")), "{words}");
    assert_eq!(report["steps"].as_array().unwrap().len(), 1);
}

/// A load that acts between all points by which nodal forces are made is looked for, and refined for, until these make its
/// resultant.
#[test]
fn a_load_between_the_points_is_found() {
    let load = "loads.p={ group = \"x-max\", pressure = \"exp(-((y-0.31)^2+(z-0.27)^2)/0.0002)\" }";
    for (text, element) in [(CUBE, "tet4"), (CUBE, "tet10")] {
        let element = format!("analysis.element={element}");
        let settings = [load, &element, "mesh.box.cells=[2, 2, 2]", "adapt={}", "refine={ steps = 7 }"];
        let (_, report, words) = run(text, &settings);
        let steps = report["steps"].as_array().unwrap();
        let pushed = |step: &Value| step["reactions"]["s"][0].as_f64().unwrap();
        let whole = 0.0002 * PI;
        assert!(pushed(&steps[0]).abs() < 0.01 * whole, "the points of the first mesh see it");
        assert!(steps[0]["error"]["relative"].as_f64().unwrap() > 0.99, "{words}");
        let found = pushed(&steps[steps.len() - 1]);
        assert!((found - whole).abs() < 0.1 * whole, "{found}, not {whole}");
    }
}

/// Where no point at all sees it, this is said.
#[test]
fn a_load_that_no_point_sees_is_told() {
    let load = "loads.p={ group = \"x-max\", pressure = \"max(0, 1 - ((y-0.31)^2+(z-0.2711)^2)/1e-14)\" }";
    let (_, _, words) = run(CUBE, &[load, "adapt={}"]);
    assert!(words.contains("nothing is strained, though there are loads"), "{words}");
}

/// A quantity that vanishes by symmetry: refinement for a fraction of it ends, and says why.
#[test]
fn a_quantity_that_is_zero_ends_the_run() {
    let bar = [
        "mesh.box.size=[4.0, 1.0, 1.0]",
        "mesh.box.cells=[8, 2, 2]",
        "analysis.element=tet10",
        "quantities.q={ average = \"uy\", group = \"x-max\" }",
        "refine={ steps = 20, stop = { quantity_error = 0.01, max_cells = 50_000 } }",
    ];
    let (code, report, words) = run(PLATE, &bar);
    assert_eq!((code, &report["stop_reason"]), (Some(7), &Value::from("zero")), "{words}");
    let [value, bar] = ["value", "error"].map(|key| last(&report, &format!("/quantities/q/{key}")));
    assert!(value.abs() <= bar && bar < 1e-3 * last(&report, "/max_displacement"), "{value} +- {bar}");
    assert!(words.contains("zero within its error bar") && words.contains("absolute = ..."), "{words}");
}
