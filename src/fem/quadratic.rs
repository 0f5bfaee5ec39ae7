//! The stiffness of ten-node cells.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::{Model, Space, tet10};
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
    let rows: Vec<(Vec<u32>, Vec<DMat3>)> = (0..nodes)
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|i| {
            let around = cells.at(i as u32);
            let mut columns: Vec<u32> = around.iter().flat_map(|&t| space.cell(t as usize)).collect();
            columns.sort_unstable();
            columns.dedup();
            let mut blocks = vec![DMat3::ZERO; columns.len()];
            for t in around.iter().map(|&t| t as usize) {
                let [lambda, mu] = lame[mesh.regions()[t].0 as usize];
                let own = space.cell(t).position(|v| v as usize == i).unwrap_or_default();
                for (v, product) in space.cell(t).zip(gradient_products(space, t, own)) {
                    let slot = columns.partition_point(|&c| c < v);
                    blocks[slot] += tet10::stiffness_block(lambda, mu, product);
                }
            }
            (columns, blocks)
        })
        .collect();
    let mut starts = vec![0];
    starts.extend(rows.iter().scan(0, |end, (columns, _)| {
        *end += columns.len();
        Some(*end)
    }));
    let (columns, blocks): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    BlockMatrix { starts, columns: columns.concat(), blocks: blocks.concat() }
}

/// `int grad N_a (grad N_b)^T dV` over cell `t` for node `a` and all ten nodes `b`: exact where edges are straight, else by
/// quadrature of degree five.
fn gradient_products(space: &Space<'_>, t: usize, a: usize) -> [DMat3; 10] {
    if !space.is_curved(t) {
        let (volume, g) = space.frame(t, [0.25; 4]);
        return tet10::gradient_products(a, g).map(|product| volume * product);
    }
    let mut products = [DMat3::ZERO; 10];
    for (l, _, weight) in space.cell_rule(t) {
        let gradients = tet10::gradients(space.frame(t, l).1, l);
        for (product, b) in products.iter_mut().zip(gradients) {
            *product += tet10::outer(weight * gradients[a], b);
        }
    }
    products
}
