//! Mode "best", objective "quality": what it must reach, and what it must not touch.
//!
//! `TetMesh::new` itself checks after every step that all cells are positive and that the boundary faces are exactly
//! the boundary, so a step that returns has kept both.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use proptest::prelude::*;
use subsolid::mesh::quality::{Quality, quality};
use subsolid::mesh::{TetMesh, features, generate, read};
use subsolid::subdiv::options::{Boundary, Mode, Objective, Optimise, Options, QualityMeasure, Scheme};
use subsolid::subdiv::{self, History, Refined};

const BEST: Optimise = Optimise {
    mode: Mode::Best,
    objective: Objective::Quality,
    directions: true,
    measure: QualityMeasure::MinSine,
    passes: 3,
    target_angle: 32.0,
    valence_limit: 50,
};

fn step(mesh: &TetMesh, history: &History, selected: &[bool], boundary: Boundary) -> Refined {
    let options = Options { boundary, optimise: BEST, ..Options::default() };
    subdiv::refine(mesh, history, selected, &options).unwrap()
}

/// A box of two regions that meet at x = 0.5, its inner vertices moved by up to `jitter`.
fn two_regions(n: usize, jitter: f64) -> TetMesh {
    let mut parts = generate::box_tets([1.0; 3], [n; 3]).unwrap().into_parts();
    parts.region_names.push("right".to_owned());
    for (t, tet) in parts.tets.iter().enumerate() {
        let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
        parts.regions[t].0 = u16::from(x > 0.5);
    }
    for p in &mut parts.points {
        let inside = p.min_element() > 0.1 && p.max_element() < 0.9 && (p.x - 0.5).abs() > 0.1;
        let wave = DVec3::new((37.0 * p.y + 3.0).sin(), (41.0 * p.z).cos(), (43.0 * p.x + 1.0).sin());
        *p += if inside { jitter * wave } else { DVec3::ZERO };
    }
    features::with_creases(TetMesh::new(parts).unwrap(), 40.0, &[])
}

fn unit_box(n: usize) -> TetMesh {
    features::with_creases(generate::box_tets([1.0; 3], [n; 3]).unwrap(), 40.0, &[])
}

fn tripod() -> Option<TetMesh> {
    let Some(folder) = std::env::var_os("SUBSOLID_DATA") else {
        eprintln!("skipped: SUBSOLID_DATA is not set, so there is no tripod to refine");
        return None;
    };
    let input = read::read(&std::path::Path::new(&folder).join("tripod.GiD.msh")).unwrap().mesh;
    Some(features::with_creases(input, 70.0, &[]))
}

fn group_areas(mesh: &TetMesh) -> Vec<f64> {
    let area = |name: &String| {
        let faces = mesh.group_faces(mesh.group(name).unwrap());
        faces.map(|f| 0.5 * features::face_normal(mesh.points(), f.vertices).length()).sum()
    };
    mesh.groups().iter().map(area).collect()
}

fn region_volumes(mesh: &TetMesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.region_names().len()];
    for t in 0..mesh.tets().len() {
        volumes[mesh.regions()[t].0 as usize] += mesh.cell_volume(t);
    }
    volumes
}

/// The solid is the same: regions, groups and features have kept their volumes, areas and lengths.
fn assert_same_solid(before: &TetMesh, after: &TetMesh) {
    let close = |old: f64, new: f64| assert!((old - new).abs() <= 1e-12 * old.max(1.0), "{old} became {new}");
    for (old, new) in region_volumes(before).into_iter().zip(region_volumes(after)) {
        close(old, new);
    }
    for (old, new) in group_areas(before).into_iter().zip(group_areas(after)) {
        close(old, new);
    }
    close(features::feature_count_and_length(before).1, features::feature_count_and_length(after).1);
}

fn assert_reaches(mesh: &TetMesh, worst: f64, average: f64) {
    let q = quality(mesh);
    assert!(q.worst >= worst && q.average >= average && q.max_valence <= 65 && q.inverted == 0, "{q:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn random_selections_leave_the_same_solid(
        seeds in proptest::collection::vec(any::<u64>(), 2),
        jitter in 0.0..0.06_f64,
        fixed in any::<bool>(),
        share in 1_u64..9,
    ) {
        let (mut mesh, boundary) = if fixed {
            (two_regions(4, jitter), Boundary::Fixed)
        } else {
            (unit_box(3), Boundary::Approximating)
        };
        let mut history = History::default();
        for seed in seeds {
            let random = |t: u64| (t + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(seed).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 33;
            let selected: Vec<bool> = (0..mesh.tets().len() as u64).map(|t| random(t) % 10 < share && t % 7 < 3).collect();
            let refined = step(&mesh, &history, &selected, boundary);
            assert_same_solid(&mesh, &refined.mesh);
            prop_assert_eq!(quality(&refined.mesh).inverted, 0);
            (mesh, history) = (refined.mesh, refined.history);
        }
    }
}

#[test]
fn red_refinement_can_be_optimised_too() {
    let mesh = two_regions(4, 0.06);
    let red = Options { scheme: Scheme::Red, ..Options::default() };
    let refined = subdiv::refine(&mesh, &History::default(), &vec![true; mesh.tets().len()], &red).unwrap().mesh;
    let better = subdiv::optimise_quality(&refined, &BEST).unwrap();
    assert_same_solid(&mesh, &better);
    let (before, after) = (quality(&refined), quality(&better));
    assert!(after.worst > before.worst.min(26.0) && after.average > before.average, "{before:?} {after:?}");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let mesh = unit_box(4);
    let selected: Vec<bool> = (0..mesh.tets().len()).map(|t| t % 5 != 0).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| step(&mesh, &History::default(), &selected, Boundary::Approximating))
    };
    let one = run(1);
    for threads in [2, 8] {
        let many = run(threads);
        assert_eq!(one.mesh.tets(), many.mesh.tets());
        assert_eq!(one.mesh.points(), many.mesh.points());
        assert_eq!(one.history, many.history);
    }
}

/// Refines the cells at one vertex again and again; the quality at each level, worst first.
fn ten_levels(mesh: &TetMesh, at: DVec3, boundary: Boundary) {
    let near = |p: &&DVec3| (**p - at).length();
    let v = mesh.points().iter().min_by(|p, q| near(p).total_cmp(&near(q))).copied().unwrap();
    let v = mesh.points().iter().position(|p| *p == v).unwrap() as u32;
    let (mut mesh, mut history) = (mesh.clone(), History::default());
    let mut levels: Vec<Quality> = Vec::new();
    for _ in 0..10 {
        let selected: Vec<bool> = mesh.tets().iter().map(|t| t.contains(&v)).collect();
        let refined = step(&mesh, &history, &selected, boundary);
        (mesh, history) = (refined.mesh, refined.history);
        levels.push(quality(&mesh));
    }
    let worst = levels.iter().map(|q| q.worst).fold(f64::INFINITY, f64::min);
    let valence = levels.iter().map(|q| q.max_valence).max().unwrap();
    println!("{boundary:?} {at}: worst {worst:.1}, valence {valence}, {} cells", mesh.tets().len());
    assert!(worst >= 17.0 && valence <= 70, "{levels:#?}");
}

#[test]
fn ten_levels_at_one_vertex_of_a_box_keep_their_quality() {
    for boundary in [Boundary::Fixed, Boundary::Approximating] {
        for at in [DVec3::splat(0.5), DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.5, 0.0, 0.0), DVec3::ZERO] {
            ten_levels(&unit_box(4), at, boundary);
        }
    }
}

/// An interior vertex, one on the smooth boundary, one inside a crease, and one where creases meet.
fn kinds(mesh: &TetMesh) -> [DVec3; 4] {
    let mut creases = vec![0; mesh.points().len()];
    for v in mesh.creases().iter().flat_map(|c| c.vertices) {
        creases[v as usize] += 1;
    }
    let mut boundary = vec![false; mesh.points().len()];
    for v in mesh.faces().iter().flat_map(|f| f.vertices) {
        boundary[v as usize] = true;
    }
    let first = |on: bool, least: usize, most: usize| {
        let found = (0..creases.len()).find(|&v| boundary[v] == on && (least..=most).contains(&creases[v]));
        mesh.points()[found.unwrap()]
    };
    [first(false, 0, 0), first(true, 0, 0), first(true, 2, 2), first(true, 3, 9)]
}

#[test]
fn ten_levels_at_one_vertex_of_the_tripod_keep_their_quality() {
    let Some(mesh) = tripod() else { return };
    let mesh = step(&mesh, &History::default(), &vec![true; mesh.tets().len()], Boundary::Fixed).mesh;
    for boundary in [Boundary::Fixed, Boundary::Approximating] {
        for at in kinds(&mesh) {
            ten_levels(&mesh, at, boundary);
        }
    }
}

/// The targets of the first step on the papers' tripod, and of both steps where the second is asked for.
fn tripod_steps(boundary: Boundary, targets: &[(f64, f64)]) {
    let Some(mut mesh) = tripod() else { return };
    let (mut history, length) = (History::default(), features::feature_count_and_length(&mesh).1);
    for &(worst, average) in targets {
        let refined = step(&mesh, &history, &vec![true; mesh.tets().len()], boundary);
        (mesh, history) = (refined.mesh, refined.history);
        assert_reaches(&mesh, worst, average);
        assert!((features::feature_count_and_length(&mesh).1 - length).abs() < 1e-12 * length);
    }
}

#[test]
fn the_tripod_reaches_its_quality_in_one_step() {
    tripod_steps(Boundary::Approximating, &[(25.0, 43.0)]);
    // Better than the improvers of Gmsh (20.5) and mmg3d (16.6) after red refinement.
    tripod_steps(Boundary::Fixed, &[(20.6, 43.0)]);
}

#[test]
#[ignore = "a minute in an unoptimised build"]
fn the_tripod_keeps_its_quality_in_a_second_step() {
    tripod_steps(Boundary::Approximating, &[(25.0, 43.0), (24.0, 41.0)]);
    tripod_steps(Boundary::Fixed, &[(20.6, 43.0), (18.7, 41.0)]);
}
