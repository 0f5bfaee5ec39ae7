//! Catmull-Clark solids: their masks, and the functions of their limit.

use glam::DVec3;
use subsolid::limit::{Basis, Table};
use subsolid::mesh::hex::HexMesh;
use subsolid::mesh::hex::generate::box_hexes;
use subsolid::subdiv::catmull_clark;
use subsolid::subdiv::options::CatmullClark;

/// One refinement of values on a line of control points by the cubic B-spline with natural ends: the knots halved.
fn halved(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mut fine = Vec::new();
    for i in 0..n {
        let vertex =
            if i == 0 || i == n - 1 { values[i] } else { (values[i - 1] + 6.0 * values[i] + values[i + 1]) / 8.0 };
        fine.push(vertex);
        if i + 1 < n {
            fine.push(0.5 * (values[i] + values[i + 1]));
        }
    }
    fine
}

#[test]
fn a_box_is_refined_as_the_tensor_product_of_splines() {
    let n = [4, 3, 5];
    let mesh = box_hexes([1.0; 3], n).unwrap().with_creases(30.0, &[]);
    // A value a vertex that is no product: a sum of two.
    let line = |axis: usize, k: usize| -> Vec<f64> {
        (0..=n[axis]).map(|i| ((1 + i * (axis + 2) + 3 * k) as f64 * 0.7).sin()).collect()
    };
    for variant in [CatmullClark::Bajaj, CatmullClark::Printed] {
        let refined = catmull_clark::refine(&mesh, variant).unwrap();
        for k in 0..2 {
            let lines = [0, 1, 2].map(|axis| line(axis, k));
            let value = |p: &DVec3, lines: &[Vec<f64>; 3], cells: [usize; 3]| -> f64 {
                (0..3).map(|a| lines[a][(p[a] * cells[a] as f64).round() as usize]).product()
            };
            let coarse: Vec<f64> = mesh.points().iter().map(|p| value(p, &lines, n)).collect();
            let fine = refined.stencils.apply(&coarse);
            let fine_lines = lines.clone().map(|l| halved(&l));
            // Linear splitting puts the refined vertices at even places.
            let places = catmull_clark::split_linearly(&mesh).unwrap();
            for (v, p) in places.mesh.points().iter().enumerate() {
                let want = value(p, &fine_lines, n.map(|n| 2 * n));
                assert!((fine[v] - want).abs() < 1e-14, "{p}: {} {want}", fine[v]);
            }
        }
        assert!((refined.mesh.volume() - 1.0).abs() < 1e-13);
    }
}

/// The functions of each class at points.
fn tabulate(basis: &Basis, points: &[DVec3]) -> Vec<Table> {
    (0..basis.classes()).map(|class| basis.table(class, points)).collect()
}

fn sums(mesh: &HexMesh, enriched: bool) {
    let points: Vec<DVec3> = (0..27)
        .map(|i| DVec3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64) * 0.43 + DVec3::splat(0.06))
        .collect();
    let basis = Basis::new(mesh, CatmullClark::Bajaj, enriched);
    let tables = tabulate(&basis, &points);
    for t in 0..mesh.cells().len() {
        let (own, table) = (basis.cell(t), &tables[basis.class(t)]);
        assert_eq!(own.len(), table.functions);
        for i in 0..points.len() {
            let (n, dn) = (table.values_at(i), table.gradients_at(i));
            let plain = |k: &usize| (own[*k] as usize) < mesh.points().len();
            let one: f64 = (0..own.len()).filter(plain).map(|k| n[k]).sum();
            let zero: DVec3 = (0..own.len()).filter(plain).map(|k| dn[k]).sum();
            assert!((one - 1.0).abs() < 1e-13 && zero.length() < 1e-12, "cell {t}: {one} {zero}");
        }
    }
}

#[test]
fn functions_sum_to_one() {
    sums(&box_hexes([1.0; 3], [4, 3, 5]).unwrap().with_creases(30.0, &[]), false);
    sums(&box_hexes([1.0; 3], [1, 2, 1]).unwrap().with_creases(30.0, &[]), true);
}
