//! The coarse matrix `P^T A P`.

use super::frame::Projector;
use super::operator::{Entries, Operator, Padded};
use super::order::{NONE, split};
use super::real::Real;
use super::rows::{Rows, add_scaled, lanes, wide};
use super::transfer::{Transfer, WIDE};
use rayon::prelude::*;

/// The upper triangle of a coarse matrix, the blocks of each row by their rows, columns ascending.
pub(super) struct Coarse<T> {
    rows: Vec<Vec<(u32, Padded<T, 6, WIDE>)>>,
    /// For each row the rows above that have a block in its column, with the place of that block.
    above: Vec<Vec<[u32; 2]>>,
}

/// Blocks of a row being summed up, found by column.
struct Sums<T, const N: usize> {
    place: Vec<u32>,
    columns: Vec<u32>,
    blocks: Vec<[[T; WIDE]; N]>,
}

impl<T: Real, const N: usize> Sums<T, N> {
    fn new(columns: usize) -> Self {
        Self { place: vec![NONE; columns], columns: Vec::new(), blocks: Vec::new() }
    }

    #[inline(always)]
    fn at(&mut self, column: u32) -> &mut [[T; WIDE]; N] {
        let place = &mut self.place[column as usize];
        if *place == NONE {
            *place = self.columns.len() as u32;
            self.columns.push(column);
            self.blocks.push([[T::default(); WIDE]; N]);
        }
        &mut self.blocks[*place as usize]
    }

    /// Empties the row.
    fn clear(&mut self) {
        self.columns.iter().for_each(|&j| self.place[j as usize] = NONE);
        self.columns.clear();
        self.blocks.clear();
    }
}

/// `A P`, chunk by chunk.
fn product<T: Real, const N: usize, const W: usize>(a: &Operator<T, N, W>, p: &Transfer<T, N>) -> Vec<Rows<T>> {
    let chunk = |sums: &mut Sums<T, N>, c: usize| {
        // Nodes reach about twice as many aggregates through the matrix as by themselves.
        let count = a.order.nodes(c).len();
        let mut product = Rows::with_capacity(count, 8 * count, 6 * N, WIDE - 6);
        for i in a.order.nodes(c) {
            wide(
                #[inline(always)]
                || {
                    let own = &a.diagonal[i];
                    add_row(sums, |r, c| own[c][r], p.row(i));
                    for (columns, values) in a.row(i) {
                        for (block, &j) in values.chunks_exact(N * N).zip(columns) {
                            add_row(sums, |r, c| block[c * N + r], p.row(j as usize));
                        }
                    }
                },
            );
            for (column, block) in sums.columns.iter().zip(&sums.blocks) {
                product.push(*column, block, 6);
            }
            product.end_row();
            sums.clear();
        }
        product.finish()
    };
    (0..a.order.chunks()).into_par_iter().map_init(|| Sums::new(p.coarse()), chunk).collect()
}

/// Adds a block times a row of `P`.
#[inline(always)]
fn add_row<T: Real, const N: usize>(
    sums: &mut Sums<T, N>,
    block: impl Fn(usize, usize) -> T,
    (columns, values): (&[u32], &[T]),
) {
    for (b, &j) in columns.iter().enumerate() {
        let part = &values[b * 6 * N..b * 6 * N + (6 * N + WIDE - 6)];
        let rows: [[T; WIDE]; N] = std::array::from_fn(|c| lanes(part, 6 * c));
        for (r, sum) in sums.at(j).iter_mut().enumerate() {
            for (c, row) in rows.iter().enumerate() {
                add_scaled(sum, block(r, c), row);
            }
        }
    }
}

impl<T: Real> Coarse<T> {
    /// `P^T A P`; combinations of unknowns that are not free get the stiffness of the free ones.
    pub fn new<const N: usize, const W: usize>(
        a: &Operator<T, N, W>,
        p: &Transfer<T, N>,
        free: &[Projector<6>],
    ) -> Self {
        let product = product(a, p);
        let chunk = a.order.chunk;
        let row = |sums: &mut Sums<T, 6>, j: usize| {
            wide(
                #[inline(always)]
                || {
                    for (i, block) in p.uses(j) {
                        let rows: [[T; WIDE]; N] = std::array::from_fn(|r| lanes(block, 6 * r));
                        let (c, k) = split(i, chunk);
                        let (columns, values, _) = product[c].row(k);
                        for (&column, block) in columns.iter().zip(values.windows(6 * N + WIDE - 6).step_by(6 * N)) {
                            if column as usize >= j {
                                let block: [[T; WIDE]; N] = std::array::from_fn(|r| lanes(block, 6 * r));
                                add_transposed(sums.at(column), &rows, &block);
                            }
                        }
                    }
                },
            );
            let mut columns = sums.columns.clone();
            columns.sort_unstable();
            let block = |column: u32| clean(&sums.blocks[sums.place[column as usize] as usize]);
            let mut row: Vec<_> = columns.into_iter().map(|column| (column, block(column))).collect();
            sums.clear();
            if let (Some(free), Some((_, own))) = (&free[j], row.first_mut()) {
                hold(own, free);
            }
            row
        };
        let count = p.coarse();
        let rows: Vec<Vec<_>> =
            (0..count).into_par_iter().with_min_len(16).map_init(|| Sums::new(count), row).collect();
        let mut above = vec![Vec::new(); count];
        for (i, row) in (0..).zip(&rows) {
            for (k, (j, _)) in (0..).zip(row).skip(1) {
                above[*j as usize].push([i, k]);
            }
        }
        Self { rows, above }
    }

    /// Calls back with the neighbours of a node.
    pub fn neighbours(&self, i: u32, call: &mut dyn FnMut(u32)) {
        self.above[i as usize].iter().for_each(|[j, _]| call(*j));
        self.rows[i as usize].iter().skip(1).for_each(|(j, _)| call(*j));
    }

    /// Appends the entries of a row.
    pub fn row(&self, place: &[u32], i: u32, entries: &mut Entries<T, 6, WIDE>) {
        for &[j, k] in &self.above[i as usize] {
            entries.push((place[j as usize], self.rows[j as usize][k as usize].1));
        }
        for (j, block) in &self.rows[i as usize] {
            entries.push((place[*j as usize], transposed(block)));
        }
    }
}

/// `sum += P^T B`.
#[inline(always)]
fn add_transposed<T: Real, const N: usize>(sum: &mut [[T; WIDE]; 6], p: &[[T; WIDE]; N], block: &[[T; WIDE]; N]) {
    for (k, sum) in sum.iter_mut().enumerate() {
        for r in 0..N {
            add_scaled(sum, p[r][k], &block[r]);
        }
    }
}

/// The block without what is in its padding, and without what is negligible.
fn clean<T: Real>(block: &[[T; WIDE]; 6]) -> [[T; WIDE]; 6] {
    block.map(|row| std::array::from_fn(|c| if c < 6 { row[c].cleaned() } else { T::default() }))
}

fn transposed<T: Real>(block: &[[T; WIDE]; 6]) -> [[T; WIDE]; 6] {
    std::array::from_fn(|c| std::array::from_fn(|r| if r < 6 { block[r][c] } else { T::default() }))
}

/// Gives the combinations that are not free the mean stiffness of the others.
fn hold<T: Real>(block: &mut [[T; WIDE]; 6], free: &[[f64; 6]; 6]) {
    let trace: f64 = (0..6).map(|k| block[k][k].get()).sum();
    let count: f64 = (0..6).map(|k| free[k][k]).sum();
    let mean = if count > 0.5 && trace > 0.0 { trace / count } else { 1.0 };
    for r in 0..6 {
        for c in 0..6 {
            let rest = if r == c { 1.0 - free[r][c] } else { -free[r][c] };
            block[r][c] += T::new(mean * rest);
        }
    }
}
