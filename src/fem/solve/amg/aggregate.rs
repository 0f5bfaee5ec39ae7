//! Gathering the nodes of a level into aggregates, each a node of the next level.

use super::operator::{Operator, Padded};
use super::order::{NONE, split};
use super::real::Real;
use rayon::prelude::*;
use smallvec::SmallVec;

/// Nodes below which an aggregate is given up: the smoothed motions of tiny ones have large energies.
const SMALLEST: usize = 6;

/// Aggregates of nodes.
pub(super) struct Aggregates {
    /// The aggregate of each node; [`NONE`] for a node without neighbours, which smoothing solves for.
    pub of: Vec<u32>,
    /// Number of aggregates.
    pub count: usize,
}

/// Neighbours of each node that it is strongly coupled with.
struct Strong {
    chunk: usize,
    /// Of the rows of each chunk: starts, columns.
    rows: Vec<(Vec<u32>, Vec<u32>)>,
}

impl Strong {
    /// Nodes i and j are strongly coupled if `|A_ij|^2 > theta^2 |A_ii| |A_jj|`, in the norm of Frobenius.
    fn new<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>, theta: f64) -> Self {
        let own = |d: &Padded<T, N, W>| theta as f32 * d.iter().map(|c| squares::<T, N>(&c[..N])).sum::<f32>().sqrt();
        let own: Vec<f32> = a.diagonal.par_iter().with_min_len(1024).map(own).collect();
        let rows = |c: usize| {
            let (mut starts, mut columns) = (vec![0], Vec::new());
            for i in a.order.nodes(c) {
                for (near, values) in a.row(i) {
                    for (k, &j) in near.iter().enumerate() {
                        if squares::<T, N>(&values[k * N * N..(k + 1) * N * N]) > own[i] * own[j as usize] {
                            columns.push(j);
                        }
                    }
                }
                starts.push(columns.len() as u32);
            }
            (starts, columns)
        };
        Self { chunk: a.order.chunk, rows: (0..a.order.chunks()).into_par_iter().map(rows).collect() }
    }

    fn row(&self, i: usize) -> &[u32] {
        let (c, k) = split(i, self.chunk);
        let (starts, columns) = &self.rows[c];
        &columns[starts[k] as usize..starts[k + 1] as usize]
    }
}

/// The sum of squares of a block or a part of it.
#[inline(always)]
fn squares<T: Real, const N: usize>(values: &[T]) -> f32 {
    // One sum a column: they do not wait for each other.
    let mut sums = [0.0; N];
    for column in values.chunks_exact(N) {
        for (sum, v) in sums.iter_mut().zip(column) {
            let v = v.get() as f32;
            *sum += v * v;
        }
    }
    sums.iter().sum()
}

impl Aggregates {
    /// Greedy aggregation (Vanek, Mandel and Brezina 1996): a node whose strong neighbours are all unclaimed claims them;
    /// leftovers join the neighbouring aggregate that they have most links to.
    pub fn new<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>, theta: f64) -> Self {
        let strong = Strong::new(a, theta);
        let mut of = vec![NONE; a.len()];
        let mut count = 0;
        for &i in &a.order.curve {
            let near = strong.row(i as usize);
            if of[i as usize] == NONE && !near.is_empty() && near.iter().all(|&j| of[j as usize] == NONE) {
                claim(&mut of, count, i, &strong);
                count += 1;
            }
        }
        join(&mut of, a, &strong, |_| true);
        let mut found = Self { of, count: count as usize };
        found.claim_leftovers(a);
        found.dissolve_small(a, &strong);
        found.close_gaps(&a.order.curve);
        found
    }

    /// Nodes that no aggregate is linked to, in the order of the curve, make aggregates with their unclaimed neighbours.
    fn claim_leftovers<T: Real, const N: usize, const W: usize>(&mut self, a: &Operator<T, N, W>) {
        for &i in &a.order.curve {
            let i = i as usize;
            let [(left, _), (right, _)] = a.row(i);
            if self.of[i] == NONE && !(left.is_empty() && right.is_empty()) {
                self.of[i] = self.count as u32;
                for &j in left.iter().chain(right) {
                    let of = &mut self.of[j as usize];
                    *of = if *of == NONE { self.count as u32 } else { *of };
                }
                self.count += 1;
            }
        }
    }

    /// Gives the nodes of small aggregates to larger neighbours, where there are any.
    fn dissolve_small<T: Real, const N: usize, const W: usize>(&mut self, a: &Operator<T, N, W>, strong: &Strong) {
        let mut sizes = vec![0; self.count];
        self.of.iter().filter(|of| **of != NONE).for_each(|of| sizes[*of as usize] += 1);
        let small = |of: u32| of != NONE && sizes[of as usize] < SMALLEST;
        let old = self.of.clone();
        self.of.iter_mut().filter(|of| small(**of)).for_each(|of| *of = NONE);
        join(&mut self.of, a, strong, |i| old[i] != NONE);
        for (of, old) in self.of.iter_mut().zip(old) {
            *of = if *of == NONE { old } else { *of };
        }
    }

    /// Numbers the aggregates anew, in the order of their first nodes on the curve.
    fn close_gaps(&mut self, curve: &[u32]) {
        let mut number = vec![NONE; self.count];
        self.count = 0;
        for &i in curve {
            let of = self.of[i as usize];
            if of != NONE && number[of as usize] == NONE {
                number[of as usize] = self.count as u32;
                self.count += 1;
            }
        }
        self.of.iter_mut().filter(|of| **of != NONE).for_each(|of| *of = number[*of as usize]);
    }
}

/// Makes an aggregate of a node and its strong neighbours, and of theirs where these are few, as on flat cells.
fn claim(of: &mut [u32], aggregate: u32, node: u32, strong: &Strong) {
    let mut members = vec![node];
    of[node as usize] = aggregate;
    let mut next = 0;
    while next < members.len() && (next == 0 || members.len() < SMALLEST) {
        for &j in strong.row(members[next] as usize) {
            if of[j as usize] == NONE {
                of[j as usize] = aggregate;
                members.push(j);
            }
        }
        next += 1;
    }
}

/// Lets unclaimed nodes join the neighbouring aggregate that they have most links to: first strong ones, then any, then
/// again from the nodes that joined, as long as there are such.
fn join<T: Real, const N: usize, const W: usize>(
    of: &mut [u32],
    a: &Operator<T, N, W>,
    strong: &Strong,
    wanted: impl Fn(usize) -> bool,
) {
    let mut left: Vec<u32> =
        a.order.curve.iter().copied().filter(|&i| of[i as usize] == NONE && wanted(i as usize)).collect();
    while !left.is_empty() {
        let best = |i: &u32| {
            let [(before, _), (after, _)] = a.row(*i as usize);
            let any = || before.iter().chain(after);
            most_links(of, strong.row(*i as usize).iter()).or_else(|| most_links(of, any()))
        };
        let chosen: Vec<Option<u32>> = left.par_iter().with_min_len(256).map(best).collect();
        let before = left.len();
        for (i, chosen) in left.iter().zip(&chosen) {
            of[*i as usize] = chosen.unwrap_or(NONE);
        }
        left.retain(|&i| of[i as usize] == NONE);
        if left.len() == before {
            break;
        }
    }
}

/// The aggregate that most of the nodes belong to, the smallest of equals.
fn most_links<'a>(of: &[u32], nodes: impl Iterator<Item = &'a u32>) -> Option<u32> {
    let mut near: SmallVec<[u32; 64]> = nodes.map(|&j| of[j as usize]).filter(|&of| of != NONE).collect();
    near.sort_unstable();
    near.chunk_by(|a, b| a == b).rev().max_by_key(|same| same.len()).map(|same| same[0])
}
