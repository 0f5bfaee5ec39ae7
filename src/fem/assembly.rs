//! The linear system: stiffness, nodal forces, and which displacements are prescribed.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::numbering::Dofs;
use super::options::Element;
use super::{FemError, Model, Space, check, loads, springs, tet4, tet10};
use crate::mesh::topology::NodeCells;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// The linear system `K u = f` of all nodes, with the displacements that are prescribed.
#[derive(Debug, Clone)]
pub struct System {
    /// Stiffness between all nodes, prescribed ones included: reactions and energy need it.
    pub(super) stiffness: BlockMatrix,
    /// Force of the loads at each node.
    pub(super) loads: Vec<DVec3>,
    pub(super) numbering: Dofs,
    /// Positions of the nodes: the rigid motions that the iterative solver builds on depend on them.
    pub(super) points: Vec<DVec3>,
}

impl System {
    /// Degrees of freedom: three a node.
    #[must_use]
    pub fn dofs(&self) -> usize {
        3 * self.loads.len()
    }

    /// Unknown degrees of freedom: those that no support prescribes.
    #[must_use]
    pub fn free_dofs(&self) -> usize {
        self.numbering.free()
    }

    /// Sum of all loads.
    #[must_use]
    pub fn total_load(&self) -> DVec3 {
        self.loads.iter().sum()
    }
}

/// Assembles stiffness, loads and supports of a model on the elements of a mesh.
///
/// It does not ask whether the supports hold the solid: see [`super::check_constraints`], which is needed once only, as
/// refinement inherits the supports.
///
/// # Errors
/// A material, support or load that makes no sense on this mesh; see [`FemError`].
pub fn assemble(space: &Space<'_>, model: &Model) -> Result<System, FemError> {
    check::check(space.mesh(), model)?;
    let numbering = Dofs::new(space, model)?;
    let loads = loads::nodal_forces(space, model)?;
    let mut stiffness = stiffness(space, model);
    springs::add(space, model, &mut stiffness);
    Ok(System { stiffness, loads, numbering, points: space.points().to_vec() })
}

/// The stiffness of all nodes. Each row is gathered by one task from the cells of its node in ascending order, so that
/// no atomics are needed and the bytes do not depend on the number of threads.
fn stiffness(space: &Space<'_>, model: &Model) -> BlockMatrix {
    let mesh = space.mesh();
    let lame: Vec<[f64; 2]> = model.materials.iter().map(|m| [m.lambda(), m.mu()]).collect();
    let lame = |t: usize| lame[mesh.regions()[t].0 as usize];
    match space.element() {
        Element::Tet4 => {
            let nodes = |t: usize| mesh.tets()[t];
            gather(space, nodes, |t, a| {
                let (volume, g) = tet4::gradients(mesh.cell_points(t));
                let [lambda, mu] = lame(t).map(|modulus| volume * modulus);
                g.map(|b| tet4::stiffness_block(lambda, mu, g[a], b))
            })
        }
        Element::Tet10 => {
            let nodes = |t: usize| {
                let mut nodes = [0; 10];
                nodes.iter_mut().zip(space.cell(t)).for_each(|(place, v)| *place = v);
                nodes
            };
            gather(space, nodes, |t, a| ten_node_row(space, t, a, lame(t)))
        }
    }
}

/// Row `a` of the stiffness of a ten-node cell: exact where edges are straight, else by quadrature of degree five.
fn ten_node_row(space: &Space<'_>, t: usize, a: usize, [lambda, mu]: [f64; 2]) -> [DMat3; 10] {
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

/// The matrix of cells of `N` nodes; `row` gives a row of the matrix of a cell.
fn gather<const N: usize>(
    space: &Space<'_>,
    nodes: impl Fn(usize) -> [u32; N] + Sync,
    row: impl Fn(usize, usize) -> [DMat3; N] + Sync,
) -> BlockMatrix {
    let rows = space.points().len();
    let cells = NodeCells::of(rows, space.mesh().tets().len(), |t| nodes(t).into_iter());
    let (starts, columns) = pattern(rows, &cells, &nodes);
    let mut blocks = vec![DMat3::ZERO; columns.len()];
    let mut chunks = Vec::with_capacity(rows.div_ceil(CHUNK));
    let mut rest = blocks.as_mut_slice();
    for first in (0..rows).step_by(CHUNK) {
        let last = rows.min(first + CHUNK);
        let (chunk, tail) = rest.split_at_mut(starts[last] - starts[first]);
        chunks.push((first..last, chunk));
        rest = tail;
    }
    chunks.into_par_iter().for_each(|(range, mut chunk)| {
        for i in range {
            let columns = &columns[starts[i]..starts[i + 1]];
            let (blocks, tail) = chunk.split_at_mut(columns.len());
            chunk = tail;
            for t in cells.at(i as u32).iter().map(|&t| t as usize) {
                let nodes = nodes(t);
                // The node belongs to the cell, whose nodes are in the lists that were made of the cells.
                let own = nodes.iter().position(|&v| v as usize == i).unwrap_or_default();
                for (v, block) in nodes.into_iter().zip(row(t, own)) {
                    blocks[columns.partition_point(|&c| c < v)] += block;
                }
            }
        }
    });
    BlockMatrix { starts, columns, blocks }
}

/// Nodes that share a cell with each node (itself included), ascending, as compressed rows.
fn pattern<const N: usize>(
    rows: usize,
    cells: &NodeCells,
    nodes: impl Fn(usize) -> [u32; N] + Sync,
) -> (Vec<usize>, Vec<u32>) {
    let chunks: Vec<(Vec<usize>, Vec<u32>)> = (0..rows.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let (mut lengths, mut columns, mut row) = (Vec::with_capacity(CHUNK), Vec::new(), Vec::new());
            for i in chunk * CHUNK..rows.min((chunk + 1) * CHUNK) {
                row.clear();
                row.extend(cells.at(i as u32).iter().flat_map(|&t| nodes(t as usize)));
                row.sort_unstable();
                row.dedup();
                lengths.push(row.len());
                columns.extend_from_slice(&row);
            }
            (lengths, columns)
        })
        .collect();
    let mut starts = Vec::with_capacity(rows + 1);
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
