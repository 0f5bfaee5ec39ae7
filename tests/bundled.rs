//! One number of each bundled scenario, against a source that is not this program. `scenarios/fichera.toml` and
//! `scenarios/le10.toml` expect their own; tests/quantities.rs runs the first.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// The report of a bundled scenario with settings.
fn report(scenario: &str, settings: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario);
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.arg("run").arg(path).args(["--json", "-", "--set", "output.vtk=false"]).current_dir(folder.path());
    settings.iter().for_each(|s| {
        command.args(["--set", s]);
    });
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn last(report: &Value) -> &Value {
    report["steps"].as_array().unwrap().last().unwrap()
}

/// Relative deviation of a number of the last step.
fn deviation(report: &Value, key: &str, expected: f64) -> f64 {
    last(report)[key].as_f64().unwrap() / expected - 1.0
}

#[test]
fn the_bracket_is_that_of_calculix() {
    // CalculiX 2.20 on the same mesh of C3D4 elements, with the same forces at nodes (benches/peers/calculix.py).
    let coarse = report("bracket.toml", &["analysis.element=tet4", "refine.strategy=none", "solver.tolerance=1e-10"]);
    assert!(deviation(&coarse, "strain_energy", 62.909_414).abs() < 1e-6);
    assert!(deviation(&coarse, "max_displacement", 0.064_116_447).abs() < 1e-6);
    // And on the same polyhedron with 24,600 C3D10 elements (the same script with --reference).
    let red = ["refine.scheme=red", "refine.strategy=global", "refine.steps=1", "refine.optimise.mode=paper"];
    assert!(deviation(&report("bracket.toml", &red), "strain_energy", 90.402).abs() < 1e-5);
    // That is a lower bound, two percent at most below the limit; the adaptive run comes closer.
    let short = deviation(&report("bracket.toml", &[]), "strain_energy", 90.402);
    assert!((0.0..0.02).contains(&short), "{short}");
}

#[test]
fn the_thick_plate_has_the_stress_of_nafems() {
    // It would not succeed without the stress that it expects.
    let report = report("le10.toml", &[]);
    let stress = &report["expectations"]["stress"];
    assert_eq!((stress["expected"].as_f64(), stress["passed"].as_bool()), (Some(-5.38), Some(true)));
}

#[test]
fn the_cantilever_bends_as_a_beam() {
    // Timoshenko's beam: F L^3 / (3 E I) + F L / (k G A) with I = 20 * 10^3 / 12, G = E / 2.6, k = 5/6. The clamped end of
    // the solid cannot shrink sideways, which makes it stiffer by about one percent.
    let (force, length, young) = (500.0, 120.0_f64, 210_000.0);
    let bending = force * length.powi(3) / (3.0 * young * 20.0 * 1000.0 / 12.0);
    let shear = force * length / (5.0 / 6.0 * young / 2.6 * 200.0);
    let tip = "quantities.tip={ average = \"uz\", group = \"x-max\" }";
    let report = report("cantilever.toml", &["refine.steps=2", tip]);
    let ratio = -last(&report)["quantities"]["tip"]["value"].as_f64().unwrap() / (bending + shear);
    assert!((0.98..1.0).contains(&ratio), "{ratio} of the beam's deflection");
}

#[test]
fn the_tripod_has_the_energy_of_other_programs() {
    if std::env::var_os("SUBSOLID_DATA").is_none() {
        return println!("skipped: SUBSOLID_DATA is not set");
    }
    // Several finite-element programs agree on these figures of the unrefined mesh.
    let report = report("tripod.toml", &["refine.strategy=none", "solver.tolerance=1e-11"]);
    assert!(deviation(&report, "strain_energy", 6.382_330_187_8).abs() < 1e-9);
    assert!(deviation(&report, "max_displacement", 0.126_521_862).abs() < 1e-8);
}
