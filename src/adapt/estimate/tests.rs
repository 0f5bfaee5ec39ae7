//! Properties of the estimator: what it must not see, what it must see, and how it scales.

use super::*;
use crate::adapt::options::Marking;
use crate::fem::options::Element;
use crate::mesh::generate::box_tets;
use crate::mesh::{RegionId, TetMesh};
use glam::DVec3;
use proptest::prelude::*;

const STEEL: Material = Material { youngs_modulus: 210.0, poissons_ratio: 0.3, density: 0.0 };
const BOTH: [Estimator; 2] = [Estimator::Spr, Estimator::Averaging];

/// The mean of a linear stress on each cell: its value at the centroid.
fn sample(mesh: &TetMesh, stress: impl Fn(DVec3) -> SymTensor) -> Vec<SymTensor> {
    (0..mesh.tets().len()).map(|t| stress(mesh.cell_points(t).into_iter().sum::<DVec3>() / 4.0)).collect()
}

fn linear(p: DVec3) -> SymTensor {
    [1.0 + p.x, 2.0 - 3.0 * p.y, p.x + p.z, 4.0 * p.z, 0.5 * p.x - p.y, 2.0]
}

fn kinked(p: DVec3) -> SymTensor {
    [(p.x - 0.5).abs(), 0.0, 0.0, (p.y - 0.3).max(0.0), 0.0, 0.0]
}

/// A box whose vertices are moved off the lattice, the outer ones too, so that nothing holds by symmetry.
fn skewed_box(n: usize) -> TetMesh {
    let mut parts = box_tets([1.0; 3], [n; 3]).unwrap().into_parts();
    let size = 0.12 / n as f64;
    for (i, p) in parts.points.iter_mut().enumerate() {
        let i = i as f64;
        *p += size * DVec3::new((12.9 * i).sin(), (78.2 * i).sin(), (37.7 * i).cos());
    }
    TetMesh::new(parts).unwrap()
}

/// The box in two regions that meet at x = 1/2.
fn two_regions(n: usize) -> TetMesh {
    let mesh = box_tets([1.0; 3], [n; 3]).unwrap();
    let regions = sample(&mesh, |p| [p.x; 6]).iter().map(|s| RegionId(u16::from(s[0] > 0.5))).collect();
    let mut parts = mesh.into_parts();
    parts.regions = regions;
    parts.region_names = vec!["left".to_owned(), "right".to_owned()];
    TetMesh::new(parts).unwrap()
}

/// Vertices off the boundary.
fn inner_vertices(mesh: &TetMesh) -> Vec<usize> {
    let mut inner = vec![true; mesh.points().len()];
    mesh.faces().iter().flat_map(|f| f.vertices).for_each(|v| inner[v as usize] = false);
    (0..inner.len()).filter(|&v| inner[v]).collect()
}

fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-11 * scale
}

#[test]
fn a_constant_stress_has_no_error() {
    let mesh = skewed_box(3);
    let stress = [3.0, -1.0, 2.0, 0.5, 0.25, -4.0];
    for estimator in BOTH {
        let errors = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(sample(&mesh, |_| stress)), estimator);
        assert!(errors.energy() < 1e-13, "{estimator:?}: {}", errors.energy());
        for s in &errors.nodal_stress {
            assert!((0..6).all(|i| close(s[i], stress[i], 4.0)));
        }
    }
}

/// SPR gives a linear stress back at every inner vertex; averaging does not on a skewed mesh.
#[test]
fn spr_recovers_a_linear_stress_exactly() {
    let mesh = skewed_box(4);
    let stress = sample(&mesh, linear);
    let worst = |estimator| {
        let recovered =
            estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(stress.clone()), estimator).nodal_stress;
        let difference = |v: usize| minus(&recovered[v], &linear(mesh.points()[v])).map(f64::abs);
        inner_vertices(&mesh).into_iter().flat_map(difference).fold(0.0, f64::max)
    };
    assert!(worst(Estimator::Spr) < 1e-12, "{}", worst(Estimator::Spr));
    assert!(worst(Estimator::Averaging) > 1e-3, "{}", worst(Estimator::Averaging));
}

/// On a cell with four inner vertices the estimate for a linear stress is the exact integral, here by a quadrature of
/// degree two on the cell (Hammer and Stroud 1956, four points).
#[test]
fn the_integral_is_exact() {
    let mesh = skewed_box(5);
    let stress = sample(&mesh, linear);
    let errors = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(stress.clone()), Estimator::Spr);
    let mut inner = vec![false; mesh.points().len()];
    inner_vertices(&mesh).into_iter().for_each(|v| inner[v] = true);
    let root5 = 5.0_f64.sqrt();
    let (near, far) = ((5.0 + 3.0 * root5) / 20.0, (5.0 - root5) / 20.0);
    let cells: Vec<usize> = (0..stress.len()).filter(|&t| mesh.tets()[t].iter().all(|&v| inner[v as usize])).collect();
    assert!(cells.len() > 100);
    for t in cells {
        let p = mesh.cell_points(t);
        let points = p.map(|q| far * p.into_iter().sum::<DVec3>() + (near - far) * q);
        let integral: f64 = points.iter().map(|&q| STEEL.compliance_energy(minus(&linear(q), &stress[t]))).sum();
        let want = 0.25 * mesh.cell_volume(t) * integral;
        assert!(close(errors.squared[t], want, want), "{} {want}", errors.squared[t]);
    }
}

#[test]
fn a_jump_within_a_region_is_seen_where_it_is() {
    let mesh = box_tets([1.0; 3], [8; 3]).unwrap();
    let stress = sample(&mesh, |p| [(p.x - 0.5).signum(), 0.0, 0.0, 0.0, 0.0, 0.0]);
    for estimator in BOTH {
        let errors = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(stress.clone()), estimator);
        for (t, &squared) in errors.squared.iter().enumerate() {
            let x = mesh.cell_points(t).into_iter().sum::<DVec3>().x / 4.0;
            if (x - 0.5).abs() < 0.125 {
                assert!(squared > 1e-8, "{estimator:?} misses cell {t} at x = {x}");
            } else {
                assert!(squared < 1e-24, "{estimator:?} sees cell {t} at x = {x}");
            }
        }
    }
}

/// The complementary product inverts Hooke's law: eps : C : eps = s : C^-1 : s.
#[test]
fn the_complementary_product_is_the_energy_of_the_strain() {
    let (e, nu) = (STEEL.youngs_modulus, STEEL.poissons_ratio);
    let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let strain = [0.1, -0.2, 0.3, 0.05, -0.15, 0.25];
    let trace: f64 = strain[..3].iter().sum();
    let stress = std::array::from_fn(|i| 2.0 * mu * strain[i] + if i < 3 { lambda * trace } else { 0.0 });
    let product: f64 = (0..6).map(|i| if i < 3 { 1.0 } else { 2.0 } * stress[i] * strain[i]).sum();
    assert!(close(STEEL.compliance_energy(stress), product, product));
}

#[test]
fn a_jump_between_regions_is_no_error() {
    let mesh = two_regions(4);
    let soft = Material { youngs_modulus: 1.0, ..STEEL };
    let stress = sample(&mesh, |p| if p.x > 0.5 { [100.0; 6] } else { [1.0; 6] });
    for estimator in BOTH {
        let errors = estimate(&Space::linear(&mesh), &[STEEL, soft], &Stress::constant(stress.clone()), estimator);
        assert!(errors.energy() < 1e-11, "{estimator:?}: {}", errors.energy());
        // Output shows the mean on the interface; at the centre both regions have the same volume.
        let middle = mesh.points().iter().position(|p| *p == DVec3::splat(0.5)).unwrap();
        assert!(close(errors.nodal_stress[middle][0], 50.5, 100.0), "{:?}", errors.nodal_stress[middle]);
    }
}

#[test]
fn the_squared_error_grows_with_the_square_of_the_load() {
    let mesh = skewed_box(3);
    let stress = sample(&mesh, kinked);
    let thrice: Vec<SymTensor> = stress.iter().map(|s| s.map(|x| 3.0 * x)).collect();
    for estimator in BOTH {
        let [one, nine] = [&stress, &thrice].map(|s| {
            estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(s.clone()), estimator).energy().powi(2)
        });
        assert!(close(nine, 9.0 * one, nine) && one > 0.0);
    }
}

#[test]
fn flat_patches_are_averaged() {
    // A plate one brick thick has no vertex inside.
    let mesh = box_tets([10.0, 10.0, 1e-3], [5, 5, 1]).unwrap();
    let errors = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(sample(&mesh, linear)), Estimator::Spr);
    assert!(errors.energy().is_finite());
    let largest = errors.nodal_stress.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(largest <= 40.0, "{largest}");
}

#[test]
fn the_relative_error_compares_with_the_exact_energy() {
    let errors = CellErrors {
        squared: vec![4.0, 5.0],
        unseen: Vec::new(),
        raised: Vec::new(),
        unresolved: Vec::new(),
        nodal_stress: Vec::new(),
        recovered: Recovered::default(),
        unestimated: Vec::new(),
    };
    // 2 U_exact = 2 U_h + eta^2 = 16 + 9
    assert!(close(errors.relative(8.0), 0.6, 1.0));
    assert_eq!(
        CellErrors {
            squared: vec![0.0],
            unseen: Vec::new(),
            raised: Vec::new(),
            unresolved: Vec::new(),
            nodal_stress: Vec::new(),
            recovered: Recovered::default(),
            unestimated: Vec::new()
        }
        .relative(0.0),
        0.0
    );
}

/// A cell put on the middle of a side has a vertex of its own: its own stress there is no recovered stress.
#[test]
fn a_vertex_of_one_cell_sees_the_cells_around_it() {
    let parts = skewed_box(4).into_parts();
    let (mut points, mut tets) = (parts.points, parts.tets);
    let centre = |f: [u32; 3]| f.into_iter().map(|v| points[v as usize]).sum::<DVec3>() / 3.0;
    let target = DVec3::new(0.5, 0.5, 1.0);
    let nearest = |f: &&crate::mesh::Face, g: &&crate::mesh::Face| {
        centre(f.vertices).distance(target).total_cmp(&centre(g.vertices).distance(target))
    };
    let [a, b, c] = parts.faces.iter().min_by(nearest).unwrap().vertices;
    let (tip, own) = (points.len() as u32, tets.len());
    points.push(centre([a, b, c]) + 0.2 * DVec3::Z);
    tets.push([a, b, c, tip]);
    let mesh = TetMesh::from_cells(points, tets, "solid").unwrap();
    let stress = sample(&mesh, linear);
    let errors = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(stress.clone()), Estimator::Spr);
    let (recovered, exact) = (errors.nodal_stress[tip as usize], linear(mesh.points()[tip as usize]));
    assert!((0..6).all(|i| close(recovered[i], exact[i], 10.0)), "{recovered:?} {exact:?} {:?}", stress[own]);
}

/// A region of one cell, and a mesh of one cell: nothing is known about their errors, and nothing else is said.
#[test]
fn the_error_of_an_isolated_cell_is_not_known() {
    let mut parts = box_tets([1.0; 3], [2; 3]).unwrap().into_parts();
    parts.region_names.push("inlay".to_owned());
    parts.regions[7] = RegionId(1);
    let mesh = TetMesh::new(parts).unwrap();
    let tet =
        TetMesh::from_cells(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2, 3]], "solid").unwrap();
    for estimator in BOTH {
        for (mesh, cell) in [(&mesh, 7), (&tet, 0)] {
            let errors =
                estimate(&Space::linear(mesh), &[STEEL; 2], &Stress::constant(sample(mesh, kinked)), estimator);
            assert_eq!(errors.unestimated, [cell]);
            assert!(errors.energy().is_nan() && errors.relative(1.0).is_nan() && errors.relative(0.0).is_nan());
            let marked = crate::adapt::mark(&errors.squared, &errors.unestimated, Marking::Threshold(1e9)).unwrap();
            assert!((0..marked.len()).all(|t| marked[t] == (t == cell as usize)));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Other numbers for vertices and cells give the same errors but for rounding.
    #[test]
    fn the_estimate_follows_a_relabelling(
        vertex_order in Just((0..64_usize).collect::<Vec<_>>()).prop_shuffle(),
        cell_order in Just((0..162_usize).collect::<Vec<_>>()).prop_shuffle(),
        rotate in 0..3_usize,
    ) {
        let mesh = skewed_box(3);
        let points = vertex_order.iter().map(|&v| mesh.points()[v]).collect();
        let mut new_number = vec![0_u32; 64];
        vertex_order.iter().zip(0..).for_each(|(&v, new)| new_number[v] = new);
        let relabelled = |&t: &usize| {
            let mut tet = mesh.tets()[t].map(|v| new_number[v as usize]);
            tet[..3].rotate_left(rotate);
            tet
        };
        let other = TetMesh::from_cells(points, cell_order.iter().map(relabelled).collect(), "solid").unwrap();
        for estimator in BOTH {
            let one = estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(sample(&mesh, kinked)), estimator);
            let two = estimate(&Space::linear(&other), &[STEEL], &Stress::constant(sample(&other, kinked)), estimator);
            let scale = one.squared.iter().copied().fold(0.0, f64::max);
            for (new, &old) in cell_order.iter().enumerate() {
                prop_assert!(close(two.squared[new], one.squared[old], scale));
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let mesh = skewed_box(6);
    let stress = sample(&mesh, kinked);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| estimate(&Space::linear(&mesh), &[STEEL], &Stress::constant(stress.clone()), Estimator::Spr))
    };
    assert_eq!(with(1), with(4));
}

/// A linear stress in ten-node cells is continuous, so that neither method sees an error, at whatever vertex.
#[test]
fn ten_node_cells_have_no_error_where_the_stress_is_linear() {
    for mesh in [skewed_box(3), skewed_box(1)] {
        let corners: Vec<[SymTensor; 4]> = (0..mesh.tets().len()).map(|t| mesh.cell_points(t).map(linear)).collect();
        let space = Space::new(&mesh, Element::Tet10, &[]);
        for estimator in BOTH {
            let errors = estimate(&space, &[STEEL], &Stress::linear(&corners), estimator);
            assert!(errors.energy() < 1e-10, "{estimator:?}: {}", errors.energy());
            for (s, x) in errors.nodal_stress.iter().zip(space.points()) {
                assert!(s.iter().zip(linear(*x)).all(|(a, b)| close(*a, b, 100.0)), "{estimator:?} at {x}: {s:?}");
            }
        }
    }
}

/// A quadratic stress, of which each cell has the linear interpolant between its vertices minus the mean of what that
/// misses, is recovered exactly by SPR at the nodes whose patches fit; so the estimate is the error.
#[test]
fn the_recovered_stress_of_ten_node_cells_is_the_best_quadratic() {
    let quadratic = |p: DVec3| [p.x * p.x, p.y * p.z, p.z * p.z - p.x, p.x * p.y, 1.0 - p.y * p.y, p.x * p.z];
    let mesh = skewed_box(4);
    let space = Space::new(&mesh, Element::Tet10, &[]);
    // The linear function that agrees with the quadratic at the four sampling points of each cell.
    let (own, other) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    let corners: Vec<[SymTensor; 4]> = (0..mesh.tets().len())
        .map(|t| {
            let x = mesh.cell_points(t);
            let sum: DVec3 = x.into_iter().sum();
            let at = x.map(|x| quadratic(own * x + other * (sum - x)));
            // s_k = (own - other) c_k + other sum c, with sum s = sum c.
            std::array::from_fn(|k| {
                std::array::from_fn(|i| (at[k][i] - other * at.iter().map(|s| s[i]).sum::<f64>()) / (own - other))
            })
        })
        .collect();
    let stress = Stress::linear(&corners);
    let errors = estimate(&space, &[STEEL], &stress, Estimator::Spr);
    for (s, x) in errors.nodal_stress.iter().zip(space.points()) {
        assert!(s.iter().zip(quadratic(*x)).all(|(a, b)| close(*a, b, 1000.0)), "at {x}: {s:?}");
    }
    // The integral of the squared difference, by the midpoint rule on a cube collapsed to the cell.
    let n = 30;
    for t in (0..mesh.tets().len()).step_by(40) {
        let x = mesh.cell_points(t);
        let (mut sum, mut weight) = (0.0, 0.0);
        for place in 0..n * n * n {
            let [a, b, c] = [place % n, place / n % n, place / n / n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
            let jacobian = (1.0 - a).powi(2) * (1.0 - b);
            let l = [a, b * (1.0 - a), c * (1.0 - a) * (1.0 - b), (1.0 - a) * (1.0 - b) * (1.0 - c)];
            let point: DVec3 = x.iter().zip(l).map(|(x, l)| l * *x).sum();
            sum += jacobian * STEEL.compliance_energy(minus(&quadratic(point), &stress.at(t, l)));
            weight += jacobian;
        }
        let exact = mesh.cell_volume(t) * sum / weight;
        assert!((errors.squared[t] - exact).abs() < 0.015 * exact, "{t}: {} {exact}", errors.squared[t]);
    }
}

/// The error of a stress that is quadratic along x is the same on a body of whatever thickness, in whatever direction it is
/// thin: fits see flat cells as they see others.
#[test]
fn thin_cells_are_estimated_as_thick_ones_are() {
    let quadratic = |x: f64| [x * x, 0.0, 0.0, 0.0, 0.0, 0.0];
    let turned = glam::DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let relative = |thickness: f64| {
        let flat = box_tets([1.0, 1.0, thickness], [4, 4, 1]).unwrap();
        let corners: Vec<[SymTensor; 4]> =
            (0..flat.tets().len()).map(|t| flat.cell_points(t).map(|p| quadratic(p.x))).collect();
        let mut parts = flat.into_parts();
        parts.points.iter_mut().for_each(|p| *p = turned * *p);
        let mesh = TetMesh::new(parts).unwrap();
        let space = Space::new(&mesh, Element::Tet10, &[]);
        let errors = estimate(&space, &[STEEL], &Stress::linear(&corners), Estimator::Spr);
        errors.energy().powi(2) / mesh.volume()
    };
    let thick = relative(0.25);
    for thickness in [0.1, 1e-2, 1e-3] {
        let thin = relative(thickness);
        assert!((thin / thick - 1.0).abs() < 0.05, "{thickness}: {thin} {thick}");
    }
}

/// Two bodies that touch at an edge only, under different constant stresses: neither's is an error of the other.
#[test]
fn parts_that_touch_at_an_edge_are_recovered_apart() {
    let (a, b) = (box_tets([1.0; 3], [2; 3]).unwrap(), box_tets([1.0; 3], [2; 3]).unwrap());
    let mut points = a.points().to_vec();
    let place = |p: DVec3| p + DVec3::new(1.0, 1.0, 0.0);
    let mut number = Vec::new();
    for p in b.points().iter().map(|p| place(*p)) {
        let same = a.points().iter().position(|q| q.distance(p) < 1e-12);
        number.push(same.unwrap_or(points.len()) as u32);
        if same.is_none() {
            points.push(p);
        }
    }
    let tets: Vec<[u32; 4]> =
        a.tets().iter().copied().chain(b.tets().iter().map(|t| t.map(|v| number[v as usize]))).collect();
    let mesh = TetMesh::from_cells(points, tets, "solid").unwrap();
    let first = a.tets().len();
    let stress: Vec<SymTensor> = (0..mesh.tets().len()).map(|t| [f64::from(u8::from(t < first)); 6]).collect();
    let corners: Vec<[SymTensor; 4]> = stress.iter().map(|s| [*s; 4]).collect();
    for (element, stress) in [(Element::Tet4, Stress::constant(stress)), (Element::Tet10, Stress::linear(&corners))] {
        let errors = estimate(&Space::new(&mesh, element, &[]), &[STEEL], &stress, Estimator::Spr);
        assert!(errors.energy() < 1e-12, "{element:?}: {}", errors.energy());
    }
}

/// Ten cells around an edge whose one end lies nearly in the plane of all other corners: nearly a quadric passes through all
/// samples around the other end, which a fit must not follow.
#[test]
fn a_quadric_near_all_samples_does_not_spoil_the_recovered_stress() {
    let ring = (0..10).map(|k| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 10.0).sin_cos();
        DVec3::new(cos, 1.3 * sin, 1e-3 * (7.0 * f64::from(k)).sin())
    });
    let points: Vec<DVec3> = [DVec3::ZERO, DVec3::new(0.03, 0.01, 1.0)].into_iter().chain(ring).collect();
    let tets = (0..10_u32).map(|k| [0, 2 + k, 2 + (k + 1) % 10, 1]).collect();
    let mesh = TetMesh::from_cells(points, tets, "ring").unwrap();
    // Of the size of one, and different from cell to cell.
    let corners: Vec<[SymTensor; 4]> =
        (0..10).map(|t| std::array::from_fn(|k| [(1.0 + 3.7 * f64::from(t) + k as f64).sin(); 6])).collect();
    let space = Space::new(&mesh, Element::Tet10, &[]);
    let errors = estimate(&space, &[STEEL], &Stress::linear(&corners), Estimator::Spr);
    assert!(errors.nodal_stress.iter().flatten().all(|s| s.abs() < 10.0), "{:?}", errors.nodal_stress);
}
