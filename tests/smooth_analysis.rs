//! Analysis on smooth solids: patch test, nested spaces, reactions, and what a cantilever needs of unknowns.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;

/// Runs a scenario with settings; gives its code, what it says, and its report.
fn run(text: &str, settings: &[&str]) -> (i32, String, Value) {
    command_of("run", text, settings)
}

/// The same of any command.
fn command_of(word: &str, text: &str, settings: &[&str]) -> (i32, String, Value) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, text).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.current_dir(folder.path()).args([word, "s.toml", "--json", "-", "--set", "output.vtk=false"]);
    settings.iter().for_each(|s| {
        command.args(["--set", s]);
    });
    let output = command.output().unwrap();
    let said =
        String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ").replace("│ ", "");
    (output.status.code().unwrap(), said, serde_json::from_slice(&output.stdout).unwrap_or_default())
}

fn last(report: &Value) -> &Value {
    report["steps"].as_array().unwrap().last().unwrap()
}

/// A cube whose surface is displaced linearly.
const PATCH: &str = "[mesh.box]\nsize = [1, 1, 1]\ncells = [2, 2, 2]\n[materials.m]\nyoungs_modulus = 100\npoissons_ratio = 0.3\n\
                     [supports.all]\nnormal = { direction = [0, 0, 1], angle = 180 }\n\
                     displacement = { x = \"0.01*x + 0.02*y\", y = \"0.01*z\", z = \"0.03*x - 0.01*z\" }\n\
                     [analysis]\nelement = \"tet4\"\n";

#[test]
fn linear_displacements_are_exact() {
    // Half of 2 mu e:e + lambda (tr e)^2 with e = sym(grad u).
    let (lambda, mu) = (100.0 * 0.3 / (1.3 * 0.4), 100.0 / 2.6);
    let (xx, zz, xy, yz, xz): (f64, f64, f64, f64, f64) = (0.01, -0.01, 0.01, 0.005, 0.015);
    let square = xx * xx + zz * zz + 2.0 * (xy * xy + yz * yz + xz * xz);
    let energy = 0.5 * (2.0 * mu * square + lambda * (xx + zz).powi(2));
    for basis in ["control", "nodes"] {
        for octahedra in ["diagonal", "centroid"] {
            let smooth = format!("analysis.smooth={{ steps = 2, basis = \"{basis}\", octahedra = \"{octahedra}\" }}");
            let (code, said, report) = run(PATCH, &[&smooth, "solver.tolerance=1e-12"]);
            assert_eq!(code, 0, "{said}");
            let found = last(&report)["strain_energy"].as_f64().unwrap();
            assert!((found / energy - 1.0).abs() < 1e-9, "{smooth}: {found} {energy}");
        }
    }
}

const CANTILEVER: &str = "[mesh.box]\nsize = [4, 1, 1]\ncells = [8, 2, 2]\n[materials.m]\nyoungs_modulus = 1000\n\
                          poissons_ratio = 0.3\n[supports.clamp]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
                          [loads.tip]\ngroup = \"x-max\"\nforce = [0, 0, -1]\n[analysis]\nelement = \"tet4\"\n\
                          [solver]\ntolerance = 1e-10\n";

/// Energy and unknowns; the reaction holds the load.
fn cantilever(settings: &[&str]) -> (f64, f64) {
    let (code, said, report) = run(CANTILEVER, settings);
    assert_eq!(code, 0, "{said}");
    let step = last(&report);
    let reaction: Vec<f64> =
        step["reactions"]["clamp"].as_array().unwrap().iter().map(|r| r.as_f64().unwrap()).collect();
    assert!((reaction[2] - 1.0).abs() < 1e-7 && reaction[0].abs() + reaction[1].abs() < 1e-7, "{reaction:?}");
    (step["strain_energy"].as_f64().unwrap(), step["free_dofs"].as_f64().unwrap())
}

#[test]
fn spaces_are_nested_and_smooth_functions_are_worth_their_unknowns() {
    let plain = cantilever(&[]);
    assert_eq!(plain, cantilever(&["analysis.smooth={ steps = 0, basis = \"nodes\" }"]));
    let none = cantilever(&["analysis.smooth={ steps = 0 }"]);
    assert!((none.0 / plain.0 - 1.0).abs() < 1e-8 && none.1 == plain.1);
    // Twice as many unknowns or more.
    let more = cantilever(&["mesh.box.cells=[12, 3, 2]"]);
    assert!(more.1 >= 2.0 * plain.1);
    let mut before = plain.0;
    for steps in 1..=3 {
        let [control, nodes] = ["control", "nodes"]
            .map(|basis| cantilever(&[&format!("analysis.smooth={{ steps = {steps}, basis = \"{basis}\" }}")]));
        // The energy under a force is a lower bound, and the larger the larger the space is.
        assert!(control.0 < nodes.0, "{steps} steps: {control:?} {nodes:?}");
        assert!(control.1 == plain.1 && nodes.1 > 5.0 * plain.1);
        assert!(control.0 > before && control.0 > more.0, "{steps} steps: {control:?} {before} {more:?}");
        before = control.0;
    }
}

#[test]
fn the_control_mesh_is_refined_red_or_not_at_all() {
    let smooth = "analysis.smooth={ steps = 1 }";
    let (code, said, report) = run(CANTILEVER, &[smooth, "refine={ scheme = \"red\", steps = 1 }"]);
    assert_eq!((code, report["steps"].as_array().unwrap().len()), (0, 2), "{said}");
    for (setting, words) in [
        ("refine={ steps = 1 }", "scheme = \"red\""),
        ("analysis.element=\"tet10\"", "four-node cells"),
        ("analysis.smooth={ steps = 9 }", "from 0 to 5"),
    ] {
        let (code, said, _) = run(CANTILEVER, &[smooth, setting]);
        assert!(code == 3 && said.contains(words), "{setting}: {code}, {said}");
    }
}

/// A known solution on the unit cube, whose sides slide.
const CUBE: &str = "[mesh.box]\nsize = [1, 1, 1]\ncells = [4, 4, 4]\n[materials.m]\nyoungs_modulus = 1\npoissons_ratio = 0.3\n\
                    [exact]\nsolution = \"smooth-cube\"\n[analysis]\nelement = \"tet4\"\n\
                    [supports.x]\nany = [{ group = \"x-min\" }, { group = \"x-max\" }]\nfix = [\"x\"]\n\
                    [supports.y]\nany = [{ group = \"y-min\" }, { group = \"y-max\" }]\nfix = [\"y\"]\n\
                    [supports.z]\nany = [{ group = \"z-min\" }, { group = \"z-max\" }]\nfix = [\"z\"]\n";

/// Smooth functions have stresses that hardly jump; their error is seen all the same.
#[test]
fn the_estimate_of_smooth_functions_is_that_of_their_error() {
    for (steps, cells) in [(1, 4), (1, 8), (2, 4), (2, 8), (3, 4)] {
        let settings =
            [format!("analysis.smooth={{ steps = {steps} }}"), format!("mesh.box.cells=[{cells}, {cells}, {cells}]")];
        let (code, said, report) = run(CUBE, &[&settings[0], &settings[1]]);
        assert_eq!(code, 0, "{said}");
        let effectivity = last(&report)["error"]["effectivity"].as_f64().unwrap();
        assert!((0.85..1.15).contains(&effectivity), "{settings:?}: {effectivity}");
    }
    // So a run can stop by it.
    let tolerance = "refine={ scheme = \"red\", stop = { relative_error = 0.3 }, steps = 3 }";
    let (code, said, report) = run(CUBE, &["analysis.smooth={ steps = 1 }", tolerance]);
    let error = last(&report)["error"]["true_relative"].as_f64().unwrap();
    assert!(code == 0 && error < 0.3 && report["steps"].as_array().unwrap().len() == 2, "{error}: {said}");
}

#[test]
fn forecasts_count_the_mesh_that_is_analysed() {
    for smooth in ["{ steps = 2 }", "{ steps = 1, octahedra = \"centroid\" }", "{ steps = 1, basis = \"nodes\" }"] {
        let settings = [format!("analysis.smooth={smooth}"), "refine={ scheme = \"red\", steps = 1 }".to_owned()];
        let [check, report] =
            ["check", "run"].map(|command| command_of(command, CUBE, &[&settings[0], &settings[1]]).2);
        let (forecast, made) = (&check["forecast"]["steps"], &report["steps"]);
        for step in 0..2 {
            assert_eq!(forecast[step]["cells"], made[step]["cells"], "{smooth}");
            assert_eq!(forecast[step]["nodes"], made[step]["nodes"], "{smooth}");
            assert_eq!(forecast[step]["dofs"], made[step]["dofs"], "{smooth}");
        }
    }
}

#[test]
fn what_has_no_effect_or_another_body_is_said() {
    let smooth = "analysis.smooth={ steps = 1 }";
    let red = "refine={ scheme = \"red\", steps = 0, optimise = { mode = \"paper\" } }";
    let warnings = |text: &str, settings: &[&str]| run(text, settings).2["warnings"].to_string();
    let said = warnings(CUBE, &[smooth, red, "adapt.grow=1"]);
    assert!(said.contains("refine.optimise has no effect") && said.contains("[adapt] chooses cells"), "{said}");
    let rod = "[mesh.cylinder]\nradius = 1\nlength = 2\ncells = [2, 2]\n[materials.m]\nyoungs_modulus = 1\npoissons_ratio = 0.3\n\
               [exact]\nsolution = \"quadratic-patch\"\n[supports.all]\nnormal = { direction = [0, 0, 1], angle = 180 }\n\
               fix = \"exact\"\n[analysis]\nelement = \"tet4\"\n";
    let said = warnings(rod, &[smooth]);
    assert!(said.contains("another body"), "{said}");
}
