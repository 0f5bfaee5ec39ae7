use super::super::assembly::System;
use super::super::loads::integrate_faces;
use super::super::numbering::{Dofs, Prescribed};
use super::super::options::{HexOptions, SolverOptions};
use super::super::{Load, LoadKind, Material, Model, Spectrum, Support, SymTensor, Weakly, solve, traction};
use super::*;
use crate::field::{Field, Function, VectorField};
use crate::mesh::GroupId;
use crate::mesh::generate::box_tets;
use crate::mesh::hex::generate::{box_hexes, from_tets, prism};
use crate::subdiv::catmull_clark;
use crate::subdiv::options::CatmullClark;

const ALL: [HexElement; 5] =
    [HexElement::Hex8, HexElement::Hex20, HexElement::Hex27, HexElement::CatmullClark, HexElement::CatmullClarkPlus];

/// lambda = 1, mu = 0.7.
fn material() -> Material {
    let (lambda, mu) = (1.0, 0.7);
    let youngs_modulus = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
    Material { youngs_modulus, poissons_ratio: lambda / (2.0 * (lambda + mu)), density: 0.0 }
}

/// phi = e^(1.5 x) cos 0.9 y cos 1.2 z is harmonic: its gradient is a displacement without body force, with the stress
/// 2 mu Hess phi.
fn harmonic(x: DVec3) -> SymTensor {
    let e = (1.5 * x.x).exp();
    let ((sy, cy), (sz, cz)) = ((0.9 * x.y).sin_cos(), (1.2 * x.z).sin_cos());
    let h = [
        2.25 * e * cy * cz,
        -0.81 * e * cy * cz,
        -1.44 * e * cy * cz,
        -1.35 * e * sy * cz,
        1.08 * e * sy * sz,
        -1.8 * e * cy * sz,
    ];
    h.map(|h| 1.4 * h)
}

/// Solves under the tractions of a stress, six coefficients of corners held against rigid motions.
fn under_tractions(space: &HexSpace<'_>, stress: fn(DVec3) -> SymTensor) -> (HexSolution, Model) {
    let model = Model { materials: vec![material()], supports: Vec::new(), loads: Vec::new() };
    let mesh = space.mesh();
    let corners = corners_below(mesh);
    let [a, b, c] = corners.map(|v| mesh.points()[v as usize]);
    // About the z axis corner b turns across the way to it.
    let across = (b - a).cross(DVec3::Z).abs();
    let turning = u8::from(across.y > across.x);
    assert!((c - a).cross(b - a).length() > 0.1);
    let held = |v: usize, components: &[u8]| -> Vec<Prescribed> {
        let hold = |&component| Prescribed { node: corners[v], component, value: 0.0, support: 0 };
        components.iter().map(hold).collect()
    };
    let mut prescribed = [held(0, &[0, 1, 2]), held(1, &[turning, 2]), held(2, &[2])].concat();
    prescribed.sort_by_key(|p| (p.node, p.component));
    let mut loads = vec![DVec3::ZERO; space.points().len()];
    for group in (0..mesh.groups().len() as u32).map(GroupId) {
        integrate_faces(space, group, &mut loads, |area, x| Ok(traction(stress(x), area))).unwrap();
    }
    let stiffness = matrix::stiffness(space, &model.materials).unwrap();
    let numbering = Dofs::from_used(vec![true; loads.len()], prescribed);
    let system = System { stiffness, loads, numbering, points: space.whereabouts(), linear: None };
    let options = SolverOptions { method: super::super::options::Method::Direct, ..SolverOptions::default() };
    let solved = solve(&system, &options, None).unwrap();
    let solution = HexSolution {
        displacement: solved.displacement,
        strain_energy: 0.0,
        compliance: 0.0,
        reactions: Vec::new(),
        info: solved.info,
    };
    (solution, model)
}

/// Three vertices in the plane z = 0 where creases meet: their coefficients are their displacements.
fn corners_below(mesh: &HexMesh) -> [u32; 3] {
    let meet = |v: &u32| mesh.creases().iter().filter(|c| c.vertices.contains(v)).count() > 2;
    let below = (0..mesh.points().len() as u32).filter(|v| mesh.points()[*v as usize].z == 0.0);
    let corners: Vec<u32> = below.filter(meet).collect();
    [corners[0], corners[1], corners[2]]
}

/// Relative error in the energy norm.
fn energy_error(space: &HexSpace<'_>, model: &Model, solution: &HexSolution, stress: fn(DVec3) -> SymTensor) -> f64 {
    let rule = Rule::cube(6);
    let tables = space.tables(rule.points.clone());
    let mut sums = [0.0; 2];
    for t in 0..space.mesh().cells().len() {
        let table = tables.of(space, t);
        for (q, weight) in rule.weights.iter().enumerate() {
            let (x, jacobian) = space.frame(t, &table, q);
            let (exact, computed) = (stress(x), solution.stress(space, model, t, &table, q));
            let volume = weight * jacobian.determinant();
            let error = std::array::from_fn(|i| exact[i] - computed[i]);
            sums[0] += volume * model.materials[0].compliance_energy(error);
            sums[1] += volume * model.materials[0].compliance_energy(exact);
        }
    }
    (sums[0] / sums[1]).sqrt()
}

fn cube(n: usize) -> HexMesh {
    box_hexes([1.0; 3], [n; 3]).unwrap().with_creases(30.0, &[])
}

/// Figures of a prototype in another language, to the digits it gave.
#[test]
fn errors_under_the_tractions_of_a_harmonic_potential() {
    type Rows = &'static [(usize, f64, f64)];
    let expected: [(HexElement, Rows); 4] = [
        (HexElement::Hex8, &[(2, 0.208, 5e-4), (4, 0.107, 5e-4), (8, 0.0538, 5e-5), (16, 0.0270, 5e-5)]),
        (HexElement::Hex27, &[(2, 0.0189, 5e-5), (4, 4.91e-3, 5e-6), (8, 1.25e-3, 5e-6)]),
        (HexElement::CatmullClark, &[(2, 0.0934, 5e-5), (4, 0.0363, 5e-5), (8, 0.0133, 5e-5), (16, 4.73e-3, 5e-6)]),
        (HexElement::CatmullClarkPlus, &[(2, 1.65e-3, 5e-6), (4, 2.4e-4, 5e-6), (8, 3.2e-5, 5e-7)]),
    ];
    let mut wrong = Vec::new();
    for (element, rows) in expected {
        for &(n, want, digits) in rows {
            let mesh = cube(n);
            let space = HexSpace::new(&mesh, element, HexOptions::default());
            let (solution, model) = under_tractions(&space, harmonic);
            let error = energy_error(&space, &model, &solution, harmonic);
            if (error - want).abs() > digits {
                wrong.push((element, n, error, want));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The bar [0, 4] x [0, 1] x [0, 1] clamped at both ends under a load on its top.
fn bar(element: HexElement, nx: usize) -> ((usize, f64, f64), Spectrum) {
    let mesh = box_hexes([4.0, 1.0, 1.0], [nx, nx / 4, nx / 4]).unwrap().with_creases(30.0, &[]);
    let space = HexSpace::new(&mesh, element, HexOptions::default());
    let group = |name| mesh.group(name).unwrap();
    let top = group("z-max");
    let model = Model {
        materials: vec![Material { youngs_modulus: 1.0, poissons_ratio: 0.3, density: 0.0 }],
        supports: ["x-min", "x-max"].map(|g| Support::new(g, group(g), [Some(0.0); 3])).to_vec(),
        loads: vec![Load { name: "load".to_owned(), kind: LoadKind::Traction(top, VectorField::from(DVec3::NEG_Z)) }],
    };
    let system = assemble_hexes(&space, &model).unwrap();
    let solved = solve(&system, &SolverOptions::default(), None).unwrap();
    let solution = recover_hexes(&space, &model, &system, &solved);
    // As the prototype did: at nodes of serendipity cells, at Gauss points of others.
    let side = |i: usize| i as f64 / 2.0;
    let points: Vec<DVec3> = match element {
        HexElement::Hex20 => (0..9).map(|i| DVec3::new(side(i % 3), side(i / 3), 1.0)).collect(),
        _ => Rule::face(5, 5).points,
    };
    let tables = space.tables(points.clone());
    let mut lowest = 0.0_f64;
    for (t, _) in mesh.group_faces(top).map(|f| space.cell_of_face(f)) {
        for q in 0..points.len() {
            lowest = lowest.min(space.interpolate(&solution.displacement, t, &tables.of(&space, t), q).z);
        }
    }
    ((system.free_dofs(), -lowest, solution.compliance), Spectrum::of(&system))
}

#[test]
fn a_clamped_bar() {
    use HexElement::{CatmullClark as Cc, CatmullClarkPlus as Plus, Hex8, Hex20, Hex27};
    // Unknowns, largest displacement, compliance, condition number plain and scaled, iterations with scaling.
    let expected = [
        (Hex8, 16, 1125, 13.160, 31.155, [1.2e3, 9.1e2], 40..100),
        (Hex8, 32, 7533, 13.768, 32.669, [4.5e3, 3.8e3], 108..111),
        (Hex20, 8, 657, 13.653, 32.160, [3.8e3, 2.5e3], 98..101),
        (Hex20, 16, 4125, 13.931, 33.021, [1.4e4, 1.0e4], 182..185),
        (Hex27, 8, 1125, 13.763, 32.647, [2.7e3, 1.7e3], 69..72),
        (Hex27, 16, 7533, 13.967, 33.198, [8.9e3, 6.8e3], 141..144),
        (Cc, 4, 36, 11.509, 26.811, [1.0e2, 1.0e2], 10..11),
        (Cc, 8, 189, 12.751, 30.118, [1.5e2, 1.4e2], 45..48),
        (Cc, 16, 1125, 13.755, 32.582, [4.9e2, 4.6e2], 94..97),
        (Cc, 32, 7533, 13.966, 33.169, [1.6e3, 1.5e3], 136..139),
        (Plus, 16, 2499, 13.999, 33.298, [3.7e8, 4.0e3], 372..376),
    ];
    let mut wrong = Vec::new();
    for (element, nx, dofs, displacement, compliance, conditions, iterations) in expected {
        let (got, spectrum) = bar(element, nx);
        let near = |got: f64, want: f64| (got / want - 1.0).abs() < 0.1;
        let right = got.0 == dofs
            && (got.1 - displacement).abs() < 6e-4
            && (got.2 - compliance).abs() < 6e-4
            && near(spectrum.condition, conditions[0])
            && near(spectrum.scaled_condition, conditions[1])
            && iterations.contains(&spectrum.scaled_iterations);
        if !right {
            wrong.push((element, nx, got, spectrum));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A constant strain is exact for all elements on cells that are no boxes, when the integrals are.
#[test]
fn patch_test() {
    for element in ALL {
        let mut parts = cube(4).into_parts();
        // Vertices inside move; those of the boundary stay.
        for (i, p) in parts.points.iter_mut().enumerate() {
            let inside = (0..3).all(|a| p[a] > 0.01 && p[a] < 0.99);
            if inside {
                let wobble = |k: usize| 0.04 * ((i * (k + 3)) as f64 * 1.7).sin();
                *p += DVec3::new(wobble(0), wobble(1), wobble(2));
            }
        }
        let mesh = HexMesh::new(parts).unwrap();
        let options = HexOptions { points: element_points(element), ..HexOptions::default() };
        let space = HexSpace::new(&mesh, element, options);
        let stress = |_: DVec3| [1.0, -0.4, 0.3, 0.2, 0.7, -0.5];
        let (solution, model) = under_tractions(&space, stress);
        let error = energy_error(&space, &model, &solution, stress);
        assert!(error < 1e-12, "{element:?}: {error:.3e}");
    }
}

/// Gauss points that integrate the products of gradients exactly on cells that are no boxes.
fn element_points(element: HexElement) -> Option<usize> {
    let smooth = matches!(element, HexElement::CatmullClark | HexElement::CatmullClarkPlus);
    smooth.then_some(5)
}

/// Along an edge where three or five cells meet the functions are no polynomials, but errors fall by order 1.7 and more.
#[test]
fn orders_of_convergence_around_extraordinary_edges() {
    for sides in [3, 5] {
        // Refined by its masks the body stays as it is, and so does the way its cells are mapped.
        let error = |steps: usize| {
            let mut mesh = prism(sides, 1.0, 1.0, [2, 2]).unwrap().with_creases(30.0, &[]);
            (0..steps).for_each(|_| mesh = catmull_clark::refine(&mesh, CatmullClark::Bajaj).unwrap().mesh);
            let options = HexOptions { splits: 1, ..HexOptions::default() };
            let space = HexSpace::new(&mesh, HexElement::CatmullClarkPlus, options);
            let (solution, model) = under_tractions(&space, harmonic);
            energy_error(&space, &model, &solution, harmonic)
        };
        let errors = [0, 1, 2].map(error);
        let order = (errors[1] / errors[2]).log2();
        assert!(order > 1.7, "{sides} sides: {errors:?}");
    }
}

/// The patch test where other than four cells meet at edges: an error of quadrature, which falls as cells are split for it.
#[test]
fn patch_test_around_extraordinary_edges() {
    let stress = |_: DVec3| [1.0, -0.4, 0.3, 0.2, 0.7, -0.5];
    let brick = box_tets([1.0; 3], [1; 3]).unwrap();
    for (name, mesh) in [
        ("3", prism(3, 1.0, 1.0, [2, 2]).unwrap()),
        ("5", prism(5, 1.0, 1.0, [2, 2]).unwrap()),
        ("6", prism(6, 1.0, 1.0, [2, 2]).unwrap()),
        ("mixed", from_tets(&brick).unwrap()),
    ] {
        let mesh = mesh.with_creases(30.0, &[]);
        for element in [HexElement::CatmullClark, HexElement::CatmullClarkPlus] {
            let error = |splits: u32| {
                let space = HexSpace::new(&mesh, element, HexOptions { splits, ..HexOptions::default() });
                let (solution, model) = under_tractions(&space, stress);
                energy_error(&space, &model, &solution, stress)
            };
            let errors = [0, 1, 2, 3].map(error);
            let default = errors[HexOptions::default().splits as usize];
            assert!(default < 5e-4 && errors.windows(2).all(|w| w[1] < w[0]), "{name}: {errors:?}");
        }
    }
}

/// An infinitesimal rotation prescribed at one end and nothing at the other is exact, and stores no energy.
#[test]
fn affine_displacements_of_supports_are_exact() {
    let mesh = prism(5, 1.0, 2.0, [1, 2]).unwrap();
    let group = |name: &str| mesh.group(name).unwrap();
    let ends = [group("z-min"), group("z-max")];
    let mesh = mesh.with_creases(30.0, &ends);
    let turn =
        |c: usize| Some(Field::Function(Function::new("rotation", move |x| DVec3::new(0.2, 0.3, 0.5).cross(x)[c])));
    let support = |group| Support { displacement: [0, 1, 2].map(turn), ..Support::new("end", group, [None; 3]) };
    let model = Model { materials: vec![material()], supports: vec![support(ends[0])], loads: Vec::new() };
    for element in ALL {
        let space = HexSpace::new(&mesh, element, HexOptions::default());
        let system = assemble_hexes(&space, &model).unwrap();
        let solved = solve(&system, &SolverOptions::default(), None).unwrap();
        let solution = recover_hexes(&space, &model, &system, &solved);
        assert!(solution.strain_energy < 1e-16, "{element:?}: {}", solution.strain_energy);
    }
}

/// The estimate tells the error of a smooth problem.
#[test]
fn estimates_are_as_large_as_errors() {
    let bounds = [
        (HexElement::Hex8, 0.9, 1.1),
        (HexElement::Hex20, 0.9, 3.0),
        (HexElement::Hex27, 0.9, 3.0),
        (HexElement::CatmullClark, 0.6, 1.1),
        (HexElement::CatmullClarkPlus, 0.9, 4.0),
    ];
    for (element, least, most) in bounds {
        let mesh = cube(4);
        let space = HexSpace::new(&mesh, element, HexOptions::default());
        let (solution, model) = under_tractions(&space, harmonic);
        let recovered = RecoveredStress::new(&space, &model, &solution);
        let estimate = HexErrors::estimate(&space, &model, &solution, &recovered).energy();
        let zero = HexSolution { displacement: vec![DVec3::ZERO; space.points().len()], ..solution.clone() };
        // Without a displacement the error is the whole.
        let [of_nothing, of_solution] = [&zero, &solution].map(|s| energy_error(&space, &model, s, harmonic));
        let nothing = RecoveredStress::new(&space, &model, &zero);
        assert!((of_nothing - 1.0).abs() < 1e-12);
        assert_eq!(HexErrors::estimate(&space, &model, &zero, &nothing).energy(), 0.0);
        let size = (2.0 * solution_energy(&space, &model, harmonic)).sqrt();
        let effectivity = estimate / (of_solution * size);
        assert!((least..most).contains(&effectivity), "{element:?}: {effectivity:.3}");
    }
}

/// Energy of a stress in the body.
fn solution_energy(space: &HexSpace<'_>, model: &Model, stress: fn(DVec3) -> SymTensor) -> f64 {
    let rule = Rule::cube(6);
    let tables = space.tables(rule.points.clone());
    let cells = 0..space.mesh().cells().len();
    let point = |t: usize, q: usize| {
        let (x, jacobian) = space.frame(t, &tables.of(space, t), q);
        0.5 * rule.weights[q] * jacobian.determinant() * model.materials[0].compliance_energy(stress(x))
    };
    cells.flat_map(|t| (0..rule.weights.len()).map(move |q| (t, q))).map(|(t, q)| point(t, q)).sum()
}

/// A constant stress is recovered as it is, at the boundary too, where bubbles of the first layer reach into the second.
#[test]
fn a_constant_stress_is_recovered() {
    for element in ALL {
        let mesh = cube(4);
        let space =
            HexSpace::new(&mesh, element, HexOptions { points: element_points(element), ..HexOptions::default() });
        let stress = |_: DVec3| [1.0, -0.4, 0.3, 0.2, 0.7, -0.5];
        let (solution, model) = under_tractions(&space, stress);
        let recovered = RecoveredStress::new(&space, &model, &solution);
        let tables = space.tables(Rule::cube(3).points);
        for t in 0..mesh.cells().len() {
            for q in 0..27 {
                let got = recovered.at(&space, t, &tables.of(&space, t), q);
                let worst = (0..6).map(|c| (got[c] - stress(DVec3::ZERO)[c]).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-6, "{element:?}, cell {t}: {got:?}");
            }
        }
    }
}

/// A beam on an oblique plane, held along the plane's normal in the mean: the stress of its uniaxial tension is exact.
#[test]
fn sliding_on_an_oblique_plane() {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    for element in ALL {
        let mut parts = box_hexes([2.0, 1.0, 1.0], [4, 2, 2]).unwrap().into_parts();
        parts.points.iter_mut().for_each(|p| *p = turn * *p);
        let mesh = HexMesh::new(parts).unwrap().with_creases(30.0, &[]);
        let group = |name: &str| mesh.group(name).unwrap();
        let slide = |name: &str| Support { weakly: Some(Weakly::Normal), ..Support::new(name, group(name), [None; 3]) };
        let pull = Load {
            name: "pull".to_owned(),
            kind: LoadKind::Traction(group("x-max"), VectorField::from(turn * DVec3::X)),
        };
        let model = Model {
            materials: vec![material()],
            supports: ["x-min", "y-min", "z-min"].map(slide).to_vec(),
            loads: vec![pull],
        };
        let space = HexSpace::new(&mesh, element, HexOptions::default());
        check_hex_constraints(&space, &model).unwrap();
        let system = assemble_hexes(&space, &model).unwrap();
        let options = SolverOptions { tolerance: 1e-12, ..SolverOptions::default() };
        let solved = solve(&system, &options, None).unwrap();
        let solution = recover_hexes(&space, &model, &system, &solved);
        let energy = 0.5 * 2.0 / material().youngs_modulus;
        assert!((solution.strain_energy / energy - 1.0).abs() < 1e-8, "{element:?}: {}", solution.strain_energy);
        let held = turn * -DVec3::X;
        assert!(solution.reactions[0].distance(held) < 1e-7, "{element:?}: {}", solution.reactions[0]);
        assert!(solution.reactions[1].length() < 1e-7 && solution.reactions[2].length() < 1e-7);
    }
}

/// A clamp in the mean comes to the same as one at nodes as meshes get finer, and its force balances the load.
#[test]
fn a_clamp_in_the_mean() {
    for element in ALL {
        let apart = [2, 4].map(|n| {
            let mesh = box_hexes([2.0, 1.0, 1.0], [2 * n, n, n]).unwrap().with_creases(30.0, &[]);
            let group = |name: &str| mesh.group(name).unwrap();
            let load = Load { name: "load".to_owned(), kind: LoadKind::Force(group("x-max"), DVec3::NEG_Z) };
            let energy = |weakly| {
                let clamp = Support { weakly, ..Support::new("clamp", group("x-min"), [Some(0.0); 3]) };
                let model = Model { materials: vec![material()], supports: vec![clamp], loads: vec![load.clone()] };
                let space = HexSpace::new(&mesh, element, HexOptions::default());
                let system = assemble_hexes(&space, &model).unwrap();
                let solved = solve(&system, &SolverOptions::default(), None).unwrap();
                let solution = recover_hexes(&space, &model, &system, &solved);
                assert!(solution.reactions[0].distance(DVec3::Z) < 1e-6, "{element:?}: {}", solution.reactions[0]);
                solution.strain_energy
            };
            (energy(Some(Weakly::Components)) / energy(None) - 1.0).abs()
        });
        assert!(apart[1] < 0.9 * apart[0] && apart[1] < 0.03, "{element:?}: {apart:?}");
    }
}
