//! Elements on hexahedral meshes: Lagrange elements of 8, 20 and 27 nodes, and Catmull-Clark solids.
//!
//! All of them are isoparametric and look alike: a cell has a list of functions, whose values and derivatives at points of its
//! unit cube stand in a table shared by all cells of its class; a function's coefficient is a vector, of the position (its
//! node or control point) as of the displacement. Bubbles have no position: their coefficient is zero.

mod error;
mod lagrange;
mod lattice;
mod loads;
mod matrix;
mod nitsche;
mod patches;
mod places;
mod quantity;
mod recovery;
mod rule;
mod shared;
mod stress;
mod supports;
mod system;
#[cfg(test)]
mod tests;

pub use error::HexErrors;
pub use lattice::Lattice;
pub use matrix::check_hex_shapes;
pub use places::HexLocator;
pub use quantity::HexState;
pub use recovery::RecoveredStress;
pub use rule::Rule;
pub use stress::{HexSolution, recover_hexes};
pub use supports::{check_hex_constraints, common_edges, prescribed_on_hexes};
pub use system::assemble_hexes;

use super::SymTensor;
use super::options::{HexElement, HexOptions};
use crate::limit::{Basis, Part, Table};
use crate::mesh::hex::HexMesh;
use glam::{DMat3, DVec3};
use lagrange::Lagrange;
use rayon::prelude::*;
use shared::Shared;
use std::borrow::Cow;
use std::ops::Range;

/// A mesh with the functions of its elements.
#[derive(Debug)]
pub struct HexSpace<'m> {
    mesh: &'m HexMesh,
    element: HexElement,
    options: HexOptions,
    points: Vec<DVec3>,
    functions: Functions,
}

#[derive(Debug)]
enum Functions {
    Lagrange(Lagrange),
    Limit(Basis),
}

/// The functions of all cells at the same points of their unit cubes.
#[derive(Debug)]
pub struct Tables {
    points: Vec<DVec3>,
    tables: Shared<Table>,
}

/// The functions of a cell at one point, with their physical derivatives.
#[derive(Debug, Clone, Default)]
pub struct AtPoint {
    /// Where it is.
    pub x: DVec3,
    /// Determinant of the Jacobian.
    pub determinant: f64,
    /// Columns: derivatives of the position along the axes of the unit cube.
    pub jacobian: DMat3,
    /// Gradients of the functions.
    pub gradients: Vec<DVec3>,
}

impl<'m> HexSpace<'m> {
    /// The space of an element on a mesh, which Catmull-Clark elements take for a control mesh that
    /// [`HexMesh::check_smoothable`] accepts.
    #[must_use]
    pub fn new(mesh: &'m HexMesh, element: HexElement, options: HexOptions) -> Self {
        let functions = match element {
            HexElement::Hex8 | HexElement::Hex20 | HexElement::Hex27 => {
                Functions::Lagrange(Lagrange::new(mesh, element))
            }
            HexElement::CatmullClark => Functions::Limit(Basis::new(mesh, options.masks, false)),
            HexElement::CatmullClarkPlus => Functions::Limit(Basis::new(mesh, options.masks, true)),
        };
        let points = match &functions {
            Functions::Lagrange(lagrange) => lagrange.points(mesh),
            Functions::Limit(basis) => {
                let mut points = mesh.points().to_vec();
                points.resize(basis.len(), DVec3::ZERO);
                points
            }
        };
        Self { mesh, element, options, points, functions }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &'m HexMesh {
        self.mesh
    }

    /// The element.
    #[must_use]
    pub fn element(&self) -> HexElement {
        self.element
    }

    /// The coefficients of the position: nodes or control points; zero for bubbles.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// A place for each function: of bubbles that of their vertices.
    #[must_use]
    pub fn whereabouts(&self) -> Vec<DVec3> {
        let mut places = self.points.clone();
        if let Functions::Limit(basis) = &self.functions {
            let vertices = self.mesh.points().len();
            let own = basis.bubbles().iter().map(|b| self.points[b.vertex as usize]);
            places.truncate(vertices);
            places.extend(own);
        }
        places
    }

    /// How many vertices of the boundary have no bubble, and how many there are.
    #[must_use]
    pub fn without_bubbles(&self) -> (usize, usize) {
        let mut vertices: Vec<u32> = self.mesh.faces().iter().flat_map(|f| f.vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut own: Vec<u32> = match &self.functions {
            Functions::Lagrange(_) => Vec::new(),
            Functions::Limit(basis) => basis.bubbles().iter().map(|b| b.vertex).collect(),
        };
        own.dedup();
        (vertices.len().saturating_sub(own.len()), vertices.len())
    }

    /// Number of functions with a coefficient of the position: all but bubbles, which come last.
    #[must_use]
    pub fn placed(&self) -> usize {
        match &self.functions {
            Functions::Lagrange(_) => self.points.len(),
            Functions::Limit(_) => self.mesh.points().len(),
        }
    }

    /// The functions that do not vanish on cell `t`, in the order of its tables.
    #[must_use]
    pub fn cell(&self, t: usize) -> &[u32] {
        match &self.functions {
            Functions::Lagrange(lagrange) => lagrange.cell(t),
            Functions::Limit(basis) => basis.cell(t),
        }
    }

    /// The class of a cell: cells of one class have the same tables.
    #[must_use]
    pub fn class(&self, t: usize) -> usize {
        match &self.functions {
            Functions::Lagrange(_) => 0,
            Functions::Limit(basis) => basis.class(t),
        }
    }

    /// Number of classes.
    #[must_use]
    pub fn classes(&self) -> usize {
        match &self.functions {
            Functions::Lagrange(_) => 1,
            Functions::Limit(basis) => basis.classes(),
        }
    }

    /// Whether the cells of a class are cubic polynomials: inside a regular grid of control points, or at its boundary.
    #[must_use]
    pub fn is_regular(&self, class: usize) -> bool {
        match &self.functions {
            Functions::Lagrange(_) => true,
            Functions::Limit(basis) => basis.is_regular(class),
        }
    }

    /// Whether several cells are of a class.
    pub(super) fn is_shared(&self, class: usize) -> bool {
        match &self.functions {
            Functions::Lagrange(_) => true,
            Functions::Limit(basis) => basis.is_shared(class),
        }
    }

    /// The parts of the unit cube, halved `depth` times at most, in which the functions of a class are polynomials or which are
    /// too small to be halved again.
    pub(super) fn parts(&self, class: usize, depth: u32) -> Vec<Part> {
        match &self.functions {
            Functions::Lagrange(_) => vec![(DVec3::ZERO, 1.0)],
            Functions::Limit(basis) => basis.parts(class, depth),
        }
    }

    /// The functions of all cells at points of the unit cube.
    #[must_use]
    pub fn tables(&self, points: Vec<DVec3>) -> Tables {
        Tables { points, tables: Shared::new(self) }
    }

    /// The functions of a class as others that do not depend on each other, see [`Basis::lifted`].
    pub(super) fn lifted(&self, class: usize, functions: usize) -> Vec<Option<Vec<(usize, f64)>>> {
        match &self.functions {
            Functions::Lagrange(_) => (0..functions).map(|v| Some(vec![(v, 1.0)])).collect(),
            Functions::Limit(basis) => basis.lifted(class),
        }
    }

    /// The coefficients of a field of tensors given by those of [`HexSpace::lifted`] functions.
    pub(super) fn lowered(&self, lifted: Vec<SymTensor>) -> Vec<SymTensor> {
        let Functions::Limit(basis) = &self.functions else { return lifted };
        basis.lowered(&lifted, |terms| {
            let mut sum = [0.0; 6];
            terms.for_each(|(term, scale)| sum.iter_mut().zip(term).for_each(|(sum, x)| *sum += scale * x));
            sum
        })
    }

    /// The functions of one class at points of the unit cube.
    #[must_use]
    pub fn table(&self, class: usize, points: &[DVec3]) -> Table {
        match &self.functions {
            Functions::Lagrange(lagrange) => lagrange.table(points),
            Functions::Limit(basis) => basis.table(class, points),
        }
    }

    /// How the elements are made and integrated.
    #[must_use]
    pub fn options(&self) -> HexOptions {
        self.options
    }

    /// Gauss points a direction of the stiffness of a class: those asked for, else what suits the element, and one more where it
    /// is no polynomial.
    #[must_use]
    pub fn gauss_points(&self, class: usize) -> usize {
        self.options.points.unwrap_or(self.degree() + 1 + usize::from(!self.is_regular(class)))
    }

    /// Degree of the functions in each coordinate, where they are polynomials.
    #[must_use]
    pub fn degree(&self) -> usize {
        match self.element {
            HexElement::Hex8 => 1,
            HexElement::Hex20 | HexElement::Hex27 => 2,
            HexElement::CatmullClark | HexElement::CatmullClarkPlus => 3,
        }
    }

    /// Position and Jacobian of cell `t` at point `q` of a table.
    #[must_use]
    pub fn frame(&self, t: usize, table: &Table, q: usize) -> (DVec3, DMat3) {
        let (mut x, mut jacobian) = (DVec3::ZERO, DMat3::ZERO);
        for ((&v, n), dn) in self.cell(t).iter().zip(table.values_at(q)).zip(table.gradients_at(q)) {
            let p = self.points[v as usize];
            x += *n * p;
            jacobian.x_axis += dn.x * p;
            jacobian.y_axis += dn.y * p;
            jacobian.z_axis += dn.z * p;
        }
        (x, jacobian)
    }

    /// The functions of cell `t` at point `q` of a table, in the physical frame; `at` is overwritten.
    pub fn at_point(&self, t: usize, table: &Table, q: usize, at: &mut AtPoint) {
        (at.x, at.jacobian) = self.frame(t, table, q);
        at.determinant = at.jacobian.determinant();
        let inverse = at.jacobian.inverse().transpose();
        at.gradients.clear();
        at.gradients.extend(table.gradients_at(q).iter().map(|dn| inverse * *dn));
    }

    /// A field given by coefficients, at point `q` of a table.
    #[must_use]
    pub fn interpolate(&self, coefficients: &[DVec3], t: usize, table: &Table, q: usize) -> DVec3 {
        self.cell(t).iter().zip(table.values_at(q)).map(|(&v, n)| *n * coefficients[v as usize]).sum()
    }

    /// Something of each cell, computed in parallel.
    pub(super) fn of_cells<T: Send>(&self, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        self.of_some_cells(0..self.mesh.cells().len(), of)
    }

    /// Something of each of some cells, computed in parallel.
    pub(super) fn of_some_cells<T: Send>(&self, cells: Range<usize>, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        cells.into_par_iter().map(of).collect()
    }

    /// The cell of a boundary face (an index into [`HexMesh::faces`]) and its face there.
    #[must_use]
    pub fn cell_of_face(&self, face: usize) -> (usize, usize) {
        let topology = self.mesh.topology();
        let number = topology.boundary_number(face);
        let t = topology.face_cells()[number as usize][0] as usize;
        (t, topology.cell_faces()[t].iter().position(|f| *f == number).unwrap_or(0))
    }
}

impl Tables {
    /// The table of cell `t`.
    #[must_use]
    pub fn of(&self, space: &HexSpace<'_>, t: usize) -> Cow<'_, Table> {
        let class = space.class(t);
        self.tables.of(space, class, || space.table(class, &self.points))
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }
}

/// The outward area vector of face `k` of a cell (see [`crate::mesh::hex::FACES`]) per area of the unit square.
pub(super) fn face_area(k: usize, jacobian: &DMat3) -> DVec3 {
    let axis = k / 2;
    let (u, v) = (jacobian.col((axis + 1) % 3), jacobian.col((axis + 2) % 3));
    if k % 2 == 1 { u.cross(v) } else { v.cross(u) }
}
