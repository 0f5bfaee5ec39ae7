//! The functions of a ring's vertices on its first cell: B-splines where the ring is a grid; else those of the eight
//! children, whose rings are found by one step of subdivision, mapped back by its masks.

use super::Table;
use super::ring::{Grid, Ring, Shape};
use super::spline;
use crate::mesh::hex::HexTopology;
use crate::subdiv::catmull_clark::{Control, Split, Stencils};
use crate::subdiv::options::CatmullClark;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::rc::Rc;

/// Levels of subdivision after which a cell counts as a point. Away from extraordinary edges a few suffice; on them the
/// functions' values converge at least by a factor of 0.63 a level.
const DEEPEST: usize = 60;

/// The functions at points of the unit cube.
pub(super) fn table(shape: &Shape, points: &[DVec3], variant: CatmullClark) -> Table {
    descend(shape, points, &mut Known { variant, families: FxHashMap::default() }, 0)
}

/// The families of rings met so far: near extraordinary edges the same come back level after level.
struct Known {
    variant: CatmullClark,
    families: FxHashMap<Shape, Rc<Family>>,
}

impl Known {
    fn family(&mut self, shape: &Shape) -> Option<Rc<Family>> {
        if let Some(family) = self.families.get(shape) {
            return Some(family.clone());
        }
        let family = Rc::new(Family::new(shape, self.variant)?);
        self.families.insert(shape.clone(), family.clone());
        Some(family)
    }
}

fn descend(shape: &Shape, points: &[DVec3], known: &mut Known, depth: usize) -> Table {
    let functions = shape.vertices();
    let mut table = Table {
        functions,
        values: vec![0.0; functions * points.len()],
        gradients: vec![DVec3::ZERO; functions * points.len()],
    };
    let mut add = |point: usize, v: usize, value: f64, gradient: DVec3| {
        table.values[point * functions + v] += value;
        table.gradients[point * functions + v] += gradient;
    };
    if let Some(grid) = shape.regular() {
        points.iter().enumerate().for_each(|(i, at)| tensor(&grid, *at, &mut |v, n, dn| add(i, v, n, dn)));
        return table;
    }
    let family = if depth == DEEPEST { None } else { known.family(shape) };
    let Some(family) = family else {
        points.iter().enumerate().for_each(|(i, at)| trilinear(*at, &mut |v, n, dn| add(i, v, n, dn)));
        return table;
    };
    let mut of_child: [(Vec<usize>, Vec<DVec3>); 8] = Default::default();
    for (i, &at) in points.iter().enumerate() {
        let halves = [0, 1, 2].map(|axis| usize::from(at[axis] > 0.5));
        let child = halves[0] | halves[1] << 1 | halves[2] << 2;
        of_child[child].0.push(i);
        of_child[child].1.push(2.0 * at - DVec3::from_array(halves.map(|h| h as f64)));
    }
    for (child, (numbers, places)) in of_child.iter().enumerate().filter(|(_, c)| !c.0.is_empty()) {
        let ring = &family.children[child];
        let finer = descend(&ring.shape, places, known, depth + 1);
        for (q, &i) in numbers.iter().enumerate() {
            let functions = finer.values_at(q).iter().zip(finer.gradients_at(q));
            for (&v, (n, dn)) in ring.vertices.iter().zip(functions) {
                for (parent, weight) in family.stencils.row(v as usize) {
                    add(i, parent as usize, weight * n, 2.0 * weight * *dn);
                }
            }
        }
    }
    table
}

/// A ring after one step of subdivision.
struct Family {
    stencils: Stencils,
    /// The rings of the children of the first cell.
    children: Vec<Ring>,
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
        let finer = Control { cells: &split.cells, topology: &finer, creased, corner };
        Some(Self { children: (0..8).map(|child| Ring::of(&finer, child)).collect(), stencils })
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
