//! The cells that show hexahedral elements: Lagrange cells through the points of a lattice, Bezier cells, or small linear ones.

use super::options::HexCells;
use super::vtk::Values;
use crate::fem::hexes::{HexSpace, Lattice};
use crate::mesh::hex::to_vtk_order;
use rustc_hash::FxHashMap;
use vtkio::model::{Attribute, CellType};

/// Cells of a file with its points.
pub(super) struct Shown {
    pub kinds: Vec<CellType>,
    pub connectivity: Vec<u64>,
    pub offsets: Vec<u64>,
    /// Cells of the file that show an element.
    pub each: usize,
    points: Vec<Source>,
}

/// What a point of the file holds.
#[derive(Clone, Copy)]
enum Source {
    /// The values at a point of the lattice.
    At(u32),
    /// The Bernstein coefficients at a place of a cell's lattice.
    Coefficient(u32, u32),
}

/// Degree of Bezier cells.
const CUBIC: usize = 3;

/// Makes of the values of a cubic polynomial at 0, 1/3, 2/3 and 1 its Bernstein coefficients, row by row, in sixths.
const BERNSTEIN: [[f64; 4]; 4] =
    [[6.0, 0.0, 0.0, 0.0], [-5.0, 18.0, -9.0, 2.0], [2.0, -9.0, 18.0, -5.0], [0.0, 0.0, 0.0, 6.0]];

impl Shown {
    pub fn new(space: &HexSpace<'_>, lattice: &Lattice, how: HexCells) -> Self {
        let every = || (0..lattice.sources.len() as u32).map(Source::At).collect();
        match how {
            HexCells::Linear => Self { points: every(), ..Self::linear(lattice) },
            HexCells::Bezier if lattice.order == CUBIC => Self::bezier(space, lattice),
            _ => Self { points: every(), ..Self::curved(lattice) },
        }
    }

    /// A cell of the lattice's order for each element, without points.
    fn curved(lattice: &Lattice) -> Self {
        let (order, side) = (lattice.order, (lattice.order + 1).pow(3));
        let places = vtk_places(order);
        let kind = if order == 1 { CellType::Hexahedron } else { CellType::LagrangeHexahedron };
        let connectivity: Vec<u64> =
            lattice.cells.chunks_exact(side).flat_map(|own| places.iter().map(|&q| u64::from(own[q]))).collect();
        let cells = lattice.cells.len() / side;
        let offsets = (1..=cells as u64).map(|c| c * side as u64).collect();
        Self { kinds: vec![kind; cells], connectivity, offsets, each: 1, points: Vec::new() }
    }

    /// The lattice's own small cells, without points.
    fn linear(lattice: &Lattice) -> Self {
        let (order, side) = (lattice.order, lattice.order + 1);
        let mut connectivity = Vec::new();
        for own in lattice.cells.chunks_exact(side.pow(3)) {
            for small in 0..order.pow(3) {
                let lowest = small % order + side * (small / order % order + side * (small / order / order));
                let corner = |c: u32| lowest as u32 + (c & 1) + side as u32 * ((c >> 1 & 1) + side as u32 * (c >> 2));
                let corners = to_vtk_order(std::array::from_fn(|c| corner(c as u32)));
                connectivity.extend(corners.map(|q| u64::from(own[q as usize])));
            }
        }
        let cells = connectivity.len() / 8;
        let offsets = (1..=cells as u64).map(|c| 8 * c).collect();
        Self { kinds: vec![CellType::Hexahedron; cells], connectivity, offsets, each: order.pow(3), points: Vec::new() }
    }

    /// Bezier cells where elements are polynomials, Lagrange cells elsewhere. Corners are the same points for both.
    fn bezier(space: &HexSpace<'_>, lattice: &Lattice) -> Self {
        let mut shown = Self::curved(lattice);
        let side = (CUBIC + 1).pow(3);
        let places = vtk_places(CUBIC);
        // Points by the lattice's number and whether they are coefficients.
        let mut numbers: FxHashMap<(u32, bool), u64> = FxHashMap::default();
        shown.connectivity.clear();
        for (t, own) in lattice.cells.chunks_exact(side).enumerate() {
            let regular = space.is_regular(space.class(t));
            if regular {
                shown.kinds[t] = CellType::BezierHexahedron;
            }
            for &q in &places {
                let is_corner = [q % 4, q / 4 % 4, q / 16].iter().all(|i| i % CUBIC == 0);
                let coefficient = regular && !is_corner;
                let next = shown.points.len() as u64;
                shown.connectivity.push(*numbers.entry((own[q], coefficient)).or_insert_with(|| {
                    shown.points.push(if coefficient {
                        Source::Coefficient(t as u32, q as u32)
                    } else {
                        Source::At(own[q])
                    });
                    next
                }));
            }
        }
        shown
    }

    /// The values of a field at the lattice's points, so many components each, as the file's points hold them.
    pub fn at_points(&self, lattice: &Lattice, values: &[f64], width: usize) -> Vec<f64> {
        let mut all = Vec::with_capacity(width * self.points.len());
        for source in &self.points {
            match *source {
                Source::At(p) => all.extend(&values[width * p as usize..][..width]),
                Source::Coefficient(t, q) => {
                    let own = &lattice.cells[64 * t as usize..][..64];
                    let q = q as usize;
                    let rows = [q % 4, q / 4 % 4, q / 16].map(|i| BERNSTEIN[i]);
                    all.extend((0..width).map(|c| {
                        let term = |i: usize| {
                            let weight = rows[0][i % 4] * rows[1][i / 4 % 4] * rows[2][i / 16];
                            weight * values[width * own[i] as usize + c]
                        };
                        (0..64).map(term).sum::<f64>() / 216.0
                    }));
                }
            }
        }
        all
    }

    /// A value of each element for each cell of the file.
    pub fn in_cells<T: Copy>(&self, values: &[T]) -> Vec<T> {
        values.iter().flat_map(|v| std::iter::repeat_n(*v, self.each)).collect()
    }

    /// A field of the elements for the cells of the file.
    pub fn cell_attribute(&self, name: &str, values: Values<'_>) -> Attribute {
        match values {
            Values::Scalars(v) => Values::Scalars(&self.in_cells(v)).attribute(name),
            Values::Vectors(v) => Values::Vectors(&self.in_cells(v)).attribute(name),
            Values::Tensors(v) => Values::Tensors(&self.in_cells(v)).attribute(name),
            Values::Flags(v) => Values::Flags(&self.in_cells(v)).attribute(name),
        }
    }

    /// A field at the lattice's points for those of the file.
    pub fn point_attribute(&self, lattice: &Lattice, name: &str, values: Values<'_>) -> Attribute {
        match values {
            Values::Scalars(v) => Attribute::generic(name, 1).with_data(self.at_points(lattice, v, 1)),
            Values::Vectors(v) => {
                Attribute::vectors(name).with_data(self.at_points(lattice, &super::vtk::coordinates(v), 3))
            }
            Values::Tensors(v) => Attribute::generic(name, 6).with_data(self.at_points(lattice, &v.concat(), 6)),
            Values::Flags(_) => values.attribute(name),
        }
    }
}

/// The places of the lattice (x fastest) in the order of VTK's Lagrange hexahedra: corners, edges, faces, inside
/// (`vtkHigherOrderHexahedron::PointIndexFromIJK`, as files before version 2.1 have it).
pub(super) fn vtk_places(order: usize) -> Vec<usize> {
    let side = order + 1;
    let at = |x: [usize; 3]| x[0] + side * (x[1] + side * x[2]);
    let inner = 1..order;
    let corner = |c: u32| [c & 1, c >> 1 & 1, c >> 2].map(|b| b as usize * order);
    let mut places: Vec<usize> = to_vtk_order(std::array::from_fn(|c| c as u32)).map(|c| at(corner(c))).to_vec();
    for z in [0, order] {
        places.extend(inner.clone().map(|i| at([i, 0, z])));
        places.extend(inner.clone().map(|i| at([order, i, z])));
        places.extend(inner.clone().map(|i| at([i, order, z])));
        places.extend(inner.clone().map(|i| at([0, i, z])));
    }
    for [x, y] in [[0, 0], [order, 0], [0, order], [order, order]] {
        places.extend(inner.clone().map(|i| at([x, y, i])));
    }
    let square = |point: &dyn Fn(usize, usize) -> usize| -> Vec<usize> {
        (1..order).flat_map(|v| (1..order).map(move |u| (u, v))).map(|(u, v)| point(u, v)).collect()
    };
    for x in [0, order] {
        places.extend(square(&|u, v| at([x, u, v])));
    }
    for y in [0, order] {
        places.extend(square(&|u, v| at([u, y, v])));
    }
    for z in [0, order] {
        places.extend(square(&|u, v| at([u, v, z])));
    }
    places.extend(inner.clone().flat_map(|z| square(&|u, v| at([u, v, z]))));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_place_of_the_lattice_is_written_once() {
        for order in 1..5 {
            let mut places = vtk_places(order);
            places.sort_unstable();
            assert_eq!(places, (0..(order + 1).pow(3)).collect::<Vec<_>>());
        }
    }
}
