//! The limit of Catmull-Clark subdivision on irregular meshes: masks, basis, bubbles and limit positions against what brute
//! force gives.
#![allow(clippy::unwrap_used)]

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use subsolid::limit::{Basis, Table};
use subsolid::mesh::generate::box_tets;
use subsolid::mesh::hex::generate::{box_hexes, cylinder, from_tets, prism, sphere_shell, tube, tunnel};
use subsolid::mesh::hex::{FACES, HexMesh, HexMeshParts, NONE, QuadFace};
use subsolid::mesh::weights::WeightRows;
use subsolid::mesh::{PatchId, RegionId};
use subsolid::subdiv::catmull_clark::{Control, child_lattice, interpolated, refine, split_linearly};
use subsolid::subdiv::options::CatmullClark;

const VARIANTS: [CatmullClark; 2] = [CatmullClark::Bajaj, CatmullClark::Printed];

/// Meshes of all kinds of vertices, with their creases.
fn meshes() -> Vec<(String, HexMesh)> {
    let mut list: Vec<(String, HexMesh)> =
        [3, 5, 6, 8, 10].map(|n| (format!("prism {n}"), prism(n, 1.5, 2.0, [2, 3]).unwrap())).into();
    list.push(("box".to_owned(), box_hexes([1.0, 2.0, 1.5], [2, 3, 1]).unwrap()));
    list.push(("tets".to_owned(), from_tets(&box_tets([1.0; 3], [1; 3]).unwrap()).unwrap()));
    list.push(("tunnel".to_owned(), tunnel([3.0, 3.0, 2.0], [4, 3, 2], [1, 1]).unwrap()));
    list.push(("cylinder".to_owned(), cylinder(1.0, 2.0, [2, 2, 2]).unwrap()));
    list.push(("tube".to_owned(), tube([1.0, 2.0], 1.0, [1, 5, 2], false).unwrap()));
    list.push(("shell".to_owned(), sphere_shell([1.0, 2.0], [1, 2], false).unwrap()));
    list.push(("eighth".to_owned(), sphere_shell([1.0, 2.0], [2, 2], true).unwrap()));
    list.into_iter().map(|(name, mesh)| (name, mesh.with_creases(50.0, &[]))).collect()
}

/// A number in [-1, 1) for each index.
fn noise(i: usize) -> f64 {
    let x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((x ^ x >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn noisy(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|i| noise(i + 1_000_003 * seed)).collect()
}

fn row(stencils: &WeightRows, i: usize) -> Vec<(u32, f64)> {
    stencils.row(i).collect()
}

#[test]
fn rows_sum_to_one() {
    for (name, mesh) in meshes() {
        for variant in VARIANTS {
            let control = Control::of(&mesh);
            for stencils in [control.stencils(variant), control.linear_stencils(), control.limit_stencils(variant)] {
                for i in 0..stencils.rows() {
                    let sum: f64 = stencils.row(i).map(|e| e.1).sum();
                    assert!((sum - 1.0).abs() < 4e-15, "{name}: row {i} sums to 1 + {:e}", sum - 1.0);
                }
            }
        }
    }
}

#[test]
fn regular_masks_are_those_of_the_cubic_spline() {
    let mesh = box_hexes([1.0; 3], [4; 3]).unwrap().with_creases(30.0, &[]);
    let topology = mesh.topology();
    // How many weights of each size, in units of 1/512.
    let census = |stencils: &WeightRows, i: usize| {
        let mut counts = BTreeMap::new();
        for (_, weight) in stencils.row(i) {
            assert_eq!((weight * 512.0).fract(), 0.0);
            *counts.entry((weight * 512.0) as u32).or_insert(0) += 1;
        }
        counts
    };
    let inner = |v: &u32| mesh.points()[*v as usize].to_array().iter().all(|x| *x > 0.0 && *x < 1.0);
    let (vertices, edges) = (mesh.points().len(), topology.edges().len());
    for variant in VARIANTS {
        let stencils = Control::of(&mesh).stencils(variant);
        let of_cell = vertices + edges + topology.faces().len();
        assert_eq!(census(&stencils, of_cell), BTreeMap::from([(64, 8)]));
        let f = (0..topology.faces().len()).find(|&f| !topology.is_boundary(f as u32)).unwrap();
        assert_eq!(census(&stencils, vertices + edges + f), BTreeMap::from([(96, 4), (16, 8)]));
        let e = topology.edges().iter().position(|e| e.iter().all(inner)).unwrap();
        assert_eq!(census(&stencils, vertices + e), BTreeMap::from([(144, 2), (24, 8), (4, 8)]));
        let v = (0..vertices as u32).find(inner).unwrap();
        assert_eq!(census(&stencils, v as usize), BTreeMap::from([(216, 1), (36, 6), (6, 12), (1, 8)]));
        let limits = Control::of(&mesh).limit_stencils(variant);
        let weights: Vec<f64> = limits.row(v as usize).map(|e| e.1).collect();
        for (weight, count) in [(8.0 / 27.0, 1), (2.0 / 27.0, 6), (1.0 / 54.0, 12), (1.0 / 216.0, 8)] {
            assert_eq!(weights.iter().filter(|w| (*w - weight).abs() < 1e-15).count(), count);
        }
    }
}

/// The ring of a vertex after a step, as a matrix over the ring before it.
fn ring_matrix(mesh: &HexMesh, v: u32, variant: CatmullClark) -> DMatrix<f64> {
    let (topology, stencils) = (mesh.topology(), Control::of(mesh).stencils(variant));
    let (vertices, edges, faces) = (mesh.points().len(), topology.edges().len(), topology.faces().len());
    let mut ring = vec![(v, v as usize)];
    for &e in topology.vertex_edges(v) {
        let ends = topology.edges()[e as usize];
        ring.push((ends[0] + ends[1] - v, vertices + e as usize));
    }
    for (f, face) in topology.faces().iter().enumerate() {
        if let Some(own) = face.iter().position(|w| *w == v) {
            ring.push((face[(own + 2) % 4], vertices + edges + f));
        }
    }
    for &t in topology.vertex_cells(v) {
        let cell = mesh.cells()[t as usize];
        let own = cell.iter().position(|w| *w == v).unwrap();
        ring.push((cell[7 ^ own], vertices + edges + faces + t as usize));
    }
    DMatrix::from_fn(ring.len(), ring.len(), |i, j| {
        stencils.row(ring[i].1).find(|(w, _)| *w == ring[j].0).map_or(0.0, |e| e.1)
    })
}

#[test]
fn rings_have_the_known_eigenvalues_and_limit_weights() {
    let known =
        [(3, 0.4101, 0.2826), (5, 0.5500, 0.3053), (6, 0.5797, 0.3115), (8, 0.6111, 0.3196), (10, 0.6263, 0.3246)];
    for (n, rounded, printed) in known {
        let mesh = prism(n, 1.0, 4.0, [2, 4]).unwrap().with_creases(30.0, &[]);
        let v =
            (0..mesh.points().len()).find(|&v| mesh.points()[v].distance(DVec3::new(0.0, 0.0, 2.0)) < 1e-12).unwrap();
        let matrix = ring_matrix(&mesh, v as u32, CatmullClark::Bajaj);
        let size = matrix.nrows();
        // How many singular values of the matrix less a number vanish.
        let nullity = |value: f64| {
            let shifted = &matrix - DMatrix::identity(size, size) * value;
            shifted.singular_values().iter().filter(|s| **s < 1e-12).count()
        };
        // Across the edge, that of Catmull-Clark surfaces; along it, that of a spline.
        let c = (std::f64::consts::TAU / f64::from(n as u32)).cos();
        let across = (5.0 + c + ((c + 9.0) * (c + 1.0)).sqrt()) / 16.0;
        assert!((across - rounded).abs() < 6e-5);
        assert_eq!((nullity(1.0), nullity(across)), (1, 2), "valence {n}");
        assert!(nullity(0.5) >= 1);
        // Without the largest, powers fall as the next.
        let ones = DMatrix::from_element(size, 1, 1.0);
        let mut power = matrix.clone();
        (0..8).for_each(|_| power = &power * &power);
        let mut rest = &matrix - &ones * power.row(0);
        (0..6).for_each(|_| rest = &rest * &rest);
        let rate = rest.norm().powf(1.0 / 64.0);
        assert!(rate < 1.05 * across.max(0.5), "valence {n}: {rate}");
        for (variant, want, digits) in [(VARIANTS[0], 8.0 / 27.0, 1e-13), (VARIANTS[1], printed, 6e-5)] {
            let limits = Control::of(&mesh).limit_stencils(variant);
            let own = row(&limits, v).iter().find(|e| e.0 as usize == v).unwrap().1;
            assert!((own - want).abs() < digits, "valence {n}, {variant:?}: {own} is not {want}");
        }
    }
}

#[test]
fn limits_do_not_change_by_refinement() {
    for (name, mesh) in meshes() {
        for variant in VARIANTS {
            let values = noisy(mesh.points().len(), 3);
            let control = Control::of(&mesh);
            let limit = control.limit_stencils(variant).apply(&values);
            let refined = refine(&mesh, variant).unwrap();
            let fine = refined.stencils.apply(&values);
            let again = Control::of(&refined.mesh).limit_stencils(variant).apply(&fine);
            for (v, (a, b)) in limit.iter().zip(&again).enumerate() {
                assert!((a - b).abs() < 1e-14, "{name}, {variant:?}: vertex {v} goes to {a} and {b}");
            }
        }
    }
}

#[test]
fn affine_maps_commute_with_refinement() {
    for (seed, (name, mesh)) in meshes().into_iter().enumerate() {
        let column = |i: usize| DVec3::from_array([0, 1, 2].map(|j| noise(12 * seed + 3 * i + j)));
        let mut frame = DMat3::from_cols(column(0), column(1), column(2)) + DMat3::from_diagonal(DVec3::splat(3.0));
        frame.x_axis *= 2.0;
        let map = |p: DVec3| frame * p + column(3);
        for variant in VARIANTS {
            let first = refine(&mesh, variant).unwrap().mesh;
            let mut parts = mesh.clone().into_parts();
            parts.points.iter_mut().for_each(|p| *p = map(*p));
            let then = refine(&HexMesh::new(parts).unwrap(), variant).unwrap().mesh;
            for (p, q) in first.points().iter().zip(then.points()) {
                assert!((map(*p) - q).length() < 1e-13 * first.diagonal() * 8.0, "{name}: {p}");
            }
            assert_eq!(first.cells(), then.cells());
        }
    }
}

/// Points of the unit cube, none on a plane of coordinates that are dyadic.
fn samples() -> Vec<DVec3> {
    let x = [0.0612, 0.37, 0.8831];
    (0..27).map(|i| DVec3::new(x[i % 3], x[i / 3 % 3], x[i / 9])).collect()
}

/// The functions of each class at points.
fn tabulate(basis: &Basis, points: &[DVec3]) -> Vec<Table> {
    (0..basis.classes()).map(|class| basis.table(class, points)).collect()
}

#[test]
fn functions_sum_to_one_and_have_the_gradients_they_say() {
    const H: f64 = 1e-5;
    let points = samples();
    let moved = |axis: usize, by: f64| points.iter().map(|p| p + by * DVec3::AXES[axis]).collect::<Vec<_>>();
    for (name, mesh) in meshes() {
        for variant in VARIANTS {
            for enriched in [false, true] {
                let basis = Basis::new(&mesh, variant, enriched);
                let tables = tabulate(&basis, &points);
                let ahead =
                    [0, 1, 2].map(|axis| [tabulate(&basis, &moved(axis, H)), tabulate(&basis, &moved(axis, -H))]);
                for t in 0..mesh.cells().len() {
                    let (own, class) = (basis.cell(t), basis.class(t));
                    for i in 0..points.len() {
                        let (n, dn) = (tables[class].values_at(i), tables[class].gradients_at(i));
                        let plain = |k: &usize| (own[*k] as usize) < mesh.points().len();
                        let one: f64 = (0..own.len()).filter(plain).map(|k| n[k]).sum();
                        let zero: DVec3 = (0..own.len()).filter(plain).map(|k| dn[k]).sum();
                        assert!((one - 1.0).abs() < 1e-13 && zero.length() < 1e-12, "{name}, cell {t}: {one} {zero}");
                        for (k, gradient) in dn.iter().enumerate() {
                            for axis in 0..3 {
                                let [up, down] = &ahead[axis];
                                let got = (up[class].values_at(i)[k] - down[class].values_at(i)[k]) / (2.0 * H);
                                assert!((got - gradient[axis]).abs() < 2e-8, "{name}, cell {t}: {got} {gradient}");
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The cells that share a vertex with cell `t`, which comes first, with values of their vertices.
fn ring(mesh: &HexMesh, values: &[f64], t: usize) -> (HexMesh, Vec<f64>) {
    let near = |cell: &[u32; 8]| cell.iter().any(|v| mesh.cells()[t].contains(v));
    let others = (0..mesh.cells().len()).filter(|&u| u != t && near(&mesh.cells()[u]));
    let mut vertices: Vec<u32> = Vec::new();
    let mut number = |v: u32| {
        vertices.iter().position(|w| *w == v).unwrap_or_else(|| {
            vertices.push(v);
            vertices.len() - 1
        }) as u32
    };
    let cells: Vec<[u32; 8]> = [t].into_iter().chain(others).map(|u| mesh.cells()[u].map(&mut number)).collect();
    let points = vertices.iter().map(|&v| mesh.points()[v as usize]).collect();
    let parts = HexMesh::tagged(points, cells, &[]).unwrap().into_parts();
    let local = |v: u32| vertices.iter().position(|w| *w == v).map(|v| v as u32);
    let creases = mesh.creases().iter().filter_map(|crease| {
        let mut ends = [local(crease.vertices[0])?, local(crease.vertices[1])?];
        ends.sort_unstable();
        let own = |cell: &[u32; 8]| ends.iter().all(|v| cell.contains(v));
        parts.cells.iter().any(own).then_some(subsolid::mesh::Crease { vertices: ends, ..*crease })
    });
    let creases: Vec<_> = creases.collect();
    let corners = mesh.corners().iter().filter_map(|&v| local(v)).collect();
    let mesh = HexMesh::new(HexMeshParts { creases, corners, ..parts }).unwrap();
    (mesh, vertices.iter().map(|&v| values[v as usize]).collect())
}

/// Cells of a mesh, one for each class.
fn one_a_class(basis: &Basis) -> Vec<usize> {
    let cells = |class: usize| (0..).find(|&t| basis.class(t) == class).unwrap();
    (0..basis.classes()).map(cells).collect()
}

#[test]
fn tables_agree_with_deep_subdivision() {
    const LEVELS: usize = 6;
    for (name, mesh) in meshes() {
        for variant in VARIANTS {
            let basis = Basis::new(&mesh, variant, false);
            let values = noisy(mesh.points().len(), 7);
            for (class, t) in one_a_class(&basis).into_iter().enumerate().filter(|(class, _)| class % 3 == 0) {
                let own: Vec<f64> = basis.cell(t).iter().map(|&a| values[a as usize]).collect();
                // Down to vertices of the cell, and by a path inside.
                for path in [class / 3 % 8, 7 - class / 3 % 8, 8] {
                    let (mut part, mut control) = ring(&mesh, &values, t);
                    let (mut origin, mut size) = (DVec3::ZERO, 1.0);
                    for level in 0..LEVELS {
                        let child = if path < 8 { path } else { (3 * path + 5 * level) % 8 };
                        let fine = split_linearly(&part).unwrap().mesh;
                        let finer = Control::of(&part).stencils(variant).apply(&control);
                        size *= 0.5;
                        let [x, y, z] = child_lattice(child, 0).map(|x| x as f64);
                        origin += size * DVec3::new(x, y, z);
                        (part, control) = ring(&fine, &finer, child);
                    }
                    let limits = Control::of(&part).limit_stencils(variant);
                    let corner = |c: usize| DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64);
                    let points: Vec<DVec3> = (0..8).map(|c| origin + size * corner(c)).collect();
                    let table = basis.table(basis.class(t), &points);
                    for (c, &v) in part.cells()[0].iter().enumerate() {
                        let want: f64 = limits.row(v as usize).map(|(w, weight)| weight * control[w as usize]).sum();
                        let got: f64 = table.values_at(c).iter().zip(&own).map(|(n, x)| n * x).sum();
                        assert!(
                            (got - want).abs() < 1e-10,
                            "{name}, {variant:?}, cell {t}, {}: {got} {want}",
                            points[c]
                        );
                    }
                }
            }
        }
    }
}

/// The sheets of the boundary: faces that hang together through edges of two cells, numbered by first face.
fn sheets(mesh: &HexMesh) -> Vec<u32> {
    let topology = mesh.topology();
    let mut sheets = vec![NONE; topology.faces().len()];
    let mut next = 0;
    for first in topology.boundary().map(|(f, _)| f) {
        if sheets[first as usize] != NONE {
            continue;
        }
        let mut open = vec![first];
        while let Some(f) = open.pop() {
            if sheets[f as usize] == NONE {
                sheets[f as usize] = next;
                let joints =
                    topology.face_edges()[f as usize].into_iter().filter(|e| topology.edge_cells(*e).len() == 2);
                open.extend(joints.flat_map(|e| topology.boundary_faces_at(e)));
            }
        }
        next += 1;
    }
    sheets
}

/// Where points of a face, given by weights of its vertices, lie in a cell.
fn in_cell(cell: &[u32; 8], face: [u32; 4], weights: &[[f64; 4]]) -> Vec<DVec3> {
    let corner = |v: u32| {
        let c = cell.iter().position(|w| *w == v).unwrap();
        DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64)
    };
    weights.iter().map(|w| (0..4).map(|i| w[i] * corner(face[i])).sum()).collect()
}

#[test]
fn bubbles_are_continuous_and_vanish_on_their_sheets() {
    let places = [[0.3, 0.2], [0.61, 0.87], [0.9, 0.05]];
    let weights = places.map(|[x, y]: [f64; 2]| [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y]);
    for (name, mesh) in meshes() {
        let basis = Basis::new(&mesh, CatmullClark::Bajaj, true);
        let sheets = sheets(&mesh);
        let vertices = mesh.points().len();
        // The values on a face, seen from a cell.
        let seen = |t: u32, face: [u32; 4]| {
            let points = in_cell(&mesh.cells()[t as usize], face, &weights);
            let table = basis.table(basis.class(t as usize), &points);
            (0..places.len())
                .map(|i| basis.cell(t as usize).iter().copied().zip(table.values_at(i).iter().copied()).collect())
                .collect::<Vec<BTreeMap<u32, f64>>>()
        };
        let topology = mesh.topology();
        for (f, (&face, &[t, u])) in topology.faces().iter().zip(topology.face_cells()).enumerate() {
            let first = seen(t, face);
            if u == NONE {
                for (a, value) in first.iter().flatten().filter(|(a, _)| **a as usize >= vertices) {
                    let bubble = &basis.bubbles()[*a as usize - vertices];
                    let vanishes = !bubble.sheets.contains(&sheets[f]) || value.abs() < 1e-14;
                    assert!(vanishes, "{name}: {bubble:?} is {value} on face {face:?}");
                }
                continue;
            }
            for (one, other) in first.iter().zip(seen(u, face)) {
                for a in one.keys().chain(other.keys()) {
                    let (x, y) = (one.get(a).unwrap_or(&0.0), other.get(a).unwrap_or(&0.0));
                    assert!((x - y).abs() < 1e-13, "{name}: function {a} of {vertices} is {x} and {y} on {face:?}");
                }
            }
        }
    }
}

#[test]
fn enriched_boxes_have_all_tricubics() {
    let n = [2, 1, 3];
    let mesh = box_hexes([2.0, 1.0, 3.0], n).unwrap().with_creases(30.0, &[]);
    let basis = Basis::new(&mesh, CatmullClark::Bajaj, true);
    assert_eq!(basis.len(), n.iter().map(|n| n + 3).product::<usize>());
    let x = [0.07, 0.33, 0.67, 0.93];
    let points: Vec<DVec3> = (0..64).map(|i| DVec3::new(x[i % 4], x[i / 4 % 4], x[i / 16])).collect();
    let rows = points.len() * mesh.cells().len();
    let (mut matrix, mut right) = (DMatrix::zeros(rows, basis.len()), DMatrix::zeros(rows, 64));
    for t in 0..mesh.cells().len() {
        let (table, cell) = (basis.table(basis.class(t), &points), mesh.cell_points(t));
        for (i, p) in points.iter().enumerate() {
            let row = t * points.len() + i;
            basis.cell(t).iter().zip(table.values_at(i)).for_each(|(&a, &n)| matrix[(row, a as usize)] += n);
            // On a box with natural ends the limit is the box itself.
            let q = cell[0] + *p * (cell[7] - cell[0]);
            for k in 0..64 {
                right[(row, k)] = q.x.powi(k as i32 % 4) * q.y.powi(k as i32 / 4 % 4) * q.z.powi(k as i32 / 16);
            }
        }
    }
    let solution = matrix.clone().svd(true, true).solve(&right, 1e-13).unwrap();
    let miss = (&matrix * solution - right).amax();
    assert!(miss < 1e-10, "{miss}");
}

#[test]
fn a_limit_passes_through_given_points() {
    for (name, mesh) in meshes() {
        for variant in VARIANTS {
            let through = interpolated(mesh.clone(), variant).unwrap();
            let limit = Control::of(&through).limit_stencils(variant).apply(through.points());
            for (p, q) in limit.iter().zip(mesh.points()) {
                assert!(p.distance(*q) < 1e-13 * mesh.diagonal(), "{name}: {p} {q}");
            }
            assert_eq!(through.creases(), mesh.creases());
        }
    }
}

#[test]
fn control_points_of_a_closed_circle_lie_on_the_known_one() {
    for n in [8, 16] {
        let mesh = tube([1.0, 2.0], 1.0, [2, n, 2], false).unwrap().with_creases(50.0, &[]);
        let through = interpolated(mesh.clone(), CatmullClark::Bajaj).unwrap();
        let grown = 6.0 / (4.0 + 2.0 * (std::f64::consts::TAU / n as f64).cos());
        for (p, q) in through.points().iter().zip(mesh.points()) {
            assert!((p - q * DVec3::new(grown, grown, 1.0)).length() < 1e-12, "{p} {q}");
        }
    }
}

/// A mesh without tags.
fn plain(points: &[[f64; 3]], cells: &[[u32; 8]]) -> Result<HexMesh, subsolid::mesh::hex::HexError> {
    HexMesh::tagged(points.iter().map(|p| DVec3::from_array(*p)).collect(), cells.to_vec(), &[])
}

/// The corners of a unit cube moved by whole steps.
fn cube(at: [f64; 3]) -> Vec<[f64; 3]> {
    (0..8).map(|c| [0, 1, 2].map(|axis| at[axis] + f64::from(c >> axis & 1))).collect()
}

#[test]
fn unfit_meshes_are_refused_by_name() {
    use subsolid::mesh::hex::HexError as E;
    let first = [0, 1, 2, 3, 4, 5, 6, 7];
    let twisted = plain(&cube([0.0; 3]), &[[0, 1, 2, 3, 4, 5, 7, 6]]).unwrap_err();
    assert!(matches!(twisted, E::Twisted { cell: 0, vertex: 2 | 3 | 6 | 7, .. }), "{twisted}");
    let repeated = plain(&cube([0.0; 3]), &[[0, 1, 2, 3, 4, 5, 6, 6]]).unwrap_err();
    assert!(matches!(repeated, E::RepeatedVertex { cell: 0, vertex: 6, .. }), "{repeated}");

    let points = [cube([0.0; 3]), cube([1.0, 0.0, 0.0]), cube([0.9, 0.0, 0.0])].concat();
    let crowded = plain(&points, &[first, [1, 9, 3, 11, 5, 13, 7, 15], [1, 17, 3, 19, 5, 21, 7, 23]]).unwrap_err();
    assert!(matches!(crowded, E::CrowdedFace { cells: [0, 1, 2], .. }), "{crowded}");
    let inward = plain(
        &points,
        &[
            first,
            [1, 17, 3, 19, 5, 21, 7, 23].map(|v| {
                if v == 5 {
                    7
                } else if v == 7 {
                    5
                } else {
                    v
                }
            }),
        ],
    );
    assert!(matches!(inward, Err(E::InwardFace { cells: [0, 1], .. } | E::Twisted { .. })));

    // Two cubes that share an edge, or a vertex.
    let points = [cube([0.0; 3]), cube([1.0, 1.0, 0.0]), cube([1.0, 1.0, 1.0])].concat();
    let edge = plain(&points[..16], &[first, [3, 9, 10, 11, 7, 13, 14, 15]]).unwrap().with_creases(30.0, &[]);
    let edge = edge.check_smoothable().unwrap_err();
    let E::NotManifold { what: "edge", vertices, .. } = &edge else { panic!("{edge}") };
    assert_eq!(*vertices, [3, 7]);
    let vertex = plain(&points, &[first, [7, 17, 18, 19, 20, 21, 22, 23]]).unwrap().with_creases(30.0, &[]);
    let vertex = vertex.check_smoothable().unwrap_err();
    let E::NotManifold { what: "vertex", vertices, .. } = &vertex else { panic!("{vertex}") };
    assert_eq!(*vertices, [7]);

    let smooth = refine(&box_hexes([1.0; 3], [2; 3]).unwrap(), CatmullClark::Bajaj).unwrap_err();
    let E::SmoothSingleCell { edge, .. } = &smooth else { panic!("{smooth}") };
    assert_eq!(*edge, [0, 1]);
}

#[test]
fn boundary_faces_that_are_missing_or_foreign_are_named() {
    use subsolid::mesh::hex::HexError as E;
    let mesh = plain(&cube([0.0; 3]), &[[0, 1, 2, 3, 4, 5, 6, 7]]).unwrap();
    let parts = |faces: Vec<QuadFace>| HexMeshParts { regions: vec![RegionId(0)], faces, ..mesh.clone().into_parts() };
    let faces = mesh.faces().to_vec();
    assert!(matches!(HexMesh::new(parts(faces[1..].to_vec())), Err(E::MissingFace { .. })));
    let foreign = QuadFace { vertices: FACES[0].map(|c| c as u32 ^ 7), patch: PatchId(0) };
    assert!(matches!(HexMesh::new(parts([faces, vec![foreign]].concat())), Err(E::ForeignFace { .. })));
}
