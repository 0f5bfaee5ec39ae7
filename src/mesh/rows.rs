//! Entries sorted into rows (compressed rows), on several threads.

use rayon::prelude::*;

/// Entries of rows, one row after the other.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// Where each row begins, and where the last one ends.
    pub starts: Vec<u32>,
    pub entries: Vec<u32>,
}

/// Most threads that a sort is worth: each looks at all entries.
const MOST: usize = 8;

impl Rows {
    /// Sorts entries into `count` rows: `of` gives row and entry of all that item `i` of `items` brings. In each row they
    /// stay in the order of the items, whatever the number of threads: each thread has rows of its own.
    pub fn new<I>(count: usize, items: usize, of: impl Fn(usize) -> I + Sync) -> Self
    where
        I: IntoIterator<Item = (u32, u32)>,
    {
        let piece = count.div_ceil(rayon::current_num_threads().min(MOST)).max(1);
        let mut starts = vec![0_u32; count + 1];
        starts[1..].par_chunks_mut(piece).enumerate().for_each(|(k, lengths)| {
            let first = k * piece;
            for (row, _) in (0..items).flat_map(&of) {
                if let Some(length) = lengths.get_mut((row as usize).wrapping_sub(first)) {
                    *length += 1;
                }
            }
        });
        for row in 0..count {
            starts[row + 1] += starts[row];
        }
        let mut entries = vec![0_u32; starts[count] as usize];
        let mut pieces = Vec::new();
        let mut rest = entries.as_mut_slice();
        for first in (0..count).step_by(piece) {
            let rows = &starts[first..=count.min(first + piece)];
            let (own, tail) = rest.split_at_mut((rows[rows.len() - 1] - rows[0]) as usize);
            pieces.push((first, rows, own));
            rest = tail;
        }
        pieces.into_par_iter().for_each(|(first, rows, own)| {
            let mut next: Vec<u32> = rows[..rows.len() - 1].iter().map(|start| start - rows[0]).collect();
            for (row, entry) in (0..items).flat_map(&of) {
                if let Some(place) = next.get_mut((row as usize).wrapping_sub(first)) {
                    own[*place as usize] = entry;
                    *place += 1;
                }
            }
        });
        Self { starts, entries }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The entries of a row.
    pub fn row(&self, row: usize) -> &[u32] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rows_are_those_of_a_stable_sort_on_any_number_of_threads(
            pairs in prop::collection::vec((0_u32..40, 0_u32..1000), 0..300), threads in 1_usize..9
        ) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let rows = pool.install(|| Rows::new(40, pairs.len(), |i| [pairs[i]]));
            let mut sorted = pairs.clone();
            sorted.sort_by_key(|p| p.0);
            prop_assert_eq!(&rows.entries, &sorted.iter().map(|p| p.1).collect::<Vec<_>>());
            for r in 0..rows.len() {
                prop_assert_eq!(rows.row(r).len(), pairs.iter().filter(|p| p.0 as usize == r).count());
            }
        }
    }
}
