//! Compressed rows of small blocks, and the kernels on them.

use super::real::Real;
use pulp::Arch;

/// Rows of blocks of `size` numbers each. Kernels read whole vectors of lanes at the rows or columns of a block, and so up
/// to `over` numbers beyond it: some follow the last one.
pub(super) struct Rows<T> {
    starts: Vec<u32>,
    pub columns: Vec<u32>,
    values: Vec<T>,
    size: usize,
    over: usize,
}

impl<T: Real> Rows<T> {
    /// No rows yet, room for some.
    pub fn with_capacity(rows: usize, blocks: usize, size: usize, over: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        let values = Vec::with_capacity(blocks * size + over);
        Self { starts, columns: Vec::with_capacity(blocks), values, size, over }
    }

    /// Appends a block to the last row, given its parts.
    #[inline(always)]
    pub fn push<const L: usize>(&mut self, column: u32, parts: &[[T; L]], take: usize) {
        self.columns.push(column);
        for part in parts {
            self.values.extend_from_slice(&part[..take]);
        }
    }

    /// Appends a copy of a block.
    pub fn copy(&mut self, column: u32, block: &[T]) {
        self.columns.push(column);
        self.values.extend_from_slice(&block[..self.size]);
    }

    /// Appends a row.
    pub fn copy_row(&mut self, columns: &[u32], values: &[T]) {
        self.columns.extend_from_slice(columns);
        self.values.extend_from_slice(&values[..columns.len() * self.size]);
        self.end_row();
    }

    /// Ends the last row.
    pub fn end_row(&mut self) {
        self.starts.push(self.columns.len() as u32);
    }

    /// Ends the last row of all.
    pub fn finish(mut self) -> Self {
        self.values.extend(std::iter::repeat_n(T::default(), self.over));
        self
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and blocks of row `k`, and the first of its blocks.
    #[inline(always)]
    pub fn row(&self, k: usize) -> (&[u32], &[T], usize) {
        let (first, last) = (self.starts[k] as usize, self.starts[k + 1] as usize);
        (&self.columns[first..last], &self.values[first * self.size..last * self.size + self.over], first)
    }

    /// Block `b`.
    #[inline(always)]
    pub fn block(&self, b: usize) -> &[T] {
        &self.values[b * self.size..(b + 1) * self.size + self.over]
    }
}

/// Runs a kernel compiled for the widest vectors that the processor has. What it calls must be inlined.
#[inline(always)]
pub(super) fn wide<R>(kernel: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(kernel)
}

/// `W` lanes from a slice.
#[inline(always)]
pub(super) fn lanes<T: Real, const W: usize>(values: &[T], first: usize) -> [T; W] {
    let mut lanes = [T::default(); W];
    lanes.copy_from_slice(&values[first..first + W]);
    lanes
}

/// `sum += a x`.
#[inline(always)]
pub(super) fn add_scaled<T: Real, const W: usize>(sum: &mut [T; W], a: T, x: &[T; W]) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += a * *x;
    }
}

/// `a - b`.
#[inline(always)]
pub(super) fn minus<T: Real, const W: usize>(a: &[T; W], b: &[T; W]) -> [T; W] {
    std::array::from_fn(|l| a[l] - b[l])
}

/// Sum of the vectors.
#[inline(always)]
pub(super) fn total<T: Real, const N: usize, const W: usize>(parts: &[[T; W]; N]) -> [T; W] {
    let mut sum = parts[0];
    for part in &parts[1..] {
        add(&mut sum, part);
    }
    sum
}

/// `sum += x`.
#[inline(always)]
pub(super) fn add<T: Real, const W: usize>(sum: &mut [T; W], x: &[T; W]) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += *x;
    }
}

/// Product of a matrix, given by its columns, and the first `N` entries of `x`.
#[inline(always)]
pub(super) fn columns_times<T: Real, const N: usize, const W: usize>(columns: &[[T; W]; N], x: &[T; W]) -> [T; W] {
    let mut sum = [T::default(); W];
    for c in 0..N {
        add_scaled(&mut sum, x[c], &columns[c]);
    }
    sum
}
