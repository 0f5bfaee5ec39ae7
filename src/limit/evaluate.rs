//! The functions of a ring's vertices on its first cell: B-splines where the ring is a grid; else those of the eight
//! children, whose rings are found by one step of subdivision, mapped back by its masks.

use super::Table;
use super::ring::{Grid, Ring, Shape};
use super::spline;
use crate::mesh::hex::HexTopology;
use crate::mesh::weights::WeightRows;
use crate::subdiv::catmull_clark::{Control, Split};
use crate::subdiv::options::CatmullClark;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::sync::{Arc, PoisonError, RwLock};

/// Levels of subdivision after which a cell counts as a point. Away from extraordinary edges a few suffice; on them the
/// functions' values converge at least by a factor of 0.63 a level.
const DEEPEST: usize = 60;

/// The functions at points of the unit cube.
pub(super) fn table(shape: &Shape, points: &[DVec3], families: &Families) -> Table {
    let functions = shape.vertices();
    let mut sums = Sums { functions, all: vec![0.0; 4 * functions * points.len()] };
    let within = Within { places: points.to_vec(), numbers: (0..points.len()).collect(), depth: 0 };
    descend(shape, &Weights::identity(functions), within, &mut Known::new(families), &mut sums);
    sums.table(points.len())
}

/// Points in a part of the unit cube.
struct Within {
    /// In the part's own coordinates.
    places: Vec<DVec3>,
    /// Their numbers in the table.
    numbers: Vec<usize>,
    /// Levels below the cell.
    depth: usize,
}

/// The control points of a ring as combinations of those of the first one, row by row.
struct Weights {
    columns: usize,
    all: Vec<f64>,
}

impl Weights {
    fn identity(columns: usize) -> Self {
        let mut all = vec![0.0; columns * columns];
        (0..columns).for_each(|i| all[i * columns + i] = 1.0);
        Self { columns, all }
    }

    fn row(&self, v: usize) -> &[f64] {
        &self.all[v * self.columns..(v + 1) * self.columns]
    }

    /// Those of a child's ring.
    fn child(&self, stencils: &WeightRows, ring: &Ring) -> Self {
        let mut all = vec![0.0; self.columns * ring.vertices.len()];
        for (&v, row) in ring.vertices.iter().zip(all.chunks_exact_mut(self.columns)) {
            for (parent, weight) in stencils.row(v as usize) {
                row.iter_mut().zip(self.row(parent as usize)).for_each(|(sum, w)| *sum += weight * w);
            }
        }
        Self { columns: self.columns, all }
    }
}

/// Values and the three derivatives of all functions at each point, one after the other.
struct Sums {
    functions: usize,
    all: Vec<f64>,
}

impl Sums {
    /// Adds functions of a ring (four rows a point: values, derivatives; one column a vertex), which are combinations of the
    /// first ring's.
    fn add(&mut self, numbers: &[usize], local: &[f64], weights: &Weights) {
        let (n, rows) = (self.functions, 4 * numbers.len());
        let columns = weights.all.len() / n;
        let mut product = vec![0.0; rows * n];
        matmul(
            MatMut::from_row_major_slice_mut(&mut product, rows, n),
            Accum::Replace,
            MatRef::from_row_major_slice(local, rows, columns),
            MatRef::from_row_major_slice(&weights.all, columns, n),
            1.0,
            Par::Seq,
        );
        for (&number, own) in numbers.iter().zip(product.chunks_exact(4 * n)) {
            let sums = &mut self.all[4 * n * number..4 * n * (number + 1)];
            sums.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
        }
    }

    fn table(&self, points: usize) -> Table {
        let n = self.functions;
        let mut table = Table { functions: n, values: Vec::with_capacity(n * points), gradients: Vec::new() };
        table.gradients.reserve(n * points);
        for own in self.all.chunks_exact(4 * n) {
            table.values.extend(&own[..n]);
            table.gradients.extend((n..2 * n).map(|i| DVec3::new(own[i], own[i + n], own[i + 2 * n])));
        }
        table
    }
}

/// A part of the unit cube: a cube with its lowest corner and its side.
pub type Part = (DVec3, f64);

/// The parts of the unit cube, halved `depth` times at most, in which functions are polynomials or which are too small to be
/// halved again. `projections` are sets of the cube's faces, as bits: the functions take values below a point on these too.
pub(super) fn parts(shape: &Shape, projections: &[u8], depth: u32, families: &Families) -> Vec<Part> {
    let mut known = Known::new(families);
    let (mut parts, mut open) = (Vec::new(), vec![(0, [0; 3])]);
    while let Some((level, index)) = open.pop() {
        let mut plain = |faces: u8| is_polynomial(shape, [0, level], below(index, level, faces), &mut known);
        if level == depth || (plain(0) && projections.iter().all(|&faces| plain(faces))) {
            let size = 0.5_f64.powi(level as i32);
            parts.push((size * DVec3::from_array(index.map(f64::from)), size));
        } else {
            let child = |c: u32| [0, 1, 2].map(|axis| 2 * index[axis] + (c >> axis & 1));
            open.extend((0..8).rev().map(|c| (level + 1, child(c))));
        }
    }
    parts
}

/// The part of a level on all these faces below a part.
fn below(mut index: [u32; 3], level: u32, faces: u8) -> [u32; 3] {
    let last = (1 << level) - 1;
    (0..6).filter(|f| faces >> f & 1 == 1).for_each(|f| index[f / 2] = if f % 2 == 1 { last } else { 0 });
    index
}

/// Whether functions are polynomials on a part of the unit cube, so many levels below that of `shape`.
fn is_polynomial(shape: &Shape, [from, level]: [u32; 2], index: [u32; 3], known: &mut Known<'_>) -> bool {
    if level == 0 || shape.regular().is_some() {
        return shape.regular().is_some();
    }
    let Some(family) = known.family(shape, from as usize) else { return false };
    let halves = index.map(|i| (i >> (level - 1) & 1) as usize);
    let child = &family.children[halves[0] | halves[1] << 1 | halves[2] << 2];
    is_polynomial(&child.shape, [from + 1, level - 1], index, known)
}

/// Levels from which on rings are remembered for all cells: near extraordinary edges the same come back level after level,
/// while those above are as many as there are different rings in the mesh.
const COMMON: usize = 2;

/// The families of rings that many cells have in common.
#[derive(Debug)]
pub(super) struct Families {
    variant: CatmullClark,
    known: RwLock<FxHashMap<Shape, Arc<Family>>>,
}

impl Families {
    pub fn new(variant: CatmullClark) -> Self {
        Self { variant, known: RwLock::default() }
    }
}

/// The families of rings met so far below one cell.
struct Known<'a> {
    common: &'a Families,
    own: FxHashMap<Shape, Arc<Family>>,
}

impl<'a> Known<'a> {
    fn new(common: &'a Families) -> Self {
        Self { common, own: FxHashMap::default() }
    }

    /// The family of a ring that belongs to a part of this level.
    fn family(&mut self, shape: &Shape, level: usize) -> Option<Arc<Family>> {
        if let Some(family) = self.own.get(shape) {
            return Some(family.clone());
        }
        // A thread that failed left the map as it was.
        let common = || self.common.known.read().unwrap_or_else(PoisonError::into_inner).get(shape).cloned();
        let family = match common().filter(|_| level >= COMMON) {
            Some(family) => family,
            None => Arc::new(Family::new(shape, self.common.variant)?),
        };
        if level >= COMMON {
            let mut known = self.common.known.write().unwrap_or_else(PoisonError::into_inner);
            known.entry(shape.clone()).or_insert_with(|| family.clone());
        }
        self.own.insert(shape.clone(), family.clone());
        Some(family)
    }
}

/// Points from which on combinations are carried down to a part, of all functions; fewer points' few functions are carried up.
const MANY: usize = 32;

/// Adds the functions at points of a part, whose control points are combinations of the first ring's.
fn descend(shape: &Shape, weights: &Weights, within: Within, known: &mut Known<'_>, sums: &mut Sums) {
    if within.places.len() < MANY || shape.regular().is_some() {
        let mut local = climb(shape, &within.places, known, within.depth);
        // Derivatives are those along the axes of the cell.
        let (scale, columns) = (0.5_f64.powi(-(within.depth as i32)), shape.vertices());
        for own in local.chunks_exact_mut(4 * columns) {
            own[columns..].iter_mut().for_each(|dn| *dn *= scale);
        }
        sums.add(&within.numbers, &local, weights);
        return;
    }
    let Some(family) = known.family(shape, within.depth) else { return };
    for (child, places, chosen) in by_child(&within.places) {
        let ring = &family.children[child];
        let own = weights.child(&family.stencils, ring);
        let numbers = chosen.iter().map(|i| within.numbers[*i]).collect();
        descend(&ring.shape, &own, Within { places, numbers, depth: within.depth + 1 }, known, sums);
    }
}

/// The functions of a ring at points of its first cell: four rows a point, the values and the derivatives.
fn climb(shape: &Shape, places: &[DVec3], known: &mut Known<'_>, depth: usize) -> Vec<f64> {
    let columns = shape.vertices();
    let mut local = vec![0.0; 4 * columns * places.len()];
    let mut add = |i: usize, v: usize, n: f64, dn: DVec3| {
        let own = &mut local[4 * columns * i..4 * columns * (i + 1)];
        own[v] += n;
        (0..3).for_each(|axis| own[(axis + 1) * columns + v] += dn[axis]);
    };
    if let Some(grid) = shape.regular() {
        places.iter().enumerate().for_each(|(i, at)| tensor(&grid, *at, &mut |v, n, dn| add(i, v, n, dn)));
        return local;
    }
    let Some(family) = (if depth < DEEPEST { known.family(shape, depth) } else { None }) else {
        places.iter().enumerate().for_each(|(i, at)| trilinear(*at, &mut |v, n, dn| add(i, v, n, dn)));
        return local;
    };
    for (child, places, chosen) in by_child(places) {
        let ring = &family.children[child];
        let finer = climb(&ring.shape, &places, known, depth + 1);
        let own = ring.vertices.len();
        for (&i, rows) in chosen.iter().zip(finer.chunks_exact(4 * own)) {
            for (place, &v) in ring.vertices.iter().enumerate() {
                let dn = DVec3::new(rows[own + place], rows[2 * own + place], rows[3 * own + place]);
                if rows[place] == 0.0 && dn == DVec3::ZERO {
                    continue;
                }
                for (parent, weight) in family.stencils.row(v as usize) {
                    add(i, parent as usize, weight * rows[place], 2.0 * weight * dn);
                }
            }
        }
    }
    local
}

/// The children of a cell that hold points: child, their places in it, and their numbers.
fn by_child(places: &[DVec3]) -> impl Iterator<Item = (usize, Vec<DVec3>, Vec<usize>)> {
    let mut of_child: [(Vec<DVec3>, Vec<usize>); 8] = Default::default();
    for (i, &at) in places.iter().enumerate() {
        let halves = [0, 1, 2].map(|axis| usize::from(at[axis] > 0.5));
        let child = &mut of_child[halves[0] | halves[1] << 1 | halves[2] << 2];
        child.0.push(2.0 * at - DVec3::from_array(halves.map(|h| h as f64)));
        child.1.push(i);
    }
    let held = of_child.into_iter().enumerate().filter(|(_, c)| !c.1.is_empty());
    held.map(|(child, (places, numbers))| (child, places, numbers))
}

/// A ring after one step of subdivision.
#[derive(Debug)]
struct Family {
    stencils: WeightRows,
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
