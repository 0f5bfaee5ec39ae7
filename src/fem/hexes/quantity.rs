//! Single numbers of a solution on hexahedra.

use super::super::options::{Field, Total};
use super::super::quantity::{of_displacement, of_stress};
use super::super::{Cells, Extent, Model, QuantityKind, SymTensor};
use super::rule::Quadrature;
use super::stress::material;
use super::{HexLocator, HexSolution, HexSpace, RecoveredStress, Rule, face_area};
use crate::limit::Table;
use glam::DVec3;

/// Gauss points a direction for means, and lattice points a direction for maxima.
const POINTS: usize = 5;

/// A solution with its recovered stress.
#[derive(Clone, Copy)]
pub struct HexState<'a> {
    /// The mesh and its functions.
    pub space: &'a HexSpace<'a>,
    /// What was solved on it.
    pub model: &'a Model,
    /// The solution.
    pub solution: &'a HexSolution,
    /// Its stress, recovered.
    pub recovered: &'a RecoveredStress,
}

impl HexState<'_> {
    /// The number that a quantity is: of the recovered stress, but for means over cells, as on tetrahedra. Boxes do not cut
    /// cells here: the whole of each cell of the region counts.
    #[must_use]
    pub fn value(&self, kind: QuantityKind, locator: &HexLocator<'_, '_>) -> f64 {
        match kind {
            QuantityKind::Average(field, Extent::Faces(group)) => {
                let (mut sum, mut area) = (0.0, 0.0);
                self.on_faces(group, |t, k, table, q, weight| {
                    let weight = weight * face_area(k, &self.space.frame(t, table, q).1).length();
                    sum += weight * self.at(field, t, table, q);
                    area += weight;
                });
                sum / area
            }
            QuantityKind::Average(field, Extent::Cells(cells)) => {
                let of = |t, table: &Table, q| match field.is_stress() {
                    true => of_stress(field, self.solution.stress(self.space, self.model, t, table, q)),
                    false => of_displacement(field, self.displacement(t, table, q)),
                };
                self.integral(cells, of) / self.integral(cells, |_, _, _| 1.0)
            }
            QuantityKind::Maximum(field, extent) => self.maximum(field, extent),
            QuantityKind::Value(field, point) => {
                let found = locator.nearest(point);
                let table = self.space.table(self.space.class(found.cell), &[found.at]);
                self.at(field, found.cell, &table, 0)
            }
            QuantityKind::Total(what, cells) => self.integral(cells, |t, table, q| {
                let material = material(self.space, self.model, t);
                match what {
                    Total::Volume => 1.0,
                    Total::Mass => material.density,
                    Total::StrainEnergy => {
                        0.5 * material.compliance_energy(self.solution.stress(self.space, self.model, t, table, q))
                    }
                }
            }),
            QuantityKind::Reaction(support, component) => self.solution.reactions[support][component],
        }
    }

    /// The displacement at point `q` of a table of cell `t`.
    #[must_use]
    pub fn displacement(&self, t: usize, table: &Table, q: usize) -> DVec3 {
        self.space.interpolate(&self.solution.displacement, t, table, q)
    }

    /// The recovered stress at point `q` of a table of cell `t`.
    #[must_use]
    pub fn stress(&self, t: usize, table: &Table, q: usize) -> SymTensor {
        self.recovered.at(self.space, t, table, q)
    }

    fn at(&self, field: Field, t: usize, table: &Table, q: usize) -> f64 {
        if field.is_stress() {
            of_stress(field, self.stress(t, table, q))
        } else {
            of_displacement(field, self.displacement(t, table, q))
        }
    }

    /// Visits the Gauss points of a group's faces: cell, its face, table, point, weight.
    fn on_faces(&self, group: crate::mesh::GroupId, mut visit: impl FnMut(usize, usize, &Table, usize, f64)) {
        let rules: [Rule; 6] = std::array::from_fn(|k| Rule::face(k, POINTS));
        let tables: [super::Tables; 6] = std::array::from_fn(|k| self.space.tables(rules[k].points.clone()));
        for face in self.space.mesh().group_faces(group) {
            let (t, k) = self.space.cell_of_face(face);
            let table = tables[k].of(self.space, t);
            rules[k].weights.iter().enumerate().for_each(|(q, w)| visit(t, k, &table, q, *w));
        }
    }

    fn integral(&self, cells: Cells, of: impl Fn(usize, &Table, usize) -> f64 + Sync) -> f64 {
        let quadrature = Quadrature::new(self.space, POINTS);
        let sums = self.space.of_cells(|t| {
            if cells.region.is_some_and(|r| r != self.space.mesh().regions()[t]) {
                return 0.0;
            }
            let (weights, table) = quadrature.of(self.space, t);
            let point = |(q, w): (usize, &f64)| w * self.space.frame(t, &table, q).1.determinant() * of(t, &table, q);
            weights.iter().enumerate().map(point).sum::<f64>()
        });
        sums.iter().sum()
    }

    /// The largest value at the points of a lattice in each cell or face.
    fn maximum(&self, field: Field, extent: Extent) -> f64 {
        let side = |i: usize| i as f64 / (POINTS - 1) as f64;
        let lattice: Vec<DVec3> = (0..POINTS.pow(3))
            .map(|i| DVec3::new(side(i % POINTS), side(i / POINTS % POINTS), side(i / POINTS / POINTS)))
            .collect();
        let tables = self.space.tables(lattice);
        let of = |t: usize, wanted: &dyn Fn(DVec3) -> bool| {
            let table = tables.of(self.space, t);
            let points = (0..tables.points().len()).filter(|q| wanted(tables.points()[*q]));
            points.map(|q| self.at(field, t, &table, q)).fold(f64::NEG_INFINITY, f64::max)
        };
        match extent {
            Extent::Cells(cells) => {
                let inside = |t: &usize| cells.region.is_none_or(|r| r == self.space.mesh().regions()[*t]);
                (0..self.space.mesh().cells().len())
                    .filter(inside)
                    .map(|t| of(t, &|_| true))
                    .fold(f64::NEG_INFINITY, f64::max)
            }
            Extent::Faces(group) => {
                let faces = self.space.mesh().group_faces(group).map(|f| self.space.cell_of_face(f));
                let face = |(t, k): (usize, usize)| of(t, &|p| p[k / 2] == (k % 2) as f64);
                faces.map(face).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}
