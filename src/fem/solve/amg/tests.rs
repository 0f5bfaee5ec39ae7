//! What makes multigrid a preconditioner: it is symmetric, positive, and near the inverse.

use super::Hierarchy;
use crate::fem::block_matrix::{dot, norm};
use crate::fem::options::Element;
use crate::fem::{GroupId, Material, Model, Space, Support, System, assemble};
use crate::mesh::generate::box_tets;
use glam::DVec3;

/// A box that stands fixed and leans on a sliding support.
fn system(poissons_ratio: f64, element: Element) -> System {
    let mesh = box_tets([3.0, 1.0, 1.5], [18, 6, 9]).unwrap();
    let support = |group, displacement| Support::new("", GroupId(group), displacement);
    let supports = vec![support(4, [Some(0.0); 3]), support(0, [Some(0.0), None, None])];
    let materials = vec![Material { youngs_modulus: 2.0, poissons_ratio, density: 0.0 }];
    assemble(&Space::new(&mesh, element, &[]), &Model { materials, supports, loads: vec![] }).unwrap()
}

/// Fixed irregular vectors that vanish where displacements are prescribed.
fn vectors(system: &System) -> [Vec<DVec3>; 2] {
    let at =
        |i: usize, k: f64| DVec3::new((k * i as f64).sin(), (1.7 * k * i as f64).cos(), (k + 0.3 * i as f64).sin());
    [12.9, 78.2].map(|k| system.numbering.mask().iter().enumerate().map(|(i, m)| *m * at(i, k)).collect())
}

fn apply<T: super::Real>(hierarchy: &mut Hierarchy<T>, r: &[DVec3]) -> Vec<DVec3> {
    let mut z = vec![DVec3::ZERO; r.len()];
    hierarchy.apply(r, norm(r), &mut z).unwrap();
    z
}

fn hierarchy<T: super::Real>(system: &System) -> Hierarchy<T> {
    Hierarchy::of(system, None).unwrap()
}

#[test]
fn a_cycle_is_symmetric_and_positive_in_either_smoother() {
    for (poissons_ratio, element) in [(0.3, Element::Tet4), (0.49, Element::Tet4), (0.3, Element::Tet10)] {
        let system = system(poissons_ratio, element);
        let [x, y] = vectors(&system);
        let mut double = hierarchy::<f64>(&system);
        let (mx, my) = (apply(&mut double, &x), apply(&mut double, &y));
        let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
        assert!(dot(&x, &mx) > 0.0 && (dot(&y, &mx) - dot(&x, &my)).abs() < 1e-12 * size);
        let single = apply(&mut hierarchy::<f32>(&system), &x);
        let difference: Vec<DVec3> = single.iter().zip(&mx).map(|(a, b)| *a - *b).collect();
        assert!(norm(&difference) < 1e-4 * norm(&mx), "{} {}", norm(&difference), norm(&mx));
    }
}

#[test]
fn prescribed_components_stay_zero() {
    let system = system(0.3, Element::Tet10);
    let [x, _] = vectors(&system);
    let z = apply(&mut hierarchy::<f32>(&system), &x);
    assert!(z.iter().zip(system.numbering.mask()).all(|(z, m)| *z == *m * *z));
}

#[test]
fn vertices_of_straight_ten_node_cells_have_the_stiffness_of_four_node_cells() {
    let system = system(0.3, Element::Tet10);
    let linear = system.linear.as_ref().unwrap();
    let vertices = linear.stiffness.rows();
    let [x, _] = vectors(&system);
    let mut on_all = x[..vertices].to_vec();
    on_all.extend(linear.ends.iter().map(|e| 0.5 * (x[e[0] as usize] + x[e[1] as usize])));
    let force = system.stiffness.times(&on_all);
    let mut on_vertices = force[..vertices].to_vec();
    for (ends, f) in linear.ends.iter().zip(&force[vertices..]) {
        ends.iter().for_each(|&v| on_vertices[v as usize] += 0.5 * *f);
    }
    let expected = linear.stiffness.times(&x[..vertices]);
    let difference: Vec<DVec3> = on_vertices.iter().zip(&expected).map(|(a, b)| *a - *b).collect();
    assert!(norm(&difference) < 1e-13 * norm(&expected));
}
