//! Sqrt(3) subdivision: what must hold after every step, on generated meshes, random selections and the papers' tripod.
//!
//! `TetMesh::new` itself checks after every step that all cells are positive and that the boundary faces are exactly
//! the boundary, so a step that returns has kept both.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use proptest::prelude::*;
use subsolid::mesh::{TetMesh, features, generate, quality, read, topology};
use subsolid::subdiv::options::{Boundary, Options, Scheme};
use subsolid::subdiv::{self, History, Refined};

const BOUNDARIES: [Boundary; 3] = [Boundary::Fixed, Boundary::Approximating, Boundary::Interpolating];

fn options(boundary: Boundary) -> Options {
    Options { scheme: Scheme::Sqrt3, boundary, ..Options::default() }
}

fn unit_box(n: usize) -> TetMesh {
    features::with_creases(generate::box_tets([1.0; 3], [n; 3]).unwrap(), 40.0, &[])
}

/// A box of two regions that meet at x = 0.5.
fn two_regions(n: usize) -> TetMesh {
    let mut parts = unit_box(n).into_parts();
    parts.region_names.push("right".to_owned());
    for (t, tet) in parts.tets.iter().enumerate() {
        let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        parts.regions[t].0 = u16::from(x > 0.5);
    }
    features::with_creases(TetMesh::new(parts).unwrap(), 40.0, &[])
}

fn refine_all(mesh: &TetMesh, history: &History, boundary: Boundary) -> Refined {
    subdiv::refine(mesh, history, &vec![true; mesh.tets().len()], &options(boundary)).unwrap()
}

fn group_area(mesh: &TetMesh, name: &str) -> f64 {
    let group = mesh.group(name).unwrap();
    mesh.group_faces(group).map(|f| 0.5 * features::face_normal(mesh.points(), f.vertices).length()).sum()
}

fn region_volume(mesh: &TetMesh, region: u16) -> f64 {
    (0..mesh.tets().len()).filter(|&t| mesh.regions()[t].0 == region).map(|t| mesh.cell_volume(t)).sum()
}

/// Euler's relation for a solid ball or a tripod with one handle: V - E + F - T with F = (4 T + B) / 2.
fn euler(mesh: &TetMesh) -> i64 {
    let count = |n: usize| i64::try_from(n).unwrap();
    let faces = (4 * mesh.tets().len() + mesh.faces().len()) / 2;
    count(mesh.points().len()) - count(topology::edges(mesh.tets()).len()) + count(faces) - count(mesh.tets().len())
}

fn assert_sound(before: &TetMesh, after: &Refined, volume_tolerance: f64) {
    let mesh = &after.mesh;
    assert_eq!(quality::quality(mesh).inverted, 0);
    assert!(after.info.worst_sine > 0.0);
    assert_eq!(euler(mesh), euler(before));
    assert!((mesh.volume() - before.volume()).abs() <= volume_tolerance * before.volume());
    let length = |m: &TetMesh| features::feature_count_and_length(m).1;
    assert!((length(mesh) - length(before)).abs() <= 1e-12 * length(before));
    let group_areas = |m: &TetMesh| m.groups().iter().map(|g| group_area(m, g)).collect::<Vec<_>>();
    for (old, new) in group_areas(before).iter().zip(group_areas(mesh)) {
        assert!((old - new).abs() <= 1e-12 * old, "a group's area changed from {old} to {new}");
    }
}

#[test]
fn uniform_steps_keep_a_box_with_its_groups_and_creases() {
    for boundary in BOUNDARIES {
        let (mut mesh, mut history) = (unit_box(2), History::default());
        for _ in 0..3 {
            let refined = refine_all(&mesh, &history, boundary);
            // The faces of a box are planar, so the smoothing rule keeps the volume too.
            assert_sound(&mesh, &refined, 1e-12);
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

#[test]
fn nodes_of_a_uniform_step_are_those_of_the_rules() {
    let mesh = unit_box(3);
    let boundary_edges = features::boundary_edges(mesh.faces()).len();
    let fixed = refine_all(&mesh, &History::default(), Boundary::Fixed).mesh;
    assert_eq!(fixed.points().len(), mesh.points().len() + mesh.tets().len() + boundary_edges);
    assert_eq!(fixed.faces().len(), 4 * mesh.faces().len());

    let first = refine_all(&mesh, &History::default(), Boundary::Approximating);
    assert_eq!(first.mesh.points().len(), mesh.points().len() + mesh.tets().len() + mesh.faces().len());
    assert_eq!(first.mesh.faces().len(), 3 * mesh.faces().len());
    assert_eq!(first.mesh.creases(), mesh.creases(), "creases wait in an odd step");
    let second = refine_all(&first.mesh, &first.history, Boundary::Approximating).mesh;
    assert_eq!(second.creases().len(), 3 * mesh.creases().len(), "and are trisected in an even one");
    let centres = first.mesh.tets().len() + first.mesh.faces().len();
    // Each crease takes two centres (its faces get none) and gives two thirds.
    assert_eq!(second.points().len(), first.mesh.points().len() + centres);
    assert_eq!(second.faces().len(), 9 * mesh.faces().len());
}

#[test]
fn a_closed_smooth_surface_follows_the_rule_of_kobbelt() {
    // A box whose creases are ignored: every boundary vertex is smooth.
    let mesh = features::with_creases(generate::box_tets([1.0; 3], [3; 3]).unwrap(), 180.0, &[]);
    let mut parts = mesh.into_parts();
    (parts.groups, parts.patches) = (Vec::new(), vec![Vec::new()]);
    parts.creases.clear();
    for face in &mut parts.faces {
        face.patch.0 = 0;
    }
    let mesh = TetMesh::new(parts).unwrap();
    let refined = refine_all(&mesh, &History::default(), Boundary::Approximating);
    let mut neighbours = vec![Vec::new(); mesh.points().len()];
    for (edge, _) in features::boundary_edges(mesh.faces()) {
        neighbours[edge[0] as usize].push(mesh.points()[edge[1] as usize]);
        neighbours[edge[1] as usize].push(mesh.points()[edge[0] as usize]);
    }
    let mut arrived = 0;
    for (v, around) in neighbours.iter().enumerate().filter(|(_, n)| !n.is_empty()) {
        let n = around.len() as f64;
        let alpha = (4.0 - 2.0 * (2.0 * std::f64::consts::PI / n).cos()) / 9.0;
        let mean = around.iter().copied().sum::<DVec3>() / n;
        let expected = mesh.points()[v] * (1.0 - alpha) + mean * alpha;
        arrived += usize::from((refined.mesh.points()[v] - expected).length() < 1e-14);
    }
    let smooth = neighbours.iter().filter(|n| !n.is_empty()).count();
    assert_eq!(arrived, smooth - refined.info.rejected, "every vertex arrives, or is counted as rejected");
    assert_eq!(refined.info.rejected, 0);
    // New boundary vertices are barycentres of old faces.
    let centres: Vec<DVec3> = mesh
        .faces()
        .iter()
        .map(|f| f.vertices.iter().map(|&v| mesh.points()[v as usize]).sum::<DVec3>() / 3.0)
        .collect();
    let first_new = mesh.points().len() as u32;
    let mut new: Vec<u32> = refined.mesh.faces().iter().flat_map(|f| f.vertices).filter(|&v| v >= first_new).collect();
    new.sort_unstable();
    new.dedup();
    assert_eq!(new.len(), centres.len());
    for v in new {
        assert!(centres.iter().any(|c| (refined.mesh.points()[v as usize] - *c).length() < 1e-14));
    }
}

#[test]
fn regions_keep_their_volumes_and_stay_conforming() {
    let (mut mesh, mut history) = (two_regions(2), History::default());
    for step in 0..3 {
        let selected: Vec<bool> = (0..mesh.tets().len()).map(|t| step == 0 || t % 3 == 0).collect();
        let refined = subdiv::refine(&mesh, &history, &selected, &options(Boundary::Fixed)).unwrap();
        assert_sound(&mesh, &refined, 1e-12);
        for region in [0, 1] {
            assert!((region_volume(&refined.mesh, region) - 0.5).abs() < 1e-12);
        }
        (mesh, history) = (refined.mesh, refined.history);
    }
}

#[test]
fn an_empty_selection_changes_nothing() {
    let mesh = unit_box(2);
    for boundary in BOUNDARIES {
        let none = vec![false; mesh.tets().len()];
        let refined = subdiv::refine(&mesh, &History::default(), &none, &options(boundary)).unwrap();
        assert_eq!(refined.mesh.tets(), mesh.tets());
        assert_eq!(refined.mesh.points(), mesh.points());
        assert_eq!(refined.history, History::default());
    }
}

#[test]
fn refining_one_corner_again_and_again_keeps_the_mesh_sound_and_graded() {
    for boundary in BOUNDARIES {
        let (mut mesh, mut history) = (unit_box(2), History::default());
        for _ in 0..5 {
            let at_corner: Vec<bool> =
                mesh.tets().iter().map(|t| t.iter().any(|&v| mesh.points()[v as usize].length() < 1e-9)).collect();
            let refined = subdiv::refine(&mesh, &history, &at_corner, &options(boundary)).unwrap();
            assert_sound(&mesh, &refined, 1e-12);
            (mesh, history) = (refined.mesh, refined.history);
        }
        let levels = |t: &[u32; 4]| t.iter().any(|&v| mesh.points()[v as usize].length() < 1e-9);
        let finest = mesh.tets().iter().zip(mesh.levels()).filter(|(t, _)| levels(t)).map(|(_, l)| *l).min();
        assert_eq!(finest, Some(5), "cells at the corner were refined in every step");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_selections_on_a_random_box_leave_a_sound_mesh(
        seeds in proptest::collection::vec(any::<u64>(), 3),
        jitter in 0.0..0.18_f64,
        boundary in prop::sample::select(BOUNDARIES.to_vec()),
        share in 1_u64..9,
    ) {
        let mut parts = unit_box(3).into_parts();
        for p in &mut parts.points {
            // Interior vertices only: the faces stay planar, so the volume must be kept exactly.
            let inside = p.min_element() > 0.1 && p.max_element() < 0.9;
            let wave = DVec3::new((37.0 * p.y + 3.0).sin(), (41.0 * p.z).cos(), (43.0 * p.x + 1.0).sin());
            *p += if inside { jitter / 3.0 * wave } else { DVec3::ZERO };
        }
        let (mut mesh, mut history) = (TetMesh::new(parts).unwrap(), History::default());
        for seed in seeds {
            let random = |t: u64| (t + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(seed).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 33;
            let selected: Vec<bool> = (0..mesh.tets().len() as u64).map(|t| random(t) % 10 < share && t % 7 < 3).collect();
            let refined = subdiv::refine(&mesh, &history, &selected, &options(boundary)).unwrap();
            assert_sound(&mesh, &refined, 1e-12);
            prop_assert!(refined.info.split >= refined.info.asked);
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

#[test]
fn the_same_input_gives_the_same_mesh() {
    let mesh = unit_box(3);
    let selected: Vec<bool> = (0..mesh.tets().len()).map(|t| t % 5 == 0).collect();
    let run = || subdiv::refine(&mesh, &History::default(), &selected, &options(Boundary::Approximating)).unwrap();
    let (a, b) = (run(), run());
    assert_eq!(a.mesh.tets(), b.mesh.tets());
    assert_eq!(a.mesh.points(), b.mesh.points());
    assert_eq!(a.history, b.history);
}

/// The paper's own mesh (2010, Table 1): counts are exact, quality must beat the paper's 6.1 and 4.9 degrees by far.
#[test]
fn two_uniform_steps_on_the_tripod() {
    let Some(folder) = std::env::var_os("SUBSOLID_DATA") else {
        eprintln!("skipped: SUBSOLID_DATA is not set, so there is no tripod to refine");
        return;
    };
    let input = read::read(&std::path::Path::new(&folder).join("tripod.GiD.msh")).unwrap().mesh;
    let (mut mesh, mut history) = (features::with_creases(input, 70.0, &[]), History::default());
    let (count, length) = features::feature_count_and_length(&mesh);
    assert_eq!(count, 294);
    for (nodes, features, worst) in [(Some(5_476), 294, 13.0), (None, 882, 10.0)] {
        let refined = refine_all(&mesh, &history, Boundary::Approximating);
        (mesh, history) = (refined.mesh, refined.history);
        let found = features::feature_count_and_length(&mesh);
        assert_eq!(found.0, features);
        assert!((found.1 - length).abs() < 1e-12 * length);
        assert_eq!(euler(&mesh), 0, "one handle");
        assert!(nodes.is_none_or(|n| n == mesh.points().len()));
        let quality = quality::quality(&mesh);
        assert!(quality.inverted == 0 && quality.worst >= worst, "{quality:?}");
    }
}
