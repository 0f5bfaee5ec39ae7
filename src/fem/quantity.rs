//! Single numbers of a solution: averages, maxima, values at points, totals, reactions.

use super::clip::{self, Piece, WHOLE, Weights};
use super::options::{Field, Total};
use super::{Model, Solution, SymTensor, double_contraction, von_mises};
use crate::mesh::features::face_normal;
use crate::mesh::locate::Located;
use crate::mesh::{GroupId, RegionId, TetMesh};
use glam::DVec3;

/// A named number of a solution, in terms of groups and regions, so that it holds on every refinement of the mesh it was
/// made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name in the scenario.
    pub name: String,
    /// What.
    pub kind: QuantityKind,
}

/// What a quantity is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuantityKind {
    /// Mean over an extent: on faces of the recovered stress, in cells of the stress of the elements.
    Average(Field, Extent),
    /// Maximum over an extent, of the recovered stress. Displacements by their signed component.
    Maximum(Field, Extent),
    /// Value at a point: of the recovered stress, and of the displacement by the shape functions. A point outside the mesh
    /// stands for the nearest point of the mesh.
    Value(Field, DVec3),
    /// Integral over cells.
    Total(Total, Cells),
    /// Component of the force that a support (an index into the model's) exerts.
    Reaction(usize, usize),
}

/// Where a field is averaged or searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extent {
    /// Boundary faces.
    Faces(GroupId),
    /// The inside.
    Cells(Cells),
}

/// Cells of a region (all if absent), and of these what lies inside a box (smallest and largest coordinates): cells across
/// its sides count with their part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cells {
    /// The region.
    pub region: Option<RegionId>,
    /// The box.
    pub within: Option<[DVec3; 2]>,
}

impl Cells {
    /// The pieces of cell `t` that belong here.
    fn pieces(&self, mesh: &TetMesh, t: usize) -> Vec<Piece> {
        if self.region.is_some_and(|r| r != mesh.regions()[t]) {
            return Vec::new();
        }
        match self.within {
            Some([min, max]) => clip::inside(mesh.cell_points(t), min, max),
            None => vec![WHOLE],
        }
    }

    /// Volume of what belongs here.
    #[must_use]
    pub fn volume(&self, mesh: &TetMesh) -> f64 {
        self.integral(mesh, |_| 1.0)
    }

    /// Integral of a density that is constant on each cell.
    fn integral(&self, mesh: &TetMesh, density: impl Fn(usize) -> f64) -> f64 {
        let part = |t: usize| self.pieces(mesh, t).iter().map(clip::share).sum::<f64>();
        (0..mesh.tets().len()).map(|t| (t, part(t))).map(|(t, part)| part * mesh.cell_volume(t) * density(t)).sum()
    }
}

/// A solution on its mesh, with the stress recovered at the vertices.
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    /// The mesh.
    pub mesh: &'a TetMesh,
    /// What was solved on it.
    pub model: &'a Model,
    /// The solution.
    pub solution: &'a Solution,
    /// Recovered stress at each vertex.
    pub nodal_stress: &'a [SymTensor],
}

/// Corners of the quadrature rule of degree 2 on tetrahedra: one coordinate, and the three others.
const TET_RULE: [f64; 2] = [0.585_410_196_624_968_5, 0.138_196_601_125_010_5];

/// Those of the rule of degree 2 on triangles.
const TRIANGLE_RULE: [f64; 2] = [2.0 / 3.0, 1.0 / 6.0];

impl State<'_> {
    /// The number that a quantity is; `locate` finds the cell of a point. NaN where an average has nothing to average.
    #[must_use]
    pub fn value(&self, kind: QuantityKind, locate: &dyn Fn(DVec3) -> Located) -> f64 {
        match kind {
            QuantityKind::Average(field, Extent::Faces(group)) => self.face_mean(field, group),
            QuantityKind::Average(field, Extent::Cells(cells)) => self.cell_mean(field, cells),
            QuantityKind::Maximum(field, extent) => self.maximum(field, extent),
            QuantityKind::Value(field, point) => {
                let found = locate(point);
                self.at(field, self.mesh.tets()[found.cell], found.weights)
            }
            QuantityKind::Total(what, cells) => self.total(what, cells),
            QuantityKind::Reaction(support, component) => self.solution.reactions[support][component],
        }
    }

    /// The displacement at a point of a cell.
    #[must_use]
    pub fn displacement(&self, cell: usize, weights: [f64; 4]) -> DVec3 {
        interpolate(&self.solution.displacement, self.mesh.tets()[cell], weights)
    }

    /// The recovered stress at a point of a cell.
    #[must_use]
    pub fn stress(&self, cell: usize, weights: [f64; 4]) -> SymTensor {
        self.stress_between(self.mesh.tets()[cell], weights)
    }

    fn stress_between<const N: usize>(&self, vertices: [u32; N], weights: [f64; N]) -> SymTensor {
        let mut stress = [0.0; 6];
        for (v, w) in vertices.into_iter().zip(weights) {
            stress.iter_mut().zip(self.nodal_stress[v as usize]).for_each(|(sum, s)| *sum += w * s);
        }
        stress
    }

    /// A field between vertices, of the displacement and of the recovered stress.
    fn at<const N: usize>(&self, field: Field, vertices: [u32; N], weights: [f64; N]) -> f64 {
        match field {
            field if field.is_stress() => of_stress(field, self.stress_between(vertices, weights)),
            field => of_displacement(field, interpolate(&self.solution.displacement, vertices, weights)),
        }
    }

    fn face_mean(&self, field: Field, group: GroupId) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for face in self.mesh.group_faces(group) {
            let weight = face_normal(self.mesh.points(), face.vertices).length();
            let values = (0..3).map(|i| self.at(field, face.vertices, corner_weights(TRIANGLE_RULE, i)));
            sum += weight * values.sum::<f64>() / 3.0;
            area += weight;
        }
        sum / area
    }

    fn cell_mean(&self, field: Field, cells: Cells) -> f64 {
        let (mut sum, mut volume) = (0.0, 0.0);
        for t in 0..self.mesh.tets().len() {
            for piece in cells.pieces(self.mesh, t) {
                let weight = clip::share(&piece) * self.mesh.cell_volume(t);
                let mean = if field.is_stress() {
                    of_stress(field, self.solution.stress[t])
                } else {
                    let points = (0..4).map(|i| inner_point(&piece, corner_weights(TET_RULE, i)));
                    points.map(|w| of_displacement(field, self.displacement(t, w))).sum::<f64>() / 4.0
                };
                sum += weight * mean;
                volume += weight;
            }
        }
        sum / volume
    }

    /// Fields between vertices are convex, so that their maximum over a polytope is at one of its corners.
    fn maximum(&self, field: Field, extent: Extent) -> f64 {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        match extent {
            Extent::Faces(group) => {
                let vertices = self.mesh.group_faces(group).flat_map(|f| f.vertices);
                largest(&mut vertices.map(|v| self.at(field, [v], [1.0])))
            }
            Extent::Cells(cells) => largest(&mut (0..self.mesh.tets().len()).map(|t| {
                let corners = cells.pieces(self.mesh, t).into_iter().flatten();
                largest(&mut corners.map(|w| self.at(field, self.mesh.tets()[t], w)))
            })),
        }
    }

    fn total(&self, what: Total, cells: Cells) -> f64 {
        let material = |t: usize| &self.model.materials[self.mesh.regions()[t].0 as usize];
        match what {
            Total::Volume => cells.volume(self.mesh),
            Total::Mass => cells.integral(self.mesh, |t| material(t).density),
            Total::StrainEnergy => cells.integral(self.mesh, |t| {
                let stress = self.solution.stress[t];
                0.5 * double_contraction(stress, material(t).strain(stress))
            }),
        }
    }
}

/// The `i`-th point of a rule with one point a corner.
fn corner_weights<const N: usize>([own, other]: [f64; 2], i: usize) -> [f64; N] {
    std::array::from_fn(|j| if i == j { own } else { other })
}

/// A point of a piece, seen from its cell.
fn inner_point(piece: &Piece, at: Weights) -> Weights {
    std::array::from_fn(|i| piece.iter().zip(at).map(|(corner, w)| w * corner[i]).sum())
}

fn interpolate<const N: usize>(values: &[DVec3], vertices: [u32; N], weights: [f64; N]) -> DVec3 {
    vertices.into_iter().zip(weights).map(|(v, w)| w * values[v as usize]).sum()
}

fn of_displacement(field: Field, u: DVec3) -> f64 {
    match field {
        Field::Ux => u.x,
        Field::Uy => u.y,
        Field::Uz => u.z,
        _ => u.length(),
    }
}

fn of_stress(field: Field, s: SymTensor) -> f64 {
    match field {
        Field::Sxx => s[0],
        Field::Syy => s[1],
        Field::Szz => s[2],
        Field::Sxy => s[3],
        Field::Syz => s[4],
        Field::Sxz => s[5],
        _ => von_mises(s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The pieces of all cells fill the common part of two boxes, whatever planes cut them.
        #[test]
        fn the_part_of_a_mesh_in_a_box_has_the_volume_of_the_overlap(
            a in prop::array::uniform3(-0.5_f64..1.5), b in prop::array::uniform3(-0.5_f64..1.5)
        ) {
            let mesh = box_tets([1.0; 3], [2, 3, 2]).unwrap();
            let (a, b) = (DVec3::from_array(a), DVec3::from_array(b));
            let (min, max) = (a.min(b), a.max(b));
            let overlap = (max.min(DVec3::ONE) - min.max(DVec3::ZERO)).max(DVec3::ZERO).element_product();
            let cells = Cells { region: None, within: Some([min, max]) };
            prop_assert!((cells.volume(&mesh) - overlap).abs() < 1e-13);
        }
    }
}
