//! The error-driven optimiser: what it keeps, what it lowers, how weights are carried over.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use subsolid::mesh::{TetMesh, features, generate, quality};
use subsolid::subdiv::options::{Mode, Objective, Optimise, Options, Scheme};
use subsolid::subdiv::{self, Directions, History, Weights};

fn unit_box(n: usize) -> TetMesh {
    features::with_creases(generate::box_tets([1.0; 3], [n; 3]).unwrap(), 40.0, &[])
}

/// A box of two regions that meet at x = 0.5, refined at the selected cells.
fn refined(scheme: Scheme, regions: bool, selected: impl Fn(usize) -> bool) -> (TetMesh, Vec<subdiv::Stencil>) {
    let mut parts = unit_box(2).into_parts();
    if regions {
        parts.region_names.push("right".to_owned());
        for (t, tet) in parts.tets.iter().enumerate() {
            let x = tet.iter().map(|&v| parts.points[v as usize].x).sum::<f64>() / 4.0;
            parts.regions[t].0 = u16::from(x > 0.5);
        }
    }
    let mesh = features::with_creases(TetMesh::new(parts).unwrap(), 40.0, &[]);
    let selected: Vec<bool> = (0..mesh.tets().len()).map(selected).collect();
    let options = Options { scheme, ..Options::default() };
    let refined = subdiv::refine(&mesh, &History::default(), &selected, &options).unwrap();
    (refined.mesh, refined.transfer)
}

fn weighted_cost(mesh: &TetMesh, weights: &[f64]) -> f64 {
    let weight = |tet: &[u32; 4]| tet.iter().map(|&v| weights[v as usize]).sum::<f64>() / 4.0;
    mesh.tets().iter().enumerate().map(|(t, tet)| weight(tet) * subdiv::cell_cost(mesh.cell_points(t))).sum()
}

fn measures(mesh: &TetMesh) -> Vec<f64> {
    let area = |name: &String| {
        let group = mesh.group(name).unwrap();
        mesh.group_faces(group).map(|f| features::face_normal(mesh.points(), f.vertices).length()).sum::<f64>()
    };
    let region = |r: usize| {
        let cells = (0..mesh.tets().len()).filter(|&t| mesh.regions()[t].0 as usize == r);
        cells.map(|t| mesh.cell_volume(t)).sum::<f64>()
    };
    let mut all: Vec<f64> = mesh.groups().iter().map(area).collect();
    all.extend((0..mesh.region_names().len()).map(region));
    all.push(features::feature_count_and_length(mesh).1);
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn the_cost_falls_and_the_solid_its_groups_regions_and_features_stay(
        seed in 1_u64..1_000_000,
        red in any::<bool>(),
        regions in any::<bool>(),
    ) {
        let random = |i: u64| (i + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_mul(seed) >> 40;
        let scheme = if red { Scheme::Red } else { Scheme::Sqrt3 };
        let (mesh, _) = refined(scheme, regions, |t| red || random(t as u64) % 3 > 0);
        let weights: Vec<f64> = (0..mesh.points().len()).map(|v| 1.0 + (random(v as u64) % 100) as f64).collect();
        // TetMesh::new inside checks that all cells are positive and the boundary is complete.
        let factors = Weights::Factors(weights.clone());
        let run = |first: usize| subdiv::optimise_error(&mesh, &factors, 3, first).unwrap();
        let all = run(mesh.points().len());
        prop_assert_eq!(all.mesh.points().len(), mesh.points().len());
        prop_assert!(weighted_cost(&all.mesh, &weights) < weighted_cost(&mesh, &weights));
        let fewer = run(27);
        prop_assert!(fewer.kept.windows(2).all(|k| k[0] < k[1]) && fewer.kept[..27].iter().copied().eq(0..27));
        let constant = |mesh: &TetMesh, weights: &[f64]| weighted_cost(mesh, weights) * (mesh.points().len() as f64).powf(2.0 / 3.0);
        prop_assert!(constant(&fewer.mesh, &fewer.carry_over(&weights)) < constant(&mesh, &weights));
        let directions = |v: usize| Directions([0.1, weights[v], 1.0, 0.2, 0.0, 0.3]) * weights[v];
        let directions = Weights::Directions((0..mesh.points().len()).map(directions).collect());
        let directed = subdiv::optimise_error(&mesh, &directions, 3, 27).unwrap();
        for optimised in [&all.mesh, &fewer.mesh, &directed.mesh] {
            for (old, new) in measures(&mesh).into_iter().zip(measures(optimised)) {
                prop_assert!((old - new).abs() < 1e-12 * old, "{} {}", old, new);
            }
            let floor = quality::quality(&mesh).worst.min(14.99);
            prop_assert!(quality::quality(optimised).worst >= floor);
        }
    }
}

/// Vertices that refinement put on flat faces and straight creases go where nothing is to be gained by them, and only there.
#[test]
fn vertices_of_flat_surfaces_and_straight_creases_go_where_they_are_not_worth_their_price() {
    let (mesh, _) = refined(Scheme::Red, false, |_| true);
    let weights = mesh.points().iter().map(|p| if p.x < 0.5 { 1e4 } else { 1.0 }).collect();
    let optimised = subdiv::optimise_error(&mesh, &Weights::Factors(weights), 3, 27).unwrap().mesh;
    // On the front face or on one of its creases, left and right of the middle.
    let on = |mesh: &TetMesh, crease: bool, left: bool| {
        let is_on = |p: &&glam::DVec3| p.z == 0.0 && (p.y == 0.0) == crease && (p.x < 0.5) == left && p.y < 1.0;
        mesh.points().iter().filter(is_on).count()
    };
    for crease in [false, true] {
        let [before, after] = [&mesh, &optimised].map(|m| [true, false].map(|left| on(m, crease, left)));
        assert!(2 * after[1] < before[1] + 2 && after[0] > after[1], "{crease}: {before:?} {after:?}");
    }
    for (old, new) in measures(&mesh).into_iter().zip(measures(&optimised)) {
        assert!((old - new).abs() < 1e-12 * old, "{old} {new}");
    }
}

#[test]
fn the_same_input_gives_the_same_mesh_and_weights_move_vertices_where_they_are_large() {
    let (mesh, _) = refined(Scheme::Red, false, |_| true);
    let weights: Vec<f64> = mesh.points().iter().map(|p| if p.x < 0.5 { 100.0 } else { 1.0 }).collect();
    let weights = Weights::Factors(weights);
    let run = || subdiv::optimise_error(&mesh, &weights, 3, mesh.points().len()).unwrap().mesh;
    let (a, b) = (run(), run());
    assert_eq!((a.tets(), a.points()), (b.tets(), b.points()));
    let left = |m: &TetMesh| m.points().iter().map(|p| p.x).sum::<f64>();
    assert!(left(&a) < left(&mesh), "vertices gather where the weights are large");
}

/// Where the second derivatives are those of a function of x alone, cells become short along x and long across it, and
/// such a function is interpolated better than on any mesh without directions.
#[test]
fn cells_become_short_in_the_direction_of_the_second_derivatives() {
    let (mesh, _) = refined(Scheme::Sqrt3, false, |_| true);
    let squared: Vec<f64> = (0..mesh.tets().len()).map(|t| subdiv::cell_cost(mesh.cell_points(t))).collect();
    let along = |axis: usize| {
        let moment = std::array::from_fn(|i| f64::from(u8::from(i == axis)));
        let weights = Weights::directions(&mesh, &vec![moment; mesh.points().len()], &squared);
        subdiv::optimise_error(&mesh, &weights, 10, mesh.points().len()).unwrap().mesh
    };
    let none = subdiv::optimise_error(&mesh, &Weights::factors(&mesh, &squared), 10, mesh.points().len()).unwrap().mesh;
    // The mean square of the gradient's error of x_i^2 / 2 in the cells, by a rule exact for it: at the four vertices and
    // the centroid with weights 1 and 16.
    let error = |mesh: &TetMesh, axis: usize| {
        let cell = |t: usize| {
            let p = mesh.cell_points(t);
            let volume = quality::volume(p);
            let gradients = quality::face_normals(p).map(|n| n * (-1.0 / (6.0 * volume)));
            let slope = (0..4).fold(glam::DVec3::ZERO, |g, k| g + gradients[k] * (0.5 * p[k][axis].powi(2)));
            let centroid = p.iter().sum::<glam::DVec3>() / 4.0;
            let at = |x: glam::DVec3| {
                let mut exact = glam::DVec3::ZERO;
                exact[axis] = x[axis];
                (exact - slope).length_squared()
            };
            volume / 20.0 * (p.iter().map(|x| at(*x)).sum::<f64>() + 16.0 * at(centroid))
        };
        (0..mesh.tets().len()).map(cell).sum::<f64>()
    };
    for axis in 0..3 {
        let directed = along(axis);
        let (with, without) = (error(&directed, axis), error(&none, axis));
        assert!(with < 0.8 * without, "along {axis}: {with}, without directions {without}");
        assert!(error(&directed, (axis + 1) % 3) > without, "there is no free lunch");
    }
}

#[test]
fn linear_fields_are_carried_over_exactly_and_wrong_lengths_are_refused() {
    for scheme in [Scheme::Red, Scheme::Sqrt3] {
        // Fixed boundary without optimised positions: new vertices lie where their stencils say.
        let (mesh, transfer) = refined(scheme, false, |_| true);
        let old = mesh.points().len() - transfer.len();
        let field: Vec<f64> = (0..old).map(|v| 1.0 + v as f64).collect();
        let carried = subdiv::carry_over(&field, &transfer);
        assert_eq!(carried.len(), mesh.points().len());
        assert_eq!(&carried[..old], &field[..]);
        for (value, stencil) in carried[old..].iter().zip(&transfer) {
            assert!((stencil.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            let parents = stencil.vertices.map(|v| carried[v as usize]);
            let (low, high) = parents.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
            assert!((low..=high).contains(value), "a mean lies between its parents");
        }
        for wrong in [field, vec![-1.0; carried.len()], vec![f64::NAN; carried.len()]] {
            let directions = wrong.iter().map(|x| Directions([*x, 1.0, 1.0, 0.0, 0.0, 0.0])).collect();
            assert!(subdiv::optimise_error(&mesh, &Weights::Directions(directions), 1, 0).is_err());
            assert!(subdiv::optimise_error(&mesh, &Weights::Factors(wrong), 1, 0).is_err());
        }
        let Weights::Factors(same) = Weights::Factors(carried[..old].to_vec()).carried_over(&transfer) else {
            panic!()
        };
        assert_eq!(same, carried);
    }
}

/// Refining at one corner again and again for analysis keeps the floor of 15 degrees and the valence in bounds.
#[test]
fn deep_refinement_for_analysis_keeps_angles_and_valence() {
    let optimise = Optimise { mode: Mode::Best, objective: Objective::Error, ..Optimise::default() };
    let options = Options { optimise, ..Options::default() };
    let (mut mesh, mut history) = (unit_box(2), History::default());
    let input = mesh.points().len();
    for level in 1..=6 {
        let at_corner: Vec<bool> =
            mesh.tets().iter().map(|t| t.iter().any(|&v| mesh.points()[v as usize].length() < 1e-9)).collect();
        let refined = subdiv::refine(&mesh, &history, &at_corner, &options).unwrap();
        let weights = Weights::Factors(vec![1.0; refined.mesh.points().len()]);
        let optimised = subdiv::optimise_error(&refined.mesh, &weights, 3, input).unwrap();
        history = refined.history.renumbered(&optimised.kept);
        mesh = optimised.mesh;
        let quality = quality::quality(&mesh);
        assert!(quality.worst > 14.9 && quality.max_valence <= 70, "level {level}: {quality:?}");
    }
}
