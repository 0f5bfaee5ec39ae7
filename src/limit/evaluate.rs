//! The functions of a ring's vertices on its first cell: B-splines where the ring is a grid; else those of the eight
//! children, whose rings are found by one step of subdivision, mapped back by its masks.

use super::Table;
use super::ring::{Grid, Ring, Shape};
use super::spline;
use crate::mesh::hex::HexTopology;
use crate::subdiv::catmull_clark::{Control, Split, Stencils};
use crate::subdiv::options::CatmullClark;
use glam::DVec3;

/// Levels of subdivision after which a cell counts as a point. Away from extraordinary edges a few suffice; on them the
/// functions' values converge at least by a factor of 0.63 a level.
const DEEPEST: usize = 60;

/// The functions at points of the unit cube.
pub(super) fn table(shape: &Shape, points: &[DVec3], variant: CatmullClark) -> Table {
    let functions = shape.vertices();
    let mut table = Table {
        functions,
        values: vec![0.0; functions * points.len()],
        gradients: vec![DVec3::ZERO; functions * points.len()],
    };
    let places: Vec<(usize, DVec3)> = points.iter().copied().enumerate().collect();
    descend(shape, &places, variant, 0, &mut |point, v, value, gradient| {
        let at = point * functions + v;
        table.values[at] += value;
        table.gradients[at] += gradient;
    });
    table
}

/// Receives the number of a point, a vertex of the ring, and what is to be added to its value and gradient there.
type Add<'a> = &'a mut dyn FnMut(usize, usize, f64, DVec3);

fn descend(shape: &Shape, points: &[(usize, DVec3)], variant: CatmullClark, depth: usize, add: Add<'_>) {
    if let Some(grid) = shape.regular() {
        points.iter().for_each(|&(i, at)| tensor(&grid, at, &mut |v, value, gradient| add(i, v, value, gradient)));
        return;
    }
    if depth == DEEPEST {
        points.iter().for_each(|&(i, at)| trilinear(at, &mut |v, value, gradient| add(i, v, value, gradient)));
        return;
    }
    let mut of_child: [Vec<(usize, DVec3)>; 8] = Default::default();
    for &(i, at) in points {
        let halves = [0, 1, 2].map(|axis| usize::from(at[axis] > 0.5));
        let child = halves[0] | halves[1] << 1 | halves[2] << 2;
        of_child[child].push((i, 2.0 * at - DVec3::from_array(halves.map(|h| h as f64))));
    }
    let Some(family) = Family::new(shape, variant) else { return };
    for (child, points) in of_child.iter().enumerate().filter(|(_, points)| !points.is_empty()) {
        let ring = family.ring(child);
        descend(&ring.shape, points, variant, depth + 1, &mut |i, v, value, gradient| {
            for (parent, weight) in family.stencils.row(ring.vertices[v] as usize) {
                add(i, parent as usize, weight * value, 2.0 * weight * gradient);
            }
        });
    }
}

/// A ring after one step of subdivision.
struct Family {
    split: Split,
    topology: HexTopology,
    stencils: Stencils,
    creased: Vec<bool>,
    corner: Vec<bool>,
}

impl Family {
    /// `None` does not occur: the cells of a ring are those of a mesh.
    fn new(shape: &Shape, variant: CatmullClark) -> Option<Self> {
        let cells = shape.mesh_cells();
        let topology = HexTopology::new(shape.vertices(), &cells).ok()?;
        let control = shape.control(&cells, &topology);
        let stencils = control.stencils(variant);
        let split = Split::new(&cells, &topology, shape.vertices());
        let finer = HexTopology::new(stencils.rows(), &split.cells).ok()?;
        let mut creased = vec![false; finer.edges().len()];
        for (e, ends) in (0..).zip(topology.edges()).filter(|(e, _)| control.creased[*e as usize]) {
            for &v in ends {
                if let Some(half) = finer.edge([v, split.edge_point(e)]) {
                    creased[half as usize] = true;
                }
            }
        }
        let mut corner = control.corner;
        corner.resize(stencils.rows(), false);
        Some(Self { split, topology: finer, stencils, creased, corner })
    }

    /// The ring of a child of the first cell.
    fn ring(&self, child: usize) -> Ring {
        let control = Control {
            cells: &self.split.cells,
            topology: &self.topology,
            creased: self.creased.clone(),
            corner: self.corner.clone(),
        };
        Ring::of(&control, child as u32)
    }
}

/// The tensor product of splines.
fn tensor(grid: &Grid, at: DVec3, add: &mut dyn FnMut(usize, f64, DVec3)) {
    let [x, y, z] = [0, 1, 2].map(|axis| spline::ended(at[axis], grid.lower[axis], grid.upper[axis]));
    for (place, &v) in grid.places.iter().enumerate().filter(|(_, v)| **v != u16::MAX) {
        let ([x, dx], [y, dy], [z, dz]) = (x[place % 4], y[place / 4 % 4], z[place / 16]);
        add(usize::from(v), x * y * z, DVec3::new(dx * y * z, x * dy * z, x * y * dz));
    }
}

/// The trilinear functions of the corners.
fn trilinear(at: DVec3, add: &mut dyn FnMut(usize, f64, DVec3)) {
    for c in 0..8 {
        let side = |axis: usize| if c >> axis & 1 == 1 { [at[axis], 1.0] } else { [1.0 - at[axis], -1.0] };
        let ([x, dx], [y, dy], [z, dz]) = (side(0), side(1), side(2));
        add(c, x * y * z, DVec3::new(dx * y * z, x * dy * z, x * y * dz));
    }
}
