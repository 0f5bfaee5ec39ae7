//! Galerkin's method in a subspace: displacements that are combinations of fewer, as of the control points of a smooth solid.
//!
//! With the nodes' displacements `u = S c` the system of the control values is `S^T K S c = S^T f`.

use super::block_matrix::{BlockMatrix, CHUNK};
use super::numbering::{Dofs, prescribed};
use super::{FemError, Model, Solution, Solved, Space, System, recover, springs};
use crate::mesh::TetMesh;
use crate::mesh::weights::WeightRows;
use glam::DMat3;
use rayon::prelude::*;

/// The system of the control values. Supports hold the control points of their faces: on flat faces, whose borders are creases, all
/// nodes then; what they prescribe is met exactly where it is linear in the place.
///
/// # Errors
/// [`FemError::ConflictingSupports`], [`FemError::NotFiniteAt`].
pub fn restrict(system: &System, basis: &WeightRows, control: &TetMesh, model: &Model) -> Result<System, FemError> {
    let space = Space::linear(control);
    let numbering = Dofs::from_prescribed(&space, prescribed(&space, model)?);
    let transposed = basis.transposed();
    Ok(System {
        stiffness: product(&system.stiffness, basis, &transposed),
        loads: transposed.apply(&system.loads),
        numbering,
        points: control.points().to_vec(),
        linear: None,
    })
}

/// Recovers a solution on the nodes from the one of the control values: reactions are those of the restricted system.
#[must_use]
pub fn recover_restricted(
    space: &Space<'_>,
    model: &Model,
    (fine, restricted): (&System, &System),
    (basis, solved): (&WeightRows, &Solved),
) -> Solution {
    let nodes = Solved { displacement: basis.apply(&solved.displacement), info: solved.info.clone() };
    let mut solution = recover::recover(space, model, fine, &nodes);
    let internal = restricted.stiffness.times(&solved.displacement);
    solution.reactions = recover::reactions(model, restricted, &internal);
    for (support, reaction) in model.supports.iter().zip(&mut solution.reactions) {
        *reaction += springs::reaction(space, support, &nodes.displacement);
    }
    solution
}

/// A row of blocks while it is summed up: one place a column, zero between rows.
struct Sums {
    blocks: Vec<DMat3>,
    touched: Vec<u32>,
}

impl Sums {
    fn new(width: usize) -> Self {
        Self { blocks: vec![DMat3::ZERO; width], touched: Vec::new() }
    }

    fn add(&mut self, column: u32, block: DMat3) {
        self.blocks[column as usize] += block;
        self.touched.push(column);
    }

    /// The row, by ascending column.
    fn take(&mut self) -> (Vec<u32>, Vec<DMat3>) {
        let mut columns = std::mem::take(&mut self.touched);
        columns.sort_unstable();
        columns.dedup();
        let blocks = columns.iter().map(|&c| std::mem::replace(&mut self.blocks[c as usize], DMat3::ZERO)).collect();
        (columns, blocks)
    }
}

/// `S^T K S`. Each row sums in the order of the nodes, whatever the number of threads.
fn product(stiffness: &BlockMatrix, basis: &WeightRows, transposed: &WeightRows) -> BlockMatrix {
    // K S, row by row.
    let times_basis = |first: usize| {
        let mut sums = Sums::new(basis.width());
        let row = |i: usize| {
            for (j, block) in stiffness.row(i) {
                basis.row(j).for_each(|(b, weight)| sums.add(b, weight * *block));
            }
            sums.take()
        };
        (first..stiffness.rows().min(first + CHUNK)).map(row).collect::<Vec<_>>()
    };
    let firsts: Vec<usize> = (0..stiffness.rows()).step_by(CHUNK).collect();
    let half: Vec<Vec<(Vec<u32>, Vec<DMat3>)>> = firsts.into_par_iter().map(times_basis).collect();
    let rows: Vec<(Vec<u32>, Vec<DMat3>)> = (0..transposed.rows())
        .into_par_iter()
        .map_init(
            || Sums::new(basis.width()),
            |sums, a| {
                for (i, weight) in transposed.row(a) {
                    let (columns, blocks) = &half[i as usize / CHUNK][i as usize % CHUNK];
                    columns.iter().zip(blocks).for_each(|(&b, block)| sums.add(b, weight * *block));
                }
                sums.take()
            },
        )
        .collect();
    let mut matrix = BlockMatrix { starts: vec![0], columns: Vec::new(), blocks: Vec::new() };
    for (columns, blocks) in rows {
        matrix.columns.extend(columns);
        matrix.blocks.extend(blocks);
        matrix.starts.push(matrix.columns.len());
    }
    symmetrised(matrix)
}

/// The matrix with its lower half made that of the upper one: sums in other orders differ by rounding.
fn symmetrised(mut matrix: BlockMatrix) -> BlockMatrix {
    for i in 0..matrix.rows() {
        for place in matrix.starts[i]..matrix.starts[i + 1] {
            let (j, block) = (matrix.columns[place], matrix.blocks[place]);
            if (j as usize) > i
                && let Some(mirrored) = matrix.block_mut(j, i as u32)
            {
                *mirrored = block.transpose();
            } else if j as usize == i {
                matrix.blocks[place] = 0.5 * (block + block.transpose());
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::options::SolverOptions;
    use crate::fem::{Load, LoadKind, Material, Support, assemble, solve};
    use crate::mesh::generate::box_tets;
    use glam::DVec3;

    #[test]
    fn the_identity_restricts_to_the_system_itself() {
        let mesh = box_tets([2.0, 1.0, 1.0], [3, 2, 2]).unwrap();
        let group = |name: &str| mesh.group(name).unwrap();
        let model = Model {
            materials: vec![Material { youngs_modulus: 10.0, poissons_ratio: 0.3, density: 0.0 }],
            supports: vec![Support::new("clamp", group("x-min"), [Some(0.0); 3])],
            loads: vec![Load { name: "pull".into(), kind: LoadKind::Force(group("x-max"), DVec3::new(1.0, 2.0, 3.0)) }],
        };
        let space = Space::linear(&mesh);
        let system = assemble(&space, &model).unwrap();
        let basis = WeightRows::identity(mesh.points().len());
        let restricted = restrict(&system, &basis, &mesh, &model).unwrap();
        let [a, b] = [&system, &restricted].map(|s| solve(s, &SolverOptions::default(), None).unwrap());
        let largest = a.displacement.iter().map(|u| u.length()).fold(0.0, f64::max);
        assert!(a.displacement.iter().zip(&b.displacement).all(|(u, v)| u.distance(*v) < 1e-9 * largest));
        let solution = recover_restricted(&space, &model, (&system, &restricted), (&basis, &b));
        assert!((solution.reactions[0] + DVec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
    }
}
