//! The linear system: stiffness, nodal forces, and which displacements are prescribed.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::numbering::Dofs;
use super::{FemError, Model, check, loads, springs, tet4};
use crate::mesh::topology::VertexCells;
use crate::mesh::{TetMesh, quality};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::ops::Range;

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
    /// Of ten-node cells, what their vertices are.
    pub(super) linear: Option<Linear>,
}

/// The vertices of ten-node cells with straight edges: the first nodes, before the midpoints of the edges.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// Stiffness of the four-node cells between the vertices: `P^T K P`, where `P` gives midpoints the mean of their edge's
    /// ends.
    pub stiffness: BlockMatrix,
    /// The vertices that each midpoint lies between.
    pub ends: Vec<[u32; 2]>,
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

/// Assembles stiffness, loads and supports of a model on a mesh.
///
/// It does not ask whether the supports hold the solid: see [`super::check_constraints`], which is needed once only, as
/// refinement inherits the supports.
///
/// # Errors
/// A material, support or load that makes no sense on this mesh; see [`FemError`].
pub fn assemble(mesh: &TetMesh, model: &Model) -> Result<System, FemError> {
    check::check(mesh, model)?;
    let numbering = Dofs::new(mesh, model)?;
    let loads = loads::nodal_forces(mesh, model)?;
    let mut stiffness = stiffness(mesh, model);
    springs::add(mesh, model, &mut stiffness);
    Ok(System { stiffness, loads, numbering, points: mesh.points().to_vec(), linear: None })
}

/// The stiffness of all nodes. Each row is gathered by one task from the cells of its node in ascending order, so that
/// no atomics are needed and the bytes do not depend on the number of threads.
fn stiffness(mesh: &TetMesh, model: &Model) -> BlockMatrix {
    let cells = VertexCells::new(mesh.points().len(), mesh.tets());
    let rows = mesh.points().len();
    let (starts, columns) = pattern(rows, &cells, mesh.tets());
    let lame: Vec<[f64; 2]> = model.materials.iter().map(|m| [m.lambda(), m.mu()]).collect();
    let mut blocks = vec![DMat3::ZERO; columns.len()];
    let first_rows: Vec<usize> = (0..rows).step_by(CHUNK).collect();
    let mut chunks = Vec::with_capacity(first_rows.len());
    let mut rest = blocks.as_mut_slice();
    for first in first_rows {
        let last = rows.min(first + CHUNK);
        let (chunk, tail) = rest.split_at_mut(starts[last] - starts[first]);
        chunks.push((first..last, chunk));
        rest = tail;
    }
    let gather = |slots: &mut Vec<u32>, (range, mut chunk): (Range<usize>, &mut [DMat3])| {
        for i in range {
            let row = &columns[starts[i]..starts[i + 1]];
            let (blocks, tail) = chunk.split_at_mut(row.len());
            (0..).zip(row).for_each(|(slot, &v)| slots[v as usize] = slot);
            gather_row(mesh, &lame, i as u32, cells.at(i as u32), slots, blocks);
            chunk = tail;
        }
    };
    chunks.into_par_iter().for_each_init(|| vec![0; rows], gather);
    BlockMatrix { starts, columns, blocks }
}

/// Nodes that share a cell with each node (itself included), ascending, as compressed rows; `cells` are the cells at each
/// node, `nodes` the nodes of each cell.
fn pattern<const K: usize>(rows: usize, cells: &VertexCells, nodes: &[[u32; K]]) -> (Vec<usize>, Vec<u32>) {
    const NEVER: u32 = u32::MAX;
    let chunk = |seen: &mut Vec<u32>, chunk: usize| {
        let (mut lengths, mut columns) = (Vec::with_capacity(CHUNK), Vec::new());
        for i in chunk * CHUNK..rows.min((chunk + 1) * CHUNK) {
            let first = columns.len();
            for v in cells.at(i as u32).iter().flat_map(|&t| nodes[t as usize]) {
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
    let chunks = (0..rows.div_ceil(CHUNK)).into_par_iter().map_init(|| vec![NEVER; rows], chunk);
    let chunks: Vec<(Vec<usize>, Vec<u32>)> = chunks.collect();
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

/// Adds the blocks of node `i` from its cells; `slots` says where the block of each of its neighbours is.
fn gather_row(mesh: &TetMesh, lame: &[[f64; 2]], i: u32, cells: &[u32], slots: &[u32], blocks: &mut [DMat3]) {
    let region = |t: &u32| mesh.regions()[*t as usize].0 as usize;
    let one = cells.first().map(region).filter(|&one| cells.iter().all(|t| region(t) == one));
    for &t in cells {
        let tet = mesh.tets()[t as usize];
        let p = mesh.cell_points(t as usize);
        let n = quality::face_normals(p);
        // With grad N_i = -n_i / (6 V), `V grad N_i grad N_j^T` is this times `n_i n_j^T`.
        let weight = 1.0 / (36.0 * quality::volume(p));
        // Node i belongs to its cells.
        let own = tet.iter().position(|&v| v == i).map_or(DVec3::ZERO, |a| n[a]);
        for (v, n) in tet.into_iter().zip(n) {
            let block = &mut blocks[slots[v as usize] as usize];
            if one.is_some() {
                // In one material the products are summed up first.
                let n = weight * n;
                *block += DMat3::from_cols(own * n.x, own * n.y, own * n.z);
            } else {
                let [lambda, mu] = lame[region(&t)].map(|modulus| weight * modulus);
                *block += tet4::stiffness_block(lambda, mu, own, n);
            }
        }
    }
    if let Some([lambda, mu]) = one.map(|region| lame[region]) {
        blocks.iter_mut().for_each(|block| *block = tet4::isotropic(lambda, mu, *block));
    }
}
