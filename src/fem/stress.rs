//! The stress of the elements: a polynomial in each cell, with jumps between them.

use super::{Model, Space, SymTensor, tet4, tet10};
use crate::mesh::TetMesh;
use glam::DVec3;
use rayon::prelude::*;

/// Stress in each cell: constant for four-node cells, linear for ten-node cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Stress {
    /// One tensor a cell, or four: those at its vertices.
    values: Vec<SymTensor>,
    linear: bool,
}

impl Stress {
    /// A stress that is constant in each cell.
    #[must_use]
    pub fn constant(cells: Vec<SymTensor>) -> Self {
        Self { values: cells, linear: false }
    }

    /// A stress that is linear in each cell, given at its vertices.
    #[must_use]
    pub fn linear(corners: &[[SymTensor; 4]]) -> Self {
        Self { values: corners.concat(), linear: true }
    }

    /// The stress of nodal displacements, `C : sum_a sym(u_a grad N_a^T)`.
    #[must_use]
    pub(super) fn of(space: &Space<'_>, model: &Model, u: &[DVec3]) -> Self {
        let mesh = space.mesh();
        let linear = !space.midside().is_empty();
        let material = |t: usize| &model.materials[mesh.regions()[t].0 as usize];
        let cells = (0..mesh.tets().len()).into_par_iter();
        let values = if linear {
            cells
                .flat_map_iter(|t| {
                    let (_, g) = tet4::gradients(mesh.cell_points(t));
                    let stress = move |k: usize| {
                        let corner = std::array::from_fn(|i| f64::from(u8::from(i == k)));
                        let moves = space.cell(t).map(|v| u[v as usize]);
                        material(t).stress(tet4::strain(tet10::gradients(g, corner).into_iter().zip(moves)))
                    };
                    (0..4).map(stress)
                })
                .collect()
        } else {
            cells
                .map(|t| {
                    let (_, g) = tet4::gradients(mesh.cell_points(t));
                    material(t).stress(tet4::strain(g.into_iter().zip(mesh.tets()[t].map(|v| u[v as usize]))))
                })
                .collect()
        };
        Self { values, linear }
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        if self.linear { self.values.len() / 4 } else { self.values.len() }
    }

    /// True if the stress varies in the cells.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.linear
    }

    /// The mean stress of cell `t`.
    #[must_use]
    pub fn mean(&self, t: usize) -> SymTensor {
        self.at(t, [0.25; 4])
    }

    /// The mean stress of each cell.
    #[must_use]
    pub fn means(&self) -> Vec<SymTensor> {
        (0..self.cells()).map(|t| self.mean(t)).collect()
    }

    /// The stress at barycentric coordinates of cell `t`.
    #[must_use]
    pub fn at(&self, t: usize, l: [f64; 4]) -> SymTensor {
        if !self.linear {
            return self.values[t];
        }
        let corners = &self.values[4 * t..4 * t + 4];
        std::array::from_fn(|i| corners.iter().zip(l).map(|(s, l)| l * s[i]).sum())
    }

    /// Integral of half stress times strain over each cell.
    pub fn energies(&self, mesh: &TetMesh, model: &Model) -> impl Iterator<Item = f64> {
        (0..self.cells()).map(|t| {
            let density = |s| 0.5 * model.materials[mesh.regions()[t].0 as usize].compliance_energy(s);
            if !self.linear {
                return mesh.cell_volume(t) * density(self.values[t]);
            }
            // The mean of a quadratic form of a linear field: (sum_i q(s_i) + q(sum_i s_i)) / 20.
            let corners = &self.values[4 * t..4 * t + 4];
            let sum = std::array::from_fn(|i| corners.iter().map(|s| s[i]).sum());
            let squares: f64 = corners.iter().map(|s| density(*s)).sum();
            mesh.cell_volume(t) / 20.0 * (squares + density(sum))
        })
    }
}
