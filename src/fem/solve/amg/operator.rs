//! A level's matrix, split for Gauss-Seidel sweeps.

use super::order::{Order, split};
use super::real::Real;
use super::rows::{Rows, add, add_scaled, columns_times, lanes, minus, total, wide};
use crate::fem::FemError;
use rayon::prelude::*;
use std::ops::Range;

/// A block with padded columns.
pub(super) type Padded<T, const N: usize, const W: usize> = [[T; W]; N];

/// A symmetric positive definite matrix of `N` x `N` blocks, a row a node. Vectors have `W` entries a node, of which the
/// last `W - N` are padding.
///
/// Diagonal, lower and upper blocks are stored apart, each in the order in which a sweep reads them: what the memory
/// delivers in order arrives several times faster.
pub(super) struct Operator<T, const N: usize, const W: usize> {
    pub order: Order,
    pub diagonal: Vec<Padded<T, N, W>>,
    /// Inverses of the diagonal blocks.
    pub inverses: Vec<Padded<T, N, W>>,
    /// Rows of each chunk left of the diagonal, columns ascending.
    lower: Vec<Rows<T>>,
    /// Rows of each chunk right of the diagonal, last row first.
    upper: Vec<Rows<T>>,
}

/// A row while it is made: places and blocks.
pub(super) type Entries<T, const N: usize, const W: usize> = Vec<(u32, Padded<T, N, W>)>;

/// What a chunk's rows are made into.
struct Part<T, const N: usize, const W: usize> {
    diagonal: Vec<Padded<T, N, W>>,
    inverses: Vec<Padded<T, N, W>>,
    lower: Rows<T>,
    upper: Rows<T>,
}

impl<T: Real, const N: usize, const W: usize> Operator<T, N, W> {
    /// Numbers read beyond a block.
    const OVER: usize = W - N;

    /// Makes the matrix; `row` appends the entries of a node, given by its natural number, with their places.
    ///
    /// # Errors
    /// [`FemError::Multigrid`]: a diagonal block is not positive definite.
    pub fn new<R>(order: Order, row: R) -> Result<Self, FemError>
    where
        R: Fn(u32, &mut Entries<T, N, W>) + Sync,
    {
        let part = |entries: &mut Entries<T, N, W>, c: usize| Self::part(&order, c, entries, &row);
        let parts: Vec<Part<T, N, W>> =
            (0..order.chunks()).into_par_iter().map_init(Entries::new, part).collect::<Result<_, _>>()?;
        let mut this = Self { diagonal: Vec::new(), inverses: Vec::new(), lower: Vec::new(), upper: Vec::new(), order };
        for part in parts {
            this.diagonal.extend(part.diagonal);
            this.inverses.extend(part.inverses);
            this.lower.push(part.lower);
            this.upper.push(part.upper);
        }
        Ok(this)
    }

    /// The rows of a chunk, made in `entries`.
    fn part<R: Fn(u32, &mut Entries<T, N, W>)>(
        order: &Order,
        c: usize,
        entries: &mut Entries<T, N, W>,
        row: &R,
    ) -> Result<Part<T, N, W>, FemError> {
        let nodes = order.nodes(c);
        entries.clear();
        let mut below = Vec::with_capacity(nodes.len());
        let (mut lowers, mut uppers) = (0, 0);
        let mut rows = Vec::new();
        // The places of each row in ascending order, with the numbers of their entries: blocks are too large to be sorted.
        let mut sorted: Vec<(u32, u32)> = Vec::new();
        for i in nodes.clone() {
            let first = sorted.len();
            row(order.natural[i], entries);
            sorted.extend((first..).zip(&entries[first..]).map(|(e, (j, _))| (*j, e as u32)));
            let own = &mut sorted[first..];
            own.sort_unstable();
            let left = own.partition_point(|(j, _)| (*j as usize) < i);
            below.push(left);
            rows.push(first);
            lowers += left;
            uppers += own.len() - left - 1;
        }
        rows.push(sorted.len());
        let size = N * N;
        let mut part = Part {
            diagonal: Vec::with_capacity(nodes.len()),
            inverses: Vec::with_capacity(nodes.len()),
            lower: Rows::with_capacity(nodes.len(), lowers, size, Self::OVER),
            upper: Rows::with_capacity(nodes.len(), uppers, size, Self::OVER),
        };
        for (k, i) in nodes.clone().enumerate() {
            let (left, rest) = sorted[rows[k]..rows[k + 1]].split_at(below[k]);
            for &(j, e) in left {
                part.lower.push(j, &entries[e as usize].1, N);
            }
            part.lower.end_row();
            let own = &entries[rest[0].1 as usize].1;
            let inverse = inverse(own).ok_or_else(|| FemError::Multigrid {
                detail: format!("node {} of {} on a level", order.natural[i], order.len()),
            })?;
            part.diagonal.push(*own);
            part.inverses.push(inverse);
        }
        for k in (0..nodes.len()).rev() {
            for &(j, e) in &sorted[rows[k] + below[k] + 1..rows[k + 1]] {
                part.upper.push(j, &entries[e as usize].1, N);
            }
            part.upper.end_row();
        }
        (part.lower, part.upper) = (part.lower.finish(), part.upper.finish());
        Ok(part)
    }

    /// Nodes.
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Blocks stored.
    pub fn blocks(&self) -> usize {
        let count = |rows: &[Rows<T>]| rows.iter().map(|r| r.columns.len()).sum::<usize>();
        self.len() + count(&self.lower) + count(&self.upper)
    }

    /// Columns and blocks (by columns) of row `i` without its diagonal: those to the left, those to the right.
    #[inline(always)]
    pub fn row(&self, i: usize) -> [(&[u32], &[T]); 2] {
        let (c, k) = split(i, self.order.chunk);
        let last = self.order.nodes(c).len() - 1;
        let ((left, a, _), (right, b, _)) = (self.lower[c].row(k), self.upper[c].row(last - k));
        [(left, a), (right, b)]
    }

    /// `D^-1 x` of a node.
    #[inline(always)]
    pub fn relax(&self, i: usize, x: &[T; W]) -> [T; W] {
        columns_times(&self.inverses[i], x)
    }

    /// `z = (D + L)^-1 r`.
    pub fn solve_lower(&self, r: &[[T; W]], z: &mut [[T; W]]) {
        for colour in &self.order.colours {
            let base = colour.start * self.order.chunk;
            let (done, rest) = z.split_at_mut(base);
            let count = self.order.nodes(colour.end - 1).end - base;
            let own = rest[..count].par_chunks_mut(self.order.chunk);
            own.zip(colour.clone()).for_each(|(own, c)| self.solve_lower_chunk(c, r, done, own));
        }
    }

    fn solve_lower_chunk(&self, c: usize, r: &[[T; W]], done: &[[T; W]], own: &mut [[T; W]]) {
        let first = c * self.order.chunk;
        wide(
            #[inline(always)]
            || {
                for k in 0..own.len() {
                    let (columns, values, _) = self.lower[c].row(k);
                    let known = |j: usize| if j < first { &done[j] } else { &own[j - first] };
                    let sum = row_times::<T, N, W>(columns, values, known);
                    own[k] = self.relax(first + k, &minus(&r[first + k], &sum));
                }
            },
        );
    }

    /// `z = (D + U)^-1 r`.
    pub fn solve_upper(&self, r: &[[T; W]], z: &mut [[T; W]]) {
        for colour in self.order.colours.iter().rev() {
            let base = colour.start * self.order.chunk;
            let end = self.order.nodes(colour.end - 1).end;
            let (head, done) = z.split_at_mut(end);
            let own = head[base..].par_chunks_mut(self.order.chunk);
            own.zip(colour.clone()).for_each(|(own, c)| self.solve_upper_chunk(c, r, (end, done), own));
        }
    }

    fn solve_upper_chunk(&self, c: usize, r: &[[T; W]], (end, done): (usize, &[[T; W]]), own: &mut [[T; W]]) {
        let Range { start: first, end: own_end } = self.order.nodes(c);
        wide(
            #[inline(always)]
            || {
                for k in (0..own.len()).rev() {
                    let (columns, values, _) = self.upper[c].row(own.len() - 1 - k);
                    let known = |j: usize| if j < own_end { &own[j - first] } else { &done[j - end] };
                    let sum = row_times::<T, N, W>(columns, values, known);
                    own[k] = self.relax(first + k, &minus(&r[first + k], &sum));
                }
            },
        );
    }

    /// `out = r - L x`.
    pub fn without_lower(&self, r: &[[T; W]], x: &[[T; W]], out: &mut [[T; W]]) {
        out.par_chunks_mut(self.order.chunk).enumerate().for_each(|(c, out)| {
            let first = c * self.order.chunk;
            wide(
                #[inline(always)]
                || {
                    for (k, out) in out.iter_mut().enumerate() {
                        let (columns, values, _) = self.lower[c].row(k);
                        *out = minus(&r[first + k], &row_times::<T, N, W>(columns, values, |j| &x[j]));
                    }
                },
            );
        });
    }

    /// `out = -U x`.
    pub fn minus_upper(&self, x: &[[T; W]], out: &mut [[T; W]]) {
        out.par_chunks_mut(self.order.chunk).enumerate().for_each(|(c, out)| {
            wide(
                #[inline(always)]
                || {
                    for (k, out) in out.iter_mut().rev().enumerate() {
                        let (columns, values, _) = self.upper[c].row(k);
                        *out = minus(&[T::default(); W], &row_times::<T, N, W>(columns, values, |j| &x[j]));
                    }
                },
            );
        });
    }

    /// Calls `take` with each node, `A x` there, and the node's places in some vectors.
    #[inline(always)]
    pub fn times<const V: usize>(
        &self,
        x: &[[T; W]],
        vectors: [&mut [[T; W]]; V],
        take: impl Fn(usize, [T; W], [&mut [T; W]; V]) + Sync,
    ) {
        let mut rest = vectors.map(|v| v.chunks_mut(self.order.chunk));
        let chunks: Vec<[&mut [[T; W]]; V]> =
            (0..self.order.chunks()).map(|_| rest.each_mut().map(|v| v.next().unwrap_or_default())).collect();
        chunks.into_par_iter().enumerate().for_each(|(c, mut vectors)| {
            let (nodes, last) = (self.order.nodes(c), self.order.nodes(c).len() - 1);
            wide(
                #[inline(always)]
                || {
                    for (k, i) in nodes.enumerate() {
                        let ((left, below, _), (right, above, _)) = (self.lower[c].row(k), self.upper[c].row(last - k));
                        let mut sum = columns_times(&self.diagonal[i], &x[i]);
                        add(&mut sum, &row_times::<T, N, W>(left, below, |j| &x[j]));
                        add(&mut sum, &row_times::<T, N, W>(right, above, |j| &x[j]));
                        take(i, sum, vectors.each_mut().map(|v| &mut v[k]));
                    }
                },
            );
        });
    }
}

/// Sum of blocks times vectors.
#[inline(always)]
fn row_times<'a, T: Real + 'a, const N: usize, const W: usize>(
    columns: &[u32],
    values: &[T],
    x: impl Fn(usize) -> &'a [T; W],
) -> [T; W] {
    let mut sums = [[T::default(); W]; N];
    for (k, &j) in columns.iter().enumerate() {
        let block = &values[k * N * N..k * N * N + (N * N + W - N)];
        let x = x(j as usize);
        for c in 0..N {
            add_scaled(&mut sums[c], x[c], &lanes(block, c * N));
        }
    }
    total(&sums)
}

/// The inverse of a positive definite block by Cholesky's factorisation in double precision, padded with zeros.
pub(super) fn inverse<T: Real, const N: usize, const W: usize>(block: &Padded<T, N, W>) -> Option<Padded<T, N, W>> {
    let mut factor = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = block[j][i].get() - sum;
            if i == j {
                let sound = rest > f64::EPSILON * block[i][i].get();
                if !sound {
                    return None;
                }
                factor[i][i] = rest.sqrt();
            } else {
                factor[i][j] = rest / factor[j][j];
            }
        }
    }
    let mut inverse = [[T::default(); W]; N];
    for (c, column) in inverse.iter_mut().enumerate() {
        let mut x: [f64; N] = std::array::from_fn(|r| if r == c { 1.0 } else { 0.0 });
        for i in 0..N {
            x[i] = (x[i] - (0..i).map(|k| factor[i][k] * x[k]).sum::<f64>()) / factor[i][i];
        }
        for i in (0..N).rev() {
            x[i] = (x[i] - (i + 1..N).map(|k| factor[k][i] * x[k]).sum::<f64>()) / factor[i][i];
        }
        for r in 0..N {
            column[r] = T::new(x[r]);
        }
    }
    Some(inverse)
}
