//! Sparse Cholesky factorisation of a symmetric matrix, by faer's supernodes.

use super::ordering::{Graph, nested_dissection};
use crate::fem::FemError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

/// Two threads within faer gained nothing (110,964 unknowns: 1.7 s against 1.8 s), and its sums then depend on the number
/// of threads.
const SEQUENTIAL: Par = Par::Seq;

/// The lower triangle of a symmetric matrix, compressed columns with ascending rows.
pub(super) struct Lower {
    pub starts: Vec<usize>,
    pub rows: Vec<usize>,
    pub values: Vec<f64>,
}

impl Lower {
    fn pattern(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.starts.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows)
    }
}

/// A matrix and the structure of its factor, made without numeric work.
pub(super) struct Analysis {
    lower: Lower,
    symbolic: SymbolicCholesky<usize>,
}

impl Analysis {
    /// Orders the unknowns by nested dissection of a graph whose vertex v stands for the unknowns
    /// `first_unknown[v]..first_unknown[v + 1]`, and finds the structure of the factor.
    ///
    /// # Errors
    /// [`FemError::Ordering`].
    pub fn new(lower: Lower, graph: &mut Graph, first_unknown: &[usize]) -> Result<Self, FemError> {
        let vertices = nested_dissection(graph)?;
        let order: Vec<usize> = vertices.into_iter().flat_map(|v| first_unknown[v]..first_unknown[v + 1]).collect();
        let mut rank = vec![0; order.len()];
        for (k, &old) in order.iter().enumerate() {
            rank[old] = k;
        }
        let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&order, &rank, order.len()));
        let symbolic = factorize_symbolic_cholesky(lower.pattern(), Side::Lower, ordering, Default::default())
            .map_err(|e| FemError::Ordering(format!("{e:?}")))?;
        Ok(Self { lower, symbolic })
    }

    /// Numbers that the factor will hold.
    pub fn nonzeros(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Bytes that the factor will take.
    pub fn factor_bytes(&self) -> u64 {
        8 * self.nonzeros() as u64
    }

    /// Factorises; the matrix itself is given up.
    ///
    /// # Errors
    /// [`FemError::OutOfMemory`], [`FemError::NotPositiveDefinite`].
    pub fn factorise(self) -> Result<Factor, FemError> {
        let mut values: Vec<f64> = Vec::new();
        let out_of_memory = |_| FemError::OutOfMemory { bytes: self.factor_bytes() };
        values.try_reserve_exact(self.nonzeros()).map_err(out_of_memory)?;
        values.resize(self.nonzeros(), 0.0);
        let matrix = SparseColMatRef::new(self.lower.pattern(), &self.lower.values);
        let keep = Default::default();
        let mut memory = scratch(self.symbolic.factorize_numeric_llt_scratch::<f64>(SEQUENTIAL, Default::default()))?;
        let stack = MemStack::new(&mut memory);
        self.symbolic
            .factorize_numeric_llt(&mut values, matrix, Side::Lower, keep, SEQUENTIAL, stack, Default::default())
            .map_err(|error| FemError::NotPositiveDefinite { detail: format!("{error:?}") })?;
        Ok(Factor { symbolic: self.symbolic, values })
    }
}

/// A Cholesky factor.
pub(super) struct Factor {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Factor {
    /// Numbers that it holds.
    pub fn nonzeros(&self) -> usize {
        self.values.len()
    }

    /// Puts the solution for the right-hand side `x` in its place.
    ///
    /// # Errors
    /// [`FemError::OutOfMemory`].
    pub fn solve(&self, x: &mut [f64]) -> Result<(), FemError> {
        let mut memory = scratch(self.symbolic.solve_in_place_scratch::<f64>(1, SEQUENTIAL))?;
        let rows = x.len();
        let column = MatMut::from_column_major_slice_mut(x, rows, 1);
        let factor = LltRef::new(&self.symbolic, &self.values);
        factor.solve_in_place_with_conj(Conj::No, column, SEQUENTIAL, MemStack::new(&mut memory));
        Ok(())
    }
}

/// Working memory, or a refusal.
fn scratch(request: StackReq) -> Result<MemBuffer, FemError> {
    let bytes = request.unaligned_bytes_required() as u64;
    MemBuffer::try_new(request).map_err(|_| FemError::OutOfMemory { bytes })
}
