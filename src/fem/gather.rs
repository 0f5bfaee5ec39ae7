//! Matrices gathered row by row from the cells of each node: no atomics, and the bytes do not depend on the number of
//! threads.

use super::block_matrix::{BlockMatrix, CHUNK};
use crate::mesh::topology::NodeCells;
use glam::DMat3;
use rayon::prelude::*;
use std::ops::Range;

/// The matrix between nodes that share a cell. `nodes` gives the nodes of a cell; `fill` adds to the blocks of a node's row,
/// given the node and the place of each of its neighbours' blocks in the row.
pub(super) fn gather<I: Iterator<Item = u32>>(
    cells: &NodeCells,
    count: usize,
    nodes: impl Fn(u32) -> I + Sync,
    fill: impl Fn(u32, &[u32], &mut [DMat3]) + Sync,
) -> BlockMatrix {
    let (starts, columns) = pattern(cells, count, nodes);
    // Memory is touched by all threads at once.
    let mut blocks: Vec<DMat3> = rayon::iter::repeat_n(DMat3::ZERO, columns.len()).collect();
    let mut chunks = Vec::with_capacity(count.div_ceil(CHUNK));
    let mut rest = blocks.as_mut_slice();
    for first in (0..count).step_by(CHUNK) {
        let last = count.min(first + CHUNK);
        let (chunk, tail) = rest.split_at_mut(starts[last] - starts[first]);
        chunks.push((first..last, chunk));
        rest = tail;
    }
    let rows = |places: &mut Vec<u32>, (range, mut chunk): (Range<usize>, &mut [DMat3])| {
        for i in range {
            let row = &columns[starts[i]..starts[i + 1]];
            let (blocks, tail) = chunk.split_at_mut(row.len());
            (0..).zip(row).for_each(|(place, &v)| places[v as usize] = place);
            fill(i as u32, places, blocks);
            chunk = tail;
        }
    };
    chunks.into_par_iter().for_each_init(|| vec![0; count], rows);
    BlockMatrix { starts, columns, blocks }
}

/// Nodes that share a cell with each node (itself included), ascending, as compressed rows.
fn pattern<I: Iterator<Item = u32>>(
    cells: &NodeCells,
    count: usize,
    nodes: impl Fn(u32) -> I + Sync,
) -> (Vec<usize>, Vec<u32>) {
    const NEVER: u32 = u32::MAX;
    let chunk = |seen: &mut Vec<u32>, chunk: usize| {
        let (mut lengths, mut columns) = (Vec::with_capacity(CHUNK), Vec::new());
        for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
            let first = columns.len();
            for v in cells.at(i as u32).iter().flat_map(|&t| nodes(t)) {
                if seen[v as usize] != i as u32 {
                    seen[v as usize] = i as u32;
                    columns.push(v);
                }
            }
            columns[first..].sort_unstable();
            lengths.push(columns.len() - first);
        }
        (lengths, columns)
    };
    let chunks: Vec<(Vec<usize>, Vec<u32>)> =
        (0..count.div_ceil(CHUNK)).into_par_iter().map_init(|| vec![NEVER; count], chunk).collect();
    let mut starts = Vec::with_capacity(count + 1);
    starts.push(0);
    let mut columns = Vec::with_capacity(chunks.iter().map(|(_, c)| c.len()).sum());
    for (lengths, chunk) in chunks {
        for length in lengths {
            starts.push(starts[starts.len() - 1] + length);
        }
        columns.extend_from_slice(&chunk);
    }
    (starts, columns)
}
