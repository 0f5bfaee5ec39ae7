//! What the unknowns of a level's nodes mean as motions of space.

use super::aggregate::Aggregates;
use super::order::NONE;
use glam::DVec3;
use nalgebra::{Matrix6, SymmetricEigen};
use rayon::prelude::*;

/// A small square matrix, or none for the identity.
pub(super) type Projector<const N: usize> = Option<Box<[[f64; N]; N]>>;

/// A block of rows of rigid motions.
pub(super) type Rigid<const N: usize> = [[f64; 6]; N];

/// Relative size below which a pivot shows that motions of an aggregate depend on each other.
const DOUBTFUL: f64 = 1e-3;

/// Relative squared size below which a motion counts as none.
const DEPENDENT: f64 = 1e-8;

/// The nodes of a level. On the finest, a node's unknowns are its displacement (`N` = 3); on coarser ones, the translation
/// and rotation of an aggregate (`N` = 6), the rotation in units of one over the aggregate's radius.
pub(super) struct Frame<const N: usize> {
    pub points: Vec<DVec3>,
    /// Radii, on coarser levels.
    pub radii: Vec<f64>,
    /// Projectors onto the combinations of unknowns that are free.
    pub free: Vec<Projector<N>>,
}

impl<const N: usize> Frame<N> {
    /// The motion of node `i` when space moves rigidly about `centre`, rotations in units of 1 / `radius`.
    fn rigid(&self, i: usize, centre: DVec3, radius: f64) -> Rigid<N> {
        let a = (self.points[i] - centre) / radius;
        let turn = [[0.0, a.z, -a.y], [-a.z, 0.0, a.x], [a.y, -a.x, 0.0]];
        std::array::from_fn(|r| {
            let unit = |k: usize| if k == r { 1.0 } else { 0.0 };
            match r {
                0..3 => [unit(0), unit(1), unit(2), turn[r][0], turn[r][1], turn[r][2]],
                _ => [0.0, 0.0, 0.0, unit(3), unit(4), unit(5)].map(|x| x * self.radii[i] / radius),
            }
        })
    }

    /// The coarser level's nodes, and the motions of this level's nodes with them.
    pub fn coarsen(&self, aggregates: &Aggregates) -> (Frame<6>, Vec<Rigid<N>>) {
        let mut members = vec![Vec::new(); aggregates.count];
        for (i, &of) in aggregates.of.iter().enumerate().filter(|(_, of)| **of != NONE) {
            members[of as usize].push(i);
        }
        let about = |nodes: &Vec<usize>| {
            let count = nodes.len() as f64;
            let centre = nodes.iter().map(|&i| self.points[i]).sum::<DVec3>() / count;
            let own = |i: usize| self.radii.get(i).copied().unwrap_or(0.0);
            let squares: f64 = nodes.iter().map(|&i| (self.points[i] - centre).length_squared() + own(i).powi(2)).sum();
            let radius = (squares / count).sqrt();
            let radius = if radius > 0.0 { radius } else { 1.0 };
            (centre, radius, self.free_motions(nodes, centre, radius))
        };
        let coarse: Vec<(DVec3, f64, Projector<6>)> = members.par_iter().map(about).collect();
        let motion = |i: usize| match coarse.get(aggregates.of[i] as usize) {
            Some((centre, radius, free)) => {
                let mut motion = times(self.free[i].as_deref(), self.rigid(i, *centre, *radius));
                if let Some(free) = free {
                    motion = motion.map(|row| row_times(row, free));
                }
                motion
            }
            None => [[0.0; 6]; N],
        };
        let motions = (0..self.points.len()).into_par_iter().map(motion).collect();
        let mut frame = Frame { points: Vec::new(), radii: Vec::new(), free: Vec::new() };
        for (centre, radius, free) in coarse {
            frame.points.push(centre);
            frame.radii.push(radius);
            frame.free.push(free);
        }
        (frame, motions)
    }

    /// Which motions of an aggregate are independent, as a projector; none if all are.
    fn free_motions(&self, nodes: &[usize], centre: DVec3, radius: f64) -> Projector<6> {
        let mut gram = Matrix6::<f64>::zeros();
        for &i in nodes {
            for row in times(self.free[i].as_deref(), self.rigid(i, centre, radius)) {
                for (a, x) in row.iter().enumerate() {
                    for (b, y) in row.iter().enumerate() {
                        gram[(a, b)] += x * y;
                    }
                }
            }
        }
        if well_conditioned(gram) {
            return None;
        }
        let eigen = SymmetricEigen::new(gram);
        let bound = DEPENDENT * eigen.eigenvalues.amax();
        let mut projector = [[0.0; 6]; 6];
        for k in (0..6).filter(|&k| eigen.eigenvalues[k] > bound) {
            let v = eigen.eigenvectors.column(k);
            for (a, row) in projector.iter_mut().enumerate() {
                for (b, x) in row.iter_mut().enumerate() {
                    *x += v[a] * v[b];
                }
            }
        }
        Some(Box::new(projector))
    }

    /// The same nodes in another order.
    pub fn permuted(mut self, natural: &[u32]) -> Self {
        Self {
            points: natural.iter().map(|&i| self.points[i as usize]).collect(),
            radii: natural.iter().map(|&i| self.radii[i as usize]).collect(),
            free: natural.iter().map(|&i| self.free[i as usize].take()).collect(),
        }
    }
}

/// Whether no pivot of Gauss's elimination is small beside its diagonal entry.
fn well_conditioned(mut gram: Matrix6<f64>) -> bool {
    let own = gram.diagonal();
    for k in 0..6 {
        let sound = gram[(k, k)] > DOUBTFUL * own[k];
        if !sound {
            return false;
        }
        for i in k + 1..6 {
            let factor = gram[(i, k)] / gram[(k, k)];
            for j in k + 1..6 {
                gram[(i, j)] -= factor * gram[(k, j)];
            }
        }
    }
    true
}

/// A projector times a block.
fn times<const N: usize>(projector: Option<&[[f64; N]; N]>, block: Rigid<N>) -> Rigid<N> {
    let Some(projector) = projector else { return block };
    std::array::from_fn(|r| std::array::from_fn(|c| (0..N).map(|k| projector[r][k] * block[k][c]).sum()))
}

/// A row times a symmetric matrix.
fn row_times(row: [f64; 6], matrix: &[[f64; 6]; 6]) -> [f64; 6] {
    std::array::from_fn(|c| (0..6).map(|k| row[k] * matrix[k][c]).sum())
}
