//! Sparse rows that make new points of old ones.

use rayon::prelude::*;
use std::ops::{Add, Mul};

/// One row a new point: which old points it combines, and with what weights.
#[derive(Debug, Clone, Default)]
pub struct Stencils {
    starts: Vec<usize>,
    columns: Vec<u32>,
    weights: Vec<f64>,
}

impl Stencils {
    /// Makes the rows in parallel; the entries of each are sorted, and those of one column summed.
    pub(super) fn collect(rows: usize, row: impl Fn(usize, &mut Vec<(u32, f64)>) + Sync) -> Self {
        const CHUNK: usize = 4096;
        let chunk = |chunk: usize| {
            let (mut own, mut entries) = (Self { starts: vec![0], ..Self::default() }, Vec::new());
            for i in chunk * CHUNK..rows.min((chunk + 1) * CHUNK) {
                entries.clear();
                row(i, &mut entries);
                own.push(&mut entries);
            }
            own
        };
        let chunks: Vec<Self> = (0..rows.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        let mut all = Self { starts: vec![0], ..Self::default() };
        for chunk in chunks {
            let first = all.columns.len();
            all.starts.extend(chunk.starts[1..].iter().map(|s| first + s));
            all.columns.extend(chunk.columns);
            all.weights.extend(chunk.weights);
        }
        all
    }

    fn push(&mut self, entries: &mut [(u32, f64)]) {
        // A stable sort: the order of sums is that in which entries were made.
        entries.sort_by_key(|e| e.0);
        let first = self.columns.len();
        for &(column, weight) in entries.iter() {
            match self.columns[first..].last() {
                Some(&last) if last == column => {
                    if let Some(sum) = self.weights.last_mut() {
                        *sum += weight;
                    }
                }
                _ => {
                    self.columns.push(column);
                    self.weights.push(weight);
                }
            }
        }
        self.starts.push(self.columns.len());
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Old points and weights of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// The new values of a field.
    pub fn apply<T>(&self, values: &[T]) -> Vec<T>
    where
        T: Copy + Default + Send + Sync + Add<Output = T> + Mul<f64, Output = T>,
    {
        let row = |i| self.row(i).fold(T::default(), |sum, (v, w)| sum + values[v as usize] * w);
        (0..self.rows()).into_par_iter().with_min_len(1024).map(row).collect()
    }
}
