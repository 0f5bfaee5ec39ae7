//! The fuzz targets' checks on a fixed corpus: the seeds, and inputs that reached further when the targets were fuzzed.
#![allow(clippy::unwrap_used)]

#[path = "../fuzz/src/checks.rs"]
mod checks;

use std::path::Path;

type Check = fn(&[u8]);

/// Every target of `fuzz/run` with the endings of the test meshes that are its seeds.
const TARGETS: [(&str, Check, &str); 11] = [
    ("gmsh", checks::mesh, "msh"),
    ("abaqus", checks::mesh, "inp"),
    ("medit", checks::mesh, "mesh"),
    ("gid", checks::mesh, ""),
    ("vtk_legacy", checks::mesh, "vtk"),
    ("vtk_xml", checks::mesh, "vtu"),
    ("obj", checks::obj, ""),
    ("stl", checks::stl, ""),
    ("lists", checks::lists, ""),
    ("scenario", checks::scenario, ""),
    ("deformation", checks::deformation, ""),
];

fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn no_input_of_the_corpus_panics() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (target, check, ending) in TARGETS {
        let seeds = files(&root.join("fuzz/seeds").join(target));
        assert!(!seeds.is_empty(), "{target}");
        let meshes = files(&root.join("tests/meshes"));
        let meshes = meshes.into_iter().filter(|f| f.extension().is_some_and(|e| !ending.is_empty() && e == ending));
        for path in seeds.into_iter().chain(meshes) {
            println!("{}", path.display());
            check(&std::fs::read(&path).unwrap());
        }
    }
}
