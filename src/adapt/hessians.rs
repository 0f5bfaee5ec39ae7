//! Second derivatives of the displacement, recovered.

use super::CellErrors;
use crate::fem::Space;
use crate::mesh::{TetMesh, quality};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Gradients of a cell's barycentric coordinates, and its volume.
fn frame(mesh: &TetMesh, t: usize) -> (f64, [DVec3; 4]) {
    let p = mesh.cell_points(t);
    let volume = quality::volume(p);
    let scale = -1.0 / (6.0 * volume);
    (volume, quality::face_normals(p).map(|n| scale * n))
}

/// a b^T.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl CellErrors {
    /// Second moments sum_c H_c H_c of the Hessians H_c of the displacement's components, at each vertex, by their entries
    /// XX YY ZZ XY YZ XZ.
    ///
    /// The gradients of the displacement between the vertices are averaged at each vertex by volume, each region for
    /// itself; between these values they vary linearly in a cell, and their derivatives there are averaged again.
    #[must_use]
    pub fn second_moments(&self, space: &Space<'_>, displacement: &[DVec3]) -> Vec<[f64; 6]> {
        let mesh = space.mesh();
        let gradient = |t: usize| {
            let (volume, frame) = frame(mesh, t);
            let terms = mesh.tets()[t].iter().zip(frame).map(|(v, g)| outer(displacement[*v as usize], g));
            (volume, terms.fold(DMat3::ZERO, |sum, term| sum + term))
        };
        let gradients: Vec<_> = (0..mesh.tets().len()).into_par_iter().map(gradient).collect();
        let mut at_patches = vec![(0.0, DMat3::ZERO); self.recovered.at_vertices.len()];
        for (patches, (volume, gradient)) in self.recovered.patches.iter().zip(&gradients) {
            for &p in patches {
                let (total, sum) = &mut at_patches[p as usize];
                *total += volume;
                *sum += *volume * *gradient;
            }
        }
        let mean = |p: u32| {
            let (total, sum) = at_patches[p as usize];
            sum * (1.0 / total)
        };
        let hessian = |t: usize| {
            let (volume, frame) = frame(mesh, t);
            let mut rows = [DMat3::ZERO; 3];
            for (p, g) in self.recovered.patches[t].into_iter().zip(frame) {
                let gradient = mean(p).transpose();
                for (c, row) in rows.iter_mut().enumerate() {
                    *row += outer(gradient.col(c), g);
                }
            }
            (volume, rows.map(|h| (h + h.transpose()) * 0.5))
        };
        let hessians: Vec<_> = (0..mesh.tets().len()).into_par_iter().map(hessian).collect();
        let mut at_vertices = vec![(0.0, [DMat3::ZERO; 3]); mesh.points().len()];
        for (tet, (volume, hessian)) in mesh.tets().iter().zip(&hessians) {
            for &v in tet {
                let (total, sums) = &mut at_vertices[v as usize];
                *total += volume;
                sums.iter_mut().zip(hessian).for_each(|(sum, h)| *sum += *volume * *h);
            }
        }
        let moment = |(total, sums): (f64, [DMat3; 3])| {
            let s = sums.into_iter().fold(DMat3::ZERO, |s, h| s + h * h) * (1.0 / (total * total));
            [s.col(0).x, s.col(1).y, s.col(2).z, s.col(1).x, s.col(2).y, s.col(2).x]
        };
        at_vertices.into_par_iter().map(moment).collect()
    }
}
