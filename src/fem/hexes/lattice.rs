//! Points at which cells are shown: a lattice in each, shared between neighbours.

use super::{HexSpace, Tables};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

/// A lattice of `order + 1` points a direction in each cell. Points of neighbours of one region are the same.
#[derive(Debug)]
pub struct Lattice {
    /// Steps along each axis of a cell.
    pub order: usize,
    /// The points of each cell, `(order + 1)^3` of them, x fastest.
    pub cells: Vec<u32>,
    /// A cell of each point, and the point's number in it; ascending.
    pub sources: Vec<(u32, u32)>,
    /// The functions at the lattice.
    pub tables: Tables,
}

/// The vertices that a point lies between, with the numerators of their weights.
type Key = SmallVec<[(u32, u32); 8]>;

impl Lattice {
    /// The lattice of all cells.
    #[must_use]
    pub fn new(space: &HexSpace<'_>, order: usize) -> Self {
        let (side, step) = (order + 1, 1.0 / order as f64);
        let place = |q: usize| [q % side, q / side % side, q / side / side];
        let points: Vec<DVec3> =
            (0..side.pow(3)).map(|q| step * DVec3::from_array(place(q).map(|i| i as f64))).collect();
        let mut numbers: FxHashMap<(u16, Key), u32> = FxHashMap::default();
        let (mut cells, mut sources) = (Vec::new(), Vec::new());
        for (t, cell) in space.mesh().cells().iter().enumerate() {
            let region = space.mesh().regions()[t].0;
            for q in 0..points.len() {
                let at = place(q);
                let inside = at.iter().all(|i| *i > 0 && *i < order);
                let mut next = || {
                    sources.push((t as u32, q as u32));
                    sources.len() as u32 - 1
                };
                // Points inside a cell belong to no other.
                let number =
                    if inside { next() } else { *numbers.entry((region, key(cell, at, order))).or_insert_with(next) };
                cells.push(number);
            }
        }
        Self { order, cells, sources, tables: space.tables(points) }
    }

    /// Something at each point, from its cell, the cell's table and the number of the point there.
    pub fn each<T: Send>(
        &self,
        space: &HexSpace<'_>,
        of: impl Fn(usize, &crate::limit::Table, usize) -> T + Sync,
    ) -> Vec<T> {
        let of_cell = |own: &[(u32, u32)]| -> Vec<T> {
            let t = own[0].0 as usize;
            let table = self.tables.of(space, t);
            own.iter().map(|(_, q)| of(t, &table, *q as usize)).collect()
        };
        let each: Vec<Vec<T>> = self.sources.par_chunk_by(|a, b| a.0 == b.0).map(of_cell).collect();
        each.into_iter().flatten().collect()
    }

    /// The points' places.
    #[must_use]
    pub fn places(&self, space: &HexSpace<'_>) -> Vec<DVec3> {
        self.each(space, |t, table, q| space.frame(t, table, q).0)
    }

    /// A field given by coefficients, at the points.
    #[must_use]
    pub fn values(&self, space: &HexSpace<'_>, coefficients: &[DVec3]) -> Vec<DVec3> {
        self.each(space, |t, table, q| space.interpolate(coefficients, t, table, q))
    }
}

fn key(cell: &[u32; 8], at: [usize; 3], order: usize) -> Key {
    let weight = |c: usize| -> usize { (0..3).map(|a| if c >> a & 1 == 1 { at[a] } else { order - at[a] }).product() };
    let mut key: Key = (0..8).map(|c| (cell[c], weight(c) as u32)).filter(|(_, w)| *w > 0).collect();
    key.sort_unstable();
    key
}
