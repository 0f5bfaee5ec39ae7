//! The residual estimator (Verfuerth): what the stress of the elements leaves unbalanced in cells, between them, and on the
//! boundary.
//!
//! With the body force f, the loads g, foundations k, and the components of the displacement u_D that are held,
//!
//! ```text
//! eta_K^2 = C / (2 mu) ( h_K^2 / p^2 |f + div s_h|_K^2
//!                        + 1/2 sum over inner faces of  h_F / p |[s_h n]|_F^2  with the larger mu of both sides
//!                        + sum over boundary faces of   h_F / p |g - k u_h - s_h n|_F^2  in the components not held )
//!           + sum over boundary faces of 2 mu pi / h_F |u_D - u_h|_F^2  in the components held
//! ```
//!
//! p is the degree of the displacement, h_K the edge of the regular tetrahedron of the same volume, h_F the longest edge of
//! the face. `2 mu |e|^2` never exceeds the energy of a strain e, which makes the estimate a bound but for constants of the
//! cells' shapes, however nearly incompressible the material is (Verfuerth 1999); with the larger mu on faces they do not
//! depend on jumps of the material either (Bernardi and Verfuerth 2000). The powers of p are those of Melenk and Wohlmuth
//! 2001. Forces enter as they are, not projected, so that their oscillation is in the estimate. The last term is the energy of
//! a wave of this amplitude and of length 2 h_F that decays inward. C is measured.

use crate::fem::{Data, InCells, Share, Stress, SymTensor, traction};
use crate::mesh::{Face, topology};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

/// C: makes the estimate two to three times the error of the smooth cube and of the L-prism, of either degree.
const SCALE: f64 = 1.0 / 3.0;

/// The vertices of a cell.
const CORNERS: [[f64; 4]; 4] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The squared estimate of each cell.
pub(super) fn squared(data: &Data<'_>, displacement: &[DVec3], stress: &Stress) -> Vec<f64> {
    let mesh = data.space.mesh();
    let count = mesh.tets().len();
    let share = |goal: &InCells| (0..count).into_par_iter().map(|t| goal.share(data.space, t)).collect();
    let shares: Vec<Share> = data.in_cells().map_or_else(Vec::new, share);
    let degree = if stress.is_linear() { 2.0 } else { 1.0 };
    let residual = Residual { data, displacement, stress, shares: &shares, degree };
    let neighbours = topology::face_neighbours(mesh.tets());
    let inside = |t: usize| residual.of_cell(t) + residual.between(t, &neighbours[t]);
    let mut squared: Vec<f64> = (0..count).into_par_iter().map(inside).collect();
    let cells = topology::boundary_cells(mesh.tets());
    let outside = mesh.faces().par_iter().zip(&cells).map(|(face, &t)| residual.on_boundary(face, t as usize));
    let outside: Vec<f64> = outside.collect();
    cells.into_iter().zip(outside).for_each(|(t, value)| squared[t as usize] += value);
    squared
}

struct Residual<'a> {
    data: &'a Data<'a>,
    displacement: &'a [DVec3],
    stress: &'a Stress,
    /// How cells belong to a goal, if the data are of one.
    shares: &'a [Share],
    degree: f64,
}

impl Residual<'_> {
    /// The stress at a point of a cell, less that which a goal brings.
    fn stress(&self, t: usize, l: [f64; 4]) -> SymTensor {
        let stress = self.stress.at(t, l);
        let (Some(goal), Some(share)) = (self.data.in_cells(), self.shares.get(t)) else { return stress };
        let (own, part) = (goal.stress(self.data.material(t)), inner(share, l));
        std::array::from_fn(|i| stress[i] - part * own[i])
    }

    fn mu(&self, t: usize) -> f64 {
        self.data.material(t).mu()
    }

    fn of_cell(&self, t: usize) -> f64 {
        let (data, mesh) = (self.data, self.data.space.mesh());
        let corners = mesh.cell_points(t);
        let (volume, gradients) = data.space.frame(t, [0.25; 4]);
        let divergence: DVec3 = CORNERS.iter().zip(gradients).map(|(l, g)| traction(self.stress(t, *l), g)).sum();
        let goal = data.in_cells().map_or(DVec3::ZERO, |g| g.force);
        let square = if data.body_force_varies() || goal != DVec3::ZERO {
            let part = |l| self.shares.get(t).map_or(0.0, |share| inner(share, l));
            let at = |(l, x, w)| w * (data.body_force(t, x) + part(l) * goal + divergence).length_squared();
            data.space.cell_rule(t).into_iter().map(at).sum()
        } else {
            volume * (data.body_force(t, corners[0]) + divergence).length_squared()
        };
        let size = (6.0 * SQRT_2 * mesh.cell_volume(t)).cbrt();
        SCALE * (size / self.degree).powi(2) / (2.0 * self.mu(t)) * square
    }

    /// Half of what jumps at the faces to other cells.
    fn between(&self, t: usize, neighbours: &[Option<u32>; 4]) -> f64 {
        let mesh = self.data.space.mesh();
        let (tet, points) = (mesh.tets()[t], mesh.cell_points(t));
        let mut sum = 0.0;
        for (i, other) in neighbours.iter().enumerate() {
            let Some(other) = other.map(|u| u as usize) else { continue };
            let corners: [usize; 3] = std::array::from_fn(|k| (i + 1 + k) % 4);
            let [a, b, c] = corners.map(|k| points[k]);
            let normal = 0.5 * (b - a).cross(c - a);
            let area = normal.length();
            let jump = corners.map(|k| {
                let there = mesh.tets()[other].map(|v| f64::from(u8::from(v == tet[k])));
                let (here, there) = (self.stress(t, CORNERS[k]), self.stress(other, there));
                traction(std::array::from_fn(|i| here[i] - there[i]), normal / area)
            });
            // The jump is linear on the face.
            let whole = jump.iter().sum::<DVec3>().length_squared();
            let square = area / 12.0 * (jump.iter().map(|j| j.length_squared()).sum::<f64>() + whole);
            let mu = self.mu(t).max(self.mu(other));
            sum += 0.5 * SCALE * diameter(&[a, b, c]) / (self.degree * 2.0 * mu) * square;
        }
        sum
    }

    fn on_boundary(&self, face: &Face, t: usize) -> f64 {
        let space = self.data.space;
        let points = space.mesh().points();
        let (held, stiffness) = (self.data.held(face), self.data.stiffness(face));
        let place = |v: u32| face.vertices.iter().position(|&w| w == v);
        let corners = space.mesh().tets()[t].map(place);
        let (mut unbalanced, mut missed) = (0.0, 0.0);
        for (l, x, area) in space.face_rule(face) {
            let (weight, in_cell) = (area.length(), corners.map(|k| k.map_or(0.0, |k| l[k])));
            let (normal, u) = (area / weight, space.interpolate(self.displacement, t, in_cell));
            let force = self.data.traction(face, x, normal) - stiffness * u;
            let rest = force - traction(self.stress(t, in_cell), normal);
            for (c, held) in held.iter().enumerate() {
                match held {
                    Some(field) => missed += weight * (field.at(x) - u[c]).powi(2),
                    None => unbalanced += weight * rest[c].powi(2),
                }
            }
        }
        let (size, mu) = (diameter(&face.vertices.map(|v| points[v as usize])), self.mu(t));
        SCALE * size / (self.degree * 2.0 * mu) * unbalanced + 2.0 * mu * PI / size * missed
    }
}

/// The linear function of a share at a point.
fn inner(share: &Share, l: [f64; 4]) -> f64 {
    share.corners.iter().zip(l).map(|(c, l)| c * l).sum()
}

/// The longest edge of a triangle or tetrahedron.
pub(super) fn diameter(corners: &[DVec3]) -> f64 {
    let from = |(i, a): (usize, &DVec3)| corners[i + 1..].iter().map(|b| a.distance(*b)).fold(0.0, f64::max);
    corners.iter().enumerate().map(from).fold(0.0, f64::max)
}
