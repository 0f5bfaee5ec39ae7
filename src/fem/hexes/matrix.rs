//! Matrices of element functions: the stiffness, and masses of boundary faces and cells.
//!
//! Cells are worked off in batches: their matrices are computed in parallel, then added up row by row in the order of cells.
//! So no two threads write to one row, and the bytes do not depend on their number.

use super::super::block_matrix::BlockMatrix;
use super::super::tet10::stiffness_block;
use super::super::{FemError, Material};
use super::rule::Quadrature;
use super::{AtPoint, HexSpace};
use crate::mesh::rows::Rows;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, Par};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Cells whose matrices are kept at a time: some dozens of megabytes.
const BATCH: usize = 256;

/// The stiffness of all functions, for one material a region.
///
/// # Errors
/// [`FemError::Folded`] where a Jacobian is not positive.
pub(super) fn stiffness(space: &HexSpace<'_>, materials: &[Material]) -> Result<BlockMatrix, FemError> {
    let quadrature = Quadrature::of_stiffness(space, 0, 0);
    gather(space, |t| Ok(of_cell(space, &quadrature, materials, t)?.blocks))
}

/// Checks that no cell is folded at the points of its stiffness.
///
/// # Errors
/// [`FemError::Folded`].
pub fn check_hex_shapes(space: &HexSpace<'_>) -> Result<(), FemError> {
    let quadrature = Quadrature::of_stiffness(space, 0, 0);
    let folded = space.of_cells(|t| {
        let (weights, table) = quadrature.of(space, t);
        let frames = (0..weights.len()).map(|q| space.frame(t, &table, q));
        let mut worst = frames.map(|(at, jacobian)| (at, jacobian.determinant()));
        worst.find(|(_, determinant)| determinant.is_nan() || *determinant <= 0.0)
    });
    match folded.into_iter().enumerate().find_map(|(cell, found)| Some((cell, found?))) {
        Some((cell, (at, determinant))) => Err(FemError::Folded { cell, at, determinant }),
        None => Ok(()),
    }
}

/// The stiffness of a cell as dense blocks.
pub(super) struct CellMatrix {
    pub functions: usize,
    /// Row by row.
    pub blocks: Vec<DMat3>,
}

impl CellMatrix {
    /// The block of two functions of the cell.
    pub fn block(&self, i: usize, j: usize) -> &DMat3 {
        &self.blocks[i * self.functions + j]
    }
}

/// The stiffness of cell `t`.
///
/// # Errors
/// [`FemError::Folded`].
pub(super) fn of_cell(
    space: &HexSpace<'_>,
    quadrature: &Quadrature,
    materials: &[Material],
    t: usize,
) -> Result<CellMatrix, FemError> {
    let (weights, table) = quadrature.of(space, t);
    let (mut at, n) = (AtPoint::default(), table.functions);
    // Column q holds the weighted gradients of all functions at point q.
    let mut gradients = Mat::<f64>::zeros(3 * n, weights.len());
    for (q, weight) in weights.iter().enumerate() {
        space.at_point(t, &table, q, &mut at);
        if at.determinant.is_nan() || at.determinant <= 0.0 {
            return Err(FemError::Folded { cell: t, at: at.x, determinant: at.determinant });
        }
        let scale = (weight * at.determinant).sqrt();
        let column = at.gradients.iter().flat_map(|g| (scale * *g).to_array());
        gradients.col_mut(q).iter_mut().zip(column).for_each(|(entry, g)| *entry = g);
    }
    let mut products = Mat::<f64>::zeros(3 * n, 3 * n);
    triangular::matmul(
        products.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        gradients.as_ref(),
        BlockStructure::Rectangular,
        gradients.transpose(),
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    let material = &materials[space.mesh().regions()[t].0 as usize];
    Ok(CellMatrix { functions: n, blocks: blocks(&products, n, material) })
}

/// The blocks of a cell, row by row, from the lower part of the integrals of products of gradients.
fn blocks(products: &Mat<f64>, n: usize, material: &Material) -> Vec<DMat3> {
    let (lambda, mu) = (material.lambda(), material.mu());
    let mut blocks = vec![DMat3::ZERO; n * n];
    for a in 0..n {
        for b in 0..=a {
            let entry = |i: usize, j: usize| {
                let (row, column) = (3 * a + i, 3 * b + j);
                if row >= column { products[(row, column)] } else { products[(column, row)] }
            };
            let product = DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| [0, 1, 2].map(|i| entry(i, j))));
            let block = stiffness_block(lambda, mu, product);
            blocks[a * n + b] = block;
            blocks[b * n + a] = block.transpose();
        }
    }
    blocks
}

/// The pattern of the matrix: which functions share a cell with each.
fn pattern(space: &HexSpace<'_>) -> BlockMatrix {
    let cells = space.mesh().cells().len();
    let of_function = Rows::new(space.points().len(), cells, |t| space.cell(t).iter().map(move |&v| (v, t as u32)));
    let row = |i: usize| {
        let mut columns: Vec<u32> = of_function.row(i).iter().flat_map(|&t| space.cell(t as usize)).copied().collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    };
    let rows: Vec<Vec<u32>> = (0..space.points().len()).into_par_iter().map(row).collect();
    let mut starts = vec![0];
    starts.extend(rows.iter().scan(0, |sum, row| {
        *sum += row.len();
        Some(*sum)
    }));
    let columns: Vec<u32> = rows.into_iter().flatten().collect();
    BlockMatrix { starts, blocks: vec![DMat3::ZERO; columns.len()], columns }
}

/// Sums up the matrices of all cells, given as dense blocks over their functions.
fn gather(
    space: &HexSpace<'_>,
    element: impl Fn(usize) -> Result<Vec<DMat3>, FemError> + Sync + Send,
) -> Result<BlockMatrix, FemError> {
    let mut matrix = pattern(space);
    let cells = space.mesh().cells().len();
    for first in (0..cells).step_by(BATCH) {
        let batch = first..cells.min(first + BATCH);
        let elements: Vec<Vec<DMat3>> = batch.clone().into_par_iter().map(&element).collect::<Result<_, _>>()?;
        // The rows that each function of these cells adds to, sorted by row and then by cell.
        let own = |t: usize| space.cell(t).iter().enumerate().map(move |(a, &v)| (v, t, a));
        let mut entries: Vec<(u32, usize, usize)> = batch.clone().flat_map(own).collect();
        entries.par_sort_unstable();
        let orders: Vec<Vec<u32>> = batch.clone().into_par_iter().map(|t| sorted_places(space.cell(t))).collect();
        let mut rest = matrix.blocks.as_mut_slice();
        let mut consumed = 0;
        let mut tasks = Vec::new();
        for same in entries.chunk_by(|a, b| a.0 == b.0) {
            let row = same[0].0 as usize;
            let (start, end) = (matrix.starts[row], matrix.starts[row + 1]);
            let (own, tail) = rest.split_at_mut(end - consumed);
            tasks.push((same, &mut own[start - consumed..], &matrix.columns[start..end]));
            (rest, consumed) = (tail, end);
        }
        tasks.into_par_iter().with_min_len(8).for_each(|(same, blocks, columns)| {
            for &(_, t, a) in same {
                let (functions, order) = (space.cell(t), &orders[t - first]);
                let own = &elements[t - first][a * functions.len()..(a + 1) * functions.len()];
                let mut place = 0;
                for &b in order {
                    // Ascending in both, and each is there.
                    while columns[place] < functions[b as usize] {
                        place += 1;
                    }
                    blocks[place] += own[b as usize];
                }
            }
        });
    }
    Ok(matrix)
}

/// The places of a list in the order of its entries.
fn sorted_places(list: &[u32]) -> Vec<u32> {
    let mut places: Vec<u32> = (0..list.len() as u32).collect();
    places.sort_unstable_by_key(|&p| list[p as usize]);
    places
}

/// A symmetric sparse matrix of scalars over some functions.
#[derive(Debug, Clone)]
pub(super) struct Mass {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Mass {
    /// From entries (row, column, value), summed in their order.
    pub fn new(rows: usize, mut entries: Vec<(u32, u32, f64)>) -> Self {
        entries.par_sort_by_key(|e| (e.0, e.1));
        let mut mass = Self { starts: vec![0; rows + 1], columns: Vec::new(), values: Vec::new() };
        for same in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            mass.columns.push(same[0].1);
            mass.values.push(same.iter().map(|e| e.2).sum());
            mass.starts[same[0].0 as usize + 1] = mass.columns.len();
        }
        for i in 0..rows {
            mass.starts[i + 1] = mass.starts[i + 1].max(mass.starts[i]);
        }
        mass
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().map(|c| *c as usize).zip(self.values[range].iter().copied())
    }

    /// Solves `M x = b`. Rows without entries give zero.
    pub fn solve(&self, b: &[DVec3]) -> Vec<DVec3> {
        let diagonal: Vec<f64> = (0..b.len()).map(|i| self.row(i).find(|e| e.0 == i).map_or(0.0, |e| e.1)).collect();
        let times = |x: &[DVec3]| {
            let product = |i: usize| self.row(i).map(|(j, m)| m * x[j]).sum::<DVec3>();
            (0..b.len()).into_par_iter().with_min_len(512).map(product).collect()
        };
        conjugate_gradients(times, &diagonal, b)
    }
}

/// Relative residual of mass systems of supports, and iterations at most.
const MASS_TOLERANCE: f64 = 1e-14;
const MASS_ITERATIONS: usize = 2000;

/// Solves three systems of one mass matrix, given as a product with it, by conjugate gradients with the diagonal as
/// preconditioner: mass matrices are well conditioned then. Where the diagonal is zero the solution is.
fn conjugate_gradients(times: impl Fn(&[DVec3]) -> Vec<DVec3>, diagonal: &[f64], b: &[DVec3]) -> Vec<DVec3> {
    let scaled = |r: &[DVec3]| -> Vec<DVec3> {
        r.iter().zip(diagonal).map(|(r, d)| if *d > 0.0 { *r / *d } else { DVec3::ZERO }).collect()
    };
    let dot = |x: &[DVec3], y: &[DVec3]| x.iter().zip(y).map(|(x, y)| *x * *y).sum::<DVec3>();
    let (mut x, mut r) = (vec![DVec3::ZERO; b.len()], b.to_vec());
    let mut z = scaled(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let goal = rz * (MASS_TOLERANCE * MASS_TOLERANCE);
    for _ in 0..MASS_ITERATIONS {
        if rz.cmple(goal).all() {
            break;
        }
        let mp = times(&p);
        let step = quotient(rz, dot(&p, &mp));
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * *p);
        r.iter_mut().zip(&mp).for_each(|(r, mp)| *r -= step * *mp);
        z = scaled(&r);
        let next = dot(&r, &z);
        let beta = quotient(next, rz);
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = *z + beta * *p);
        rz = next;
    }
    x
}

/// `a / b` by components; zero where `a` is zero.
fn quotient(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|c| if a[c] == 0.0 { 0.0 } else { a[c] / b[c] }))
}
