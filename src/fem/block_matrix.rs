//! A square sparse matrix of 3x3 blocks, one row and column of blocks a node.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Nodes that a task works on. Sums are made chunk by chunk and then in the order of the chunks, so their bytes do not
/// depend on the number of threads.
pub(super) const CHUNK: usize = 1024;

/// Compressed rows of 3x3 blocks; columns ascend in each row. The matrices kept here are symmetric.
#[derive(Debug, Clone)]
pub(super) struct BlockMatrix {
    /// Where each row begins, and the number of blocks.
    pub starts: Vec<usize>,
    pub columns: Vec<u32>,
    pub blocks: Vec<DMat3>,
}

impl BlockMatrix {
    /// Rows of blocks.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and blocks of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, &DMat3)> {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().map(|&j| j as usize).zip(&self.blocks[range])
    }

    /// The block of row `i` and column `j`, if it is stored.
    pub fn block_mut(&mut self, i: u32, j: u32) -> Option<&mut DMat3> {
        let range = self.starts[i as usize]..self.starts[i as usize + 1];
        let slot = self.columns[range.clone()].binary_search(&j).ok()?;
        self.blocks.get_mut(range.start + slot)
    }

    /// `(K x)_i`.
    pub fn row_times(&self, i: usize, x: &[DVec3]) -> DVec3 {
        self.row(i).fold(DVec3::ZERO, |sum, (j, block)| sum + *block * x[j])
    }

    /// `K x`.
    pub fn times(&self, x: &[DVec3]) -> Vec<DVec3> {
        (0..self.rows()).into_par_iter().with_min_len(CHUNK).map(|i| self.row_times(i, x)).collect()
    }

    /// The block on the diagonal of row `i`; zero if there is none.
    pub fn diagonal(&self, i: usize) -> DMat3 {
        self.row(i).find(|(j, _)| *j == i).map_or(DMat3::ZERO, |(_, block)| *block)
    }
}

/// `x . y`.
pub(super) fn dot(x: &[DVec3], y: &[DVec3]) -> f64 {
    let partial = |(x, y): (&[DVec3], &[DVec3])| x.iter().zip(y).map(|(x, y)| x.dot(*y)).sum();
    let partials: Vec<f64> = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)).map(partial).collect();
    partials.iter().sum()
}

/// `|x|`.
pub(super) fn norm(x: &[DVec3]) -> f64 {
    dot(x, x).sqrt()
}
