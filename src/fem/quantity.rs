//! Single numbers of a solution: averages, maxima, values at points, totals, reactions.

use super::clip::{self, Piece, WHOLE, Weights};
use super::options::{Field, Total};
use super::quadrature::FOUR_POINTS;
use super::{Model, Solution, Space, SymTensor, von_mises};
use crate::mesh::locate::Located;
use crate::mesh::quality::EDGES;
use crate::mesh::{Face, GroupId, RegionId, TetMesh, topology};
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
        let part = |t: usize| self.pieces(mesh, t).iter().map(clip::share).sum::<f64>();
        (0..mesh.tets().len()).map(|t| part(t) * mesh.cell_volume(t)).sum()
    }

    /// Points of cell `t` with their volumes, for integrals over the part of it that belongs here.
    pub(super) fn points(&self, space: &Space<'_>, t: usize) -> Vec<(Weights, f64)> {
        let mesh = space.mesh();
        if space.is_curved(t) {
            return self.curved_points(space, t);
        }
        let pieces = self.pieces(mesh, t);
        let points = |piece: &Piece| {
            let volume = clip::share(piece) * mesh.cell_volume(t) / 4.0;
            FOUR_POINTS.map(|l| (inner_point(piece, l), volume))
        };
        pieces.iter().flat_map(points).collect()
    }

    /// Those of a curved cell. Across the sides of a box it is cut as if it consisted of 64 straight ones.
    fn curved_points(&self, space: &Space<'_>, t: usize) -> Vec<(Weights, f64)> {
        if self.region.is_some_and(|r| r != space.mesh().regions()[t]) {
            return Vec::new();
        }
        let inside = |[min, max]: [DVec3; 2]| {
            let within = |v: u32| {
                let x = space.points()[v as usize];
                x.cmpge(min).all() && x.cmple(max).all()
            };
            space.cell(t).all(within)
        };
        let Some([min, max]) = self.within.filter(|within| !inside(*within)) else {
            return space.cell_rule(t).map(|(l, _, volume)| (l, volume)).to_vec();
        };
        let mut points = Vec::new();
        for part in clip::halves(WHOLE).into_iter().flat_map(clip::halves) {
            for piece in clip::inside(part.map(|l| space.position(t, l)), min, max) {
                let share = clip::share(&piece) * clip::share(&part) / 4.0;
                points.extend(FOUR_POINTS.map(|l| {
                    let l = inner_point(&part, inner_point(&piece, l));
                    (l, share * space.frame(t, l).0)
                }));
            }
        }
        points
    }

    /// The volume of all these points.
    pub(super) fn points_volume(&self, space: &Space<'_>) -> f64 {
        let of_cell = |t| self.points(space, t).into_iter().map(|(_, volume)| volume).sum::<f64>();
        (0..space.mesh().tets().len()).map(of_cell).sum()
    }
}

/// A solution on its mesh, with the recovered stress.
#[derive(Clone, Copy)]
pub struct State<'a> {
    /// The mesh and its nodes.
    pub space: &'a Space<'a>,
    /// What was solved on it.
    pub model: &'a Model,
    /// The solution.
    pub solution: &'a Solution,
    /// Recovered stress at the nodes of a cell, of the cell's region: where regions meet, stress may jump.
    pub recovered: &'a dyn Fn(usize) -> [SymTensor; 10],
}

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
                self.at(field, found.cell, found.weights)
            }
            QuantityKind::Total(what, cells) => self.total(what, cells),
            QuantityKind::Reaction(support, component) => self.solution.reactions[support][component],
        }
    }

    /// The displacement at a point of a cell.
    #[must_use]
    pub fn displacement(&self, cell: usize, weights: [f64; 4]) -> DVec3 {
        self.space.interpolate(&self.solution.displacement, cell, weights)
    }

    /// The recovered stress at a point of a cell.
    #[must_use]
    pub fn stress(&self, cell: usize, weights: [f64; 4]) -> SymTensor {
        let mut stress = [0.0; 6];
        for (s, n) in (self.recovered)(cell).iter().zip(self.space.shape(weights)) {
            stress.iter_mut().zip(s).for_each(|(sum, s)| *sum += n * s);
        }
        stress
    }

    /// A field at a point of a cell, of the displacement and of the recovered stress.
    fn at(&self, field: Field, cell: usize, weights: Weights) -> f64 {
        if field.is_stress() {
            of_stress(field, self.stress(cell, weights))
        } else {
            of_displacement(field, self.displacement(cell, weights))
        }
    }

    /// The faces of a group, each with its cell.
    fn faces(&self, group: GroupId) -> impl Iterator<Item = (&Face, usize)> {
        let mesh = self.space.mesh();
        let cells = topology::boundary_cells(mesh.tets());
        let inside = move |face: &Face| mesh.patch_groups()[face.patch.0 as usize].contains(&group);
        mesh.faces().iter().zip(cells).filter(move |(face, _)| inside(face)).map(|(face, t)| (face, t as usize))
    }

    /// Barycentric coordinates in a cell of a point of one of its faces.
    fn in_cell(&self, cell: usize, face: &Face, l: [f64; 3]) -> Weights {
        let place = |v: u32| face.vertices.iter().position(|&w| w == v).map_or(0.0, |k| l[k]);
        self.space.mesh().tets()[cell].map(place)
    }

    fn face_mean(&self, field: Field, group: GroupId) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for (face, cell) in self.faces(group) {
            for (l, _, weight) in self.space.face_rule(face) {
                let weight = weight.length();
                sum += weight * self.at(field, cell, self.in_cell(cell, face, l));
                area += weight;
            }
        }
        sum / area
    }

    fn cell_mean(&self, field: Field, cells: Cells) -> f64 {
        let (mut sum, mut volume) = (0.0, 0.0);
        for t in 0..self.space.mesh().tets().len() {
            for (l, weight) in cells.points(self.space, t) {
                let value = if field.is_stress() {
                    of_stress(field, self.solution.stress.at(t, l))
                } else {
                    of_displacement(field, self.displacement(t, l))
                };
                sum += weight * value;
                volume += weight;
            }
        }
        sum / volume
    }

    /// The largest value at nodes and at corners of cut cells. Between the nodes of four-node cells fields are convex, so
    /// that there is none larger; between those of ten-node cells there may be.
    fn maximum(&self, field: Field, extent: Extent) -> f64 {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        let mesh = self.space.mesh();
        let quadratic = !self.space.midside().is_empty();
        match extent {
            Extent::Faces(group) => {
                let corners = (0..3).map(|k| std::array::from_fn(|i| f64::from(u8::from(i == k))));
                let middles = (0..3).map(|k| std::array::from_fn(|i| if i == k { 0.0 } else { 0.5 }));
                let nodes: Vec<[f64; 3]> = corners.chain(middles.take(if quadratic { 3 } else { 0 })).collect();
                let of_face = |(face, cell): (&Face, usize)| {
                    largest(&mut nodes.iter().map(|l| self.at(field, cell, self.in_cell(cell, face, *l))))
                };
                largest(&mut self.faces(group).map(of_face))
            }
            Extent::Cells(cells) => largest(&mut (0..mesh.tets().len()).map(|t| {
                let pieces = cells.pieces(mesh, t);
                let middle = |[i, j]: [usize; 2]| std::array::from_fn(|k| if k == i || k == j { 0.5 } else { 0.0 });
                let middles = EDGES.map(middle);
                let middles = if quadratic && pieces == [WHOLE] { &middles[..] } else { &[] };
                largest(&mut pieces.iter().flatten().chain(middles).map(|w| self.at(field, t, *w)))
            })),
        }
    }

    fn total(&self, what: Total, cells: Cells) -> f64 {
        let mesh = self.space.mesh();
        let cell = |t: usize| {
            let material = &self.model.materials[mesh.regions()[t].0 as usize];
            let density = |l| match what {
                Total::Volume => 1.0,
                Total::Mass => material.density,
                Total::StrainEnergy => 0.5 * material.compliance_energy(self.solution.stress.at(t, l)),
            };
            cells.points(self.space, t).into_iter().map(|(l, volume)| volume * density(l)).sum::<f64>()
        };
        (0..mesh.tets().len()).map(cell).sum()
    }
}

/// A point of a piece, seen from its cell.
fn inner_point(piece: &Piece, at: Weights) -> Weights {
    std::array::from_fn(|i| piece.iter().zip(at).map(|(corner, w)| w * corner[i]).sum())
}

pub(super) fn of_displacement(field: Field, u: DVec3) -> f64 {
    match field {
        Field::Ux => u.x,
        Field::Uy => u.y,
        Field::Uz => u.z,
        _ => u.length(),
    }
}

pub(super) fn of_stress(field: Field, s: SymTensor) -> f64 {
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
    use crate::fem::options::Element;
    use crate::mesh::generate::box_tets;
    use crate::mesh::midside::Midside;
    use crate::mesh::topology;
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

    /// The cube whose cells x = c become `x = c + y (1 - y) / 2`, which ten nodes represent and which keeps volumes: of a box at
    /// x < 1/2 the integral of `1/2 - y (1 - y) / 2` belongs to it.
    #[test]
    fn boxes_cut_curved_cells_as_they_are() {
        let bend = |p: DVec3| p + 0.5 * p.y * (1.0 - p.y) * DVec3::X;
        let flat = box_tets([1.0; 3], [2; 3]).unwrap();
        let middle = |edge: [u32; 2]| {
            let [p, q] = edge.map(|v| flat.points()[v as usize]);
            Midside { edge, position: bend(p.midpoint(q)) }
        };
        let midsides: Vec<Midside> = topology::edges(flat.tets()).into_iter().map(middle).collect();
        let mut parts = flat.into_parts();
        parts.points.iter_mut().for_each(|p| *p = bend(*p));
        let mesh = TetMesh::new(parts).unwrap();
        let space = Space::new(&mesh, Element::Tet10, &midsides);
        let within = Some([DVec3::new(-1.0, 0.2, 0.1), DVec3::new(0.5, 0.7, 0.8)]);
        let volume = Cells { region: None, within }.points_volume(&space);
        let under = |y: f64| y / 2.0 - y * y / 4.0 + y.powi(3) / 6.0;
        let exact = 0.7 * (under(0.7) - under(0.2));
        // Four parts along an edge leave a sixteenth of the 8 % that straight cells are off.
        assert!((volume - exact).abs() < 6e-3 * exact, "{volume} {exact}");
        let all = Cells { region: None, within: Some([DVec3::splat(-1.0), DVec3::splat(2.0)]) };
        assert!((all.points_volume(&space) - 1.0).abs() < 1e-13);
    }
}
