//! Linear elasticity from the outside: exact solutions, balance, reference energies of the tripod, reproducible bytes.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use subsolid::fem::options::{Element, Method, SolverOptions};
use subsolid::fem::{self, FemError, Load, LoadKind, Material, Model, Solution, Support};
use subsolid::field::Field;
use subsolid::mesh::generate::box_tets;
use subsolid::mesh::{GroupId, RegionId, TetMesh};
use subsolid::subdiv::options::{Options, Scheme};
use subsolid::subdiv::{self, History};

const STIFF: Material = Material { youngs_modulus: 1000.0, poissons_ratio: 0.3, density: 2.0 };
const FIXED: [Option<f64>; 3] = [Some(0.0); 3];

fn support(name: &str, group: GroupId, displacement: [Option<f64>; 3]) -> Support {
    Support::new(name, group, displacement)
}

fn load(kind: LoadKind) -> Load {
    Load { name: "load".to_owned(), kind }
}

fn group(mesh: &TetMesh, name: &str) -> GroupId {
    mesh.group(name).unwrap()
}

fn with(method: Method) -> SolverOptions {
    SolverOptions { method, tolerance: 1e-11, ..SolverOptions::default() }
}

/// Solves, and checks that loads and reactions balance.
fn analyse(mesh: &TetMesh, model: &Model, method: Method) -> Solution {
    let system = fem::assemble(&fem::Space::linear(mesh), model).unwrap();
    let solved = fem::solve(&system, &with(method), None).unwrap();
    let solution = fem::recover(&fem::Space::linear(mesh), model, &system, &solved);
    assert!(solution.info.residual <= 1e-11);
    let scale = solution.reactions.iter().map(|r| r.length()).fold(1e-3, f64::max);
    assert!(fem::global_balance(&system, &solution).length() < 1e-9 * scale);
    solution
}

/// Sliding supports on the three lower sides, so that a box can stretch freely.
fn rollers(mesh: &TetMesh) -> Vec<Support> {
    let roller = |axis: usize| {
        let mut displacement = [None; 3];
        displacement[axis] = Some(0.0);
        let name = ["x-min", "y-min", "z-min"][axis];
        support(name, group(mesh, name), displacement)
    };
    (0..3).map(roller).collect()
}

/// A box standing on its fixed lower side, pressed from above.
fn pressed_box(cells: usize) -> (TetMesh, Model) {
    let mesh = box_tets([1.0; 3], [cells; 3]).unwrap();
    let supports = vec![support("foot", group(&mesh, "z-min"), FIXED)];
    let loads = vec![load(LoadKind::Pressure(group(&mesh, "z-max"), 1.0.into()))];
    (mesh, Model { materials: vec![STIFF], supports, loads })
}

#[test]
fn bar_in_tension_stretches_by_stress_times_length_over_e() {
    let mesh = box_tets([4.0, 1.0, 1.0], [5, 2, 3]).unwrap();
    let end = group(&mesh, "x-max");
    let pull = DVec3::new(7.0, 0.0, 0.0);
    for kind in
        [LoadKind::Traction(end, pull.into()), LoadKind::Pressure(end, Field::from(-7.0)), LoadKind::Force(end, pull)]
    {
        let model = Model { materials: vec![STIFF], supports: rollers(&mesh), loads: vec![load(kind.clone())] };
        fem::check_constraints(&mesh, &model).unwrap();
        for method in [Method::Direct, Method::AmgCg, Method::Auto] {
            let solution = analyse(&mesh, &model, method);
            for (u, x) in solution.displacement.iter().zip(mesh.points()) {
                let exact = 7e-3 * DVec3::new(x.x, -0.3 * x.y, -0.3 * x.z);
                assert!((*u - exact).length() < 1e-12, "{kind:?} {method:?}: {u} at {x}");
            }
            for s in &solution.stress.means() {
                assert!((s[0] - 7.0).abs() < 1e-9 && s[1..].iter().all(|c| c.abs() < 1e-9));
                assert!((fem::von_mises(*s) - 7.0).abs() < 1e-9);
            }
            assert!((solution.strain_energy - 0.5 * 49.0 / 1000.0 * 4.0).abs() < 1e-10);
            assert!((solution.reactions[0] + pull).length() < 1e-9);
        }
    }
}

#[test]
fn bars_in_series_add_their_stretch() {
    let mesh = box_tets([2.0, 1.0, 1.0], [6, 2, 2]).unwrap();
    let soft: Vec<bool> =
        (0..mesh.tets().len()).map(|t| mesh.cell_points(t).iter().map(|p| p.x).sum::<f64>() > 4.0).collect();
    let mut parts = mesh.into_parts();
    parts.regions = soft.iter().map(|s| RegionId(u16::from(*s))).collect();
    parts.region_names = vec!["stiff".to_owned(), "soft".to_owned()];
    let mesh = TetMesh::new(parts).unwrap();
    let bar = |youngs_modulus| Material { youngs_modulus, poissons_ratio: 0.0, density: 0.0 };
    let pull = LoadKind::Traction(group(&mesh, "x-max"), DVec3::new(6.0, 0.0, 0.0).into());
    let materials = vec![bar(1000.0), bar(10.0)];
    let model = Model { materials, supports: rollers(&mesh), loads: vec![load(pull)] };
    for method in [Method::Direct, Method::AmgCg] {
        let solution = analyse(&mesh, &model, method);
        for (u, x) in solution.displacement.iter().zip(mesh.points()) {
            let exact = 6.0 * (x.x.min(1.0) / 1000.0 + (x.x - 1.0).max(0.0) / 10.0);
            assert!((*u - DVec3::new(exact, 0.0, 0.0)).length() < 1e-9, "{method:?}: {u} at {x}");
        }
    }
}

#[test]
fn prescribed_stretch_and_the_load_that_makes_it_agree() {
    let mesh = box_tets([4.0, 1.0, 1.0], [5, 2, 3]).unwrap();
    let mut supports = rollers(&mesh);
    supports.push(support("pull", group(&mesh, "x-max"), [Some(0.028), None, None]));
    let model = Model { materials: vec![STIFF], supports, loads: vec![] };
    for method in [Method::Direct, Method::AmgCg] {
        let solution = analyse(&mesh, &model, method);
        assert!((solution.reactions[3] - DVec3::new(7.0, 0.0, 0.0)).length() < 1e-9);
        assert!(solution.stress.means().iter().all(|s| (s[0] - 7.0).abs() < 1e-9));
    }
}

#[test]
fn column_under_its_weight_carries_it_to_the_foot() {
    let mesh = box_tets([1.0, 1.0, 3.0], [2, 2, 6]).unwrap();
    let supports = vec![support("foot", group(&mesh, "z-min"), FIXED)];
    let loads = vec![load(LoadKind::Gravity(DVec3::new(0.0, 0.0, -9.81)))];
    let solution = analyse(&mesh, &Model { materials: vec![STIFF], supports, loads }, Method::Direct);
    assert!((solution.reactions[0] - DVec3::new(0.0, 0.0, 2.0 * 3.0 * 9.81)).length() < 1e-9);
}

#[test]
fn nothing_happens_without_loads() {
    let (mesh, model) = pressed_box(2);
    for method in [Method::Direct, Method::AmgCg, Method::Auto] {
        let solution = analyse(&mesh, &Model { loads: vec![], ..model.clone() }, method);
        assert!(solution.displacement.iter().all(|u| *u == DVec3::ZERO) && solution.info.residual == 0.0);
    }
}

#[test]
fn everything_prescribed_leaves_nothing_to_solve() {
    let mesh = box_tets([1.0; 3], [1; 3]).unwrap();
    let supports = (0..6).map(|g| support("side", GroupId(g), [Some(0.5), Some(0.0), Some(0.0)])).collect();
    let model = Model { materials: vec![STIFF], supports, loads: vec![] };
    assert_eq!(fem::assemble(&fem::Space::linear(&mesh), &model).unwrap().free_dofs(), 0);
    let solution = analyse(&mesh, &model, Method::Auto);
    assert!(solution.displacement.iter().all(|u| *u == DVec3::new(0.5, 0.0, 0.0)));
    assert!(solution.strain_energy.abs() < 1e-12);
}

#[test]
fn auto_takes_cg_when_the_factor_is_too_large_and_says_so() {
    let (mesh, model) = pressed_box(4);
    let system = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap();
    let small = SolverOptions { direct_memory_limit: 1000, ..with(Method::Auto) };
    let (cg, direct) =
        (fem::solve(&system, &small, None).unwrap(), fem::solve(&system, &with(Method::Auto), None).unwrap());
    assert_eq!((cg.info.method, direct.info.method), ("amg-cg", "direct"));
    assert!(cg.info.reason.contains("limit") && direct.info.reason.contains("limit"));
    assert!(cg.displacement.iter().zip(&direct.displacement).all(|(a, b)| (*a - *b).length() < 1e-10));
}

#[test]
fn iterations_hardly_grow_with_the_mesh() {
    let iterations = [6, 12, 24].map(|cells| {
        let (mesh, model) = pressed_box(cells);
        let system = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap();
        fem::solve(&system, &SolverOptions { tolerance: 1e-8, ..with(Method::AmgCg) }, None).unwrap().info.iterations
    });
    assert!(iterations[2] < iterations[0] + 30 && iterations[2] < 80, "{iterations:?}");
}

#[test]
fn auto_solves_large_systems_by_cg() {
    let (mesh, model) = pressed_box(12);
    assert_eq!(analyse(&mesh, &model, Method::Auto).info.method, "amg-cg");
}

#[test]
fn auto_turns_to_the_direct_method_where_cg_is_slow() {
    let (mesh, model) = pressed_box(12);
    let model = Model { materials: vec![Material { poissons_ratio: 0.499_999, ..STIFF }], ..model };
    let options = SolverOptions { tolerance: 1e-6, ..with(Method::Auto) };
    let info = fem::solve(&fem::assemble(&fem::Space::linear(&mesh), &model).unwrap(), &options, None).unwrap().info;
    assert_eq!(info.method, "direct", "{info:?}");
    assert!(info.reason.contains("200 iterations"), "{info:?}");
}

#[test]
fn class_58_a_residual_above_its_tolerance_is_rounding_that_is_told_or_an_error() {
    let (mesh, model) = pressed_box(3);
    let system = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap();
    for method in [Method::Direct, Method::AmgCg] {
        let info = fem::solve(&system, &SolverOptions { tolerance: 1e-25, ..with(method) }, None).unwrap().info;
        assert!(info.residual < 1e-13 && info.reason.contains("limit of double precision"), "{info:?}");
        let error = fem::solve(&system, &SolverOptions { tolerance: f64::NAN, ..with(method) }, None).unwrap_err();
        assert!(matches!(error, FemError::NotConverged { .. }) && !error.is_model(), "{error}");
    }
}

#[test]
fn an_unheld_solid_is_not_solved() {
    let (mesh, model) = pressed_box(3);
    let model = Model { supports: vec![], ..model };
    assert!(fem::check_constraints(&mesh, &model).unwrap_err().is_model());
    let system = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap();
    for method in [Method::Direct, Method::AmgCg] {
        let error = fem::solve(&system, &with(method), None).unwrap_err();
        assert!(!error.is_model(), "{error}");
    }
}

/// What `check_constraints` says of a mesh held by these supports.
fn free_motion(mesh: &TetMesh, supports: Vec<Support>) -> String {
    let model = Model { materials: vec![STIFF], supports, loads: vec![] };
    match fem::check_constraints(mesh, &model) {
        Ok(()) => String::new(),
        Err(FemError::FreeMotion { motions, .. }) => motions.join("; "),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn free_motions_are_named() {
    let mesh = box_tets([2.0, 1.0, 1.0], [2, 1, 1]).unwrap();
    let [x, y, z] = ["x-min", "y-min", "z-min"].map(|name| group(&mesh, name));
    let along = |axis: usize| std::array::from_fn(|c| (c == axis).then_some(0.0));
    assert_eq!(free_motion(&mesh, vec![support("a", x, FIXED)]), "");
    let all = free_motion(&mesh, vec![]);
    assert!(all.starts_with("part 1 of 1 (12 cells") && all.ends_with("move and rotate in every way"), "{all}");
    let slide = free_motion(&mesh, vec![support("a", x, along(0))]);
    assert!(slide.ends_with("still move along y, move along z, rotate about x through (1, 0.5, 0.5)"), "{slide}");
    let slide = free_motion(&mesh, vec![support("a", x, along(0)), support("b", y, along(1))]);
    assert!(slide.ends_with("still move along z"), "{slide}");
    assert_eq!(free_motion(&mesh, [rollers(&mesh), vec![support("z", z, FIXED)]].concat()), "");
}

/// What can still move when a second unit box, moved by `shift`, is merged with one that is fixed at x = 0.
fn two_boxes(shift: DVec3) -> String {
    let one = box_tets([1.0; 3], [1; 3]).unwrap();
    let mut points = one.points().to_vec();
    let mut merged = |p: DVec3| {
        let known = points.iter().position(|q| *q == p);
        known.unwrap_or_else(|| {
            points.push(p);
            points.len() - 1
        }) as u32
    };
    let twin: Vec<u32> = one.points().iter().map(|p| merged(*p + shift)).collect();
    let moved = one.tets().iter().map(|t| t.map(|v| twin[v as usize]));
    let mesh = TetMesh::from_cells(points, one.tets().iter().copied().chain(moved).collect(), "solid").unwrap();
    let at_wall = |v: u32| mesh.points()[v as usize].x == 0.0;
    let wall: Vec<bool> = mesh.faces().iter().map(|f| f.vertices.into_iter().all(at_wall)).collect();
    let (mesh, wall) = mesh.with_group("wall", &wall).unwrap();
    free_motion(&mesh, vec![support("wall", wall, FIXED)])
}

#[test]
fn loose_and_hinged_parts_are_told_apart() {
    let loose = two_boxes(DVec3::new(5.0, 0.0, 0.0));
    assert!(loose.starts_with("part 2 of 2 (6 cells, box (5, 0, 0) to (6, 1, 1))"), "{loose}");
    assert!(loose.ends_with("every way"), "{loose}");
    let hinge = two_boxes(DVec3::new(1.0, 1.0, 0.0));
    assert!(hinge.ends_with("can still rotate about z through (1, 1, 0.5)"), "{hinge}");
    let ball = two_boxes(DVec3::new(1.0, 1.0, 1.0));
    assert_eq!(ball.matches("rotate about").count(), 3, "{ball}");
    assert!(!ball.contains("move along"), "{ball}");
    assert_eq!(two_boxes(DVec3::new(1.0, 0.0, 0.0)), "");
}

#[test]
fn senseless_models_are_refused_by_name() {
    let mesh = box_tets([1.0; 3], [1; 3]).unwrap();
    let good = Model { materials: vec![STIFF], supports: rollers(&mesh), loads: vec![] };
    fem::assemble(&fem::Space::linear(&mesh), &good).unwrap();
    let refuse = |model: Model, text: &str| {
        let error = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap_err();
        assert!(error.is_model() && error.to_string().contains(text), "{error}");
    };
    let material = |material: Material| Model { materials: vec![material], ..good.clone() };
    refuse(Model { materials: vec![], ..good.clone() }, "\"solid\"");
    refuse(material(Material { poissons_ratio: 0.5, ..STIFF }), "Poisson's ratio is 0.5");
    refuse(material(Material { youngs_modulus: f64::NAN, ..STIFF }), "NaN");
    refuse(Model { supports: vec![support("lost", GroupId(77), [None; 3])], ..good.clone() }, "\"lost\"");
    refuse(Model { loads: vec![load(LoadKind::Pressure(GroupId(77), 1.0.into()))], ..good.clone() }, "\"load\"");
    refuse(Model { loads: vec![load(LoadKind::Pressure(GroupId(1), f64::INFINITY.into()))], ..good.clone() }, "inf");
    let massless = material(Material { density: 0.0, ..STIFF });
    refuse(Model { loads: vec![load(LoadKind::Gravity(DVec3::X))], ..massless }, "no density");
    let mut supports = rollers(&mesh);
    supports.push(support("pulled", group(&mesh, "z-max"), [Some(0.25), None, None]));
    refuse(Model { supports, ..good }, "supports \"x-min\" and \"pulled\" prescribe x-displacements 0 and 0.25");
}

/// The tripod of the reference data with its feet fixed and its top pressed down, or `None` (said aloud) without data.
fn tripod() -> Option<(TetMesh, Model)> {
    let Ok(folder) = std::env::var("SUBSOLID_DATA") else {
        eprintln!("skipped: SUBSOLID_DATA is not set");
        return None;
    };
    let text = std::fs::read_to_string(std::path::Path::new(&folder).join("tripod.GiD.msh")).unwrap();
    let (points, tets) = read_gid_corners(&text);
    let mesh = TetMesh::from_cells(points, tets, "tripod").unwrap();
    let level = |mesh: &TetMesh, y: f64| -> Vec<bool> {
        // Nine nodes of the feet lie at -9.99999.
        let near = |v: u32| (mesh.points()[v as usize].y - y).abs() < 1e-5 + 1e-12;
        mesh.faces().iter().map(|f| f.vertices.into_iter().all(near)).collect()
    };
    let (feet, top) = (level(&mesh, -10.0), level(&mesh, 13.0));
    let (mesh, feet) = mesh.with_group("feet", &feet).unwrap();
    let (mesh, top) = mesh.with_group("top", &top).unwrap();
    let loads = vec![load(LoadKind::Traction(top, DVec3::new(0.0, -1.0, 0.0).into()))];
    Some((mesh, Model { materials: vec![STIFF], supports: vec![support("feet", feet, FIXED)], loads }))
}

/// Corner nodes and cells of a GiD file of ten-node tetrahedra, cells made positive.
fn read_gid_corners(text: &str) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let rows = |from: &str, to: &str| -> Vec<Vec<f64>> {
        let lines = text.lines().skip_while(|l| l.trim() != from).skip(1).take_while(|l| l.trim() != to);
        lines.map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
    };
    let coordinates = rows("Coordinates", "end coordinates");
    let positions: std::collections::BTreeMap<u32, DVec3> =
        coordinates.iter().map(|r| (r[0] as u32, DVec3::new(r[1], r[2], r[3]))).collect();
    let cells: Vec<[u32; 4]> =
        rows("Elements", "end elements").iter().map(|r| std::array::from_fn(|i| r[i + 1] as u32)).collect();
    let used: std::collections::BTreeSet<u32> = cells.iter().flatten().copied().collect();
    let number: std::collections::BTreeMap<u32, u32> = used.iter().copied().zip(0..).collect();
    let points: Vec<DVec3> = used.iter().map(|id| positions[id]).collect();
    let positive = |t: [u32; 4]| {
        let volume = subsolid::mesh::quality::volume(t.map(|v| points[v as usize]));
        if volume < 0.0 { [t[0], t[1], t[3], t[2]] } else { t }
    };
    let tets = cells.into_iter().map(|t| positive(t.map(|id| number[&id]))).collect();
    (points, tets)
}

fn refined(mesh: &TetMesh) -> TetMesh {
    let options = Options { scheme: Scheme::Red, ..Options::default() };
    subdiv::refine(mesh, &History::default(), &vec![true; mesh.tets().len()], &options).unwrap().mesh
}

fn max_displacement(solution: &Solution) -> f64 {
    solution.displacement.iter().map(|u| u.length()).fold(0.0, f64::max)
}

#[test]
fn tripod_meets_the_energies_of_independent_programs() {
    let Some((mut mesh, model)) = tripod() else { return };
    fem::check_constraints(&mesh, &model).unwrap();
    let reference =
        [(6.3823301878, 0.126521862, 2901), (7.5627413988, 0.149441123, 16764), (8.0724806961, 0.159452217, 110964)];
    for (level, (energy, displacement, dofs)) in reference.into_iter().enumerate() {
        if level > 0 {
            mesh = refined(&mesh);
        }
        assert_eq!(3 * mesh.points().len(), dofs);
        let methods = if level < 2 { vec![Method::Direct, Method::AmgCg] } else { vec![Method::Auto] };
        for method in methods {
            let solution = analyse(&mesh, &model, method);
            let (u, e) = (max_displacement(&solution), solution.strain_energy);
            assert!((e - energy).abs() < 1e-8 && (u - displacement).abs() < 1e-8, "level {level}: {e}, {u}");
        }
    }
}

/// Ten-node cells with straight edges: the energy that NGSolve's quadratic elements give on the same mesh.
#[test]
fn quadratic_tripod_meets_the_energy_of_an_independent_program() {
    let Some((mesh, model)) = tripod() else { return };
    let space = fem::Space::new(&mesh, Element::Tet10, &[]);
    let system = fem::assemble(&space, &model).unwrap();
    for method in [Method::Direct, Method::AmgCg] {
        let solved = fem::solve(&system, &with(method), None).unwrap();
        let energy = fem::recover(&space, &model, &system, &solved).strain_energy;
        assert!((energy - 8.199222821864).abs() < 1e-10, "{method:?}: {energy:.13}");
    }
}

/// All bytes of a solution on a pool of so many threads.
fn bytes_on(threads: usize, mesh: &TetMesh, model: &Model, method: Method) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let solution = pool.install(|| analyse(mesh, model, method));
    let vectors = solution.displacement.iter().chain(&solution.reactions).flat_map(|v| v.to_array());
    let scalars = [solution.strain_energy, solution.info.residual];
    vectors.chain(solution.stress.means().iter().flatten().copied()).chain(scalars).map(f64::to_bits).collect()
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let mesh = box_tets([3.0, 1.0, 1.0], [36, 12, 12]).unwrap();
    let supports = vec![support("foot", group(&mesh, "x-min"), FIXED)];
    let loads = vec![load(LoadKind::Traction(group(&mesh, "x-max"), DVec3::Y.into()))];
    let model = Model { materials: vec![STIFF], supports, loads };
    for method in [Method::Direct, Method::AmgCg] {
        let one = bytes_on(1, &mesh, &model, method);
        for threads in [2, 3] {
            assert!(one == bytes_on(threads, &mesh, &model, method), "{method:?} on {threads} threads");
        }
    }
}
