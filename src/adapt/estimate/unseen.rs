//! The error of data that the elements do not see.
//!
//! Nodal forces know of a body force f its best linear approximation on each cell at most, of a load g that on each face; with
//! what is left of them the computed displacement would be the same, and so would be the stress recovered from it. The
//! displacement that the rest makes (looked at in more points than nodal forces are made by) is bounded in the energy norm by
//!
//! ```text
//! h_K^2 / (pi^2 2 mu) |f - P f|_K^2 + |F| h_K^2 / |K| (1 / pi^2 + 2 / (3 pi)) / (2 mu) |g - P g|_F^2
//! ```
//!
//! with h the longest edge: Poincare's inequality on a convex cell (Payne and Weinberger 1960) and the trace inequality that
//! follows from it; the constant of Korn's inequality counts as one. Both are of higher order than the error where f and g
//! are smooth. For goals the same holds of the forces of their dual problems; a mean of a stress is the integral of `G : e(u)`
//! over part of a cell, and what is left of that has the energy of its stress, `(G - P G) : C^-1 : (G - P G)`.

use super::residual::diameter;
use crate::adapt::options::Estimator;
use crate::fem::Data;
use crate::mesh::{Face, topology};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// How many points a mesh is looked at in beside those of the rules that nodal forces are made by: loads may act between these.
const SAMPLES: usize = 300_000;

/// Along each edge of a cell or a face.
const PARTS: [usize; 2] = [4, 50];

/// The squared bound of each cell; empty where no data vary. To the residual estimator only the means of goals are unseen.
pub(super) fn squared(data: &Data<'_>, estimator: Estimator) -> Vec<f64> {
    let mesh = data.space.mesh();
    let loads = estimator != Estimator::Residual;
    let faces = loads && mesh.faces().iter().any(|face| data.traction_varies(face));
    let cells = (loads && data.body_force_varies()) || data.in_cells().is_some();
    if !cells && !faces {
        return Vec::new();
    }
    let count = mesh.tets().len();
    let parts = ((6 * SAMPLES / count) as f64).cbrt() as usize;
    let parts = parts.clamp(PARTS[0], PARTS[1]);
    let mut squared =
        if cells { (0..count).into_par_iter().map(|t| of_cell(data, t, parts)).collect() } else { vec![0.0; count] };
    if faces {
        let cells = topology::boundary_cells(mesh.tets());
        let varying = mesh.faces().iter().filter(|face| data.traction_varies(face)).count();
        let parts = (((2 * SAMPLES / varying) as f64).sqrt() as usize).clamp(PARTS[0], PARTS[1]);
        let of_faces = mesh.faces().par_iter().zip(&cells).map(|(face, &t)| on_face(data, face, t as usize, parts));
        let of_faces: Vec<f64> = of_faces.collect();
        cells.into_iter().zip(of_faces).for_each(|(t, value)| squared[t as usize] += value);
    }
    squared
}

fn of_cell(data: &Data<'_>, t: usize, parts: usize) -> f64 {
    let (mesh, material) = (data.space.mesh(), data.material(t));
    let poincare = (diameter(&mesh.cell_points(t)) / PI).powi(2) / (2.0 * material.mu());
    let mut sum = 0.0;
    if data.body_force_varies() {
        let force = |(l, x, w)| (l, data.body_force(t, x), w);
        let samples: Vec<_> = data.space.cell_samples(t, parts).into_iter().map(force).collect();
        sum += poincare * rest(&data.space.cell_rule(t).map(force), &samples, 5.0);
    }
    if let Some(goal) = data.in_cells() {
        let square = poincare * goal.force.length_squared() + material.compliance_energy(goal.stress(material));
        sum += square * goal.share(data.space, t).rest;
    }
    sum
}

fn on_face(data: &Data<'_>, face: &Face, t: usize, parts: usize) -> f64 {
    if !data.traction_varies(face) {
        return 0.0;
    }
    let mesh = data.space.mesh();
    let free = DVec3::from(data.held(face).map(|held| if held.is_some() { 0.0 } else { 1.0 }));
    let load = |(l, x, area): ([f64; 3], DVec3, DVec3)| {
        let weight = area.length();
        (l, free * data.traction(face, x, area / weight), weight)
    };
    let seen = data.space.face_rule(face).map(load);
    let samples: Vec<_> = data.space.face_samples(face, parts).into_iter().map(load).collect();
    let area: f64 = seen.iter().map(|(_, _, w)| w).sum();
    let trace = (PI.powi(-2) + 2.0 / (3.0 * PI)) * area / mesh.cell_volume(t);
    trace * diameter(&mesh.cell_points(t)).powi(2) / (2.0 * data.material(t).mu()) * rest(&seen, &samples, 4.0)
}

/// The integral over samples of the squared difference between a vector field and its best linear approximation on a simplex of
/// `N` corners by the points of a rule: of each point barycentric coordinates, value and weight.
///
/// On N corners the mass matrix is `m / (N (N + 1)) (I + 1 1^T)`, m the measure; `n` is N + 1.
fn rest<const N: usize>(rule: &[([f64; N], DVec3, f64)], samples: &[([f64; N], DVec3, f64)], n: f64) -> f64 {
    let measure: f64 = rule.iter().map(|(_, _, w)| w).sum();
    let mut moments = [DVec3::ZERO; N];
    for (l, value, w) in rule {
        moments.iter_mut().zip(l).for_each(|(m, l)| *m += w * l * *value);
    }
    let sum: DVec3 = moments.iter().sum();
    let corners = moments.map(|m| (n - 1.0) * n / measure * (m - sum / n));
    let difference = |(l, value, w): &([f64; N], DVec3, f64)| {
        let linear: DVec3 = corners.iter().zip(l).map(|(c, l)| *c * *l).sum();
        w * (*value - linear).length_squared()
    };
    samples.iter().map(difference).sum()
}
