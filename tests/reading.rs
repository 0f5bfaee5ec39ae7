//! One part in every format: the files of `tests/meshes/`, written by Gmsh, meshio and VTK (`make.py` there).
#![allow(clippy::unwrap_used)]

#[path = "meshes/binary_msh.rs"]
mod binary_msh;

use assert_cmd::Command;
use binary_msh::binary_msh;
use std::path::{Path, PathBuf};
use subsolid::fem::Space;
use subsolid::mesh::read::{Edges, MeshFile, read, read_with};
use subsolid::mesh::{TetMesh, features::face_normal, generate};
use subsolid::output::options::Compression;
use subsolid::output::vtk::{Fields, write_vtu};

/// The files, their format, the names of the regions, and those of the groups x = 0 and x = 3.
const FILES: [(&str, &str, [&str; 2], [&str; 2]); 27] = [
    ("gmsh22.msh", "Gmsh MSH 2.2 ASCII", NAMES, GROUPS),
    ("gmsh22_binary.msh", "Gmsh MSH 2.2 binary", NAMES, GROUPS),
    ("gmsh41.msh", "Gmsh MSH 4.1 ASCII", NAMES, GROUPS),
    ("gmsh41_binary.msh", "Gmsh MSH 4.1 binary", NAMES, GROUPS),
    ("partitioned.msh", "Gmsh MSH 4.1 ASCII", NAMES, GROUPS),
    ("partitioned_binary.msh", "Gmsh MSH 4.1 binary", NAMES, GROUPS),
    ("gmsh.inp", "Abaqus input", NAMES, GROUPS),
    ("meshio.inp", "Abaqus input", NONE, NONE),
    ("gmsh.mesh", "MEDIT ASCII", VOLUMES, SURFACES),
    ("meshio.mesh", "MEDIT ASCII", VOLUMES, SURFACES),
    ("gmsh.vtk", "VTK legacy ASCII", VOLUMES, SURFACES),
    ("gmsh_binary.vtk", "VTK legacy binary", VOLUMES, SURFACES),
    ("meshio_ascii.vtk", "VTK legacy ASCII", VOLUMES, SURFACES),
    ("meshio.vtk", "VTK legacy binary", VOLUMES, SURFACES),
    ("vtk42.vtk", "VTK legacy ASCII", VOLUMES, SURFACES),
    ("vtk42_binary.vtk", "VTK legacy binary", VOLUMES, SURFACES),
    ("vtk51.vtk", "VTK legacy ASCII", VOLUMES, SURFACES),
    ("vtk51_binary.vtk", "VTK legacy binary", VOLUMES, SURFACES),
    ("meshio_ascii.vtu", VTU, VOLUMES, SURFACES),
    ("meshio_raw.vtu", VTU, VOLUMES, SURFACES),
    ("meshio.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_ascii.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_inline.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_inline_zlib.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_raw.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_raw_lz4.vtu", VTU, VOLUMES, SURFACES),
    ("vtk_base64_zlib.vtu", VTU, VOLUMES, SURFACES),
];
const VTU: &str = "VTK XML unstructured grid";
const NAMES: [&str; 2] = ["steel", "rubber"];
const GROUPS: [&str; 2] = ["held", "pulled"];
const VOLUMES: [&str; 2] = ["volume-1", "volume-2"];
const SURFACES: [&str; 2] = ["surface-11", "surface-12"];
/// Names that the file has lost.
const NONE: [&str; 2] = ["", ""];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name)
}

/// VTK itself writes the numbers of a text with few digits.
fn digits(name: &str) -> f64 {
    if name.starts_with("vtk") && name.ends_with(".vtk") && !name.contains("binary") { 1e-5 } else { 1e-14 }
}

/// The cells as sorted positions, each with the name of its region.
fn cells(mesh: &TetMesh) -> Vec<([[i64; 3]; 4], usize)> {
    let round = |p: glam::DVec3| p.to_array().map(|x| (x * 1e4).round() as i64);
    let mut cells: Vec<_> = (0..mesh.tets().len())
        .map(|t| {
            let mut corners = mesh.cell_points(t).map(round);
            corners.sort_unstable();
            (corners, usize::from(mesh.regions()[t].0))
        })
        .collect();
    cells.sort_unstable();
    cells
}

fn area(mesh: &TetMesh, group: &str) -> f64 {
    let group = mesh.group(group).unwrap();
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), f.vertices).length()).sum()
}

#[test]
fn every_format_gives_the_same_mesh() {
    let reference = read(&file("gmsh22.msh")).unwrap().mesh;
    assert!((reference.volume() - 3.0 * 1.1 * 0.9).abs() < 1e-13);
    for (name, format, regions, groups) in FILES {
        let MeshFile { mesh, format: found, notes, .. } = read(&file(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(found, format, "{name}");
        assert!((mesh.volume() - reference.volume()).abs() < digits(name), "{name}: {}", mesh.volume());
        assert_eq!(mesh.faces().len(), reference.faces().len(), "{name}");
        let (mut ours, mut theirs) = (cells(&mesh), cells(&reference));
        if regions == NONE {
            assert_eq!(mesh.region_names(), ["solid"], "{name}");
            ours.iter_mut().chain(&mut theirs).for_each(|cell| cell.1 = 0);
        } else {
            assert_eq!(mesh.region_names(), regions, "{name}");
        }
        assert!(ours == theirs, "{name}: other cells or regions");
        for group in groups.into_iter().filter(|group| !group.is_empty()) {
            assert!((area(&mesh, group) - 1.1 * 0.9).abs() < digits(name), "{name}: {group}");
        }
        assert!(!notes.iter().any(|note| note.contains("parts")), "{name}: {notes:?}");
    }
}

/// Held at x = 0, pulled aside at x = 3: selectors by geometry, which hold for every format.
fn scenario(mesh: &Path) -> String {
    format!(
        r#"
mesh.file = {mesh:?}
[materials.steel]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.foot]
plane = {{ normal = [1.0, 0.0, 0.0], offset = 0.0 }}
fix = ["x", "y", "z"]
[loads.pull]
plane = {{ normal = [1.0, 0.0, 0.0], offset = 3.0 }}
traction = [1.0, 0.5, 0.25]
[refine]
strategy = "none"
"#
    )
}

#[test]
fn every_format_gives_the_same_strain_energy() {
    let folder = tempfile::tempdir().unwrap();
    let energy = |name: &str| -> f64 {
        std::fs::write(folder.path().join("part.toml"), scenario(&file(name))).unwrap();
        let mut command = Command::cargo_bin("subsolid").unwrap();
        let output = command.current_dir(folder.path()).args(["run", "part.toml", "--json", "-"]).output().unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["steps"][0]["strain_energy"].as_f64().unwrap()
    };
    let reference = energy("gmsh22.msh");
    assert!(reference > 0.0);
    for (name, ..) in FILES {
        let difference = (energy(name) / reference - 1.0).abs();
        assert!(difference < 1e4 * digits(name), "{name}: the energy differs by {difference:e}");
    }
}

#[test]
fn our_own_files_read_back_to_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.vtu");
    let mesh = read(&file("gmsh41_binary.msh")).unwrap().mesh;
    for compression in [Compression::None, Compression::Lz4, Compression::Zlib] {
        let flags = vec![true; mesh.tets().len()];
        let fields =
            Fields { cells: vec![("marked", subsolid::output::vtk::Values::Flags(&flags))], ..Fields::default() };
        write_vtu(&path, &Space::linear(&mesh), &fields, compression).unwrap();
        let again = read(&path).unwrap().mesh;
        assert_eq!((again.points(), again.tets()), (mesh.points(), mesh.tets()), "{compression:?}");
        assert_eq!(again.regions(), mesh.regions(), "{compression:?}");
        let vertices = |mesh: &TetMesh| mesh.faces().iter().map(|f| f.vertices).collect::<Vec<_>>();
        assert_eq!(vertices(&again), vertices(&mesh));
    }
}

#[test]
fn both_orders_of_bytes_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.msh");
    let mesh = generate::box_tets([1.0; 3], [2; 3]).unwrap();
    for big_endian in [false, true] {
        std::fs::write(&path, binary_msh(&mesh, big_endian)).unwrap();
        let again = read(&path).unwrap().mesh;
        assert_eq!((again.points(), again.tets()), (mesh.points(), mesh.tets()));
    }
}

/// A round bar of curved ten-node cells, whose mid-side nodes each format lists in an order of its own.
#[test]
fn curved_edges_come_out_of_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, more: &[&str]| {
        std::fs::write(folder.path().join("part.toml"), scenario(&file(name)).replace("offset = 3.0", "offset = 2.0"))
            .unwrap();
        let mut command = Command::cargo_bin("subsolid").unwrap();
        command.current_dir(&folder).args(["run", "part.toml", "--quiet", "--json", "-"]);
        command.args([
            "--set",
            "analysis.element=tet10",
            "--set",
            "solver.method=direct",
            "--set",
            "solver.tolerance=1e-11",
        ]);
        let output = command.args(more).output().unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["steps"][0]["strain_energy"].as_f64().unwrap()
    };
    let curved = ["--set", "mesh.midside=curved"];
    let reference = run("curved22.msh", &curved);
    let straight = run("curved22.msh", &[]);
    assert!(
        (straight - reference).abs() > 0.05 * reference,
        "{straight} {reference}: the bar is hexagonal without its curves"
    );
    for name in ["curved41_binary.msh", "curved.inp", "curved.mesh", "curved.vtk", "curved.vtu"] {
        let energy = run(name, &curved);
        assert!((energy - reference).abs() < 1e-10 * reference, "{name}: {energy} {reference}");
    }
}

/// A mid-side node moved far along its edge folds the cells there.
#[test]
fn folded_curved_cells_are_refused_by_their_ids() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(file("curved.inp")).unwrap();
    // The mid-side node 18 lies on the rim.
    let line = text.lines().find(|l| l.starts_with("75,")).unwrap();
    let moved = folder.path().join("folded.inp");
    std::fs::write(&moved, text.replace(line, "75, 1.0, 0.1, 0.1")).unwrap();
    let error = read_with(&moved, Edges::Curved).unwrap_err().to_string();
    assert!(error.contains("folded") && error.contains("ids "), "{error}");
    assert!(read(&moved).unwrap().midsides.is_empty(), "straight edges do not mind");
}
