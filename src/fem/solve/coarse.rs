//! The coarse space of the preconditioner: rigid motions of aggregates of nodes.
//!
//! Conjugate gradients with a preconditioner of one node's reach need more iterations the finer the mesh, since smooth
//! displacements are the slow ones. Smooth displacements are nearly rigid on small pieces of the solid, so the nodes are
//! gathered into aggregates of some sixty nodes, and the problem restricted to displacements that are rigid on each
//! aggregate is solved directly (aggregation with rigid-body modes, Vanek, Mandel and Brezina 1996, unsmoothed).

use super::cholesky::{Analysis, Factor, Lower};
use super::ordering::Graph;
use crate::fem::block_matrix::CHUNK;
use crate::fem::{FemError, System};
use glam::{DMat3, DVec3};
use nalgebra::{Matrix6, Matrix6xX, SymmetricEigen, Vector6};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Nodes an aggregate aims at.
const NODES: usize = 60;

/// Relative squared size below which a motion of an aggregate counts as fixed, or as the same as another.
const DEPENDENT: f64 = 1e-8;

/// Marks nodes of no aggregate: those without unknowns.
const NONE: u32 = u32::MAX;

/// Combinations of the six rigid modes (translations, rotations), one a column.
type Motions = Matrix6xX<f64>;

/// An aggregate, and the stiffness between its rigid modes and another's.
type Block = (u32, Matrix6<f64>);

/// The coarse space, with its factorised matrix.
pub(super) struct Coarse {
    /// Aggregate of each node, [`NONE`] for those without unknowns.
    aggregate_of: Vec<u32>,
    /// Nodes of each aggregate, ascending.
    aggregates: Vec<Vec<u32>>,
    /// Place of each node relative to the centroid of its aggregate, in units of the aggregate's size.
    arms: Vec<DVec3>,
    /// The independent motions of each aggregate.
    motions: Vec<Motions>,
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
        let aggregate_of = aggregate(system);
        let aggregates = members(&aggregate_of);
        let arms = arms(&system.points, &aggregates);
        let motions: Vec<Motions> =
            aggregates.par_iter().map(|nodes| independent_motions(system, &arms, nodes)).collect();
        let mut first = vec![0];
        for m in &motions {
            first.push(first[first.len() - 1] + m.ncols());
        }
        let rows: Vec<Vec<Block>> =
            aggregates.par_iter().map(|nodes| coarse_row(system, &aggregate_of, nodes, &arms)).collect();
        let factor = Analysis::new(coarse_matrix(&rows, &motions, &first), &mut graph(&rows), &first)?.factorise()?;
        Ok(Self { aggregate_of, aggregates, arms, motions, first, factor })
    }

    /// Adds `P (P^T K P)^-1 P^T r` to `z`, for `r` that is zero at prescribed components.
    pub fn correct(&self, mask: &[DVec3], r: &[DVec3], z: &mut [DVec3]) -> Result<(), FemError> {
        let restricted: Vec<Vector6<f64>> = self
            .aggregates
            .par_iter()
            .with_min_len(16)
            .map(|nodes| {
                nodes.iter().fold(Vector6::zeros(), |sum, &i| sum + resultant(self.arms[i as usize], r[i as usize]))
            })
            .collect();
        let mut x: Vec<f64> = Vec::with_capacity(self.first[self.first.len() - 1]);
        for (force, motions) in restricted.iter().zip(&self.motions) {
            x.extend(motions.column_iter().map(|m| m.dot(force)));
        }
        self.factor.solve(&mut x)?;
        let rigid: Vec<[DVec3; 2]> =
            self.motions.iter().zip(&self.first).map(|(m, k)| combination(m, &x[*k..])).collect();
        z.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(i, z)| {
            if let Some([shift, spin]) = rigid.get(self.aggregate_of[i] as usize) {
                *z += mask[i] * (*shift + spin.cross(self.arms[i]));
            }
        });
        Ok(())
    }
}

/// Translation and rotation of an aggregate from its coarse unknowns, of which `x` holds at least as many as needed.
fn combination(motions: &Motions, x: &[f64]) -> [DVec3; 2] {
    let q: Vector6<f64> = motions.column_iter().zip(x).map(|(m, x)| *x * m).sum();
    [DVec3::new(q[0], q[1], q[2]), DVec3::new(q[3], q[4], q[5])]
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
fn independent_motions(system: &System, arms: &[DVec3], nodes: &[u32]) -> Motions {
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
    Motions::from_columns(&kept)
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
fn grow(
    system: &System,
    active: &[bool],
    seed: usize,
    id: u32,
    aggregate: &mut [u32],
    seeds: &mut VecDeque<usize>,
) -> usize {
    let mut members = vec![seed];
    aggregate[seed] = id;
    let mut next = 0;
    while next < members.len() {
        for (j, _) in system.stiffness.row(members[next]) {
            if active[j] && aggregate[j] == NONE {
                if members.len() < NODES {
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

/// Nodes of each aggregate, ascending.
fn members(aggregate_of: &[u32]) -> Vec<Vec<u32>> {
    let mut members: Vec<Vec<u32>> = Vec::new();
    for (i, &a) in aggregate_of.iter().enumerate().filter(|(_, a)| **a != NONE) {
        let a = a as usize;
        members.resize(members.len().max(a + 1), Vec::new());
        members[a].push(i as u32);
    }
    members
}

/// Places of the nodes relative to their aggregate's centroid, over its root mean square radius.
fn arms(points: &[DVec3], aggregates: &[Vec<u32>]) -> Vec<DVec3> {
    let mut arms = vec![DVec3::ZERO; points.len()];
    for nodes in aggregates {
        let count = nodes.len() as f64;
        let centroid = nodes.iter().map(|i| points[*i as usize]).sum::<DVec3>() / count;
        let spread: f64 = nodes.iter().map(|i| (points[*i as usize] - centroid).length_squared()).sum();
        let radius = (spread / count).sqrt();
        // A node alone has no radius: its rotations are found to be dependent.
        for i in nodes.iter().filter(|_| radius > 0.0) {
            arms[*i as usize] = (points[*i as usize] - centroid) / radius;
        }
    }
    arms
}

/// Gives the nodes of small aggregates to the neighbouring aggregate with most links, and closes the gaps in the numbers.
fn dissolve_small(system: &System, sizes: &[usize], aggregate: &mut [u32]) {
    let large = |a: u32| a != NONE && sizes[a as usize] >= NODES / 4;
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

/// The lower triangle of `P^T K P` from the blocks between rigid modes.
fn coarse_matrix(rows: &[Vec<Block>], motions: &[Motions], first: &[usize]) -> Lower {
    let mut lower = Lower { starts: vec![0], rows: Vec::new(), values: Vec::new() };
    for (a, row) in rows.iter().enumerate() {
        let upper = row.iter().map(|(b, block)| (*b as usize, block)).filter(|(b, _)| *b >= a);
        let blocks: Vec<_> = upper.map(|(b, block)| (b, motions[a].transpose() * block * &motions[b])).collect();
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
    lower
}

/// Which aggregates are neighbours.
fn graph(rows: &[Vec<Block>]) -> Graph {
    let mut graph = Graph { starts: vec![0], neighbours: Vec::new() };
    for (a, row) in rows.iter().enumerate() {
        graph.neighbours.extend(row.iter().map(|(b, _)| *b as i32).filter(|b| *b != a as i32));
        graph.starts.push(graph.neighbours.len() as i32);
    }
    graph
}

/// The 6x6 blocks between the rigid modes of one aggregate and those of its neighbours, ascending.
fn coarse_row(system: &System, aggregate_of: &[u32], nodes: &[u32], arms: &[DVec3]) -> Vec<Block> {
    let mask = system.numbering.mask();
    let mut row: Vec<Block> = Vec::new();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Space;
    use crate::fem::{GroupId, Material, Model, Support, assemble};
    use crate::mesh::generate::box_tets;

    #[test]
    fn correction_is_the_galerkin_projection() {
        let mesh = box_tets([2.0, 1.0, 1.0], [12, 6, 6]).unwrap();
        let support = |group, displacement| Support::new("", GroupId(group), displacement);
        let supports = vec![support(0, [Some(0.0); 3]), support(4, [None, None, Some(0.0)])];
        let materials = vec![Material { youngs_modulus: 2.0, poissons_ratio: 0.3, density: 0.0 }];
        let system = assemble(&Space::linear(&mesh), &Model { materials, supports, loads: vec![] }).unwrap();
        let coarse = Coarse::new(&system).unwrap();
        assert!(coarse.aggregates.len() > 5 && coarse.aggregates.iter().all(|nodes| nodes.len() >= NODES / 4));
        let mask = system.numbering.mask();
        let correct = |r: &[DVec3]| {
            let mut z = vec![DVec3::ZERO; r.len()];
            coarse.correct(mask, r, &mut z).unwrap();
            z
        };
        // Corrections are rigid on each aggregate, so the correction of their own force is themselves.
        let push: Vec<DVec3> = mesh.points().iter().zip(mask).map(|(x, m)| *m * (*x + DVec3::Y)).collect();
        let z = correct(&push);
        let force: Vec<DVec3> = system.stiffness.times(&z).iter().zip(mask).map(|(f, m)| *m * *f).collect();
        let scale = z.iter().map(|z| z.length()).fold(0.0, f64::max);
        assert!(scale > 0.0);
        assert!(correct(&force).iter().zip(&z).all(|(a, b)| (*a - *b).length() < 1e-11 * scale));
    }
}
