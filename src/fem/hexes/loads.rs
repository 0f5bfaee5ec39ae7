//! Integrals over the limit geometry, for loads and foundations.

use super::super::FemError;
use super::super::loads::{InCell, Integrals, OnFace};
use super::rule::Quadrature;
use super::{HexLocator, HexSpace, face_area};
use crate::mesh::GroupId;
use glam::DVec3;

/// Gauss points a direction for loads: exact for cubic functions times cubic loads on straight cells.
const POINTS: usize = 5;

/// Visits the Gauss points of a group's faces with the functions there: (function, value), the place and the area vector.
pub(super) fn on_faces(space: &HexSpace<'_>, group: GroupId, visit: &mut OnFace<'_>) -> Result<(), FemError> {
    let rules: [Quadrature; 6] = std::array::from_fn(|k| Quadrature::on_face(space, k, POINTS));
    let mut functions = Vec::new();
    for face in space.mesh().group_faces(group) {
        let (t, k) = space.cell_of_face(face);
        let (weights, table) = rules[k].of(space, t);
        for (q, weight) in weights.iter().enumerate() {
            let (x, jacobian) = space.frame(t, &table, q);
            functions.clear();
            functions.extend(space.cell(t).iter().copied().zip(table.values_at(q).iter().copied()));
            visit(&functions, x, *weight * face_area(k, &jacobian))?;
        }
    }
    Ok(())
}

impl Integrals for HexSpace<'_> {
    fn functions(&self) -> usize {
        self.points.len()
    }

    fn region(&self, cell: usize) -> usize {
        self.mesh.regions()[cell].0 as usize
    }

    fn on_faces(&self, group: GroupId, visit: &mut OnFace<'_>) -> Result<(), FemError> {
        on_faces(self, group, visit)
    }

    fn in_cells(&self, visit: &mut InCell<'_>) -> Result<(), FemError> {
        let quadrature = Quadrature::new(self, POINTS);
        let mut functions = Vec::new();
        for t in 0..self.mesh.cells().len() {
            let (weights, table) = quadrature.of(self, t);
            for (q, weight) in weights.iter().enumerate() {
                let (x, jacobian) = self.frame(t, &table, q);
                functions.clear();
                functions.extend(self.cell(t).iter().copied().zip(table.values_at(q).iter().copied()));
                visit(t, &functions, x, weight * jacobian.determinant())?;
            }
        }
        Ok(())
    }

    fn at_place(&self, x: DVec3) -> Vec<(u32, f64)> {
        let found = HexLocator::new(self).nearest(x);
        let table = self.table(self.class(found.cell), &[found.at]);
        self.cell(found.cell).iter().copied().zip(table.values).collect()
    }
}
