//! Generated bodies: their volume, their groups, their creases.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use std::f64::consts::PI;
use subsolid::fem::{Space, options::Element};
use subsolid::mesh::features::{face_normal, feature_count_and_length, with_creases};
use subsolid::mesh::generate::{Curved, cylinder, fichera, l_prism, le10, plate_with_hole, prism, sphere_shell, tube};
use subsolid::mesh::{MeshError, TetMesh};

/// Every face of the boundary belongs to exactly one group, no group is empty, and groups close up: the sum of their
/// vector areas is zero.
fn check_groups(mesh: &TetMesh) {
    let mut faces = 0;
    for name in mesh.groups() {
        let count = mesh.group_faces(mesh.group(name).unwrap()).count();
        assert!(count > 0, "{name} is empty");
        faces += count;
    }
    assert_eq!(faces, mesh.faces().len());
}

/// The vector area of a group, pointing outward.
fn area(mesh: &TetMesh, group: &str) -> DVec3 {
    mesh.group_faces(mesh.group(group).unwrap()).map(|f| 0.5 * face_normal(mesh.points(), f.vertices)).sum()
}

/// The order with which the volume converges as the cells are halved: chords give two.
fn order(coarse: &TetMesh, fine: &TetMesh, exact: f64) -> f64 {
    let [a, b] = [coarse, fine].map(|m| exact - m.volume());
    assert!(a.abs() < 0.1 * exact, "volume {} for {exact}", coarse.volume());
    (a / b).log2()
}

#[test]
fn notched_bodies_have_their_volume_their_faces_and_their_edges() {
    for n in 1..4 {
        let (prism, corner) = (l_prism(n).unwrap(), fichera(n).unwrap());
        check_groups(&prism);
        check_groups(&corner);
        assert!((prism.volume() - 3.0).abs() < 1e-12 && (corner.volume() - 7.0).abs() < 1e-12);
        assert!((area(&prism, "notch-x") - DVec3::NEG_X).length() < 1e-12);
        assert!((area(&prism, "x-min") - DVec3::NEG_X).length() < 1e-12);
        assert!((area(&prism, "x-max") - 2.0 * DVec3::X).length() < 1e-12);
        assert!((area(&corner, "notch-z") - DVec3::Z).length() < 1e-12);
        assert!((area(&corner, "z-max") - 3.0 * DVec3::Z).length() < 1e-12);
        // Two L-shaped ends of perimeter 8 and six edges along; a cube's 24 with three more of length 1, for a corner that
        // was cut out keeps the length of the edges.
        let length = |mesh| feature_count_and_length(&with_creases(mesh, 40.0, &[])).1;
        assert!((length(prism) - 22.0).abs() < 1e-12 && (length(corner) - 30.0).abs() < 1e-12);
    }
}

#[test]
fn prisms_have_the_volume_of_their_polygon_and_their_valence_at_the_axis() {
    for (sides, cells) in [(3, [1, 1]), (5, [3, 2]), (7, [2, 3]), (24, [1, 4])] {
        let mesh = prism(sides, 1.5, 2.0, cells).unwrap();
        let [rings, layers] = cells;
        check_groups(&mesh);
        assert_eq!(mesh.tets().len(), 3 * sides * rings * rings * layers);
        let end = 0.5 * sides as f64 * 1.5 * 1.5 * (2.0 * PI / sides as f64).sin();
        assert!((mesh.volume() - 2.0 * end).abs() < 1e-12 * end, "{sides} sides: {}", mesh.volume());
        assert!((area(&mesh, "z-max") - end * DVec3::Z).length() < 1e-12 && area(&mesh, "side").length() < 1e-12);
        // The triangles of an end that meet at the axis.
        let axis = |v: &u32| mesh.points()[*v as usize].truncate().length() < 1e-12;
        let top = mesh.group("z-max").unwrap();
        assert_eq!(mesh.group_faces(top).filter(|f| f.vertices.iter().any(axis)).count(), sides);
    }
    for (sides, radius, cells) in [(2, 1.0, [1, 1]), (5, 0.0, [1, 1]), (5, 1.0, [0, 1]), (5, 1.0, [9999, 9999])] {
        assert!(matches!(prism(sides, radius, 1.0, cells), Err(MeshError::Generator(_))));
    }
}

#[test]
fn round_bodies_converge_to_their_volume_with_second_order() {
    let cylinders = [2, 4].map(|n| cylinder(1.5, 3.0, [2 * n, n]).unwrap().mesh);
    let tubes = [8, 16].map(|n| tube([1.0, 2.0], 0.5, [2, n, 1], false).unwrap().mesh);
    let shells = [3, 6].map(|n| sphere_shell([1.0, 2.0], [n, n]).unwrap().mesh);
    let plates = [2, 4].map(|n| plate_with_hole(1.0, 4.0, 0.5, [2 * n, n, 1]).unwrap().mesh);
    let ellipses = [4, 8].map(|n| le10([n, n, 2]).unwrap().mesh);
    for (meshes, exact) in [
        (&cylinders, PI * 1.5 * 1.5 * 3.0),
        (&tubes, PI * 3.0 * 0.5),
        (&shells, 4.0 / 3.0 * PI * 7.0 / 8.0),
        (&plates, 0.5 * (16.0 - PI / 4.0)),
        (&ellipses, 0.6 * PI / 4.0 * (3.25 * 2.75 - 2.0)),
    ] {
        meshes.iter().for_each(check_groups);
        let order = order(&meshes[0], &meshes[1], exact);
        assert!((order - 2.0).abs() < 0.25, "order {order} towards {exact}");
    }
}

#[test]
fn curved_groups_lie_on_their_surfaces_and_flat_ones_in_their_planes() {
    let on = |mesh: &TetMesh, group: &str, far: &dyn Fn(DVec3) -> f64| {
        for v in mesh.group_faces(mesh.group(group).unwrap()).flat_map(|f| f.vertices) {
            let p = mesh.points()[v as usize];
            assert!(far(p).abs() < 1e-12, "{group} at {p}");
        }
    };
    let flat = |p: DVec3| p.truncate().length();
    let rod = cylinder(1.5, 3.0, [3, 2]).unwrap().mesh;
    on(&rod, "side", &|p| flat(p) - 1.5);
    on(&rod, "z-max", &|p| p.z - 3.0);
    let tube = tube([1.0, 2.0], 0.5, [2, 7, 1], false).unwrap().mesh;
    on(&tube, "inner", &|p| flat(p) - 1.0);
    on(&tube, "outer", &|p| flat(p) - 2.0);
    let shell = sphere_shell([1.0, 2.0], [3, 2]).unwrap().mesh;
    on(&shell, "inner", &|p| p.length() - 1.0);
    on(&shell, "outer", &|p| p.length() - 2.0);
    for (group, axis) in [("x-min", 0), ("y-min", 1), ("z-min", 2)] {
        on(&shell, group, &|p| p[axis]);
    }
    let plate = plate_with_hole(1.0, 4.0, 0.5, [4, 3, 2]).unwrap().mesh;
    on(&plate, "hole", &|p| flat(p) - 1.0);
    on(&plate, "x-max", &|p| p.x - 4.0);
    on(&plate, "y-max", &|p| p.y - 4.0);
    on(&plate, "x-min", &|p| p.x);
    assert!((area(&plate, "y-max") - 2.0 * DVec3::Y).length() < 1e-12);
    let le10 = le10([3, 5, 2]).unwrap().mesh;
    on(&le10, "inner", &|p| (p.x / 2.0).powi(2) + p.y.powi(2) - 1.0);
    on(&le10, "outer", &|p| (p.x / 3.25).powi(2) + (p.y / 2.75).powi(2) - 1.0);
    on(&le10, "y-min", &|p| p.y);
    assert!((area(&le10, "y-min") + 1.25 * 0.6 * DVec3::Y).length() < 1e-12);
}

/// At an angle between that of the facets and a right one, the creases are the rims alone.
#[test]
fn creases_of_round_bodies_are_their_rims() {
    let length = |mesh: TetMesh| feature_count_and_length(&with_creases(mesh, 50.0, &[])).1;
    let polygon = |n: f64, r: f64| 2.0 * n * r * (PI / n).sin();
    let rims = length(tube([1.0, 2.0], 0.5, [2, 12, 1], false).unwrap().mesh);
    assert!((rims - 2.0 * (polygon(12.0, 1.0) + polygon(12.0, 2.0))).abs() < 1e-9, "{rims}");
    // Rings of four straight eighths each.
    let rod = length(cylinder(1.0, 2.0, [8, 4]).unwrap().mesh);
    assert!((rod - 4.0 * PI).abs() < 0.02 * rod, "{rod}");
    // Two spherical triangles of three quarter circles, and the three edges between them.
    let shell = length(sphere_shell([1.0, 2.0], [8, 8]).unwrap().mesh);
    assert!((shell - (3.0 * PI / 2.0 * 3.0 + 3.0)).abs() < 0.02 * shell, "{shell}");
}

#[test]
fn impossible_bodies_are_refused_by_name() {
    let mesh = |curved: Result<Curved, MeshError>| curved.map(|c| c.mesh);
    let cases: [(&str, Result<TetMesh, MeshError>); 10] = [
        ("L-prism", l_prism(0)),
        ("Fichera", fichera(usize::MAX)),
        ("radius", mesh(cylinder(0.0, 1.0, [1, 1]))),
        ("cylinder", mesh(cylinder(1.0, 1.0, [1, 0]))),
        ("wall", mesh(tube([2.0, 1.0], 1.0, [1, 8, 1], false))),
        ("three", mesh(tube([1.0, 2.0], 1.0, [1, 2, 1], false))),
        ("tube", mesh(tube([1.0, 2.0], 1.0, [1, 0, 1], true))),
        ("shell", mesh(sphere_shell([1.0, 2.0], [0, 1]))),
        ("size minus the radius", mesh(plate_with_hole(4.0, 4.0, 1.0, [1, 1, 1]))),
        ("LE10", mesh(le10([1, 0, 1]))),
    ];
    for (words, result) in cases {
        let Err(MeshError::Generator(message)) = result else { panic!("{words} accepted") };
        assert!(message.contains(words), "{message}");
    }
}

/// The volume of a body with curved edges: of the quadratic maps of its cells.
fn curved_volume(body: &Curved) -> f64 {
    let space = Space::new(&body.mesh, Element::Tet10, &body.midsides);
    (0..body.mesh.tets().len()).flat_map(|t| space.cell_rule(t)).map(|(.., volume)| volume).sum()
}

/// With curved edges the surface is of second degree: the volume converges with order four, where chords give two. All nodes
/// of round surfaces lie on them, those across the seam of a tube too, and no cell is folded.
#[test]
fn curved_bodies_converge_to_their_volume_with_fourth_order() {
    let bodies = [
        ([3, 6].map(|n| cylinder(1.5, 3.0, [n, n])), 6.75 * PI),
        ([8, 16].map(|n| tube([1.0, 2.0], 0.5, [2, n, 1], false)), 1.5 * PI),
        ([2, 4].map(|n| tube([1.0, 2.0], 0.5, [2, n, 1], true)), 0.375 * PI),
        ([2, 4].map(|n| sphere_shell([1.0, 2.0], [n, n])), 7.0 * PI / 6.0),
        ([2, 4].map(|n| plate_with_hole(1.0, 4.0, 0.5, [2 * n, n, 1])), 0.5 * (16.0 - 0.25 * PI)),
        ([3, 6].map(|n| le10([n, n, 2])), 0.6 * 0.25 * PI * (3.25 * 2.75 - 2.0)),
    ];
    for ([coarse, fine], exact) in bodies {
        let [coarse, fine] = [coarse, fine].map(|b| b.unwrap().unfolded().unwrap());
        let [a, b] = [&coarse, &fine].map(|body| exact - curved_volume(body));
        let order = (a / b).abs().log2();
        assert!((3.6..4.6).contains(&order), "{a:e} and {b:e} of {exact}: order {order}");
    }
    let tube = tube([1.0, 2.0], 0.5, [1, 5, 1], false).unwrap();
    let radius = |x: DVec3| x.truncate().length();
    let vertex = |v: u32| radius(tube.mesh.points()[v as usize]);
    let inside = tube.midsides.iter().filter(|m| m.edge.iter().all(|&v| (vertex(v) - 1.0).abs() < 1e-12));
    assert!(inside.clone().count() == 15 && inside.clone().all(|m| (radius(m.position) - 1.0).abs() < 1e-12));
}

#[test]
fn a_body_whose_curved_cells_fold_is_refused() {
    let rough = sphere_shell([1.0, 2.0], [1, 6]).unwrap().unfolded();
    assert!(matches!(rough, Err(MeshError::Generator(message)) if message.contains("folded")));
}
