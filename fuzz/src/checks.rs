//! What is done with an input: whatever it is, nothing may panic. Messages are made too.

use miette::Diagnostic;
use std::path::Path;
use subsolid::mesh::read::{AnyMesh, Edges, read_any_from, read_list, read_shape};
use subsolid::scenario::{Deformation, Scenario};

/// A reader of meshes; the format is found from the content.
pub fn mesh(data: &[u8]) {
    for edges in [Edges::Straight, Edges::Curved] {
        match read_any_from(Path::new("input"), data, edges) {
            Ok(AnyMesh::Tets(file)) => assert!(file.mesh.volume() > 0.0),
            Ok(AnyMesh::Hexes(file)) => assert!(!file.mesh.cells().is_empty()),
            Err(error) => told(&error),
        }
    }
}

/// Wavefront OBJ.
pub fn obj(data: &[u8]) {
    with_file(data, ".obj", |path| {
        let _ = read_shape(path).map_err(|error| told(&error));
    });
}

/// STL.
pub fn stl(data: &[u8]) {
    with_file(data, ".stl", |path| {
        let _ = read_shape(path).map_err(|error| told(&error));
    });
}

/// Lists of cells, edges and corners.
pub fn lists(data: &[u8]) {
    with_file(data, ".txt", |path| {
        let _ = read_list::<1>(path, "a vertex").map_err(|error| told(&error));
        let _ = read_list::<2>(path, "two vertices").map_err(|error| told(&error));
    });
}

/// Scenarios, with the expressions in them.
pub fn scenario(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let _ = Scenario::from_text(&text, Path::new("input.toml"), &[]).map_err(|error| told(&error));
}

/// Scenarios of deformations.
pub fn deformation(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let _ = Deformation::from_text(&text, Path::new("input.toml"), &[]).map_err(|error| told(&error));
}

/// The message and the help of an error.
fn told(error: &dyn Diagnostic) {
    assert!(!error.to_string().is_empty());
    let _ = error.help().map(|help| help.to_string());
}

fn with_file(data: &[u8], suffix: &str, check: impl FnOnce(&Path)) {
    let Ok(file) = tempfile::Builder::new().suffix(suffix).tempfile() else { return };
    if std::fs::write(file.path(), data).is_ok() {
        check(file.path());
    }
}
