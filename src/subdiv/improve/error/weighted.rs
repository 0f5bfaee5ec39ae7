//! Costs of many cells at once.

use super::super::lanes::{Block, Blocks, LANES, Lanes, least};
use super::cost::Shape;
use super::weight::Weight;
use glam::DVec3;
use pulp::Arch;

/// Blocks of cells with a weight each; lanes that hold no cell have none.
struct Weighted<W: Weight> {
    blocks: Blocks,
    weights: Vec<W::Block>,
}

impl<W: Weight> Default for Weighted<W> {
    fn default() -> Self {
        Self { blocks: Blocks::default(), weights: Vec::new() }
    }
}

impl<W: Weight> Weighted<W> {
    fn clear(&mut self) {
        self.blocks.clear();
        self.weights.clear();
    }

    fn push(&mut self, corners: [DVec3; 3], weight: W) {
        let lane = self.blocks.len() % LANES;
        self.blocks.push(corners);
        if lane == 0 {
            self.weights.push(W::Block::default());
        }
        if let Some(weights) = self.weights.last_mut() {
            weight.put(weights, lane);
        }
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = (&Block, &W::Block)> {
        self.blocks.iter().zip(&self.weights)
    }
}

/// Weighted cells around one vertex, whose place is varied.
pub(super) struct Fan<W: Weight> {
    cells: Weighted<W>,
}

impl<W: Weight> Default for Fan<W> {
    fn default() -> Self {
        Self { cells: Weighted::default() }
    }
}

impl<W: Weight> Fan<W> {
    pub(super) fn clear(&mut self) {
        self.cells.clear();
    }

    /// Adds a cell by its corners other than the vertex, in the order that makes (vertex, corners) positive.
    pub(super) fn push(&mut self, corners: [DVec3; 3], weight: W) {
        self.cells.push(corners, weight);
    }

    /// Weighted cost and its gradient with the vertex at each of the places; of no meaning unless all cells are positive
    /// there.
    pub(super) fn gradients<const N: usize>(&self, places: [DVec3; N]) -> [(f64, DVec3); N] {
        let cells = &self.cells;
        Arch::new().dispatch(
            #[inline(always)]
            || places.map(|p| gradient(cells, p)),
        )
    }

    /// Weighted cost (infinite unless all cells are positive) and smallest sine of the dihedral angles with the vertex at
    /// `p`.
    pub(super) fn cost_and_sine(&self, p: DVec3) -> (f64, f64) {
        let cells = &self.cells;
        Arch::new().dispatch(
            #[inline(always)]
            || cost_and_sine(cells, p),
        )
    }
}

#[inline(always)]
fn gradient<W: Weight>(cells: &Weighted<W>, p: DVec3) -> (f64, DVec3) {
    let (mut costs, mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for (block, weights) in cells.iter() {
        for lane in 0..LANES {
            let shape = Shape::new(block.corners(lane).map(|q| q - p));
            let gradient = W::gradient(&shape, weights, lane);
            costs[lane] += W::cost(&shape, weights, lane);
            x[lane] += gradient.x;
            y[lane] += gradient.y;
            z[lane] += gradient.z;
        }
    }
    let [cost, x, y, z] = [costs, x, y, z].map(|s| s.iter().sum::<f64>());
    (cost, DVec3::new(x, y, z))
}

#[inline(always)]
fn cost_and_sine<W: Weight>(cells: &Weighted<W>, p: DVec3) -> (f64, f64) {
    let (mut sums, mut smallest) = ([0.0; LANES], [f64::INFINITY; LANES]);
    let mut flat = [false; LANES];
    for (block, weights) in cells.iter() {
        for lane in 0..LANES {
            let shape = Shape::new(block.corners(lane).map(|q| q - p));
            let (volume, sine) = (shape.six_volumes, shape.squared_sine());
            sums[lane] += W::cost(&shape, weights, lane);
            smallest[lane] = least(sine, smallest[lane]);
            flat[lane] |= volume <= 0.0;
        }
    }
    let cost = if flat.contains(&true) { f64::INFINITY } else { sums.iter().sum() };
    (cost, smallest.iter().copied().fold(f64::INFINITY, f64::min).sqrt())
}

/// Cells of any corners, each with its own result.
pub(super) struct Batch<W: Weight> {
    first: Vec<[Lanes; 3]>,
    rest: Weighted<W>,
    /// Weighted costs and squared sines.
    results: Vec<[Lanes; 2]>,
}

impl<W: Weight> Default for Batch<W> {
    fn default() -> Self {
        Self { first: Vec::new(), rest: Weighted::default(), results: Vec::new() }
    }
}

impl<W: Weight> Batch<W> {
    pub(super) fn clear(&mut self) {
        self.first.clear();
        self.rest.clear();
    }

    /// Adds a cell.
    pub(super) fn push(&mut self, [p, corners @ ..]: [DVec3; 4], weight: W) {
        let lane = self.rest.blocks.len() % LANES;
        if lane == 0 {
            self.first.push(p.to_array().map(|x| [x; LANES]));
        }
        if let Some(first) = self.first.last_mut() {
            for (i, x) in p.to_array().into_iter().enumerate() {
                first[i][lane] = x;
            }
        }
        self.rest.push(corners, weight);
    }

    /// Computes all cells.
    pub(super) fn evaluate(&mut self) {
        let Self { first, rest, results } = self;
        results.resize(first.len(), [[0.0; LANES]; 2]);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for ((first, (block, weights)), result) in first.iter().zip(rest.iter()).zip(results) {
                    for lane in 0..LANES {
                        let p = DVec3::new(first[0][lane], first[1][lane], first[2][lane]);
                        let shape = Shape::new(block.corners(lane).map(|q| q - p));
                        result[0][lane] = W::cost(&shape, weights, lane);
                        result[1][lane] = shape.squared_sine();
                    }
                }
            },
        );
    }

    /// Weighted cost (infinite unless positive) and squared smallest sine of the cell that was added as number `i`.
    pub(super) fn result(&self, i: usize) -> (f64, f64) {
        let [cost, sine] = &self.results[i / LANES];
        (cost[i % LANES], sine[i % LANES])
    }
}
