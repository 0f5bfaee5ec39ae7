//! Supports of whole scenarios: what they leave free, where they contradict each other, edges.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use subsolid::fem::Space;
use subsolid::mesh::TetMesh;
use subsolid::pipeline::{load::load, resolve::resolve};
use subsolid::scenario::Scenario;
use subsolid::subdiv::options::{Options, Scheme};
use subsolid::subdiv::{self, History};

/// Two unit cubes of six tetrahedra, the second one 5 along x, as GiD writes meshes.
fn two_cubes() -> String {
    let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2]);
    let points: Vec<[usize; 3]> = corners.clone().chain(corners.map(|[x, y, z]| [x + 5, y, z])).collect();
    let walks = [[1, 2, 4], [2, 4, 1], [4, 1, 2], [1, 4, 2], [2, 1, 4], [4, 2, 1]];
    let tet = |first: usize, [a, b, _]: [usize; 3], even: bool| {
        let (p, q) = if even { (a, a + b) } else { (a + b, a) };
        [first, first + p, first + q, first + 7]
    };
    let tets = [0, 8].into_iter().flat_map(|first| (0..6).map(move |w| tet(first, walks[w], w < 3)));
    let mut text = "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n".to_owned();
    (1..).zip(&points).for_each(|(id, [x, y, z])| text += &format!("{id} {x} {y} {z}\n"));
    text += "End Coordinates\nElements\n";
    (1..).zip(tets).for_each(|(id, t)| text += &format!("{id} {}\n", t.map(|v| (v + 1).to_string()).join(" ")));
    text + "End Elements\n"
}

/// The first cube is clamped; the second is what `more` makes of it.
fn scenario(more: &str) -> String {
    format!(
        r#"
[mesh]
file = "cubes.msh"
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.clamp]
plane = {{ normal = [1, 0, 0], offset = 0 }}
fix = ["x", "y", "z"]
[loads.push]
plane = {{ normal = [0, 1, 0], offset = 1 }}
pressure = 1.0
{more}"#
    )
}

/// The exit code and the messages, in one line, of a command on a scenario.
fn refused(command: &str, more: &str) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cubes.msh"), two_cubes()).unwrap();
    std::fs::write(folder.path().join("case.toml"), scenario(more)).unwrap();
    let mut subsolid = Command::cargo_bin("subsolid").unwrap();
    let output = subsolid.args([command, "case.toml"]).current_dir(folder.path()).output().unwrap();
    assert!(!folder.path().join("results").exists());
    let text = String::from_utf8(output.stderr).unwrap();
    // Messages are broken into lines with a bar before each.
    (output.status.code(), text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" "))
}

#[test]
fn class_35_a_part_that_can_slide_and_spin_is_refused_by_both_motions() {
    // A hinge along the edge at x = 5, y = 0 that lets it slide too.
    let hinge = "[supports.hinge]\nfix = [\"x\", \"y\"]\nmeet = [{ plane = { normal = [1, 0, 0], offset = 5 } }, \
                 { plane = { normal = [0, 1, 0], offset = 0 } }]\n";
    for command in ["run", "check", "compare"] {
        let (code, message) = refused(command, hinge);
        assert_eq!(code, Some(5), "{command}: {message}");
        assert!(message.contains("part 2 of 2 (6 cells, box (5, 0, 0) to (6, 1, 1))"), "{message}");
        assert!(message.contains("can still move along z, rotate about z through (5, 0, 0.5)"), "{message}");
        assert!(message.contains("case.toml:13:1: the supports"), "the line of the hinge: {message}");
        assert!(!message.contains("part 1"), "{message}");
    }
    // A face that slides in its plane leaves three.
    let slide = "[supports.slide]\nfix = \"normal\"\nplane = { normal = [1, 0, 0], offset = 5 }\n";
    let (code, message) = refused("run", slide);
    assert!(code == Some(5) && message.contains("move along y, move along z, rotate about x"), "{message}");
    // Held by nothing at all.
    let (code, message) = refused("run", "");
    assert!(code == Some(5) && message.contains("part 2") && message.contains("in every way"), "{message}");
    assert!(message.contains("case.toml: the supports"), "{message}");
}

#[test]
fn class_36_supports_that_contradict_each_other_are_refused_with_both_lines() {
    let more = "[supports.pull]\nplane = { normal = [0, 0, 1], offset = 1 }\ndisplacement = { x = 0.5 }\n\
                [supports.far]\nplane = { normal = [1, 0, 0], offset = 6 }\nfix = [\"y\", \"z\"]\n";
    let (code, message) = refused("run", more);
    assert_eq!(code, Some(5), "{message}");
    assert!(message.contains("\"clamp\" and \"pull\"") && message.contains("displacements 0 and 0.5"), "{message}");
    assert!(message.contains("case.toml:7:1 and case.toml:13:1:"), "{message}");
}

/// A scenario of a body that is generated, resolved on its mesh.
fn resolved(text: &str) -> subsolid::pipeline::resolve::Resolved {
    let scenario = Scenario::from_text(text, std::path::Path::new("case.toml"), &[]).unwrap();
    resolve(&scenario, load(&scenario).unwrap().mesh).unwrap()
}

const BAR: &str = "[mesh.box]\nsize = [4, 1, 1]\ncells = [4, 2, 2]\n[materials.a]\nyoungs_modulus = 1.0\n\
                   poissons_ratio = 0.3\n[supports.a]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
                   [loads.a]\ngroup = \"x-max\"\npressure = 1.0\n";

#[test]
fn a_support_that_holds_nothing_of_its_own_is_told() {
    assert!(resolved(BAR).warnings.is_empty());
    let again = resolved(&format!("{BAR}[supports.b]\ngroup = \"x-min\"\nfix = \"normal\"\n"));
    assert!(
        again.warnings.iter().any(|w| w.contains("`b` holds nothing that others do not hold")),
        "{:?}",
        again.warnings
    );
    // What it holds beside is its own.
    assert!(resolved(&format!("{BAR}[supports.b]\ngroup = \"y-min\"\nfix = \"normal\"\n")).warnings.is_empty());
}

/// The mid-plane edge of the outer side, at z = 0.3, as NAFEMS holds it.
const LE10: &str = r#"
[mesh.le10]
cells = [3, 4, 2]
[materials.steel]
youngs_modulus = 210e3
poissons_ratio = 0.3
[supports.y]
group = "y-min"
fix = "normal"
[supports.x]
group = "x-min"
fix = "normal"
[supports.outer]
group = "outer"
fix = ["x", "y"]
[supports.z]
fix = ["z"]
meet = [
  { all = [{ group = "outer" }, { box = { min = [0, 0, 0], max = [4, 4, 0.3] } }] },
  { all = [{ group = "outer" }, { box = { min = [0, 0, 0.3], max = [4, 4, 0.6] } }] },
]
[loads.top]
group = "z-max"
pressure = 1.0
"#;

#[test]
fn an_edge_stays_the_edge_on_every_refinement() {
    let problem = resolved(LE10);
    let support = problem.model.supports.iter().find(|s| s.name == "z").unwrap();
    let check = |mesh: &TetMesh, least: usize| {
        let outer = mesh.group("outer").unwrap();
        let on_edge = |v: &u32| (mesh.points()[*v as usize].z - 0.3).abs() < 1e-12;
        let mut edge: Vec<u32> = mesh.group_faces(outer).flat_map(|f| f.vertices).filter(on_edge).collect();
        edge.sort_unstable();
        edge.dedup();
        assert!(edge.len() >= least, "{} vertices on the edge", edge.len());
        assert_eq!(support.nodes(&Space::linear(mesh)), edge);
    };
    check(&problem.mesh, 5);
    for scheme in [Scheme::Red, Scheme::Sqrt3, Scheme::LongestEdge] {
        let options = Options { scheme, ..Options::default() };
        let (mut mesh, mut history) = (problem.mesh.clone(), History::default());
        for _ in 0..2 {
            let all = vec![true; mesh.tets().len()];
            let refined = subdiv::refine(&mesh, &history, &all, &options).unwrap();
            (mesh, history) = (refined.mesh, refined.history);
        }
        check(&mesh, 9);
    }
}

#[test]
fn edges_that_make_no_sense_are_refused() {
    let refuse = |keys: &str| {
        let text = format!("{BAR}[supports.b]\n{keys}\n");
        let Err(error) = Scenario::from_text(&text, std::path::Path::new("case.toml"), &[]) else {
            let scenario = Scenario::from_text(&text, std::path::Path::new("case.toml"), &[]).unwrap();
            return resolve(&scenario, load(&scenario).unwrap().mesh).unwrap_err().to_string();
        };
        let text = format!("{:?}", miette::Report::new(error));
        text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ")
    };
    let edge = "meet = [{ group = \"x-max\" }, { group = \"z-min\" }]\n";
    for (keys, words) in [
        (format!("{edge}spring = 1.0"), "no area"),
        (format!("{edge}fix = \"normal\""), "no normal"),
        (format!("{edge}group = \"x-max\"\nfix = [\"x\"]"), "stands beside a selector"),
        ("meet = [{ group = \"x-max\" }]\nfix = [\"x\"]".to_owned(), "takes two selectors"),
        ("meet = [{ group = \"x-min\" }, { group = \"x-max\" }]\nfix = [\"x\"]".to_owned(), "share no vertex"),
        ("group = \"x-max\"\nfix = \"exact\"".to_owned(), "exact displacement"),
    ] {
        let said = refuse(&keys);
        assert!(said.contains(words), "{keys}: {said}");
    }
}
