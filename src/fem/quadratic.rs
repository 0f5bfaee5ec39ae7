//! The stiffness of ten-node cells.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::{Model, Space, tet4, tet10};
use crate::mesh::topology::NodeCells;
use glam::DMat3;
use rayon::prelude::*;

/// The stiffness between all nodes. Each row is gathered by one task from the cells of its node in ascending order, so
/// that its bytes do not depend on the number of threads.
pub(super) fn stiffness(space: &Space<'_>, model: &Model) -> BlockMatrix {
    let mesh = space.mesh();
    let nodes = space.points().len();
    let cells = NodeCells::of(nodes, mesh.tets().len(), |t| space.cell(t));
    let lame: Vec<[f64; 2]> = model.materials.iter().map(|m| [m.lambda(), m.mu()]).collect();
    let chunks: Vec<Rows> = (0..nodes.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut rows = Rows::default();
            for i in chunk * CHUNK..nodes.min((chunk + 1) * CHUNK) {
                let around = cells.at(i as u32);
                let first = rows.begin(around.iter().flat_map(|&t| space.cell(t as usize)));
                for t in around.iter().map(|&t| t as usize) {
                    let own = space.cell(t).position(|v| v as usize == i).unwrap_or_default();
                    let row = element_row(space, t, own, lame[mesh.regions()[t].0 as usize]);
                    for (v, block) in space.cell(t).zip(row) {
                        let slot = rows.columns[first..].partition_point(|&c| c < v);
                        rows.blocks[first + slot] += block;
                    }
                }
            }
            rows
        })
        .collect();
    let mut matrix = BlockMatrix { starts: vec![0], columns: Vec::new(), blocks: Vec::new() };
    matrix.columns.reserve_exact(chunks.iter().map(|c| c.columns.len()).sum());
    matrix.blocks.reserve_exact(matrix.columns.capacity());
    for chunk in chunks {
        let before = matrix.columns.len();
        matrix.starts.extend(chunk.ends.iter().map(|end| before + end));
        matrix.columns.extend(chunk.columns);
        matrix.blocks.extend(chunk.blocks);
    }
    matrix
}

/// Some rows of the matrix.
#[derive(Default)]
struct Rows {
    ends: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<DMat3>,
}

impl Rows {
    /// Begins a row with these columns, each perhaps several times; gives the place of its first entry.
    fn begin(&mut self, columns: impl Iterator<Item = u32>) -> usize {
        let first = self.columns.len();
        let mut row: Vec<u32> = columns.collect();
        row.sort_unstable();
        row.dedup();
        self.columns.extend(row);
        self.blocks.resize(self.columns.len(), DMat3::ZERO);
        self.ends.push(self.columns.len());
        first
    }
}

/// Row `a` of the stiffness of cell `t`: exact where edges are straight, else by quadrature of degree five.
fn element_row(space: &Space<'_>, t: usize, a: usize, [lambda, mu]: [f64; 2]) -> [DMat3; 10] {
    if !space.is_curved(t) {
        let (volume, g) = space.frame(t, [0.25; 4]);
        return tet10::stiffness_row(a, volume * lambda, volume * mu, g);
    }
    let mut row = [DMat3::ZERO; 10];
    for (l, _, weight) in space.cell_rule(t) {
        let gradients = tet10::gradients(space.frame(t, l).1, l);
        for (block, b) in row.iter_mut().zip(gradients) {
            *block += tet4::stiffness_block(weight * lambda, weight * mu, gradients[a], b);
        }
    }
    row
}
