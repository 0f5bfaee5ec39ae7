//! `subdivide --scheme catmull-clark` and `inspect` on the bundled bent bracket, and what comes back from the file.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use subsolid::mesh::hex::features::face_normal;
use subsolid::mesh::hex::{HexMesh, read};

fn bracket() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bent_bracket.msh")
}

/// Runs the program; gives its code, what it says on standard error, and the figures.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, Value) {
    let json = folder.join("figures.json");
    let output = Command::cargo_bin("subsolid").unwrap().args(arguments).arg("--json").arg(&json).output().unwrap();
    let figures = std::fs::read(&json).map(|text| serde_json::from_slice(&text).unwrap()).unwrap_or_default();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned(), figures)
}

fn area(mesh: &HexMesh, group: &str) -> f64 {
    let faces = mesh.group_faces(mesh.group(group).unwrap());
    faces.map(|f| 0.5 * face_normal(mesh.points(), mesh.faces()[f].vertices).length()).sum()
}

#[test]
fn the_bent_bracket_becomes_round() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.vtu");
    let (input, output) = (bracket(), out.display().to_string());
    let input = input.display().to_string();
    let before = read::read(&bracket()).unwrap().mesh;
    let arguments = ["subdivide", &input, "--scheme", "catmull-clark", "--steps", "2", "--interpolate", "-o", &output];
    let (code, said, figures) = run(folder.path(), &arguments);
    assert_eq!(code, 0, "{said}");
    let mesh = read::read(&out).unwrap().mesh;
    assert_eq!(
        (mesh.cells().len(), mesh.groups(), mesh.region_names()),
        (256 * 64, before.groups(), before.region_names())
    );
    for group in before.groups() {
        let [fine, coarse] = [&mesh, &before].map(|m| m.group_faces(m.group(group).unwrap()).count());
        assert_eq!(fine, 16 * coarse, "{group}");
    }
    // The plate's two legs less the holes, and the bend.
    let exact = 2.0 * 8.0 * (48.0 * 48.0 - PI * 49.0) + 48.0 * PI / 4.0 * (20.0 * 20.0 - 12.0 * 12.0);
    assert!((mesh.volume() / exact - 1.0).abs() < 1e-3 && (before.volume() / exact - 1.0).abs() > 4e-3);
    // A control polygon is longer than its limit, by one part in 600 with 64 sides; the flat faces are shorter by one in 150.
    assert!((area(&mesh, "base-hole") / (2.0 * PI * 7.0 * 8.0) - 1.0).abs() < 2e-3);
    assert!((figures["volume"].as_f64().unwrap() - mesh.volume()).abs() < 1e-9 * exact);
    // Five cells at four lines a leg, two layers thick at first.
    assert_eq!(figures["edge_valences"]["5"], 2 * 4 * 2 * 4);
    assert_eq!(figures["creases"], 4 * 160);

    let (code, _, inspected) = run(folder.path(), &["inspect", &output]);
    assert_eq!((code, &inspected["cells"], &inspected["rings"]), (0, &figures["cells"], &figures["rings"]));
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.vtu").display().to_string();
    let hexes = bracket().display().to_string();
    let tets = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bracket.msh").display().to_string();
    let smooth = ["--scheme", "catmull-clark"];
    for (mesh, more, code, words) in [
        (&hexes, &[][..], 4, "256 hexahedra and no tetrahedra"),
        (&tets, &smooth[..], 4, "no hexahedra"),
        (&hexes, &["--scheme", "catmull-clark", "--steps", "20"], 4, "20 times"),
        (&hexes, &["--scheme", "catmull-clark", "--select", "boundary"], 2, "--select"),
        (&hexes, &["--scheme", "catmull-clark", "--frames", "f"], 2, "--frames"),
    ] {
        let (got, said, _) = run(folder.path(), &[&["subdivide", mesh, "-o", &output], more].concat());
        let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(got == code && said.contains(words), "{more:?}: {got}, {said}");
        assert!(!Path::new(&output).exists());
    }
}
