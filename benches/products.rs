//! What a solution costs in units of one product with the stiffness matrix in blocks of three, which the memory bounds:
//!
//! ```text
//! cargo bench --bench products [-- --mesh MESH.msh | --bricks N] [--tet10] [--threads T] [--repeat K]
//! ```
//!
//! The mesh has groups `fixed` and `load`; without one it is a box of 6 N^3 cells (N = 32), clamped at one side and pulled at the
//! other. Each stage is repeated, the shortest time counts.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use glam::DVec3;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;
use subsolid::fem::options::{Element, Method, SolverOptions};
use subsolid::fem::{self, Load, LoadKind, Material, Model, Multigrid, Space, Support, System};
use subsolid::mesh::{TetMesh, generate, read};

/// Entries of the vectors of the triad, far more than caches hold.
const TRIAD: usize = 20_000_000;

/// What the command line says.
struct Options {
    mesh: Option<String>,
    bricks: usize,
    element: Element,
    threads: usize,
    repeat: usize,
}

fn options() -> Options {
    let mut options = Options { mesh: None, bricks: 32, element: Element::Tet4, threads: 0, repeat: 5 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut next = || words.next().unwrap_or_default();
        match word.as_str() {
            "--mesh" => options.mesh = Some(next()),
            "--bricks" => options.bricks = next().parse().unwrap(),
            "--tet10" => options.element = Element::Tet10,
            "--threads" => options.threads = next().parse().unwrap(),
            "--repeat" => options.repeat = next().parse().unwrap(),
            // From cargo.
            "--bench" => {}
            other => panic!("{other} is no option"),
        }
    }
    options
}

fn main() {
    let options = options();
    rayon::ThreadPoolBuilder::new().num_threads(options.threads).build_global().unwrap();
    let (mesh, model) = problem(&options);
    let space = Space::new(&mesh, options.element, &[]);
    let (cells, threads) = (mesh.tets().len(), rayon::current_num_threads());
    let system = fem::assemble(&space, &model).unwrap();
    println!("{cells} cells, {} unknowns, {threads} threads, best of {}", system.free_dofs(), options.repeat);

    let best = |work: &mut dyn FnMut()| shortest(options.repeat, work);
    let product = product(&system, options.repeat);
    let told = |name: &str, seconds: f64| {
        println!("{name:<36}{:>12.3} ms{:>10.1} products", 1e3 * seconds, seconds / product);
    };
    triad(options.repeat);
    told("product with the stiffness matrix", product);
    told("assembly", best(&mut || drop(black_box(fem::assemble(&space, &model).unwrap()))));
    told("setup of the multigrid", best(&mut || drop(black_box(Multigrid::new(&system).unwrap()))));
    told("cycle of the multigrid", cycle(&system, options.repeat));
    let (solve, iteration, iterations) = solution(&system, options.repeat);
    told("iteration of conjugate gradients", iteration);
    told(&format!("solution, {iterations} iterations"), solve);
}

/// Seconds of the fastest run.
fn shortest(repeat: usize, work: &mut dyn FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..repeat.max(1)).map(time).fold(f64::INFINITY, f64::min)
}

fn problem(options: &Options) -> (TetMesh, Model) {
    let (mesh, fixed, load) = match &options.mesh {
        Some(path) => (read::read(path.as_ref()).unwrap().mesh, "fixed", "load"),
        None => (generate::box_tets([1.0; 3], [options.bricks; 3]).unwrap(), "x-min", "x-max"),
    };
    let supports = vec![Support::new("fixed", mesh.group(fixed).unwrap(), [Some(0.0); 3])];
    let kind = LoadKind::Traction(mesh.group(load).unwrap(), DVec3::new(0.0, -1.0, 0.0).into());
    let loads = vec![Load { name: "load".to_owned(), kind }];
    let material = Material { youngs_modulus: 1000.0, poissons_ratio: 0.3, density: 0.0 };
    (mesh, Model { materials: vec![material], supports, loads })
}

/// Vectors that have something of everything.
fn vectors(system: &System) -> [Vec<DVec3>; 2] {
    let count = system.dofs() / 3;
    [(0..count).map(|i| DVec3::new(1.0, (i % 17) as f64, (i % 5) as f64)).collect(), vec![DVec3::ZERO; count]]
}

fn product(system: &System, repeat: usize) -> f64 {
    let [x, mut y] = vectors(system);
    shortest(10 * repeat, &mut || system.times(black_box(&x), black_box(&mut y)))
}

fn cycle(system: &System, repeat: usize) -> f64 {
    let mut multigrid = Multigrid::new(system).unwrap();
    let [r, mut z] = vectors(system);
    shortest(4 * repeat, &mut || multigrid.cycle(black_box(&r), &mut z).unwrap())
}

/// Seconds of a solution to 1e-8, of one of its iterations, and their number. An iteration is what the tolerance of 1e-11 takes more.
fn solution(system: &System, repeat: usize) -> (f64, f64, usize) {
    let solve = |tolerance| {
        let options = SolverOptions { method: Method::AmgCg, tolerance, ..SolverOptions::default() };
        let mut iterations = 0;
        let seconds =
            shortest(repeat, &mut || iterations = fem::solve(system, &options, None).unwrap().info.iterations);
        (seconds, iterations)
    };
    let ((coarse, few), (fine, many)) = (solve(1e-8), solve(1e-11));
    (coarse, (fine - coarse) / (many - few) as f64, few)
}

/// `a = b + 3 c`: what the memory delivers, 24 bytes an entry.
fn triad(repeat: usize) {
    let (mut a, b, c) = (vec![0.0; TRIAD], vec![1.0; TRIAD], vec![2.0; TRIAD]);
    let chunk = TRIAD.div_ceil(rayon::current_num_threads());
    let seconds = shortest(repeat, &mut || {
        let parts = a.par_chunks_mut(chunk).zip(b.par_chunks(chunk)).zip(c.par_chunks(chunk));
        parts.for_each(|((a, b), c)| a.iter_mut().zip(b.iter().zip(c)).for_each(|(a, (b, c))| *a = b + 3.0 * c));
        black_box(&mut a);
    });
    println!("{:<36}{:>12.1} GB/s", "triad", 24e-9 * TRIAD as f64 / seconds);
}
