//! Motions of aggregates as displacements of a level's nodes, smoothed.

use super::aggregate::Aggregates;
use super::frame::Rigid;
use super::operator::{Operator, Padded};
use super::order::{NONE, split};
use super::real::Real;
use super::rows::{Rows, add_scaled, lanes, total, wide};
use rayon::prelude::*;

/// Lanes of a coarse vector's node: six unknowns, padded with zeros.
pub(super) const WIDE: usize = 8;

/// A matrix from coarse to fine vectors, kept as rows of `N` x 6 blocks, each by its rows.
pub(super) struct Transfer<T, const N: usize> {
    chunk: usize,
    pub rows: Vec<Rows<T>>,
    /// The blocks of each coarse node once more, with their fine nodes, ascending: to look them up takes longer than to read
    /// them.
    uses: Vec<Rows<T>>,
    coarse: usize,
}

/// Coarse nodes a chunk.
const CHUNK: usize = 64;

impl<T: Real, const N: usize> Transfer<T, N> {
    /// `(I - omega D^-1 A) T` for the motions `T` of the nodes with their aggregates (Vanek, Mandel and Brezina 1996). It
    /// spends less energy on a motion of one aggregate than `T`, and as little on a motion common to all.
    pub fn smoothed<const W: usize>(
        a: &Operator<T, N, W>,
        aggregates: &Aggregates,
        motions: &[Rigid<N>],
        omega: f64,
    ) -> Self {
        let padded = |rigid: &Rigid<N>| {
            rigid.map(|row| std::array::from_fn(|c| row.get(c).map_or(T::default(), |x| T::new(*x))))
        };
        let motions: Vec<[[T; WIDE]; N]> = motions.par_iter().map(padded).collect();
        let omega = T::new(omega);
        let chunk = |c: usize| {
            let nodes = a.order.nodes(c);
            let mut rows = Rows::with_capacity(nodes.len(), 4 * nodes.len(), 6 * N, WIDE - 6);
            let mut near = Near::default();
            for i in nodes {
                wide(
                    #[inline(always)]
                    || {
                        near.gather(a, aggregates, &motions, i);
                        for &(of, k) in &near.order {
                            let kept = if of == aggregates.of[i] { motions[i] } else { [[T::default(); WIDE]; N] };
                            rows.push(of, &smooth(&a.inverses[i], omega, &kept, &near.sums[k as usize]), 6);
                        }
                    },
                );
                rows.end_row();
            }
            rows.finish()
        };
        let rows: Vec<Rows<T>> = (0..a.order.chunks()).into_par_iter().map(chunk).collect();
        let mut this = Self { chunk: a.order.chunk, rows, uses: Vec::new(), coarse: aggregates.count };
        this.find_uses();
        this
    }

    /// Lists the uses of each coarse node.
    fn find_uses(&mut self) {
        let mut starts = vec![0_u32; self.coarse + 1];
        self.rows.iter().flat_map(|r| &r.columns).for_each(|&j| starts[j as usize + 1] += 1);
        for j in 0..self.coarse {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut uses = vec![[0_u32; 2]; starts[self.coarse] as usize];
        for (c, rows) in self.rows.iter().enumerate() {
            for k in 0..rows.rows() {
                let (columns, _, first) = rows.row(k);
                for (b, &j) in columns.iter().enumerate() {
                    uses[next[j as usize] as usize] = [(c * self.chunk + k) as u32, (first + b) as u32];
                    next[j as usize] += 1;
                }
            }
        }
        let copy = |c: usize| {
            let (first, last) = (c * CHUNK, self.coarse.min((c + 1) * CHUNK));
            let count = (starts[last] - starts[first]) as usize;
            let mut copies = Rows::with_capacity(last - first, count, 6 * N, WIDE - 6);
            for j in first..last {
                for &[i, b] in &uses[starts[j] as usize..starts[j + 1] as usize] {
                    copies.copy(i, self.rows[split(i as usize, self.chunk).0].block(b as usize));
                }
                copies.end_row();
            }
            copies.finish()
        };
        self.uses = (0..self.coarse.div_ceil(CHUNK)).into_par_iter().map(copy).collect();
    }

    /// Renumbers the coarse nodes: `place` is the new number of each, `natural` the old one.
    pub fn renumber(&mut self, place: &[u32], natural: &[u32]) {
        let renumber = |rows: &mut Rows<T>| rows.columns.iter_mut().for_each(|j| *j = place[*j as usize]);
        self.rows.par_iter_mut().for_each(renumber);
        let old = |j: &u32| self.uses[*j as usize / CHUNK].row(*j as usize % CHUNK);
        let copy = |natural: &[u32]| {
            let count = natural.iter().map(|j| old(j).0.len()).sum();
            let mut copies = Rows::with_capacity(natural.len(), count, 6 * N, WIDE - 6);
            for (nodes, values, _) in natural.iter().map(old) {
                copies.copy_row(nodes, values);
            }
            copies.finish()
        };
        self.uses = natural.par_chunks(CHUNK).map(copy).collect();
    }

    /// Coarse nodes.
    pub fn coarse(&self) -> usize {
        self.coarse
    }

    /// Columns and blocks of a fine node's row.
    #[inline(always)]
    pub fn row(&self, i: usize) -> (&[u32], &[T]) {
        let (c, k) = split(i, self.chunk);
        let (columns, values, _) = self.rows[c].row(k);
        (columns, values)
    }

    /// Fine nodes that use coarse node `j`, with their blocks by rows.
    #[inline(always)]
    pub fn uses(&self, j: usize) -> impl Iterator<Item = (usize, &[T])> {
        let (nodes, values, _) = self.uses[j / CHUNK].row(j % CHUNK);
        nodes.iter().zip(values.windows(6 * N + WIDE - 6).step_by(6 * N)).map(|(&i, block)| (i as usize, block))
    }

    /// `coarse = P^T fine`.
    pub fn restrict<const W: usize>(&self, fine: &[[T; W]], coarse: &mut [[T; WIDE]]) {
        coarse.par_chunks_mut(CHUNK).zip(&self.uses).for_each(|(coarse, uses)| {
            wide(
                #[inline(always)]
                || {
                    for (k, coarse) in coarse.iter_mut().enumerate() {
                        let (nodes, values, _) = uses.row(k);
                        let mut sums = [[T::default(); WIDE]; N];
                        for (b, &i) in nodes.iter().enumerate() {
                            let block = &values[b * 6 * N..b * 6 * N + (6 * N + WIDE - 6)];
                            for (r, sum) in sums.iter_mut().enumerate() {
                                add_scaled(sum, fine[i as usize][r], &lanes(block, 6 * r));
                            }
                        }
                        *coarse = total(&sums);
                    }
                },
            );
        });
    }

    /// `fine += P coarse`.
    pub fn prolong<const W: usize>(&self, coarse: &[[T; WIDE]], fine: &mut [[T; W]]) {
        fine.par_chunks_mut(self.chunk).zip(&self.rows).for_each(|(fine, rows)| {
            wide(
                #[inline(always)]
                || {
                    for (k, fine) in fine.iter_mut().enumerate() {
                        let (columns, values, _) = rows.row(k);
                        for (x, sum) in fine.iter_mut().zip(row_times::<T, N>(columns, values, coarse)) {
                            *x += sum;
                        }
                    }
                },
            );
        });
    }
}

/// A row of blocks, each by its rows, times a vector.
#[inline(always)]
fn row_times<T: Real, const N: usize>(columns: &[u32], values: &[T], x: &[[T; WIDE]]) -> [T; N] {
    let mut sums = [[T::default(); WIDE]; N];
    for (b, &j) in columns.iter().enumerate() {
        let block = &values[b * 6 * N..b * 6 * N + (6 * N + WIDE - 6)];
        let x = &x[j as usize];
        for (r, sum) in sums.iter_mut().enumerate() {
            let row: [T; WIDE] = lanes(block, 6 * r);
            for l in 0..WIDE {
                sum[l] += row[l] * x[l];
            }
        }
    }
    sums.map(|s| ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])))
}

/// What a row of the matrix does to the motions of the aggregates that it reaches.
struct Near<T, const N: usize> {
    of: Vec<u32>,
    sums: Vec<[[T; WIDE]; N]>,
    /// The aggregates ascending, with their places.
    order: Vec<(u32, u32)>,
}

impl<T, const N: usize> Default for Near<T, N> {
    fn default() -> Self {
        Self { of: Vec::new(), sums: Vec::new(), order: Vec::new() }
    }
}

impl<T: Real, const N: usize> Near<T, N> {
    /// Row `i` of the matrix times the motions, one sum for each aggregate; the node's own first.
    #[inline(always)]
    fn gather<const W: usize>(
        &mut self,
        a: &Operator<T, N, W>,
        aggregates: &Aggregates,
        motions: &[[[T; WIDE]; N]],
        i: usize,
    ) {
        self.of.clear();
        self.sums.clear();
        let own = &a.diagonal[i];
        self.add(aggregates.of[i], |r, c| own[c][r], &motions[i]);
        for (columns, values) in a.row(i) {
            for (block, &j) in values.chunks_exact(N * N).zip(columns) {
                let j = j as usize;
                self.add(aggregates.of[j], |r, c| block[c * N + r], &motions[j]);
            }
        }
        self.order.clear();
        self.order.extend(self.of.iter().copied().zip(0..));
        self.order.sort_unstable();
    }

    /// Adds a block of the matrix times the motions of a node to its aggregate's sum.
    #[inline(always)]
    fn add(&mut self, of: u32, block: impl Fn(usize, usize) -> T, motions: &[[T; WIDE]; N]) {
        if of == NONE {
            return;
        }
        let k = self.of.iter().position(|own| *own == of).unwrap_or_else(|| {
            self.of.push(of);
            self.sums.push([[T::default(); WIDE]; N]);
            self.of.len() - 1
        });
        for (r, sum) in self.sums[k].iter_mut().enumerate() {
            for (c, motion) in motions.iter().enumerate() {
                add_scaled(sum, block(r, c), motion);
            }
        }
    }
}

/// `kept - omega D^-1 sum`, by rows; what is negligible is left out.
#[inline(always)]
fn smooth<T: Real, const N: usize, const W: usize>(
    inverse: &Padded<T, N, W>,
    omega: T,
    kept: &[[T; WIDE]; N],
    sum: &[[T; WIDE]; N],
) -> [[T; WIDE]; N] {
    std::array::from_fn(|r| {
        let mut step = [T::default(); WIDE];
        for (c, sum) in sum.iter().enumerate() {
            add_scaled(&mut step, inverse[c][r], sum);
        }
        std::array::from_fn(|l| (kept[r][l] - omega * step[l]).cleaned())
    })
}
