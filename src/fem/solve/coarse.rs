//! The coarse space of the preconditioner: rigid motions of aggregates of nodes.
//!
//! Conjugate gradients with a preconditioner of one node's reach need more iterations the finer the mesh, since smooth
//! displacements are the slow ones. Smooth displacements are nearly rigid on small pieces of the solid, so the nodes are
//! gathered into aggregates of some forty nodes, and the problem restricted to displacements that are rigid on each
//! aggregate is solved directly (aggregation with rigid-body modes, Vanek, Mandel and Brezina 1996, unsmoothed).

use super::cholesky::{Analysis, Factor, Lower};
use super::ordering::Graph;
use crate::fem::{FemError, System};
use glam::{DMat3, DVec3};
use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Nodes an aggregate aims at.
const NODES: usize = 40;
fn nodes_x() -> usize { std::env::var("NX").map_or(40, |s| s.parse().unwrap()) }

/// Relative squared size below which a motion of an aggregate counts as fixed, or as the same as another.
const DEPENDENT: f64 = 1e-8;

/// Marks nodes of no aggregate: those without unknowns.
const NONE: u32 = u32::MAX;

/// The coarse space, with its factorised matrix.
pub(super) struct Coarse {
    /// Nodes of each aggregate, ascending.
    aggregates: Vec<Vec<u32>>,
    /// Place of each node relative to the centroid of its aggregate, in units of the aggregate's size.
    arms: Vec<DVec3>,
    /// For each aggregate the independent motions: rigid modes (translations, rotations) in the columns.
    motions: Vec<nalgebra::Matrix6xX<f64>>,
    /// The first coarse unknown of each aggregate, and the number of all.
    first: Vec<usize>,
    factor: Factor,
}

impl Coarse {
    /// Aggregates the nodes and factorises the coarse matrix `P^T K P`.
    ///
    /// # Errors
    /// As the direct method's.
    pub fn new(system: &System) -> Result<Self, FemError> {
        let points = &system.points;
        let aggregate_of = aggregate(system);
        let mut aggregates = vec![Vec::new(); aggregate_of.iter().filter(|a| **a != NONE).max().map_or(0, |a| *a as usize + 1)];
        for (i, &a) in aggregate_of.iter().enumerate().filter(|(_, a)| **a != NONE) {
            aggregates[a as usize].push(i as u32);
        }
        let mut arms = vec![DVec3::ZERO; points.len()];
        for nodes in &aggregates {
            let position = |i: &u32| points[*i as usize];
            let centroid = nodes.iter().map(position).sum::<DVec3>() / nodes.len() as f64;
            let spread: f64 = nodes.iter().map(|i| (position(i) - centroid).length_squared()).sum();
            let size = (spread / nodes.len() as f64).sqrt().max(f64::MIN_POSITIVE);
            for i in nodes {
                arms[*i as usize] = (position(i) - centroid) / size;
            }
        }
        let motions: Vec<_> = aggregates.iter().map(|nodes| independent_motions(system, &arms, nodes)).collect();
        let mut first = vec![0];
        first.extend(motions.iter().scan(0, |sum, m| {
            *sum += m.ncols();
            Some(*sum)
        }));
        let (lower, mut graph) = coarse_matrix(system, &aggregate_of, &aggregates, &arms, &motions, &first);
        let factor = Analysis::new(lower, &mut graph, &first)?.factorise()?;
        Ok(Self { aggregates, arms, motions, first, factor })
    }

    /// Adds `P (P^T K P)^-1 P^T r` to `z`, for `r` that is zero at prescribed components.
    pub fn correct(&self, mask: &[DVec3], r: &[DVec3], z: &mut [DVec3]) -> Result<(), FemError> {
        let restricted: Vec<Vector6<f64>> = self
            .aggregates
            .par_iter()
            .with_min_len(16)
            .map(|nodes| nodes.iter().fold(Vector6::zeros(), |sum, &i| sum + resultant(self.arms[i as usize], r[i as usize])))
            .collect();
        let mut x: Vec<f64> = Vec::with_capacity(self.first[self.first.len() - 1]);
        for (force, motions) in restricted.iter().zip(&self.motions) {
            x.extend(motions.column_iter().map(|m| m.dot(force)));
        }
        self.factor.solve(&mut x)?;
        for (a, nodes) in self.aggregates.iter().enumerate() {
            let mut q = Vector6::zeros();
            for (m, x) in self.motions[a].column_iter().zip(&x[self.first[a]..]) {
                q += *x * m;
            }
            let (shift, spin) = (DVec3::new(q[0], q[1], q[2]), DVec3::new(q[3], q[4], q[5]));
            for &i in nodes {
                let i = i as usize;
                z[i] += mask[i] * (shift + spin.cross(self.arms[i]));
            }
        }
        Ok(())
    }
}

/// Force and moment of a nodal force.
fn resultant(arm: DVec3, force: DVec3) -> Vector6<f64> {
    let moment = arm.cross(force);
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

/// The six rigid modes at a node.
fn modes(arm: DVec3) -> [DVec3; 6] {
    std::array::from_fn(|k| if k < 3 { DVec3::AXES[k] } else { DVec3::AXES[k - 3].cross(arm) })
}

/// Combinations of rigid modes that are orthonormal as vectors of the aggregate's unknowns.
fn independent_motions(system: &System, arms: &[DVec3], nodes: &[u32]) -> nalgebra::Matrix6xX<f64> {
    let mask = system.numbering.mask();
    let mut gram = Matrix6::zeros();
    for &i in nodes {
        for (k, mode) in modes(arms[i as usize]).into_iter().enumerate() {
            let column = resultant(arms[i as usize], mask[i as usize] * mode);
            gram.set_column(k, &(gram.column(k) + column));
        }
    }
    let eigen = SymmetricEigen::new(gram);
    let bound = DEPENDENT * eigen.eigenvalues.amax();
    let kept: Vec<Vector6<f64>> = (0..6)
        .filter(|&k| eigen.eigenvalues[k] > bound)
        .map(|k| eigen.eigenvectors.column(k) / eigen.eigenvalues[k].sqrt())
        .collect();
    nalgebra::Matrix6xX::from_columns(&kept)
}

/// Gathers nodes with unknowns into connected aggregates, by breadth-first growth from the rim of those before.
fn aggregate(system: &System) -> Vec<u32> {
    let active: Vec<bool> = system.numbering.mask().iter().map(|m| *m != DVec3::ZERO).collect();
    let mut aggregate = vec![NONE; active.len()];
    let mut sizes: Vec<usize> = Vec::new();
    let mut seeds = VecDeque::new();
    for start in 0..active.len() {
        seeds.push_back(start);
        while let Some(seed) = seeds.pop_front() {
            if active[seed] && aggregate[seed] == NONE {
                sizes.push(grow(system, &active, seed, sizes.len() as u32, &mut aggregate, &mut seeds));
            }
        }
    }
    dissolve_small(system, &sizes, &mut aggregate);
    aggregate
}

/// Grows aggregate `id` from a seed; its unclaimed neighbours become seeds. Returns its size.
fn grow(system: &System, active: &[bool], seed: usize, id: u32, aggregate: &mut [u32], seeds: &mut VecDeque<usize>) -> usize {
    let mut members = vec![seed];
    aggregate[seed] = id;
    let mut next = 0;
    while next < members.len() {
        for (j, _) in system.stiffness.row(members[next]) {
            if active[j] && aggregate[j] == NONE {
                if members.len() < nodes_x() {
                    aggregate[j] = id;
                    members.push(j);
                } else {
                    seeds.push_back(j);
                }
            }
        }
        next += 1;
    }
    members.len()
}

/// Gives the nodes of small aggregates to the neighbouring aggregate with most links, and closes the gaps in the numbers.
fn dissolve_small(system: &System, sizes: &[usize], aggregate: &mut [u32]) {
    let large = |a: u32| a != NONE && sizes[a as usize] >= nodes_x() / 4;
    let old = aggregate.to_vec();
    for i in (0..old.len()).filter(|&i| old[i] != NONE && !large(old[i])) {
        let mut near: Vec<u32> = system.stiffness.row(i).map(|(j, _)| old[j]).filter(|a| large(*a)).collect();
        near.sort_unstable();
        let best = near.chunk_by(|a, b| a == b).rev().max_by_key(|same| same.len());
        aggregate[i] = best.map_or(old[i], |same| same[0]);
    }
    let mut used: Vec<u32> = aggregate.iter().copied().filter(|a| *a != NONE).collect();
    used.sort_unstable();
    used.dedup();
    for a in aggregate.iter_mut().filter(|a| **a != NONE) {
        *a = used.partition_point(|u| u < a) as u32;
    }
}

/// `P^T K P` and the graph of the aggregates.
fn coarse_matrix(
    system: &System,
    aggregate_of: &[u32],
    aggregates: &[Vec<u32>],
    arms: &[DVec3],
    motions: &[nalgebra::Matrix6xX<f64>],
    first: &[usize],
) -> (Lower, Graph) {
    let rows: Vec<Vec<(u32, Matrix6<f64>)>> =
        aggregates.par_iter().map(|nodes| coarse_row(system, aggregate_of, nodes, arms)).collect();
    let mut lower = Lower { starts: vec![0], rows: Vec::new(), values: Vec::new() };
    let mut graph = Graph { starts: vec![0], neighbours: Vec::new() };
    for (a, row) in rows.iter().enumerate() {
        graph.neighbours.extend(row.iter().filter(|(b, _)| *b as usize != a).map(|(b, _)| *b as i32));
        graph.starts.push(graph.neighbours.len() as i32);
        let blocks: Vec<_> = row
            .iter()
            .filter(|(b, _)| *b as usize >= a)
            .map(|(b, block)| (*b as usize, motions[a].transpose() * block * &motions[*b as usize]))
            .collect();
        for p in 0..motions[a].ncols() {
            for (b, block) in &blocks {
                for q in (0..block.ncols()).filter(|q| *b > a || *q >= p) {
                    lower.rows.push(first[*b] + q);
                    lower.values.push(block[(p, q)]);
                }
            }
            lower.starts.push(lower.rows.len());
        }
    }
    (lower, graph)
}

/// The 6x6 blocks between the rigid modes of one aggregate and those of its neighbours, ascending.
fn coarse_row(system: &System, aggregate_of: &[u32], nodes: &[u32], arms: &[DVec3]) -> Vec<(u32, Matrix6<f64>)> {
    let mask = system.numbering.mask();
    let mut row: Vec<(u32, Matrix6<f64>)> = Vec::new();
    for &i in nodes {
        let i = i as usize;
        for (j, block) in system.stiffness.row(i).filter(|(j, _)| aggregate_of[*j] != NONE) {
            let block = DMat3::from_diagonal(mask[i]) * *block * DMat3::from_diagonal(mask[j]);
            let slot = row.iter().position(|(b, _)| *b == aggregate_of[j]).unwrap_or_else(|| {
                row.push((aggregate_of[j], Matrix6::zeros()));
                row.len() - 1
            });
            for (k, mode) in modes(arms[j]).into_iter().enumerate() {
                let mut column = row[slot].1.column_mut(k);
                column += resultant(arms[i], block * mode);
            }
        }
    }
    row.sort_unstable_by_key(|(b, _)| *b);
    row
}
