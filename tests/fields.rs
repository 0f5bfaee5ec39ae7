//! Loads, supports and expressions against exact solutions: patch tests, foundations, columns, forces at points.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use glam::DVec3;
use std::path::Path;
use subsolid::fem::options::{Method, SolverOptions};
use subsolid::fem::{self, FemError, Solution, System};
use subsolid::mesh::TetMesh;
use subsolid::mesh::generate::box_tets;
use subsolid::pipeline::resolve::{Resolved, resolve};
use subsolid::scenario::Scenario;
use subsolid::subdiv::options::{Options, Scheme};
use subsolid::subdiv::{self, History};

const MATERIAL: &str = "[mesh.box]\nsize = [1, 2, 1.5]\ncells = [1, 1, 1]\n[materials.a]\nyoungs_modulus = 1000\n";

/// A scenario's text on the box [0, 1] x [0, 2] x [0, 1.5] of some cells, its inner vertices moved out of order.
fn on_box(cells: [usize; 3], text: &str) -> Resolved {
    let scenario = Scenario::from_text(&format!("{MATERIAL}{text}"), Path::new("case.toml"), &[]);
    let mut parts = box_tets([1.0, 2.0, 1.5], cells).unwrap().into_parts();
    let size = DVec3::new(1.0, 2.0, 1.5);
    let amplitude = 0.15 / cells.into_iter().max().unwrap() as f64;
    for (v, p) in parts.points.iter_mut().enumerate() {
        if p.cmpgt(DVec3::ZERO).all() && p.cmplt(size).all() {
            let wobble = |k: f64| (k * (v as f64 + 1.0)).sin();
            *p += amplitude * DVec3::new(wobble(12.9), wobble(78.2), wobble(37.7));
        }
    }
    let scenario = scenario.unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)));
    resolve(&scenario, TetMesh::new(parts).unwrap()).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)))
}

/// Solves on a mesh, and checks that loads and reactions balance.
fn solve_on(mesh: &TetMesh, problem: &Resolved) -> (System, Solution) {
    fem::check_constraints(mesh, &problem.model).unwrap();
    let system = fem::assemble(&fem::Space::linear(mesh), &problem.model).unwrap();
    let options = SolverOptions { method: Method::Direct, tolerance: 1e-11, ..SolverOptions::default() };
    let solution =
        fem::recover(&fem::Space::linear(mesh), &problem.model, &system, &fem::solve(&system, &options, None).unwrap());
    let scale = solution.reactions.iter().map(|r| r.length()).fold(1e-6, f64::max);
    assert!(fem::global_balance(&system, &solution).length() < 1e-9 * scale);
    (system, solution)
}

fn solved(problem: &Resolved) -> Solution {
    solve_on(&problem.mesh, problem).1
}

fn sides(text: &str) -> String {
    let planes = [("x", 0, 0.0), ("X", 0, 1.0), ("y", 1, 0.0), ("Y", 1, 2.0), ("z", 2, 0.0), ("Z", 2, 1.5)];
    let mut out = String::new();
    for (name, axis, offset) in planes {
        let normal = [0, 1, 2].map(|c| i32::from(c == axis));
        out += &format!("[supports.{name}]\nplane = {{ normal = {normal:?}, offset = {offset} }}\n{text}\n");
    }
    out
}

#[test]
fn a_displacement_that_is_linear_in_x_y_z_is_found_exactly() {
    let text = sides("displacement = { x = \"1e-3*(x + 2*y - z) + 1\", y = \"-3e-3*z\", z = \"x*2e-3 - y/1000\" }");
    let problem = on_box([4, 5, 3], &format!("poissons_ratio = 0.3\n{text}"));
    let solution = solved(&problem);
    for (u, x) in solution.displacement.iter().zip(problem.mesh.points()) {
        let exact = DVec3::new(1e-3 * (x.x + 2.0 * x.y - x.z) + 1.0, -3e-3 * x.z, 2e-3 * x.x - 1e-3 * x.y);
        assert!((*u - exact).length() < 1e-12, "{u} at {x}");
    }
}

#[test]
fn tractions_of_a_constant_stress_give_its_displacement() {
    // s_xx = 3, s_xy = 2 written as fields: on x = 1 (3, 2, 0), on y = 2 (2, 0, 0), held by the exact displacement.
    let nu = 0.25;
    let held = "[supports.a]\nany = [{ group = \"x-min\" }, { group = \"y-min\" }]\n\
         displacement = { x = \"3e-3*x + 2e-3*2.5*y\", y = \"-0.25*3e-3*y\", z = \"-0.25*3e-3*z\" }\n";
    let loads = "[loads.x]\ngroup = \"x-max\"\ntraction = [\"3 + 0*y\", \"2*(x^2 - z + z)\", 0]\n\
         [loads.y]\ngroup = \"y-max\"\ntraction = [\"4/y + 0*x\", 0, 0]\n";
    let problem = on_box([3, 4, 3], &format!("poissons_ratio = {nu}\n{held}{loads}"));
    let solution = solved(&problem);
    for s in &solution.stress.means() {
        let exact = [3.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        assert!(s.iter().zip(exact).all(|(s, e)| (s - e).abs() < 1e-9), "{s:?}");
    }
}

/// The resultant and the moment of a traction that is quadratic over a face are its integrals.
#[test]
fn a_quadratic_traction_is_integrated_exactly() {
    let text = "poissons_ratio = 0.3\n[supports.a]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
         [loads.t]\ngroup = \"x-max\"\ntraction = [\"y^2\", \"x*z^2\", \"y*z + 1\"]\n";
    let problem = on_box([1, 2, 1], text);
    let forces = fem::load_forces(&fem::Space::linear(&problem.mesh), &problem.model, &problem.model.loads[0]).unwrap();
    let total: DVec3 = forces.iter().sum();
    // Over [0, 2] x [0, 1.5]: y^2 gives 8/3 * 1.5, z^2 2 * 1.125, y z + 1 gives 2 * 1.125 + 3.
    assert!((total - DVec3::new(4.0, 2.25, 5.25)).length() < 1e-13, "{total}");
    let moment: f64 = forces.iter().zip(problem.mesh.points()).map(|(f, p)| p.y * f.x).sum();
    assert!((moment - 4.0 * 1.5).abs() < 1e-13, "the integral of y^3");
}

#[test]
fn a_hydrostatic_pressure_makes_buoyancy() {
    let all = "any = [{ group = \"x-min\" }, { group = \"x-max\" }, { group = \"y-min\" }, { group = \"y-max\" }, \
         { group = \"z-min\" }, { group = \"z-max\" }]";
    let text =
        format!("poissons_ratio = 0.3\n{}\n[loads.water]\n{all}\npressure = \"9.81*(2 - z)\"\n", sides("spring = 1"));
    let problem = on_box([2, 2, 2], &text);
    let forces = fem::load_forces(&fem::Space::linear(&problem.mesh), &problem.model, &problem.model.loads[0]).unwrap();
    let total: DVec3 = forces.iter().sum();
    assert!((total - DVec3::new(0.0, 0.0, 9.81 * 3.0)).length() < 1e-12, "{total}");
}

/// With nu = 0 and free sides the column hangs as a bar: u = b (L x - x^2 / 2) / E, with strain energy A b^2 L^3 / (6 E).
/// That of the elements lies below and comes near at second order.
#[test]
fn a_column_under_a_body_force_stretches_quadratically() {
    let gap = |n: usize| {
        let text = "poissons_ratio = 0\n[supports.top]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
             [loads.own]\nbody_force = [\"7 + 0*x\", 0, 0]\n";
        let problem = on_box([n, n, n], text);
        let solution = solved(&problem);
        assert!((solution.reactions[0] - DVec3::new(-21.0, 0.0, 0.0)).length() < 1e-9);
        1.0 - solution.strain_energy / (3.0 * 49.0 / 6000.0)
    };
    let (coarse, fine) = (gap(3), gap(6));
    assert!(0.0 < fine && fine < 0.35 * coarse, "{coarse} {fine}");
}

#[test]
fn a_varying_body_force_and_gravity_agree_where_they_are_the_same() {
    let held = "density = 2\npoissons_ratio = 0.3\n[supports.a]\ngroup = \"z-min\"\nfix = [\"x\", \"y\", \"z\"]\n";
    let forces = |load: &str| {
        let p = on_box([2, 2, 2], &format!("{held}[loads.a]\n{load}\n"));
        fem::load_forces(&fem::Space::linear(&p.mesh), &p.model, &p.model.loads[0]).unwrap()
    };
    let gravity = forces("gravity = [0, 1, -9.81]");
    for load in ["body_force = [0, 2, -19.62]", "body_force = [\"0*x\", \"2\", \"-2*9.81 + y - y\"]"] {
        let off = forces(load).iter().zip(&gravity).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{load}: {off}");
    }
    // int x y^2 z over the box = 1/2 * 8/3 * 9/8.
    let total: DVec3 = forces("body_force = [\"x*y^2*z\", 0, 0]").iter().sum();
    assert!((total.x - 1.5).abs() < 1e-13, "{total}");
}

#[test]
fn a_stiff_block_on_a_foundation_sinks_by_force_over_k_times_area() {
    let text = "poissons_ratio = 0\n[supports.ground]\ngroup = \"z-min\"\nspring = [0.5, 0.5, 2]\n\
         [loads.weight]\ngroup = \"z-max\"\nforce = [1, 0, -6]\n";
    // The area is 2: shear 1 / (0.5 * 2), sinking 6 / (2 * 2), and the block turns under the moment of the shear.
    let problem = on_box([2, 2, 2], &text.replace("[1, 0, -6]", "[0, 0, -6]").replace("1000", "1e9"));
    let solution = solved(&problem);
    for (u, x) in solution.displacement.iter().zip(problem.mesh.points()) {
        // The load is uniform and nu = 0, so the block shortens by s L / E on top of its sinking.
        let exact = DVec3::new(0.0, 0.0, -1.5 - 3.0 * x.z / 1000.0);
        assert!((*u - exact).length() < 1e-10, "{u} at {x}");
    }
    assert!((solution.reactions[0] - DVec3::new(0.0, 0.0, 6.0)).length() < 1e-9);
    // Strain energy of the block alone: s^2 / (2 E) V.
    assert!((solution.strain_energy - 9.0 / 2000.0 * 3.0).abs() < 1e-10);
    assert_eq!(problem.model.supports[0].displacement, [None, None, None]);
    solved(&on_box([2, 2, 2], text));
}

#[test]
fn a_foundation_in_one_direction_leaves_the_others_free() {
    let text = "poissons_ratio = 0\n[supports.ground]\ngroup = \"z-min\"\nspring = [0, 0, 2]\n\
         [loads.weight]\ngroup = \"z-max\"\nforce = [0, 0, -6]\n";
    let problem = on_box([1, 1, 1], text);
    let Err(FemError::FreeMotion { motions, .. }) = fem::check_constraints(&problem.mesh, &problem.model) else {
        panic!()
    };
    assert!(motions[0].contains("move along x, move along y, rotate about z"), "{motions:?}");
}

#[test]
fn a_force_at_a_point_keeps_force_and_moment_on_every_refinement() {
    let text = "poissons_ratio = 0.3\n[supports.a]\ngroup = \"z-min\"\nfix = [\"x\", \"y\", \"z\"]\n\
         [loads.finger]\npoint = [0.3, 2.0, 1.1]\nforce = [1, -2, 3]\n[loads.corner]\npoint = [1, 2, 1.5]\nforce = [0, 0, 5]\n";
    let problem = on_box([2, 2, 2], text);
    let everywhere = vec![true; problem.mesh.tets().len()];
    let options = Options { scheme: Scheme::Red, ..Options::default() };
    let fine = subdiv::refine(&problem.mesh, &History::default(), &everywhere, &options).unwrap().mesh;
    for mesh in [&problem.mesh, &fine] {
        let forces = fem::load_forces(&fem::Space::linear(mesh), &problem.model, &problem.model.loads[1]).unwrap();
        let (at, force) = (DVec3::new(0.3, 2.0, 1.1), DVec3::new(1.0, -2.0, 3.0));
        assert!((forces.iter().sum::<DVec3>() - force).length() < 1e-14);
        let moment: DVec3 = forces.iter().zip(mesh.points()).map(|(f, p)| p.cross(*f)).sum();
        assert!((moment - at.cross(force)).length() < 1e-13);
        let (_, solution) = solve_on(mesh, &problem);
        assert!((solution.reactions[0] + force + DVec3::new(0.0, 0.0, 5.0)).length() < 1e-9);
        // On a vertex, all of it goes there.
        let forces = fem::load_forces(&fem::Space::linear(mesh), &problem.model, &problem.model.loads[0]).unwrap();
        let corner = mesh.points().iter().position(|p| *p == DVec3::new(1.0, 2.0, 1.5)).unwrap();
        assert!((forces[corner].z - 5.0).abs() < 1e-14);
    }
}

/// Half a bar with a symmetry plane is the whole bar: uniform tension is exact.
#[test]
fn sliding_and_symmetry_hold_the_normal_direction_only() {
    let slide = |what: &str| {
        let text = format!(
            "poissons_ratio = 0.3\n[supports.a]\ngroup = \"x-min\"\n{what}\n[supports.b]\ngroup = \"y-min\"\n{what}\n\
             [supports.c]\nplane = {{ normal = [0, 0, -2], offset = 0 }}\n{what}\n\
             [loads.pull]\ngroup = \"x-max\"\ntraction = [\"7\", 0, 0]\n"
        );
        on_box([3, 3, 2], &text)
    };
    for what in ["fix = [\"normal\"]", "fix = \"normal\"", "symmetry = true"] {
        let problem = slide(what);
        for (u, x) in solved(&problem).displacement.iter().zip(problem.mesh.points()) {
            assert!((*u - 7e-3 * DVec3::new(x.x, -0.3 * x.y, -0.3 * x.z)).length() < 1e-12, "{what}: {u} at {x}");
        }
    }
}
