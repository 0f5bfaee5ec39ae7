//! From a scenario and a mesh to a model: what selectors match, and what is said of an ill-posed model.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use glam::DVec3;
use miette::Diagnostic as _;
use std::path::Path;
use subsolid::mesh::TetMesh;
use subsolid::pipeline::resolve::{Resolved, resolve};
use subsolid::pipeline::{ModelError, select};
use subsolid::scenario::{Scenario, Selector};
use subsolid::{Error, fem, fem::FemError};

const BASE: &str = r#"
[mesh]
file = "part.msh"
[materials.steel]
youngs_modulus = 1000
poissons_ratio = 0.3
[supports.feet]
group = "y-min"
fix = ["x", "y", "z"]
[loads.push]
group = "y-max"
traction = [0, -1, 0]
"#;

fn scenario(text: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    Scenario::from_text(text, Path::new("case.toml"), &overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// The box [0, 2] x [0, 1] x [0, 1], two cubes of six tetrahedra each, with groups "y-min" and "y-max".
fn brick() -> TetMesh {
    let index = |at: [u32; 3]| at[0] + 3 * (at[1] + 2 * at[2]);
    let points = (0..12).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6))).collect();
    let mut tets = Vec::new();
    for x in 0..2 {
        // One tetrahedron for each order of the three steps from one corner of the cube to the opposite one.
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut at = [x, 0, 0];
            let mut tet = [index(at); 4];
            for (i, axis) in order.into_iter().enumerate() {
                at[axis] += 1;
                tet[i + 1] = index(at);
            }
            if matches!(order, [0, 2, 1] | [2, 1, 0] | [1, 0, 2]) {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    let mut mesh = TetMesh::from_cells(points, tets, "solid").unwrap();
    for (name, y) in [("y-min", 0.0), ("y-max", 1.0)] {
        let faces = select::select(&mesh, &Selector::Plane { normal: DVec3::Y, offset: y, tolerance: None }).unwrap();
        mesh = mesh.with_group(name, &faces).unwrap().0;
    }
    mesh
}

/// BASE with more text behind it, on the brick.
fn resolved(more: &str, overrides: &[&str]) -> Result<Resolved, ModelError> {
    resolve(&scenario(&format!("{BASE}\n{more}"), overrides), brick())
}

/// What is wrong with a text, and the help.
fn refused(text: &str) -> (ModelError, String) {
    let fail = || resolve(&scenario(text, &[]), brick()).expect_err("accepted");
    assert_eq!(Error::from(fail()).exit_code(), 5);
    let help = fail().help().map(|h| h.to_string()).unwrap_or_default();
    (fail(), help)
}

#[test]
fn selectors_match_the_faces_whose_corners_lie_in_them() {
    for (selector, faces, area) in [
        ("group = \"y-max\"", 4, 2.0),
        ("plane = { normal = [-3, 0, 0], offset = -6 }", 2, 1.0),
        ("plane = { normal = [0, 0, 1], offset = 1.001, tolerance = 0.002 }", 4, 2.0),
        ("box = { min = [0, 0, 0], max = [1, 1, 1] }", 10, 5.0),
        ("sphere = { center = [0.5, 0.5, 0.5], radius = 0.8661 }", 10, 5.0),
        ("cylinder = { point = [1, 0, 0], axis = [5, 0, 0], radius = 1 }", 8, 4.0),
        ("normal = { direction = [0, 0, 7], angle = 1 }", 4, 2.0),
        ("normal = { direction = [0, 0, 7], angle = 90 }", 16, 8.0),
        ("not = { normal = { direction = [0, 0, 7], angle = 90 } }", 4, 2.0),
        ("all = [{ group = \"y-max\" }, { box = { min = [1, 0, 0], max = [2, 1, 1] } }]", 2, 1.0),
        ("any = [{ group = \"y-max\" }, { plane = { normal = [1, 0, 0], offset = 0 } }]", 6, 3.0),
    ] {
        let r = resolved(&format!("[loads.b]\npressure = 1\n{selector}"), &[]).unwrap();
        let s = r.selections.iter().find(|s| s.name == "b" && s.what == "load").unwrap();
        assert!((s.area - area).abs() < 1e-12, "{selector}: {s:?}");
        assert_eq!(s.faces, faces, "{selector}");
    }
}

#[test]
fn a_selector_becomes_a_group_and_a_named_group_stays_itself() {
    let r = resolved("[loads.end]\nplane = { normal = [1, 0, 0], offset = 2 }\nforce = [1, 0, 0]", &[]).unwrap();
    assert_eq!(r.mesh.groups(), ["y-min", "y-max", "load end"]);
    let (feet, end) = (r.mesh.group("y-min").unwrap(), r.mesh.group("load end").unwrap());
    assert_eq!(r.model.supports[0].group, feet);
    assert_eq!(r.model.loads[0].kind, fem::LoadKind::Force(end, DVec3::X));
    assert_eq!(r.mesh.group_faces(end).count(), 2);
    assert_eq!(r.model.materials[0].youngs_modulus, 1000.0);
    // The twelve edges of the box, four of them in two pieces.
    assert_eq!(r.mesh.creases().iter().filter(|c| c.feature).count(), 16);
}

#[test]
fn class_38_a_selector_that_matches_nothing_says_how_far_it_misses() {
    let (error, help) = refused(&BASE.replace("group = \"y-min\"", "plane = { normal = [0, 1, 0], offset = -1e-4 }"));
    let message = error.to_string();
    assert!(message.contains("support `feet`") && message.contains("case.toml:7:1"), "{message}");
    assert!(help.contains("from 0 to 1") && help.contains("tolerance = 1.1e-4") && help.contains("y-max"), "{help}");

    let apart = "all = [{ group = \"y-min\" }, { group = \"y-max\" }]";
    assert!(refused(&BASE.replace("group = \"y-min\"", apart)).1.contains("no face matches the whole"));
}

#[test]
fn class_39_an_unknown_group_is_suggested_and_all_are_listed() {
    let (_, help) = refused(&BASE.replace("\"y-min\"", "\"y_min\""));
    assert!(help.contains("did you mean `y-min`?") && help.contains("y-max"), "{help}");
    assert!(refused(&BASE.replace("\"y-min\"", "\"solid\"")).1.contains("region"));
    // The group that was made for the plane of a support is none of the mesh's.
    let plane = BASE.replace("group = \"y-min\"", "plane = { normal = [0, 1, 0], offset = 0 }");
    for wrong in ["group = \"y_max\"", "sphere = { center = [9, 9, 9], radius = 1 }"] {
        let (_, help) = refused(&plane.replace("group = \"y-max\"", wrong));
        assert!(help.contains("y-max") && !help.contains("feet"), "{help}");
    }
    let (_, help) = refused(&BASE.replace("poissons_ratio = 0.3", "group = \"solit\"\npoissons_ratio = 0.3"));
    assert!(help.contains("did you mean `solid`?"), "{help}");
}

#[test]
fn class_44_a_region_without_material_says_what_to_add() {
    let (error, help) = refused("[mesh]\nfile = \"a\"\n");
    assert!(matches!(&error, ModelError::NoMaterial { regions, .. } if regions.contains("`solid` (12 cells)")));
    assert!(help.contains("[materials.") && help.contains("group = \"solid\""));
}

#[test]
fn gravity_asks_for_densities() {
    let (error, _) = refused(&format!("{BASE}[loads.w]\ngravity = [0, -9.81, 0]\n"));
    assert!(matches!(&error, ModelError::NoDensity { materials, .. } if materials.contains("`steel`")));
}

#[test]
fn class_37_supports_may_agree_but_not_contradict_where_they_meet() {
    let side = "[supports.side]\nplane = { normal = [1, 0, 0], offset = 0 }\n";
    assert!(resolved(&format!("{side}fix = [\"x\"]"), &[]).is_ok());
    let (error, _) = refused(&format!("{BASE}{side}displacement = {{ y = 0.25 }}"));
    let ModelError::Supports { places, error, .. } = error else { panic!("{error}") };
    let FemError::ConflictingSupports { first, second, axis, values, vertex, position } = *error else {
        panic!("{error}")
    };
    assert!(places.contains(" and ") && places.matches("case.toml:").count() == 2, "{places}");
    assert_eq!((first.as_str(), second.as_str(), axis, values), ("feet", "side", "y", [0.0, 0.25]));
    assert_eq!((position.x, position.y, brick().points()[vertex]), (0.0, 0.0, position));
}

#[test]
fn class_46_features_have_to_be_in_the_mesh() {
    let r = resolved("[features]\nangle = 180\nedges = [[4, 0]]\ncorners = [7]", &[]).unwrap();
    let features: Vec<[u32; 2]> = r.mesh.creases().iter().filter(|c| c.feature).map(|c| c.vertices).collect();
    assert_eq!((features, r.mesh.corners()), (vec![[0, 4]], &[7][..]));
    assert!(refused(&format!("{BASE}[features]\nedges = [[0, 2]]")).0.to_string().contains("[0, 2]"));
    assert!(refused(&format!("{BASE}[features]\ncorners = [12]")).0.to_string().contains("12"));
}

#[test]
fn class_40_a_load_on_fixed_nodes_only_is_warned_of() {
    assert!(resolved("", &[]).unwrap().warnings.is_empty());
    assert_warned(&["loads.push.group=y-min"], "load `push` acts on fixed nodes only: supports take it");
}

#[test]
fn class_41_a_load_that_is_zero_is_warned_of() {
    assert_warned(&["loads.push.traction=[0, 0, 0]"], "load `push` is zero");
    assert_warned(&["loads.push.traction=[0, 0, 0]"], "nothing loads the model");
    assert_warned(&["loads.pull.group=y-max", "loads.pull.force=[0, 2, 0]"], "cancel out");
}

fn assert_warned(overrides: &[&str], words: &str) {
    let warnings = resolved("", overrides).unwrap().warnings;
    assert!(warnings.iter().any(|w| w.contains(words)), "{overrides:?}: {warnings:?}");
}

#[test]
fn a_sliding_support_needs_faces_normal_to_one_axis() {
    let text = |selector: &str| format!("{BASE}[supports.s]\n{selector}\nsymmetry = true\n");
    let (error, help) = refused(&text("any = [{ group = \"y-max\" }, { plane = { normal = [1, 0, 0], offset = 0 } }]"));
    assert!(error.to_string().contains("normal to") && help.contains("each plane"), "{error} {help}");
    let turned = {
        let mut parts = brick().into_parts();
        parts.points.iter_mut().for_each(|p| *p = glam::DMat3::from_rotation_z(0.3) * *p);
        TetMesh::new(parts).unwrap()
    };
    let error = resolve(&scenario(&text("group = \"y-max\""), &[]), turned).expect_err("accepted");
    assert!(matches!(error, ModelError::NotSliding { .. }), "{error}");
    assert_eq!(Error::from(error).exit_code(), 5);
}

#[test]
fn a_point_outside_the_mesh_is_refused_with_the_nearest_vertex() {
    let text = format!("{BASE}[loads.p]\npoint = [2, 1.01, 1]\nforce = [0, 0, 1]\n");
    let (error, help) = refused(&text);
    assert!(error.to_string().contains("[2, 1.01, 1]") && help.contains("[2, 1, 1]"), "{error} {help}");
    assert!(resolved("[loads.p]\npoint = [2, 1.0000001, 1]\nforce = [0, 0, 1]", &[]).is_ok());
}

#[test]
fn an_expression_without_value_names_the_point() {
    for text in [
        "[loads.p]\ngroup = \"y-max\"\ntraction = [0, \"ln(x - 1)\", 0]\n",
        "[loads.p]\nbody_force = [0, \"sqrt(-z)\", 0]\n",
        "[supports.p]\ngroup = \"y-max\"\ndisplacement = { y = \"1/x\" }\n",
        "[loads.p]\ngroup = \"y-max\"\npressure = \"max(ln(x - 1), 0)\"\n",
    ] {
        let (error, _) = refused(&format!("{BASE}{text}"));
        let ModelError::Fem(FemError::NotFiniteAt { name, value, .. }) = &error else { panic!("{error}") };
        assert!(name == "p" && !value.is_finite(), "{error}");
    }
}

#[test]
fn expressions_that_mean_the_same_do_not_contradict() {
    let side = "[supports.side]\nplane = { normal = [1, 0, 0], offset = 2 }\n";
    assert!(resolved(&format!("{side}displacement = {{ y = \"sin(pi*x/2)*y\" }}"), &[]).is_ok());
    let r = resolved(&format!("{side}displacement = {{ x = \"y + z\" }}"), &["supports.feet.fix=[\"y\", \"z\"]"]);
    assert!(r.is_ok());
}
