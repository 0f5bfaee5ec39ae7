//! What follows below a level.

use super::operator::Operator;
use super::order::NONE;
use super::real::Real;
use super::rows::add_scaled;
use crate::fem::FemError;
use crate::fem::solve::cholesky::{Analysis, Factor, Lower};
use crate::fem::solve::ordering::Graph;
use rayon::prelude::*;

/// The level of the edges' midpoints, above that of the vertices: displacements linear on each edge.
pub(super) struct Midpoints {
    /// For each node the one or two vertices it lies between, by place; [`NONE`] for those without unknowns.
    ends: Vec<[u32; 2]>,
    /// Where the nodes of each vertex begin: itself and the midpoints of its edges.
    starts: Vec<u32>,
    nodes: Vec<u32>,
}

impl Midpoints {
    /// `ends` by place, a vertex twice its own.
    pub fn new(ends: Vec<[u32; 2]>, vertices: usize) -> Self {
        let mut starts = vec![0_u32; vertices + 1];
        let uses = || ends.iter().enumerate().flat_map(|(i, &e)| e.map(|v| (i, v))).filter(|(_, v)| *v != NONE);
        uses().for_each(|(_, v)| starts[v as usize + 1] += 1);
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut nodes = vec![0; starts[vertices] as usize];
        for (i, v) in uses() {
            nodes[next[v as usize] as usize] = i as u32;
            next[v as usize] += 1;
        }
        Self { ends, starts, nodes }
    }

    /// `coarse = P^T fine`, where `free` is 1 and not 0. A vertex is listed twice among its own nodes, a midpoint once at
    /// each end.
    pub fn restrict<T: Real>(&self, fine: &[[T; 4]], free: &[[T; 4]], coarse: &mut [[T; 4]]) {
        let half = T::new(0.5);
        coarse.par_iter_mut().zip(free).with_min_len(256).enumerate().for_each(|(v, (coarse, free))| {
            let mut sum = [T::default(); 4];
            for &i in &self.nodes[self.starts[v] as usize..self.starts[v + 1] as usize] {
                add_scaled(&mut sum, half, &fine[i as usize]);
            }
            *coarse = std::array::from_fn(|c| free[c] * sum[c]);
        });
    }

    /// `fine += P coarse`, where `free` is 1 and not 0.
    pub fn prolong<T: Real>(&self, coarse: &[[T; 4]], free: &[[T; 4]], fine: &mut [[T; 4]]) {
        let half = T::new(0.5);
        fine.par_iter_mut().zip(free).zip(&self.ends).with_min_len(256).for_each(|((fine, free), ends)| {
            for x in ends.iter().filter_map(|&v| coarse.get(v as usize)) {
                for c in 0..3 {
                    fine[c] += half * free[c] * x[c];
                }
            }
        });
    }
}

/// The solution on the last level: its matrix factorised.
pub(super) struct Bottom(Factor);

impl Bottom {
    /// # Errors
    /// [`FemError::Multigrid`] if the matrix is not positive definite; as the direct method's.
    pub fn new<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>) -> Result<Self, FemError> {
        let mut graph = Graph { starts: vec![0], neighbours: Vec::new() };
        let mut lower = Lower { starts: vec![0], rows: Vec::new(), values: Vec::new() };
        for i in 0..a.len() {
            let [(left, _), (right, values)] = a.row(i);
            graph.neighbours.extend(left.iter().chain(right).map(|j| *j as i32));
            graph.starts.push(graph.neighbours.len() as i32);
            // Columns of the lower triangle are rows of the upper one; blocks are kept by columns.
            for c in 0..N {
                let own = (c..N).map(|d| (N * i + d, a.diagonal[i][c][d]));
                let blocks = right.iter().zip(values.chunks_exact(N * N));
                let others = blocks.flat_map(|(&j, block)| (0..N).map(move |d| (N * j as usize + d, block[d * N + c])));
                for (row, value) in own.chain(others) {
                    lower.rows.push(row);
                    lower.values.push(value.get());
                }
                lower.starts.push(lower.rows.len());
            }
        }
        let first: Vec<usize> = (0..=a.len()).map(|i| N * i).collect();
        match Analysis::new(lower, &mut graph, &first)?.factorise() {
            Err(FemError::NotPositiveDefinite { detail }) => {
                Err(FemError::Multigrid { detail: format!("{detail} on the last level") })
            }
            factor => Ok(Self(factor?)),
        }
    }

    /// Solves `A z = r`.
    ///
    /// # Errors
    /// As the factor's.
    pub fn solve<T: Real, const N: usize, const W: usize>(
        &self,
        r: &[[T; W]],
        z: &mut [[T; W]],
    ) -> Result<(), FemError> {
        let mut x: Vec<f64> = r.iter().flat_map(|r| r[..N].iter().map(|x| x.get())).collect();
        self.0.solve(&mut x)?;
        for (z, x) in z.iter_mut().zip(x.chunks_exact(N)) {
            for c in 0..N {
                z[c] = T::new(x[c]);
            }
        }
        Ok(())
    }
}
