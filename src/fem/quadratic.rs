//! The stiffness of ten-node cells.

use super::block_matrix::BlockMatrix;
use super::gather::gather;
use super::{Model, Space, tet10};
use crate::mesh::topology::NodeCells;
use glam::DMat3;

/// The stiffness between all nodes.
pub(super) fn stiffness(space: &Space<'_>, model: &Model) -> BlockMatrix {
    let mesh = space.mesh();
    let count = space.points().len();
    let cells = NodeCells::of(count, mesh.tets().len(), |t| space.cell(t));
    let lame: Vec<[f64; 2]> = model.materials.iter().map(|m| [m.lambda(), m.mu()]).collect();
    let region = |t: u32| mesh.regions()[t as usize].0 as usize;
    gather(
        &cells,
        count,
        |t| space.cell(t as usize),
        |i, places, blocks| {
            let around = cells.at(i);
            let one = around.first().map(|&t| region(t)).filter(|&one| around.iter().all(|&t| region(t) == one));
            for &t in around {
                let own = space.cell(t as usize).position(|v| v == i).unwrap_or_default();
                let products = gradient_products(space, t as usize, own);
                for (v, product) in space.cell(t as usize).zip(products) {
                    let [lambda, mu] = lame[region(t)];
                    // In one material the products are summed up first.
                    let whole = || tet10::stiffness_block(lambda, mu, product);
                    blocks[places[v as usize] as usize] += if one.is_some() { product } else { whole() };
                }
            }
            if let Some([lambda, mu]) = one.map(|region| lame[region]) {
                blocks.iter_mut().for_each(|block| *block = tet10::stiffness_block(lambda, mu, *block));
            }
        },
    )
}

/// `int grad N_a (grad N_b)^T dV` over cell `t` for node `a` and all ten nodes `b`: exact where edges are straight, else by
/// quadrature of degree five.
fn gradient_products(space: &Space<'_>, t: usize, a: usize) -> [DMat3; 10] {
    if !space.is_curved(t) {
        let (volume, g) = space.frame(t, [0.25; 4]);
        return tet10::gradient_products(a, volume, g);
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
