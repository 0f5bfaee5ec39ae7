//! Multigrid from the outside: iterations that hardly grow, materials and cells that are hard to smooth, parts and supports
//! of all kinds, the same bytes on any number of threads.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use subsolid::fem::options::{Element, Method, SolverOptions};
use subsolid::fem::{self, Load, LoadKind, Material, Model, Solved, Space, Support, System};
use subsolid::mesh::generate::box_tets;
use subsolid::mesh::{RegionId, TetMesh};

const FIXED: [Option<f64>; 3] = [Some(0.0); 3];

fn steel(youngs_modulus: f64, poissons_ratio: f64) -> Material {
    Material { youngs_modulus, poissons_ratio, density: 0.0 }
}

/// A box of cubes, of which some are of the second material.
fn block(cells: [usize; 3], second: impl Fn(DVec3) -> bool) -> TetMesh {
    let mesh = box_tets(cells.map(|n| n as f64), cells).unwrap();
    let centre = |t: usize| mesh.cell_points(t).into_iter().sum::<DVec3>() / 4.0;
    let regions = (0..mesh.tets().len()).map(|t| RegionId(u16::from(second(centre(t))))).collect();
    let mut parts = mesh.into_parts();
    (parts.regions, parts.region_names) = (regions, vec!["first".to_owned(), "second".to_owned()]);
    TetMesh::new(parts).unwrap()
}

/// The mesh, its lower side fixed, its upper side pulled askew.
fn system(mesh: &TetMesh, materials: [Material; 2], element: Element) -> System {
    let supports = vec![Support::new("foot", mesh.group("z-min").unwrap(), FIXED)];
    let pull = LoadKind::Traction(mesh.group("z-max").unwrap(), DVec3::new(1.0, 0.3, -2.0).into());
    let loads = vec![Load { name: "pull".to_owned(), kind: pull }];
    let model = Model { materials: materials.to_vec(), supports, loads };
    fem::assemble(&Space::new(mesh, element, &[]), &model).unwrap()
}

fn options(method: Method, tolerance: f64) -> SolverOptions {
    SolverOptions { method, tolerance, ..SolverOptions::default() }
}

fn multigrid(system: &System) -> Solved {
    fem::solve(system, &options(Method::AmgCg, 1e-8), None).unwrap()
}

fn iterations(mesh: &TetMesh, materials: [Material; 2]) -> usize {
    multigrid(&system(mesh, materials, Element::Tet4)).info.iterations
}

/// Largest distance between two solutions, relative to the largest displacement.
fn difference(a: &Solved, b: &Solved) -> f64 {
    let size = b.displacement.iter().map(|u| u.length()).fold(0.0, f64::max);
    let distances = a.displacement.iter().zip(&b.displacement).map(|(a, b)| a.distance(*b));
    distances.fold(0.0, f64::max) / size
}

#[test]
fn iterations_hardly_grow() {
    let plain = [steel(1.0, 0.3); 2];
    let counts = [8, 16, 32].map(|n| iterations(&block([n; 3], |_| false), plain));
    assert!(counts[2] <= 26 && counts[2] as f64 <= 1.3 * counts[0] as f64, "{counts:?}");
}

#[test]
fn hard_materials_and_shapes_take_few_more() {
    let n = 16;
    let slab = |x: DVec3| (x.z - 8.0).abs() < 2.0;
    let board = |x: DVec3| { x / 2.0 }.floor().element_sum().rem_euclid(2.0) == 0.0;
    let squeezed = |axis: usize| {
        let mut parts = block([n; 3], |_| false).into_parts();
        parts.points.iter_mut().for_each(|p| p[axis] *= 0.1);
        TetMesh::new(parts).unwrap()
    };
    let soft = steel(1.0, 0.3);
    let stiff = steel(1000.0, 0.3);
    let cases = [
        ("nu 0.45", 45, block([n; 3], |_| false), [steel(1.0, 0.45); 2]),
        ("nu 0.49", 60, block([n; 3], |_| false), [steel(1.0, 0.49); 2]),
        ("stiff slab", 45, block([n; 3], slab), [soft, stiff]),
        ("soft slab", 45, block([n; 3], slab), [stiff, soft]),
        ("checkerboard", 45, block([n; 3], board), [soft, stiff]),
        ("squeezed in x", 45, squeezed(0), [soft; 2]),
        ("squeezed in z", 45, squeezed(2), [soft; 2]),
    ];
    for (name, most, mesh, materials) in cases {
        let count = iterations(&mesh, materials);
        println!("{name}: {count}");
        assert!(count <= most, "{name}: {count} iterations");
    }
}

#[test]
fn ten_node_cells_take_few_more() {
    let counts = [4, 8, 12].map(|n| {
        let system = system(&block([n; 3], |_| false), [steel(1.0, 0.3); 2], Element::Tet10);
        let [quick, exact] =
            [Method::AmgCg, Method::Direct].map(|m| fem::solve(&system, &options(m, 1e-10), None).unwrap());
        assert!(difference(&quick, &exact) < 1e-8);
        multigrid(&system).info.iterations
    });
    assert!(counts[2] <= 34 && counts[2] as f64 <= 1.3 * counts[0] as f64, "{counts:?}");
}

/// Two bars apart from each other, one on a foundation and one that slides, under prescribed displacements too.
#[test]
fn parts_springs_and_sliding_supports_agree_with_the_direct_method() {
    let bar = box_tets([6.0, 2.0, 2.0], [18, 6, 6]).unwrap();
    let mut parts = bar.clone().into_parts();
    let count = parts.points.len() as u32;
    parts.points.extend(bar.points().iter().map(|p| *p + DVec3::Z * 5.0));
    parts.tets.extend(bar.tets().iter().map(|t| t.map(|v| v + count)));
    let points = parts.points;
    let mesh = TetMesh::from_cells(points, parts.tets, "solid").unwrap();
    let side = |mesh: TetMesh, name: &str, at: &dyn Fn(DVec3) -> bool| {
        let on: Vec<bool> =
            mesh.faces().iter().map(|f| f.vertices.iter().all(|&v| at(mesh.points()[v as usize]))).collect();
        mesh.with_group(name, &on).unwrap()
    };
    let (mesh, left) = side(mesh, "left", &|p| p.x == 0.0);
    let (mesh, bottom) = side(mesh, "bottom", &|p| p.z == 0.0 || p.z == 5.0);
    let (mesh, lower) = side(mesh, "lower", &|p| p.y == 0.0);
    let (mesh, right) = side(mesh, "right", &|p| p.x == 6.0);
    let mut supports = vec![
        Support::new("slide", left, [Some(0.0), None, None]),
        Support::new("bed", bottom, [None; 3]),
        Support::new("wall", lower, [None, Some(0.01), None]),
    ];
    supports[1].stiffness = DVec3::new(0.0, 0.0, 3.0);
    let pull = LoadKind::Traction(right, DVec3::new(1.0, 0.0, 0.5).into());
    let loads = vec![Load { name: "pull".to_owned(), kind: pull }];
    let model = Model { materials: vec![steel(100.0, 0.3)], supports, loads };
    for element in [Element::Tet4, Element::Tet10] {
        let system = fem::assemble(&Space::new(&mesh, element, &[]), &model).unwrap();
        let [quick, exact] =
            [Method::AmgCg, Method::Direct].map(|m| fem::solve(&system, &options(m, 1e-11), None).unwrap());
        assert!(difference(&quick, &exact) < 1e-8, "{}", difference(&quick, &exact));
        assert!(quick.info.iterations < 60, "{:?}", quick.info);
    }
}

#[test]
fn a_good_guess_saves_iterations_and_a_bad_one_does_no_harm() {
    let system = system(&block([10; 3], |_| false), [steel(1.0, 0.3); 2], Element::Tet4);
    let cold = multigrid(&system);
    let near: Vec<DVec3> = cold.displacement.iter().map(|u| *u * 1.000_001).collect();
    let far: Vec<DVec3> = cold.displacement.iter().map(|u| -1e3 * *u).collect();
    let from = |guess: &[DVec3]| fem::solve(&system, &options(Method::AmgCg, 1e-8), Some(guess)).unwrap();
    assert!(from(&near).info.iterations + 4 < cold.info.iterations);
    assert_eq!(from(&far).displacement, cold.displacement);
    assert!(from(&cold.displacement).info.iterations <= 1);
}

#[test]
fn threads_do_not_change_a_bit() {
    let slab = |x: DVec3| x.x > 7.0;
    for (materials, element) in [
        ([steel(1.0, 0.3); 2], Element::Tet4),
        ([steel(1.0, 0.49); 2], Element::Tet4),
        ([steel(1.0, 0.3); 2], Element::Tet10),
    ] {
        let solved = [1, 2, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| multigrid(&system(&block([14, 9, 9], slab), materials, element)).displacement)
        });
        assert!(solved[0] == solved[1] && solved[0] == solved[2]);
    }
}

/// A square plate of one layer of ten-node cells, a hundred times as wide as thick, clamped at one side and pressed.
fn plate(cells: usize) -> System {
    let mesh = box_tets([100.0, 100.0, 1.0], [cells, cells, 1]).unwrap();
    let supports = vec![Support::new("wall", mesh.group("x-min").unwrap(), FIXED)];
    let press = LoadKind::Traction(mesh.group("z-max").unwrap(), DVec3::NEG_Z.into());
    let loads = vec![Load { name: "press".to_owned(), kind: press }];
    let model = Model { materials: vec![steel(210e3, 0.3)], supports, loads };
    fem::assemble(&Space::new(&mesh, Element::Tet10, &[]), &model).unwrap()
}

/// Multigrid crawls on a thin plate, and no solution in double precision has a residual of 1e-8.
#[test]
fn thin_plates_are_solved_directly_where_memory_suffices() {
    let system = plate(12);
    let of = |method, limit| {
        let options = SolverOptions { method, direct_memory_limit: limit, ..options(method, 1e-8) };
        fem::solve(&system, &options, None).unwrap()
    };
    let direct = of(Method::Direct, 0);
    let auto = of(Method::Auto, 1 << 30);
    assert_eq!((auto.info.method, auto.info.residual), ("direct", direct.info.residual));
    assert!(auto.info.reason.contains("conjugate gradients at residual"), "{}", auto.info.reason);
    // Without that memory iterations go on until restarts gain nothing.
    let frugal = of(Method::Auto, 1);
    assert_eq!(frugal.info.method, "amg-cg");
    assert!(frugal.info.residual < 1e-5 && frugal.info.reason.contains("limit of double precision"));
    assert!(difference(&frugal, &direct) < 1e-5, "{}", difference(&frugal, &direct));
}

/// Inclusions of cubes and of single cells, a hundred thousand and a hundred million times softer, and such stiffer ones. Some of the
/// stiff cells hang together at edges and vertices only: mechanisms that aggregates do not represent.
#[test]
fn enormous_jumps_are_solved() {
    let inner = |x: DVec3| (x - DVec3::splat(5.0)).abs().max_element() < 2.0;
    let random = |x: DVec3| (x.dot(DVec3::new(12.9898, 78.233, 37.719)).sin() * 43_758.545_3).rem_euclid(1.0) < 0.3;
    for (name, most, mesh) in [("cube", 40, block([10; 3], inner)), ("random cells", 150, block([10; 3], random))] {
        for stiffness in [1e-8, 1e-5, 1e5, 1e8] {
            let system = system(&mesh, [steel(1.0, 0.3), steel(stiffness, 0.3)], Element::Tet4);
            let [quick, exact] =
                [Method::AmgCg, Method::Direct].map(|m| fem::solve(&system, &options(m, 1e-8), None).unwrap());
            println!("{name} {stiffness:e}: {:?}, {:.1e}", quick.info, difference(&quick, &exact));
            assert!(quick.info.iterations <= most, "{name} {stiffness:e}: {:?}", quick.info);
            assert!(quick.info.residual <= exact.info.residual.max(1e-8) * 8.0);
            assert!(difference(&quick, &exact) < 1e-5, "{name} {stiffness:e}: {}", difference(&quick, &exact));
        }
    }
}
