//! Many cells at once: coordinates side by side, so that one instruction works on several cells.
//!
//! Only element-wise operations and sums in a fixed order: results do not depend on the instruction set.

use super::cost::Shape;
use glam::DVec3;
use pulp::Arch;

/// Cells in a block.
const LANES: usize = 8;

type Lane = [f64; LANES];

/// Corners of up to [`LANES`] cells, except their first ones.
#[derive(Clone, Copy)]
struct Block {
    /// x, y, z of the three corners.
    corners: [[Lane; 3]; 3],
    weights: Lane,
}

impl Block {
    #[inline(always)]
    fn corner(&self, k: usize, lane: usize) -> DVec3 {
        DVec3::new(self.corners[k][0][lane], self.corners[k][1][lane], self.corners[k][2][lane])
    }

    fn set(&mut self, lane: usize, corners: [DVec3; 3], weight: f64) {
        for (k, p) in corners.into_iter().enumerate() {
            for (i, x) in p.to_array().into_iter().enumerate() {
                self.corners[k][i][lane] = x;
            }
        }
        self.weights[lane] = weight;
    }
}

/// Blocks that are filled cell by cell.
#[derive(Default)]
struct Blocks {
    blocks: Vec<Block>,
    len: usize,
}

impl Blocks {
    fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    /// Adds a cell. Lanes not filled yet hold a copy of it without weight.
    fn push(&mut self, corners: [DVec3; 3], weight: f64) {
        let lane = self.len % LANES;
        if lane == 0 {
            let corners = corners.map(|p| p.to_array().map(|x| [x; LANES]));
            self.blocks.push(Block { corners, weights: [0.0; LANES] });
        }
        if let Some(block) = self.blocks.last_mut() {
            block.set(lane, corners, weight);
        }
        self.len += 1;
    }
}

/// Weighted cells around one vertex, whose place is varied.
#[derive(Default)]
pub(super) struct Fan {
    blocks: Blocks,
}

impl Fan {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
    }

    /// Adds a cell by its corners other than the vertex, in the order that makes (vertex, corners) positive.
    pub(super) fn push(&mut self, corners: [DVec3; 3], weight: f64) {
        self.blocks.push(corners, weight);
    }

    /// Weighted cost and its gradient with the vertex at each of the places; of no meaning unless all cells are positive
    /// there.
    pub(super) fn gradients<const N: usize>(&self, places: [DVec3; N]) -> [(f64, DVec3); N] {
        let blocks = &self.blocks.blocks[..];
        Arch::new().dispatch(
            #[inline(always)]
            || places.map(|p| gradient(blocks, p)),
        )
    }

    /// Weighted cost (infinite unless all cells are positive) and smallest sine of the dihedral angles with the vertex at
    /// `p`.
    pub(super) fn cost_and_sine(&self, p: DVec3) -> (f64, f64) {
        let blocks = &self.blocks.blocks[..];
        Arch::new().dispatch(
            #[inline(always)]
            || cost_and_sine(blocks, p),
        )
    }
}

#[inline(always)]
fn gradient(blocks: &[Block], p: DVec3) -> (f64, DVec3) {
    let mut sums = [[0.0; LANES]; 4];
    for block in blocks {
        for lane in 0..LANES {
            let shape = Shape::new([0, 1, 2].map(|k| block.corner(k, lane) - p));
            let (weight, gradient) = (block.weights[lane], shape.gradient());
            sums[0][lane] += weight * shape.cost();
            sums[1][lane] += weight * gradient.x;
            sums[2][lane] += weight * gradient.y;
            sums[3][lane] += weight * gradient.z;
        }
    }
    let [cost, x, y, z] = sums.map(|s| s.iter().sum::<f64>());
    (cost, DVec3::new(x, y, z))
}

#[inline(always)]
fn cost_and_sine(blocks: &[Block], p: DVec3) -> (f64, f64) {
    let (mut sums, mut least) = ([0.0; LANES], [f64::INFINITY; LANES]);
    let mut flat = [false; LANES];
    for block in blocks {
        for lane in 0..LANES {
            let shape = Shape::new([0, 1, 2].map(|k| block.corner(k, lane) - p));
            let (volume, sine) = (shape.six_volumes, shape.squared_sine());
            sums[lane] += block.weights[lane] * shape.cost();
            least[lane] = if sine < least[lane] { sine } else { least[lane] };
            flat[lane] |= volume <= 0.0;
        }
    }
    let cost = if flat.contains(&true) { f64::INFINITY } else { sums.iter().sum() };
    (cost, least.iter().copied().fold(f64::INFINITY, f64::min).sqrt())
}

/// Cells of any corners, each with its own result.
#[derive(Default)]
pub(super) struct Batch {
    first: Vec<[Lane; 3]>,
    blocks: Blocks,
    /// Weighted costs and squared sines.
    results: Vec<[Lane; 2]>,
}

impl Batch {
    pub(super) fn clear(&mut self) {
        self.first.clear();
        self.blocks.clear();
    }

    /// Adds a cell.
    pub(super) fn push(&mut self, [p, corners @ ..]: [DVec3; 4], weight: f64) {
        let lane = self.blocks.len % LANES;
        if lane == 0 {
            self.first.push(p.to_array().map(|x| [x; LANES]));
        }
        if let Some(first) = self.first.last_mut() {
            for (i, x) in p.to_array().into_iter().enumerate() {
                first[i][lane] = x;
            }
        }
        self.blocks.push(corners, weight);
    }

    /// Computes all cells.
    pub(super) fn evaluate(&mut self) {
        let Self { first, blocks, results } = self;
        results.resize(first.len(), [[0.0; LANES]; 2]);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for ((first, block), result) in first.iter().zip(&blocks.blocks).zip(results) {
                    for lane in 0..LANES {
                        let p = DVec3::new(first[0][lane], first[1][lane], first[2][lane]);
                        let shape = Shape::new([0, 1, 2].map(|k| block.corner(k, lane) - p));
                        result[0][lane] = block.weights[lane] * shape.cost();
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
