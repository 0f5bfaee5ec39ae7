//! The elementary stages of a step, as `subdivide --frames` shows them.
//!
//! A frame is a `TetMesh`, whose constructor checks that all cells are positive and that the boundary faces are exactly
//! the boundary.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use subsolid::mesh::{TetMesh, features, generate, quality, read, topology};
use subsolid::subdiv::options::{Boundary, Mode, Optimise, Options, QualityMeasure, Scheme};
use subsolid::subdiv::{self, Frame, History, Refined};

/// A box whose inner vertices are out of place.
fn jittered_box() -> TetMesh {
    let mut parts = generate::box_tets([1.0, 1.2, 0.9], [3, 3, 3]).unwrap().into_parts();
    for p in &mut parts.points {
        let inside = p.x > 0.1 && p.x < 0.9 && p.y > 0.1 && p.y < 1.1 && p.z > 0.1 && p.z < 0.8;
        *p += if inside {
            0.08 * glam::DVec3::new((37.0 * p.y).sin(), (41.0 * p.z).cos(), 1.0)
        } else {
            glam::DVec3::ZERO
        };
    }
    features::with_creases(TetMesh::new(parts).unwrap(), 40.0, &[])
}

fn step(mesh: &TetMesh, history: &History, options: Options) -> Refined {
    subdiv::refine(mesh, history, &vec![true; mesh.tets().len()], &options).unwrap()
}

fn all_options() -> impl Iterator<Item = Options> {
    let boundaries = [Boundary::Fixed, Boundary::Approximating, Boundary::Interpolating];
    let sqrt3 = boundaries.map(|boundary| Options { boundary, ..Options::default() });
    let others = [Scheme::Red, Scheme::LongestEdge].map(|scheme| Options { scheme, ..Options::default() });
    let modes = |o: Options| {
        [Mode::Paper, Mode::Best].map(|mode| Options { optimise: Optimise { mode, ..o.optimise }, frames: true, ..o })
    };
    sqrt3.into_iter().chain(others).flat_map(modes)
}

/// V - E + F - T, with F from the 4 T + B sides of faces.
fn euler(mesh: &TetMesh) -> i64 {
    let count = |n: usize| i64::try_from(n).unwrap();
    let faces = (4 * mesh.tets().len() + mesh.faces().len()) / 2;
    count(mesh.points().len()) - count(topology::edges(mesh.tets()).len()) + count(faces) - count(mesh.tets().len())
}

fn find<'a>(frames: &'a [Frame], stage: &str) -> &'a TetMesh {
    &frames.iter().find(|f| f.stage == stage).unwrap_or_else(|| panic!("no stage {stage:?}")).mesh
}

#[test]
fn every_stage_keeps_the_topology_and_the_last_is_the_result() {
    let start = jittered_box();
    for options in all_options() {
        let (mut mesh, mut history) = (start.clone(), History::default());
        for _ in 0..2 {
            let refined = step(&mesh, &history, options);
            assert!(!refined.frames.is_empty(), "{options:?}");
            for frame in &refined.frames {
                assert_eq!(euler(&frame.mesh), euler(&start), "{} of {options:?}", frame.stage);
                assert_eq!(quality::quality(&frame.mesh).inverted, 0);
                // All faces of the box are planar, so that no boundary rule moves them.
                assert!((frame.mesh.volume() / start.volume() - 1.0).abs() < 1e-12, "{} of {options:?}", frame.stage);
            }
            let last = &refined.frames.last().unwrap().mesh;
            assert!(last.tets() == refined.mesh.tets() && last.points() == refined.mesh.points(), "{options:?}");
            let unwatched = step(&mesh, &history, Options { frames: false, ..options });
            assert!(unwatched.frames.is_empty());
            assert!(unwatched.mesh.tets() == last.tets() && unwatched.mesh.points() == last.points(), "{options:?}");
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

/// Section 7 of Burkhart, Hamann and Umlauf 2010: 4 n cells after the 1-4 splits, one more for each face flipped, two more
/// for each boundary face split; nodes are those of the input, one a cell, one a boundary face.
#[test]
fn the_stages_of_the_tripod_have_the_papers_counts() {
    let Ok(folder) = std::env::var("SUBSOLID_DATA") else {
        println!("skipped: SUBSOLID_DATA is not set");
        return;
    };
    let file = std::path::Path::new(&folder).join("tripod.GiD.msh");
    let mesh = features::with_creases(read::read(&file).unwrap().mesh, 70.0, &[]);
    let options = Options { boundary: Boundary::Approximating, frames: true, ..Options::default() };
    let refined = step(&mesh, &History::default(), options);
    let cells = |stage: &str| find(&refined.frames, stage).tets().len();
    assert_eq!(cells("1-4 splits"), 11_196);
    // Each old face that is gone was flipped; the few that stay would have made a flat or an inverted cell.
    let flipped = find(&refined.frames, "2-3 flips");
    let mut faces: Vec<[u32; 3]> =
        flipped.tets().iter().flat_map(|&t| topology::tet_faces(t)).map(topology::sorted3).collect();
    faces.sort_unstable();
    let mut old: Vec<[u32; 3]> =
        mesh.tets().iter().flat_map(|&t| topology::tet_faces(t)).map(topology::sorted3).collect();
    old.sort_unstable();
    let interior: Vec<[u32; 3]> = old.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]).collect();
    assert_eq!(interior.len(), 4_743);
    let kept = interior.iter().filter(|f| faces.binary_search(f).is_ok()).count();
    assert!(kept < 50, "{kept} of 4,743 flips refused");
    assert_eq!(cells("2-3 flips"), 15_939 - kept);
    assert_eq!(cells("boundary 1-3 splits"), 15_939 - kept + 3_420);
    // Creases are trisected in even steps only.
    assert_eq!(cells("crease trisections"), cells("boundary 1-3 splits"));
    assert!(refined.frames.iter().skip(2).all(|f| f.mesh.points().len() == 5_476));
}

#[test]
fn other_measures_drive_the_papers_operations() {
    let mesh = jittered_box();
    let worst = |mesh: &TetMesh, measure: quality::CellMeasure| quality::worst_and_mean(mesh, measure).0;
    let refined = |measure| {
        let optimise = Optimise { measure, ..Optimise::default() };
        step(&mesh, &History::default(), Options { optimise, frames: true, ..Options::default() })
    };
    for (measure, function) in [
        (QualityMeasure::MinSine, quality::min_sine as quality::CellMeasure),
        (QualityMeasure::MinDihedral, quality::min_dihedral),
        (QualityMeasure::MinSolidAngle, quality::min_solid_angle),
        (QualityMeasure::EdgeRatio, quality::edge_ratio),
    ] {
        let refined = refined(measure);
        let before = worst(find(&refined.frames, "boundary bisections"), function);
        let after = worst(&refined.mesh, function);
        assert!(after > before, "{measure:?}: worst {before} before, {after} after");
        assert_eq!(quality::quality(&refined.mesh).inverted, 0);
    }
}

#[test]
fn the_command_writes_every_stage_and_a_collection_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n\
                End Coordinates\nElements\n1 1 2 3 4\nEnd Elements\n";
    std::fs::write(folder.path().join("one.msh"), mesh).unwrap();
    for scheme in ["sqrt3", "red", "longest-edge"] {
        let frames = folder.path().join(scheme);
        let mut command = Command::cargo_bin("subsolid").unwrap();
        command.args(["subdivide", "one.msh", "--steps", "2", "-o", "out.vtu", "--scheme", scheme, "--json", "-"]);
        let output = command.arg("--frames").arg(&frames).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        // Standard output is for the JSON alone.
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(json["cells"].as_u64().unwrap() > 1, "{json}");
        let collection = std::fs::read_to_string(frames.join("frames.pvd")).unwrap();
        let listed: Vec<&str> = collection.split("file=\"").skip(1).map(|s| s.split('"').next().unwrap()).collect();
        let files = std::fs::read_dir(&frames).unwrap().count() - 1;
        assert!(listed.len() == files && files > 2, "{collection}");
        assert!(listed[0] == "frame_000_input.vtu" && listed.iter().all(|f| frames.join(f).is_file()), "{collection}");
        for data in ["\"new\"", "\"moved\"", "\"quality\""] {
            assert!(std::fs::read_to_string(frames.join(listed[1])).unwrap().contains(data), "{data}");
        }
    }
}
