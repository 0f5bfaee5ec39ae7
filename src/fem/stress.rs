//! The stress of the elements: a polynomial in each cell, with jumps between them.

use super::options::Element;
use super::quadrature::{FOUR_POINTS, FOUR_POINTS_OF};
use super::{Model, Space, SymTensor, tet4, tet10};
use glam::DVec3;
use rayon::prelude::*;

/// The vertices of a cell.
const CORNERS: [[f64; 4]; 4] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The values at the vertices of the linear function through four values at [`FOUR_POINTS`].
fn through(values: [SymTensor; 4]) -> [SymTensor; 4] {
    let [own, other] = FOUR_POINTS_OF;
    let sum: SymTensor = std::array::from_fn(|i| values.iter().map(|s| s[i]).sum());
    values.map(|s| std::array::from_fn(|i| (s[i] - other * sum[i]) / (own - other)))
}

/// The stress of nodal displacements at a point of a ten-node cell.
fn of_ten_nodes(space: &Space<'_>, model: &Model, u: &[DVec3], t: usize, l: [f64; 4]) -> SymTensor {
    let moves = space.cell(t).map(|v| u[v as usize]);
    let gradients = tet10::gradients(space.frame(t, l).1, l);
    let material = &model.materials[space.mesh().regions()[t].0 as usize];
    material.stress(tet4::strain(gradients.into_iter().zip(moves)))
}

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
    pub fn of(space: &Space<'_>, model: &Model, u: &[DVec3]) -> Self {
        let mesh = space.mesh();
        let linear = space.element() == Element::Tet10;
        let material = |t: usize| &model.materials[mesh.regions()[t].0 as usize];
        let cells = (0..mesh.tets().len()).into_par_iter();
        let values = if linear {
            cells
                .flat_map_iter(|t| {
                    let at = |l| of_ten_nodes(space, model, u, t, l);
                    // With curved edges the stress is no polynomial; that of the element is taken at four points.
                    if space.is_curved(t) { through(FOUR_POINTS.map(at)) } else { CORNERS.map(at) }
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

    /// Integral of half stress times strain over each cell, of the displacement `u` that the stress is of.
    #[must_use]
    pub fn energies(&self, space: &Space<'_>, model: &Model, u: &[DVec3]) -> Vec<f64> {
        let mesh = space.mesh();
        let energy = |t: usize| {
            let density = |s| 0.5 * model.materials[mesh.regions()[t].0 as usize].compliance_energy(s);
            if !self.linear {
                return mesh.cell_volume(t) * density(self.values[t]);
            }
            if space.is_curved(t) {
                let at = |(l, _, volume)| volume * density(of_ten_nodes(space, model, u, t, l));
                return space.cell_rule(t).into_iter().map(at).sum();
            }
            // The mean of a quadratic form q of a linear field: (sum_i q(s_i) + q(sum_i s_i)) / 20.
            let corners = &self.values[4 * t..4 * t + 4];
            let sum = std::array::from_fn(|i| corners.iter().map(|s| s[i]).sum());
            mesh.cell_volume(t) / 20.0 * (corners.iter().map(|s| density(*s)).sum::<f64>() + density(sum))
        };
        (0..self.cells()).into_par_iter().map(energy).collect()
    }
}
