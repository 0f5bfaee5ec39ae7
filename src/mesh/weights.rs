//! Sparse matrices of weights: new points as combinations of old ones.

use rayon::prelude::*;
use std::ops::{Add, Mul, Range};

/// A sparse matrix by rows: row `i` says which old points the new point `i` combines, and with what weights.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightRows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    weights: Vec<f64>,
    width: usize,
}

/// How many rows a thread takes at a time.
const PIECE: usize = 1 << 11;

impl WeightRows {
    /// The rows that `row` pushes, made in parallel. The entries of each are sorted, and those of one column summed in the order
    /// in which they were pushed.
    pub fn collect(rows: usize, width: usize, row: impl Fn(usize, &mut Vec<(u32, f64)>) + Sync) -> Self {
        Self::in_pieces(rows, width, |piece, range| {
            let mut entries = Vec::new();
            for i in range {
                entries.clear();
                row(i, &mut entries);
                piece.push(&mut entries);
            }
        })
    }

    /// Joins pieces, each filled with a range of rows, in order.
    fn in_pieces(rows: usize, width: usize, fill: impl Fn(&mut Self, Range<usize>) + Sync) -> Self {
        let of_piece = |first: usize| {
            let mut piece = Self::empty(width);
            fill(&mut piece, first..rows.min(first + PIECE));
            piece
        };
        let firsts: Vec<usize> = (0..rows).step_by(PIECE).collect();
        let pieces: Vec<Self> = firsts.into_par_iter().map(of_piece).collect();
        let entries = pieces.iter().map(Self::entries).sum();
        let mut all = Self::empty(width);
        all.starts.reserve(rows);
        all.columns.reserve(entries);
        all.weights.reserve(entries);
        for piece in pieces {
            let first = all.columns.len();
            all.starts.extend(piece.starts[1..].iter().map(|s| first + s));
            all.columns.extend(piece.columns);
            all.weights.extend(piece.weights);
        }
        all
    }

    /// The square matrix that changes nothing.
    #[must_use]
    pub fn identity(width: usize) -> Self {
        Self { starts: (0..=width).collect(), columns: (0..width as u32).collect(), weights: vec![1.0; width], width }
    }

    fn empty(width: usize) -> Self {
        Self { starts: vec![0], columns: Vec::new(), weights: Vec::new(), width }
    }

    fn push(&mut self, entries: &mut [(u32, f64)]) {
        // A stable sort keeps the order of sums.
        entries.sort_by_key(|e| e.0);
        for same in entries.chunk_by(|a, b| a.0 == b.0) {
            self.columns.push(same[0].0);
            self.weights.push(same.iter().map(|e| e.1).sum());
        }
        self.starts.push(self.columns.len());
    }

    /// Number of rows: of new points.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of columns: of old points.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of entries.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Old points and weights of row `i`, by ascending point.
    pub fn row(&self, i: usize) -> impl ExactSizeIterator<Item = (u32, f64)> + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// The product `self * first`: what the rows make of the points that `first` makes.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self::in_pieces(self.rows(), first.width, |piece, range| {
            // The sums of a row, in one place a column; zero between rows.
            let (mut sums, mut touched) = (vec![0.0; first.width], Vec::new());
            for i in range {
                for (middle, weight) in self.row(i) {
                    for (column, w) in first.row(middle as usize) {
                        sums[column as usize] += weight * w;
                        touched.push(column);
                    }
                }
                touched.sort_unstable();
                touched.dedup();
                piece.columns.extend_from_slice(&touched);
                piece.weights.extend(touched.iter().map(|&c| std::mem::take(&mut sums[c as usize])));
                piece.starts.push(piece.columns.len());
                touched.clear();
            }
        })
    }

    /// Some of the rows.
    #[must_use]
    pub fn select(&self, rows: &[u32]) -> Self {
        Self::collect(rows.len(), self.width, |i, row| row.extend(self.row(rows[i] as usize)))
    }

    /// The transposed matrix.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut starts = vec![0; self.width + 1];
        self.columns.iter().for_each(|&c| starts[c as usize + 1] += 1);
        for c in 0..self.width {
            starts[c + 1] += starts[c];
        }
        let (mut columns, mut weights) = (vec![0; self.entries()], vec![0.0; self.entries()]);
        let mut next = starts.clone();
        for i in 0..self.rows() {
            for (c, w) in self.row(i) {
                let place = &mut next[c as usize];
                (columns[*place], weights[*place]) = (i as u32, w);
                *place += 1;
            }
        }
        Self { starts, columns, weights, width: self.rows() }
    }

    /// The new values of a field that has one value an old point.
    pub fn apply<T>(&self, values: &[T]) -> Vec<T>
    where
        T: Copy + Default + Send + Sync + Add<Output = T> + Mul<f64, Output = T>,
    {
        let row = |i| self.row(i).fold(T::default(), |sum, (v, w)| sum + values[v as usize] * w);
        (0..self.rows()).into_par_iter().with_min_len(PIECE).map(row).collect()
    }
}
