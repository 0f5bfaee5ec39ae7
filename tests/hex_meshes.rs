//! Hexahedral meshes that are generated: what they measure, and how they are connected.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::f64::consts::PI;
use subsolid::mesh::GroupId;
use subsolid::mesh::generate::{box_tets, l_prism};
use subsolid::mesh::hex::features::face_normal;
use subsolid::mesh::hex::generate::{box_hexes, cylinder, from_tets, prism, sphere_shell, tube, tunnel};
use subsolid::mesh::hex::{HexError, HexMesh};

fn area(mesh: &HexMesh, group: &str) -> f64 {
    let group = mesh.group(group).unwrap();
    mesh.group_faces(group).map(|f| 0.5 * face_normal(mesh.points(), mesh.faces()[f].vertices).length()).sum()
}

/// How many interior edges have each valence.
fn valences(mesh: &HexMesh) -> BTreeMap<usize, usize> {
    let topology = mesh.topology();
    let mut counts = BTreeMap::new();
    for e in (0..topology.edges().len() as u32).filter(|&e| topology.boundary_faces_at(e).next().is_none()) {
        *counts.entry(topology.edge_cells(e).len()).or_default() += 1;
    }
    counts
}

/// Vertices - edges + faces - cells; each boundary face is in one group.
fn euler(mesh: &HexMesh) -> i64 {
    mesh.clone().with_creases(30.0, &[]).check_smoothable().unwrap();
    let in_groups: usize = (0..mesh.groups().len() as u32).map(|g| mesh.group_faces(GroupId(g)).count()).sum();
    assert_eq!(in_groups, mesh.faces().len());
    let t = mesh.topology();
    mesh.points().len() as i64 - t.edges().len() as i64 + t.faces().len() as i64 - mesh.cells().len() as i64
}

fn near(got: f64, want: f64, relative: f64) {
    assert!((got - want).abs() <= relative * want.abs(), "{got} is not {want}");
}

#[test]
fn prisms_have_the_valence_of_their_axis() {
    for n in [3, 5, 6, 8, 10] {
        let mesh = prism(n, 1.5, 2.0, [2, 3]).unwrap();
        assert_eq!((mesh.cells().len(), euler(&mesh)), (n * 4 * 3, 1));
        assert_eq!(valences(&mesh)[&n], 3);
        assert!(valences(&mesh).keys().all(|v| [4, n].contains(v)), "{:?}", valences(&mesh));
        let (half, n) = (PI / n as f64, n as f64);
        near(mesh.volume(), n * 1.5 * 1.5 * half.sin() * half.cos() * 2.0, 1e-13);
        near(area(&mesh, "side"), n * 2.0 * 1.5 * half.sin() * 2.0, 1e-13);
        near(area(&mesh, "z-max"), area(&mesh, "z-min"), 1e-13);
    }
}

#[test]
fn an_o_grid_fills_its_cylinder() {
    let mesh = cylinder(2.0, 3.0, [4, 3, 2]).unwrap();
    assert_eq!((mesh.cells().len(), euler(&mesh)), (2 * (16 + 48), 1));
    assert_eq!(valences(&mesh)[&3], 4 * 2);
    // A polygon of sixteen sides.
    let share = (PI / 8.0).sin() / (PI / 8.0);
    near(mesh.volume(), PI * 4.0 * 3.0 * share, 1e-12);
    near(area(&mesh, "side"), 16.0 * 4.0 * (PI / 16.0).sin() * 3.0, 1e-12);
    for core in 1..6 {
        let mesh = cylinder(1.0, 1.0, [core, 1, 1]).unwrap();
        assert!(mesh.points().iter().all(|p| p.truncate().length() < 1.0 + 1e-12));
    }
}

#[test]
fn tubes_are_closed_or_quartered() {
    for (is_quarter, around, turn) in [(false, 12, 1.0), (true, 3, 0.25)] {
        let mesh = tube([1.0, 2.0], 0.5, [2, around, 1], is_quarter).unwrap();
        assert_eq!(euler(&mesh), i64::from(is_quarter));
        near(mesh.volume(), turn * 12.0 * 0.5 * (PI / 6.0).sin() * 3.0 * 0.5, 1e-12);
        near(area(&mesh, "outer"), 2.0 * area(&mesh, "inner"), 1e-12);
        assert_eq!(valences(&mesh).keys().copied().collect::<Vec<_>>(), [4]);
    }
    let quarter = tube([1.0, 2.0], 0.5, [2, 3, 1], true).unwrap();
    near(area(&quarter, "x-min"), 0.5, 1e-12);
    let on_plane = |f: usize| quarter.faces()[f].vertices.iter().all(|&v| quarter.points()[v as usize].x == 0.0);
    assert!(quarter.group_faces(quarter.group("x-min").unwrap()).all(on_plane));
}

#[test]
fn a_shell_has_eight_radial_edges_of_valence_three() {
    for (is_eighth, edges, parts) in [(false, 8, 8.0), (true, 1, 1.0)] {
        let mesh = sphere_shell([1.0, 2.0], [4, 3], is_eighth).unwrap();
        assert_eq!(valences(&mesh)[&3], 3 * edges);
        assert_eq!((mesh.cells().len(), euler(&mesh)), (3 * 16 * 3 * edges, if is_eighth { 1 } else { 2 }));
        near(mesh.volume(), parts / 8.0 * 4.0 / 3.0 * PI * 7.0, 0.03);
        near(area(&mesh, "outer"), 4.0 * area(&mesh, "inner"), 1e-12);
        let radius = |g: &str| {
            let on = mesh.group_faces(mesh.group(g).unwrap()).flat_map(|f| mesh.faces()[f].vertices);
            on.map(|v| mesh.points()[v as usize].length()).collect::<Vec<_>>()
        };
        assert!(radius("inner").iter().all(|r| (r - 1.0).abs() < 1e-14));
        assert!(radius("outer").iter().all(|r| (r - 2.0).abs() < 1e-14));
    }
}

#[test]
fn a_tunnel_has_concave_edges_of_three_cells() {
    let mesh = tunnel([3.0, 4.0, 2.0], [3, 4, 2], [1, 2]).unwrap();
    assert_eq!(euler(&mesh), 0);
    near(mesh.volume(), 20.0, 1e-13);
    near(area(&mesh, "tunnel"), 12.0, 1e-13);
    let topology = mesh.topology();
    let concave = |e: &u32| topology.boundary_faces_at(*e).next().is_some() && topology.edge_cells(*e).len() == 3;
    assert_eq!((0..topology.edges().len() as u32).filter(concave).count(), 4 * 2);
}

#[test]
fn tetrahedra_are_split_with_their_tags() {
    let tets = l_prism(2).unwrap();
    let mesh = from_tets(&tets).unwrap();
    assert_eq!((mesh.cells().len(), euler(&mesh)), (4 * tets.tets().len(), 1));
    near(mesh.volume(), tets.volume(), 1e-13);
    near(area(&mesh, "notch-x"), 1.0, 1e-13);
    assert_eq!(mesh.groups(), tets.groups());
    let flat = box_tets([1.0, 2.0, 3.0], [2; 3]).unwrap();
    let creased = subsolid::mesh::features::with_creases(flat, 40.0, &[]);
    assert_eq!(from_tets(&creased).unwrap().creases().len(), 2 * creased.creases().len());
}

#[test]
fn impossible_shapes_are_refused() {
    let refused = |result: Result<HexMesh, HexError>| assert!(matches!(result, Err(HexError::Generator(_))));
    refused(prism(2, 1.0, 1.0, [1, 1]));
    refused(prism(5, 1.0, 1.0, [usize::MAX, 2]));
    refused(prism(5, f64::NAN, 1.0, [1, 1]));
    refused(cylinder(1.0, 1.0, [2, 0, 1]));
    refused(cylinder(1.0, 1e-300, [usize::MAX, usize::MAX, 1]));
    refused(tube([2.0, 1.0], 1.0, [1, 8, 1], false));
    refused(tube([1.0, 2.0], 1.0, [1, 2, 1], false));
    refused(sphere_shell([1.0, 2.0], [0, 1], true));
    refused(sphere_shell([0.0, 2.0], [1, 1], true));
    refused(tunnel([1.0; 3], [3, 3, 1], [2, 1]));
    refused(box_hexes([1.0; 3], [0, 1, 1]));
}
