//! Known solutions: their displacement and stress, the loads that make them, and the true error of a computed one.

mod known;

use super::options::ExactSolution;
use super::{Material, Model, Solution, Space, SymTensor, System};
use crate::field::{Field, Function};
use crate::mesh::GroupId;
use glam::DVec3;
use rayon::prelude::*;

/// Gauss-Legendre points and weights of degree 7 on [0, 1].
const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_9, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// A known solution on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// Which.
    pub solution: ExactSolution,
    /// The material of the whole solid.
    pub material: Material,
    /// Faces on which its tractions act as loads.
    pub tractions: Option<GroupId>,
}

/// How far a computed solution is from the known one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueError {
    /// Energy norm of the error, sqrt(a(e, e)).
    pub energy: f64,
    /// That over the energy norm of the known solution.
    pub relative: f64,
}

impl Exact {
    /// Whether the known solution is one of a solid with this bounding box.
    #[must_use]
    pub fn fits(&self, lo: DVec3, hi: DVec3) -> bool {
        let (want_lo, want_hi) = match self.solution {
            ExactSolution::SmoothCube => (DVec3::ZERO, DVec3::ONE),
            ExactSolution::LameSphere => (DVec3::ZERO, DVec3::splat(2.0)),
            ExactSolution::LPrism => (DVec3::new(-1.0, -1.0, 0.0), DVec3::ONE),
            ExactSolution::Kirsch => (DVec3::ZERO.with_z(lo.z), DVec3::splat(4.0).with_z(hi.z)),
            ExactSolution::LameCylinder => (DVec3::ZERO.with_z(lo.z), DVec3::splat(2.0).with_z(hi.z)),
            ExactSolution::Timoshenko => (DVec3::ZERO.with_z(lo.z), DVec3::new(8.0, 2.0, hi.z)),
            ExactSolution::QuadraticPatch => (lo, hi),
        };
        lo.distance(want_lo) < 1e-9 && hi.distance(want_hi) < 1e-9
    }

    /// Displacement at a point.
    #[must_use]
    pub fn displacement(&self, x: DVec3) -> DVec3 {
        match self.solution {
            ExactSolution::SmoothCube => known::smooth_cube(x),
            ExactSolution::LameSphere => known::lame_sphere_displacement(x, &self.material),
            ExactSolution::Kirsch => known::kirsch_displacement(x, &self.material),
            ExactSolution::LPrism => known::l_prism_displacement(x, &self.material),
            ExactSolution::QuadraticPatch => known::quadratic_patch(x),
            ExactSolution::LameCylinder => known::lame_cylinder_displacement(x, &self.material),
            ExactSolution::Timoshenko => known::timoshenko_displacement(x, &self.material),
        }
    }

    /// Component `c` of the displacement, to be prescribed.
    #[must_use]
    pub fn displacement_field(self, c: usize) -> Field {
        Field::Function(Function::new("exact", move |x| self.displacement(x)[c]))
    }

    /// Stress at a point.
    #[must_use]
    pub fn stress(&self, x: DVec3) -> SymTensor {
        match self.solution {
            ExactSolution::SmoothCube => self.material.stress(known::smooth_cube_strain(x)),
            ExactSolution::LameSphere => known::lame_sphere(x),
            ExactSolution::Kirsch => known::kirsch(x, self.material.poissons_ratio),
            ExactSolution::LPrism => known::l_prism(x, self.material.poissons_ratio),
            ExactSolution::QuadraticPatch => self.material.stress(known::quadratic_patch_strain(x)),
            ExactSolution::LameCylinder => known::lame_cylinder(x, self.material.poissons_ratio),
            ExactSolution::Timoshenko => known::timoshenko(x, self.material.poissons_ratio),
        }
    }

    /// Force per volume at a point.
    #[must_use]
    pub fn body_force(&self, x: DVec3) -> DVec3 {
        match self.solution {
            ExactSolution::SmoothCube => known::smooth_cube_force(x, &self.material),
            ExactSolution::QuadraticPatch => known::quadratic_patch_force(&self.material),
            _ => DVec3::ZERO,
        }
    }

    /// Adds the loads of the known solution to a system.
    pub fn add_loads(&self, space: &Space<'_>, system: &mut System) {
        let mesh = space.mesh();
        if matches!(self.solution, ExactSolution::SmoothCube | ExactSolution::QuadraticPatch) {
            let of_cell = |t: usize| {
                let mut forces = [DVec3::ZERO; 10];
                for (l, share) in tet_rule() {
                    let force = share * space.frame(t, l).0 * self.body_force(space.position(t, l));
                    forces.iter_mut().zip(space.shape(l)).for_each(|(sum, n)| *sum += n * force);
                }
                forces
            };
            let forces: Vec<[DVec3; 10]> = (0..mesh.tets().len()).into_par_iter().map(of_cell).collect();
            for (t, forces) in forces.into_iter().enumerate() {
                space.cell(t).zip(forces).for_each(|(v, f)| system.loads[v as usize] += f);
            }
        }
        for face in self.tractions.iter().flat_map(|g| mesh.group_faces(*g)) {
            for (l, x, area) in space.face_rule(face) {
                let force = traction(self.stress(x), area);
                space.face(face).zip(space.face_shape(l)).for_each(|(v, n)| system.loads[v as usize] += n * force);
            }
        }
    }

    /// The true error of a solution, by quadrature of degree 5 over the cells of its mesh.
    #[must_use]
    pub fn error(&self, space: &Space<'_>, model: &Model, solution: &Solution) -> TrueError {
        let mesh = space.mesh();
        let of_cell = |t: usize| {
            let material = &model.materials[mesh.regions()[t].0 as usize];
            let mut squares = [0.0; 2];
            for (weights, share) in tet_rule() {
                let exact = self.stress(space.position(t, weights));
                let (volume, computed) = (space.frame(t, weights).0, solution.stress.at(t, weights));
                let error = std::array::from_fn(|i| exact[i] - computed[i]);
                squares[0] += share * volume * material.compliance_energy(error);
                squares[1] += share * volume * material.compliance_energy(exact);
            }
            squares
        };
        let squares: Vec<[f64; 2]> = (0..mesh.tets().len()).into_par_iter().map(of_cell).collect();
        let [error, norm] = squares.iter().fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
        TrueError { energy: error.sqrt(), relative: (error / norm).sqrt() }
    }
}

/// The force on an area vector, `s n`.
fn traction(s: SymTensor, n: DVec3) -> DVec3 {
    DVec3::new(
        s[0] * n.x + s[3] * n.y + s[5] * n.z,
        s[3] * n.x + s[1] * n.y + s[4] * n.z,
        s[5] * n.x + s[4] * n.y + s[2] * n.z,
    )
}

/// Barycentric points and weights (of sum 1) on a triangle, exact up to degree 6: a square's rule with one side collapsed.
fn triangle_rule() -> impl Iterator<Item = ([f64; 3], f64)> {
    GAUSS
        .into_iter()
        .flat_map(|[u, wu]| GAUSS.into_iter().map(move |[v, wv]| ([1.0 - u, u * (1.0 - v), u * v], 2.0 * u * wu * wv)))
}

/// Barycentric points and weights (of sum 1) on a tetrahedron, exact up to degree 5.
fn tet_rule() -> impl Iterator<Item = ([f64; 4], f64)> {
    GAUSS.into_iter().flat_map(|[u, wu]| {
        triangle_rule().map(move |([a, b, c], w)| ([1.0 - u, u * a, u * b, u * c], 3.0 * u * u * wu * w))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [ExactSolution; 7] = [
        ExactSolution::SmoothCube,
        ExactSolution::LameSphere,
        ExactSolution::Kirsch,
        ExactSolution::LPrism,
        ExactSolution::QuadraticPatch,
        ExactSolution::LameCylinder,
        ExactSolution::Timoshenko,
    ];
    const MATERIAL: Material = Material { youngs_modulus: 2.0, poissons_ratio: 0.3, density: 0.0 };

    #[test]
    fn the_rule_integrates_polynomials_of_degree_five() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (i, j, k) in [(0, 0, 0), (5, 0, 0), (2, 2, 1), (1, 0, 4), (0, 3, 2)] {
            // The mean of a^i b^j c^k over a tetrahedron is 3! i! j! k! / (i + j + k + 3)!.
            let exact = 6.0 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
            let sum: f64 = tet_rule().map(|(l, w)| w * l[0].powi(i) * l[1].powi(j) * l[3].powi(k)).sum();
            assert!((sum - exact).abs() < 1e-14, "{i} {j} {k}");
        }
    }

    proptest! {
        /// Each known stress is in balance with its body force.
        #[test]
        fn the_divergence_of_the_stress_is_minus_the_body_force(x in prop::array::uniform3(0.6_f64..1.2)) {
            for solution in ALL {
                let exact = Exact { solution, material: MATERIAL, tractions: None };
                let (x, h) = (DVec3::from_array(x), 1e-5);
                let along = |axis: usize| {
                    let step = h * DVec3::AXES[axis];
                    let of = |x| traction(exact.stress(x), DVec3::AXES[axis]);
                    (of(x + step) - of(x - step)) / (2.0 * h)
                };
                let divergence = along(0) + along(1) + along(2);
                prop_assert!((divergence + exact.body_force(x)).length() < 1e-7, "{solution:?}: {divergence}");
            }
        }

        /// Each known stress is that of the symmetric gradient of the displacement.
        #[test]
        fn the_stress_is_that_of_the_displacement(x in prop::array::uniform3(0.6_f64..1.2)) {
            for solution in ALL {
                let exact = Exact { solution, material: MATERIAL, tractions: None };
                let (x, h) = (DVec3::from_array(x), 1e-5);
                let d = [0, 1, 2].map(|axis| {
                    let step = h * DVec3::AXES[axis];
                    (exact.displacement(x + step) - exact.displacement(x - step)) / (2.0 * h)
                });
                let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
                let stress = MATERIAL.stress(pairs.map(|(i, j)| 0.5 * (d[i][j] + d[j][i])));
                for (a, b) in stress.into_iter().zip(exact.stress(x)) {
                    prop_assert!((a - b).abs() < 1e-7, "{solution:?}: {stress:?} {:?}", exact.stress(x));
                }
            }
        }
    }

    /// The force on a unit area at a point, of a known solution with E = 2 and nu = 0.3.
    fn force(solution: ExactSolution, x: [f64; 3], n: DVec3) -> DVec3 {
        traction(Exact { solution, material: MATERIAL, tractions: None }.stress(DVec3::from_array(x)), n)
    }

    /// What acts on the sides is what the problems say: pressure 1 inside and nothing outside, free holes and long sides, a
    /// parabola of resultant -1 at the beam's end.
    #[test]
    fn the_tractions_are_those_of_the_problems() {
        for angle in [0.0_f64, 0.4, 1.2] {
            let n = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let of = |solution, r: f64| force(solution, (r * n).to_array(), n);
            for solution in [ExactSolution::LameSphere, ExactSolution::LameCylinder] {
                assert!((of(solution, 1.0) + n).length() < 1e-14 && of(solution, 2.0).length() < 1e-14);
            }
            assert!(of(ExactSolution::Kirsch, 1.0).length() < 1e-14);
        }
        assert!((force(ExactSolution::Kirsch, [1e-9, 1.0, 0.0], DVec3::X).x - 3.0).abs() < 1e-6);
        let beam = |x, y, n| force(ExactSolution::Timoshenko, [x, y, 0.2], n);
        for x in [0.0, 3.0, 8.0] {
            assert!(beam(x, 0.0, DVec3::Y).length() < 1e-14 && beam(x, 2.0, DVec3::Y).length() < 1e-14);
        }
        let end = |f: &dyn Fn(f64) -> f64| GAUSS.iter().map(|[t, w]| 2.0 * w * f(2.0 * t)).sum::<f64>();
        assert!((end(&|y| beam(8.0, y, DVec3::X).y) + 1.0).abs() < 1e-14);
        // At the root the moment of the force at the other end.
        assert!((end(&|y| beam(0.0, y, DVec3::X).x * (y - 1.0)) - 8.0).abs() < 1e-13);
    }

    /// The re-entrant faces of the L-prism carry no load, and its energy is known to 14 digits.
    #[test]
    fn the_l_prism_is_free_at_its_notch_and_has_the_known_energy() {
        let material = Material { youngs_modulus: 1.0, ..MATERIAL };
        let exact = Exact { solution: ExactSolution::LPrism, material, tractions: None };
        for r in [0.1, 0.5, 1.0] {
            for (x, n) in [(DVec3::new(0.0, -r, 0.3), DVec3::NEG_X), (DVec3::new(-r, 0.0, 0.3), DVec3::NEG_Y)] {
                assert!(traction(exact.stress(x), n).length() < 1e-12, "{x}");
            }
        }
        // Half the work of the tractions on the outer sides is half a(u, u): Gauss on their four straight halves.
        let side = |from: DVec3, to: DVec3, n: DVec3| {
            let pieces = 400;
            let piece = |i: usize| {
                let at = |t: f64| from.lerp(to, (i as f64 + t) / pieces as f64);
                let work = |x: DVec3| traction(exact.stress(x), n).dot(exact.displacement(x));
                GAUSS.iter().map(|[t, w]| w * work(at(*t))).sum::<f64>() * from.distance(to) / pieces as f64
            };
            (0..pieces).map(piece).sum::<f64>()
        };
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let energy = side(p(1.0, -1.0), p(1.0, 1.0), DVec3::X)
            + side(p(-1.0, 1.0), p(1.0, 1.0), DVec3::Y)
            + side(p(-1.0, 0.0), p(-1.0, 1.0), DVec3::NEG_X)
            + side(p(0.0, -1.0), p(1.0, -1.0), DVec3::NEG_Y);
        assert!((energy - 28.172_983_101_124).abs() < 1e-9, "{energy}");
    }
}
