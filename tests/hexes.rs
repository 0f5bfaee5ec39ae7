//! Scenarios on hexahedra, as a user runs them.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use subsolid::mesh::hex::HexMesh;
use subsolid::mesh::hex::curved::{Round, arcs};
use subsolid::mesh::hex::generate::tube;
use subsolid::mesh::midside::Midside;

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
    for (element, within) in [("catmull-clark", 0.003), ("catmull-clark+", 3e-4), ("hex27", 2e-4), ("hex20", 2e-4)] {
        let report = report("scenarios/tube.toml", &[&format!("analysis.element=\"{element}\"")]);
        let step = last(&report);
        let widening = step["quantities"]["widening"]["value"].as_f64().unwrap();
        assert!((widening * 75.0 / 143.0 - 1.0).abs() < within, "{element}: {widening}");
        let energy = step["strain_energy"].as_f64().unwrap();
        assert!((energy / 0.748746249106 - 1.0).abs() < 2.0 * within, "{element}: {energy}");
    }
}

/// A tube in a rigid bore, in which it may slide: u = B (r / b^2 - 1 / r) up to sign, with the pressure 1 inside.
#[test]
fn a_tube_slides_in_its_bore() {
    let bore = "supports.bore={ group = \"outer\", fix = \"normal\" }";
    for (element, within) in
        [("hex8", 0.02), ("hex20", 1e-4), ("hex27", 1e-4), ("catmull-clark", 2e-3), ("catmull-clark+", 4e-4)]
    {
        let element_key = format!("analysis.element=\"{element}\"");
        let step = last_of("scenarios/tube.toml", &[&element_key, bore]);
        // E = 1, nu = 0.3, a = 1, b = 2: 0.6 inside.
        let widening = step["quantities"]["widening"]["value"].as_f64().unwrap();
        assert!((widening / 0.6 - 1.0).abs() < within, "{element}: {widening}");
        let force = |support: &str, c: usize| step["reactions"][support][c].as_f64().unwrap();
        let sum = force("bore", 0) + force("x", 0) + force("y", 0) + force("z", 0);
        assert!((sum + 0.5).abs() < 1e-6, "{element}: {sum}");
    }
}

fn last_of(scenario: &str, set: &[&str]) -> Value {
    last(&report(scenario, set)).clone()
}

/// Curved cells stay as they are when they are split, and meshes of files are as curved as those that are generated.
#[test]
fn curved_cells() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = tube([1.0, 2.0], 0.5, [2, 4, 1], true).unwrap();
    let file = folder.path().join("tube.inp");
    std::fs::write(&file, second_order(&mesh, &arcs(&mesh, Round::Axis(None)))).unwrap();
    let file = format!("mesh={{ file = {file:?} }}");
    for element in ["hex20", "hex27"] {
        let element = format!("analysis.element=\"{element}\"");
        let set = [&*element, "mesh.tube.cells=[2, 4, 1]", "refine.steps=2"];
        let generated = report("scenarios/tube.toml", &set);
        let volumes: Vec<f64> =
            generated["steps"].as_array().unwrap().iter().map(|s| s["volume"].as_f64().unwrap()).collect();
        if element.contains("27") {
            assert!(volumes.iter().all(|v| (v / volumes[0] - 1.0).abs() < 1e-13), "{volumes:?}");
        }
        let set = [&*element, &*file];
        let read = last_of("scenarios/tube.toml", &set);
        let first = &generated["steps"][0];
        for key in ["strain_energy", "volume"] {
            let [a, b] = [&read, first].map(|step| step[key].as_f64().unwrap());
            assert!((a / b - 1.0).abs() < 1e-10, "{element}, {key}: {a} {b}");
        }
    }
}

/// A mesh of 20-node cells as an Abaqus file, with the groups as node sets.
fn second_order(mesh: &HexMesh, midsides: &[Midside]) -> String {
    use std::fmt::Write;
    // Abaqus' edges: below, above, upright.
    const EDGES: [[usize; 2]; 12] =
        [[0, 1], [1, 3], [2, 3], [0, 2], [4, 5], [5, 7], [6, 7], [4, 6], [0, 4], [1, 5], [3, 7], [2, 6]];
    let (points, topology) = (mesh.points(), mesh.topology());
    let mut text = "*NODE\n".to_owned();
    let mut node = |id: usize, x: glam::DVec3| writeln!(text, "{id}, {:?}, {:?}, {:?}", x.x, x.y, x.z).unwrap();
    points.iter().enumerate().for_each(|(v, x)| node(v + 1, *x));
    for (e, ends) in topology.edges().iter().enumerate() {
        let straight = points[ends[0] as usize].midpoint(points[ends[1] as usize]);
        let curved = midsides.iter().find(|m| m.edge == *ends).map(|m| m.position);
        node(points.len() + e + 1, curved.unwrap_or(straight));
    }
    text += "*ELEMENT, TYPE=C3D20, ELSET=solid\n";
    for (t, cell) in mesh.cells().iter().enumerate() {
        let corners = [0, 1, 3, 2, 4, 5, 7, 6].map(|c| cell[c] as usize + 1);
        let edge = |[a, b]: [usize; 2]| {
            let mut ends = [cell[a], cell[b]];
            ends.sort_unstable();
            points.len() + topology.edge(ends).unwrap() as usize + 1
        };
        let ids: Vec<String> = corners.into_iter().chain(EDGES.map(edge)).map(|id| id.to_string()).collect();
        writeln!(text, "{}, {},\n{}", t + 1, ids[..10].join(", "), ids[10..].join(", ")).unwrap();
    }
    for (g, name) in mesh.groups().iter().enumerate() {
        let faces = mesh.group_faces(subsolid::mesh::GroupId(g as u32));
        let mut ids: Vec<u32> = faces.flat_map(|f| mesh.faces()[f].vertices).map(|v| v + 1).collect();
        ids.sort_unstable();
        ids.dedup();
        let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
        writeln!(text, "*NSET, NSET={name}\n{}", ids.join(",\n")).unwrap();
    }
    text
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
