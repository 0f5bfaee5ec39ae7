//! Embedded points follow their control points: identity, affine maps, convex weights, crease surfaces, refusals, files.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use glam::{DAffine3, DMat3, DVec3};
use serde_json::Value;
use std::path::{Path, PathBuf};
use subsolid::mesh::read::read_shape;
use subsolid::mesh::tet_oct::TetOctMesh;
use subsolid::mesh::{RegionId, TetMesh, features, generate};
use subsolid::scenario::Deformation;
use subsolid::subdiv::tet_oct::{EmbedError, Embedding};

/// A unit cube in two regions that meet at x = 1/2, its inner vertices moved.
fn halves() -> TetOctMesh {
    let mut parts = generate::box_tets([1.0; 3], [4; 3]).unwrap().into_parts();
    parts.region_names.push("right".to_owned());
    for (tet, region) in parts.tets.iter().zip(&mut parts.regions) {
        let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        *region = RegionId(u16::from(x > 0.5));
    }
    let free = |p: DVec3| p.min_element() > 0.1 && p.max_element() < 0.9 && p.x != 0.5;
    let shift = |p: DVec3| 0.04 * DVec3::new((9.0 * p.y).sin(), (8.0 * p.z).cos(), (7.0 * p.x).sin());
    parts.points.iter_mut().filter(|p| free(**p)).for_each(|p| *p += shift(*p));
    (&features::with_creases(TetMesh::new(parts).unwrap(), 60.0, &[])).into()
}

/// Points inside the cube, away from its rounded parts.
fn points(count: usize) -> Vec<DVec3> {
    let share = |i: usize, step: f64| 0.02 + 0.96 * (0.5 + step * i as f64).fract();
    (0..count).map(|i| DVec3::new(share(i, 0.754_877_6), share(i, 0.569_840_2), share(i, 0.430_159_7))).collect()
}

#[test]
fn points_stay_with_the_control_points_and_follow_affine_maps() {
    let (control, points) = (halves(), points(2000));
    let map = DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&[1.3, 0.2, -0.4, 0.1, 0.7, 0.5, -0.2, 0.3, 1.1]),
        DVec3::new(2.0, -1.0, 0.5),
    );
    for steps in 0..=3 {
        let embedding = Embedding::new(&control, steps, &points).unwrap();
        let still = embedding.places(control.points());
        assert!(still.iter().zip(&points).all(|(p, q)| p.distance(*q) < 1e-13), "{steps} steps");
        let mapped: Vec<DVec3> = control.points().iter().map(|p| map.transform_point3(*p)).collect();
        let moved = embedding.places(&mapped);
        assert!(moved.iter().zip(&points).all(|(p, q)| p.distance(map.transform_point3(*q)) < 1e-12), "{steps} steps");
        assert_eq!(embedding.inverted(&mapped).0, 0);
    }
}

#[test]
fn weights_are_convex_and_give_the_places() {
    let (control, points) = (halves(), points(300));
    let embedding = Embedding::new(&control, 2, &points).unwrap();
    let moved: Vec<DVec3> =
        control.points().iter().map(|p| *p + 0.1 * DVec3::new(p.y * p.y, p.z.sin(), p.x * p.y)).collect();
    for (i, place) in embedding.places(&moved).into_iter().enumerate() {
        let weights = embedding.weights(i);
        assert!(weights.iter().all(|(_, w)| *w >= 0.0));
        assert!((weights.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-13);
        let sum: DVec3 = weights.iter().map(|&(v, w)| w * moved[v as usize]).sum();
        assert!(sum.distance(place) < 1e-13);
    }
}

#[test]
fn points_beyond_a_crease_surface_do_not_move() {
    let (control, points) = (halves(), points(2000));
    let embedding = Embedding::new(&control, 3, &points).unwrap();
    let moved: Vec<DVec3> =
        control.points().iter().map(|p| if p.x > 0.5 { *p + DVec3::new(0.0, 0.05 * p.x, 0.03) } else { *p }).collect();
    let places = embedding.places(&moved);
    let distances = |right: bool| {
        let of_side = places.iter().zip(&points).filter(move |(_, p)| (p.x > 0.5) == right);
        of_side.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
    };
    assert!(distances(false) < 1e-13 && distances(true) > 0.01);
}

#[test]
fn what_is_not_one_to_one_is_refused() {
    let control = halves();
    let outside = [DVec3::splat(0.5), DVec3::new(0.5, 0.5, 1.2), DVec3::new(0.2, 0.3, 1.1)];
    match Embedding::new(&control, 2, &outside).unwrap_err() {
        EmbedError::Outside { count: 2, total: 3, point: 1, distance, .. } => assert!((distance - 0.2).abs() < 1e-12),
        other => panic!("{other}"),
    }
    let embedding = Embedding::new(&control, 2, &points(10)).unwrap();
    let mirrored: Vec<DVec3> = control.points().iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
    let (inverted, cells) = embedding.inverted(&mirrored);
    assert!(inverted == cells && embedding.inverted(control.points()) == (0, cells));
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Runs `deform`; gives its code, what it says, and the figures.
fn deform(scenario: &Path, folder: &Path, more: &[&str]) -> (i32, String, Value) {
    let json = folder.join("figures.json");
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.arg("deform").arg(scenario).arg("--quiet").arg("--json").arg(&json).arg("--output").arg(folder).args(more);
    let output = command.output().unwrap();
    let figures = std::fs::read(&json).map(|text| serde_json::from_slice(&text).unwrap()).unwrap_or_default();
    let said =
        String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ").replace("│ ", "");
    (output.status.code().unwrap(), said, figures)
}

#[test]
fn the_bundled_deformations_run_and_begin_where_the_shapes_are() {
    for (name, file, frames) in [("cylinder", "pattern.obj", 9), ("figure", "figure.obj", 5)] {
        let folder = tempfile::tempdir().unwrap();
        let scenario = root().join(format!("scenarios/deform/{name}.toml"));
        let (code, said, figures) =
            deform(&scenario, folder.path(), &["--set", "embed.frames=2", "--set", "embed.steps=2"]);
        assert_eq!((code, figures["frames"].as_u64()), (0, Some(frames)), "{said}");
        let shape = read_shape(&root().join("scenarios/deform").join(file)).unwrap();
        let places = |frame: u64| read_shape(&folder.path().join(format!("frame_{frame:03}.vtu"))).unwrap().points;
        let [first, last] = [0, frames - 1].map(places);
        assert!(first.iter().zip(&shape.points).all(|(p, q)| p.distance(*q) < 1e-13));
        assert!(last.iter().zip(&shape.points).any(|(p, q)| p.distance(*q) > 0.3));
        assert!(folder.path().join("frames.pvd").is_file());
    }
}

#[test]
fn shapes_come_from_obj_stl_and_mesh_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read_shape(&path).unwrap()
    };
    let obj = write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1 2 3 4\nf 1/1 2/2 3/3\n");
    assert_eq!((obj.points.len(), obj.points[3]), (4, DVec3::new(0.0, 1.0, 0.5)));
    assert_eq!(obj.polygons, [vec![0, 1, 2, 3], vec![0, 1, 2]]);
    let stl = write(
        "a.stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
    );
    assert_eq!((stl.points.len(), stl.polygons.len()), (3, 1));
    let bare = folder.path().join("bare.obj");
    std::fs::write(&bare, "v 0 0 0\nv 1 0 0\n").unwrap();
    assert!(read_shape(&bare).unwrap_err().to_string().contains("no faces"));
    let vtk = "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n\
               CELLS 2 9\n3 0 1 2\n4 0 1 2 3\nCELL_TYPES 2\n5 10\n";
    let vtk = write("a.vtk", vtk);
    assert_eq!((vtk.points.len(), &vtk.polygons[..], &vtk.tets[..]), (4, &[vec![0, 1, 2]][..], &[[0, 1, 2, 3]][..]));
}

#[test]
fn scenarios_that_cannot_be_done_are_refused_with_their_reason() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), "v 0.5 0.5 0.5\nv 0.6 0.5 0.5\nv 0.5 0.6 0.5\nf 1 2 3\n").unwrap();
    let head = "[mesh.box]\nsize = [1, 1, 1]\ncells = [2, 2, 2]\n[embed]\nfile = \"a.obj\"\n[[pose]]\n";
    for (pose, code, words) in [
        ("move = [{ group = \"z-top\", displacement = { z = 1 } }]", 5, "z-top"),
        ("move = [{ points = [99], displacement = { z = 1 } }]", 5, "control point 99"),
        (
            "move = [{ sphere = { center = [9, 9, 9], radius = 1 }, displacement = { z = 1 } }]",
            5,
            "takes no control points",
        ),
        ("move = [{ displacement = { x = \"-2*x\" } }]", 5, "not one-to-one"),
        ("move = [{ displacement = { x = \"1/(x - 0.5)\" } }]", 5, "displaces control point"),
        ("move = [{ group = \"z-max\" }]", 3, "moves nothing"),
        ("move = [{ group = \"z-max\", points = [1], displacement = { z = 1 } }]", 3, "beside a selector"),
        ("move = [{ group = \"z-max\", displacement = {} }]", 3, "moves nothing"),
        ("moves = []", 3, "moves"),
        ("move = [{ displacement = { z = 1 } }]\n[features]\nangel = 3", 3, "angel"),
    ] {
        let scenario = folder.path().join("a.toml");
        std::fs::write(&scenario, head.to_owned() + pose).unwrap();
        let results = folder.path().join("results");
        let (got, said, _) = deform(&scenario, &results, &[]);
        assert!(got == code && said.contains(words), "{pose}: {got}, {said}");
        assert!(!results.exists(), "{pose}: nothing is written");
    }
}

#[test]
fn frames_of_an_earlier_run_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = root().join("scenarios/deform/figure.toml");
    for (frames, last) in [(3, 6), (1, 2)] {
        let setting = format!("embed.frames={frames}");
        let (code, said, _) = deform(&scenario, folder.path(), &["--set", &setting, "--set", "embed.steps=1"]);
        let there = |frame: usize| folder.path().join(format!("frame_{frame:03}.vtu")).is_file();
        assert!(code == 0 && there(last) && !there(last + 1), "{said}");
    }
}

#[test]
fn a_round_solid_follows_affine_maps() {
    let control: TetOctMesh = (&generate::cylinder(1.0, 1.0, [3, 3]).unwrap().mesh).into();
    let inside: Vec<DVec3> = points(500).into_iter().map(|p| p - DVec3::new(0.5, 0.5, 0.0)).collect();
    let embedding = Embedding::new(&control, 2, &inside).unwrap();
    let map = DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&[1.1, 0.3, 0.0, -0.2, 0.8, 0.1, 0.4, 0.0, 1.2]),
        DVec3::new(0.3, 2.0, -1.0),
    );
    let mapped: Vec<DVec3> = control.points().iter().map(|p| map.transform_point3(*p)).collect();
    let moved = embedding.places(&mapped);
    assert!(moved.iter().zip(&inside).all(|(p, q)| p.distance(map.transform_point3(*q)) < 1e-12));
    // The surface of the solid is inside that of its control mesh.
    assert!(matches!(Embedding::new(&control, 2, control.points()), Err(EmbedError::Outside { .. })));
}

#[test]
fn the_example_of_the_page_is_a_scenario() {
    let page = std::fs::read_to_string(root().join("docs/deformation.md")).unwrap();
    let example = page.split("``` toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let scenario = Deformation::from_text(example, Path::new("vase.toml"), &["embed.steps=2".to_owned()]).unwrap();
    assert_eq!((scenario.poses.len(), scenario.poses[0].moves.len(), scenario.steps, scenario.frames), (1, 4, 2, 10));
}
