//! Benchmarks of the hot paths: `cargo bench`. Each runs on a box of 24,576 cells (16 x 16 x 16 bricks of six), clamped at
//! one side and pulled at the other; refinement starts from 3,072 cells and makes about as many, but for `sqrt3_step`.
#![allow(clippy::unwrap_used)]

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DVec3;
use subsolid::adapt::{self, options::Estimator};
use subsolid::fem::hexes::{HexSpace, Rule, assemble_hexes};
use subsolid::fem::options::{Element, HexElement, HexOptions, Method, SolverOptions};
use subsolid::fem::{self, Load, LoadKind, Material, Model, Support};
use subsolid::limit::Basis;
use subsolid::mesh::hex::{self, HexMesh};
use subsolid::mesh::tet_oct::TetOctMesh;
use subsolid::mesh::{TetMesh, features, generate};
use subsolid::subdiv::options::{Boundary, CatmullClark, Mode, Objective, Optimise, Options, Scheme};
use subsolid::subdiv::tet_oct::Embedding;
use subsolid::subdiv::{self, Directions, History, Weights, catmull_clark, tet_oct};

fn main() {
    divan::main();
}

fn cube(bricks: usize) -> TetMesh {
    features::with_creases(generate::box_tets([1.0; 3], [bricks; 3]).unwrap(), 40.0, &[])
}

fn model(mesh: &TetMesh) -> Model {
    let clamp = Support::new("clamp", mesh.group("x-min").unwrap(), [Some(0.0); 3]);
    let pull = LoadKind::Traction(mesh.group("x-max").unwrap(), DVec3::new(1.0, 0.0, -0.2).into());
    let material = Material { youngs_modulus: 1000.0, poissons_ratio: 0.3, density: 0.0 };
    Model {
        materials: vec![material],
        supports: vec![clamp],
        loads: vec![Load { name: "pull".to_owned(), kind: pull }],
    }
}

/// One step of all cells; the rate counts the cells made.
fn refine(bencher: Bencher, scheme: Scheme, mode: Mode) {
    let mesh = cube(8);
    let all = vec![true; mesh.tets().len()];
    let options = Options { scheme, optimise: Optimise { mode, ..Optimise::default() }, ..Options::default() };
    let refined = || subdiv::refine(&mesh, &History::default(), &all, &options).unwrap().mesh;
    bencher.counter(ItemsCount::new(refined().tets().len())).bench(refined);
}

#[divan::bench(args = [Scheme::Red, Scheme::Sqrt3, Scheme::LongestEdge])]
fn refine_with_the_papers_operations(bencher: Bencher, scheme: Scheme) {
    refine(bencher, scheme, Mode::Paper);
}

#[divan::bench(args = [Scheme::Red, Scheme::Sqrt3])]
fn refine_for_quality(bencher: Bencher, scheme: Scheme) {
    refine(bencher, scheme, Mode::Best);
}

/// A step at the size of a second step on a part: from 24,576 cells, the boundary smoothed; the rate is output cells a second.
#[divan::bench(args = [Mode::Paper, Mode::Best], sample_count = 5)]
fn sqrt3_step(bencher: Bencher, mode: Mode) {
    let mesh = cube(16);
    let all = vec![true; mesh.tets().len()];
    let optimise = Optimise { mode, ..Optimise::default() };
    let options = Options { boundary: Boundary::Approximating, optimise, ..Options::default() };
    let refined = || subdiv::refine(&mesh, &History::default(), &all, &options).unwrap().mesh;
    bencher.counter(ItemsCount::new(refined().tets().len())).bench(refined);
}

/// A step of smooth tetrahedral/octahedral subdivision from 104,448 cells to 798,720; the rate is output cells a second.
#[divan::bench(sample_count = 10)]
fn tet_oct_step(bencher: Bencher) {
    let mesh = tet_oct::refine(&tet_oct::refine(&TetOctMesh::from(&cube(8))));
    let refined = || tet_oct::refine(&mesh);
    bencher.counter(ItemsCount::new(refined().cell_count())).bench(refined);
}

/// A million points in a cube.
fn cloud() -> Vec<DVec3> {
    let share = |i: usize, step: f64| 0.02 + 0.96 * (0.5 + step * i as f64).fract();
    (0..1_000_000).map(|i| DVec3::new(share(i, 0.754_877_6), share(i, 0.569_840_2), share(i, 0.430_159_7))).collect()
}

/// The weights of a million points in 3,072 control cells refined three times.
#[divan::bench(sample_count = 3)]
fn embed_points(bencher: Bencher) {
    let (control, points) = (TetOctMesh::from(&cube(8)), cloud());
    bencher.counter(ItemsCount::new(points.len())).bench(|| Embedding::new(&control, 3, &points).unwrap());
}

/// One frame of them.
#[divan::bench]
fn deform_points(bencher: Bencher) {
    let (control, points) = (TetOctMesh::from(&cube(8)), cloud());
    let embedding = Embedding::new(&control, 3, &points).unwrap();
    let moved: Vec<DVec3> = control.points().iter().map(|p| *p + DVec3::new(0.1 * p.y * p.y, 0.2 * p.x, 0.0)).collect();
    bencher.counter(ItemsCount::new(points.len())).bench(|| embedding.places(&moved));
}

#[divan::bench]
fn optimise_for_error(bencher: Bencher) {
    let mesh = cube(8);
    let all = vec![true; mesh.tets().len()];
    let optimise = Optimise { mode: Mode::Best, objective: Objective::Error, ..Optimise::default() };
    let options = Options { optimise, ..Options::default() };
    let first = mesh.points().len();
    let mesh = subdiv::refine(&mesh, &History::default(), &all, &options).unwrap().mesh;
    let weights = Weights::Directions(vec![Directions([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]); mesh.points().len()]);
    let count = ItemsCount::new(mesh.tets().len());
    bencher.counter(count).bench(|| subdiv::optimise_error(&mesh, &weights, optimise.passes, first).unwrap());
}

#[divan::bench(args = [(Element::Tet4, 16), (Element::Tet4, 32), (Element::Tet10, 16)])]
fn assemble(bencher: Bencher, (element, bricks): (Element, usize)) {
    let mesh = cube(bricks);
    let model = model(&mesh);
    let space = fem::Space::new(&mesh, element, &[]);
    bencher.counter(ItemsCount::new(mesh.tets().len())).bench(|| fem::assemble(&space, &model).unwrap());
}

/// A tube as a control mesh, refined once: 2,048 cells.
fn tube() -> HexMesh {
    let tube = hex::generate::tube([1.0, 2.0], 1.0, [4, 16, 4], false).unwrap().with_creases(40.0, &[]);
    catmull_clark::refine(&tube, CatmullClark::Bajaj).unwrap().mesh
}

/// The functions of cells around edges where three and five cells meet, at the points of a rule for their stiffness; the rate is
/// tables a second.
#[divan::bench(args = [3, 5])]
fn tabulate_catmull_clark(bencher: Bencher, sides: usize) {
    let mesh = hex::generate::prism(sides, 1.0, 1.0, [2, 4]).unwrap().with_creases(40.0, &[]);
    let basis = Basis::new(&mesh, CatmullClark::Bajaj, false);
    let points = |class| Rule::cube(4).in_parts(&basis.parts(class, 2)).points;
    let tables = || (0..basis.classes()).map(|class| basis.table(class, &points(class))).collect::<Vec<_>>();
    bencher.counter(ItemsCount::new(basis.classes())).bench(tables);
}

/// The tube held at one end and pulled at the other.
fn loaded_tube() -> (HexMesh, Model) {
    let mesh = tube();
    let pull = LoadKind::Traction(mesh.group("z-max").unwrap(), DVec3::new(0.2, 0.0, 1.0).into());
    let model = Model {
        supports: vec![Support::new("clamp", mesh.group("z-min").unwrap(), [Some(0.0); 3])],
        loads: vec![Load { name: "pull".to_owned(), kind: pull }],
        ..model(&cube(1))
    };
    (mesh, model)
}

/// Setup of multigrid and iterations for 2,048 cells.
#[divan::bench(args = [HexElement::Hex27, HexElement::CatmullClark, HexElement::CatmullClarkPlus], sample_count = 10)]
fn solve_hexahedra(bencher: Bencher, element: HexElement) {
    let (mesh, model) = loaded_tube();
    let space = HexSpace::new(&mesh, element, HexOptions::default());
    let system = assemble_hexes(&space, &model).unwrap();
    let options = SolverOptions { method: Method::AmgCg, ..SolverOptions::default() };
    bencher.counter(ItemsCount::new(system.free_dofs())).bench(|| fem::solve(&system, &options, None).unwrap());
}

/// Rings, tables and stiffness of 2,048 cells.
#[divan::bench(args = [HexElement::Hex27, HexElement::CatmullClark], sample_count = 10)]
fn assemble_hexahedra(bencher: Bencher, element: HexElement) {
    let (mesh, model) = loaded_tube();
    bencher.counter(ItemsCount::new(mesh.cells().len())).bench(|| {
        let space = HexSpace::new(&mesh, element, HexOptions::default());
        assemble_hexes(&space, &model).unwrap()
    });
}

/// Vectors as long as there are nodes.
fn vectors(system: &fem::System) -> [Vec<DVec3>; 2] {
    [vec![DVec3::new(1.0, 2.0, 3.0); system.dofs() / 3], vec![DVec3::ZERO; system.dofs() / 3]]
}

/// The product with the stiffness matrix, the unit of `benches/products.rs`.
#[divan::bench(args = [(Element::Tet4, 16), (Element::Tet4, 32), (Element::Tet10, 16)])]
fn multiply(bencher: Bencher, (element, bricks): (Element, usize)) {
    let mesh = cube(bricks);
    let system = fem::assemble(&fem::Space::new(&mesh, element, &[]), &model(&mesh)).unwrap();
    let [x, mut y] = vectors(&system);
    bencher.counter(ItemsCount::new(mesh.tets().len())).bench_local(|| system.times(&x, &mut y));
}

#[divan::bench(args = [(Element::Tet4, 16), (Element::Tet4, 32), (Element::Tet10, 16)], sample_count = 20)]
fn set_up_multigrid(bencher: Bencher, (element, bricks): (Element, usize)) {
    let mesh = cube(bricks);
    let system = fem::assemble(&fem::Space::new(&mesh, element, &[]), &model(&mesh)).unwrap();
    bencher.counter(ItemsCount::new(mesh.tets().len())).bench(|| fem::Multigrid::new(&system).unwrap());
}

#[divan::bench(args = [(Element::Tet4, 16), (Element::Tet4, 32), (Element::Tet10, 16)])]
fn cycle_through_multigrid(bencher: Bencher, (element, bricks): (Element, usize)) {
    let mesh = cube(bricks);
    let system = fem::assemble(&fem::Space::new(&mesh, element, &[]), &model(&mesh)).unwrap();
    let mut multigrid = fem::Multigrid::new(&system).unwrap();
    let [r, mut z] = vectors(&system);
    let count = ItemsCount::new(mesh.tets().len());
    bencher.counter(count).bench_local(|| multigrid.cycle(&r, &mut z).unwrap());
}

/// Setup and solution to a residual of 1e-8; the rate counts cells.
fn solve(bencher: Bencher, method: Method, element: Element, bricks: usize) {
    let mesh = cube(bricks);
    let system = fem::assemble(&fem::Space::new(&mesh, element, &[]), &model(&mesh)).unwrap();
    let options = SolverOptions { method, ..SolverOptions::default() };
    bencher.counter(ItemsCount::new(mesh.tets().len())).bench(|| fem::solve(&system, &options, None).unwrap());
}

#[divan::bench(args = [(Element::Tet4, 16), (Element::Tet4, 32), (Element::Tet10, 16)], sample_count = 20)]
fn solve_by_multigrid(bencher: Bencher, (element, bricks): (Element, usize)) {
    solve(bencher, Method::AmgCg, element, bricks);
}

#[divan::bench(sample_count = 20)]
fn solve_directly(bencher: Bencher) {
    solve(bencher, Method::Direct, Element::Tet4, 16);
}

#[divan::bench(args = [Estimator::Spr, Estimator::Averaging])]
fn estimate(bencher: Bencher, estimator: Estimator) {
    let mesh = cube(16);
    let model = model(&mesh);
    let system = fem::assemble(&fem::Space::linear(&mesh), &model).unwrap();
    let solved = fem::solve(&system, &SolverOptions::default(), None).unwrap();
    let stress = fem::recover(&fem::Space::linear(&mesh), &model, &system, &solved).stress;
    let count = ItemsCount::new(mesh.tets().len());
    bencher.counter(count).bench(|| adapt::estimate(&fem::Space::linear(&mesh), &model.materials, &stress, estimator));
}
