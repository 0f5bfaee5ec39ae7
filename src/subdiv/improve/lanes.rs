//! Cells laid out coordinate by coordinate, so that one instruction works on several of them.
//!
//! Whatever instructions the processor has, the operations and their order are the same, so the bits are too.

use glam::DVec3;

/// Cells in a block.
pub(super) const LANES: usize = 4;

/// One number of each cell of a block.
pub(super) type Lanes = [f64; LANES];

/// Three corners of each of [`LANES`] cells: x, y, z of the first, of the second, of the third.
#[derive(Clone, Copy)]
pub(super) struct Block([[Lanes; 3]; 3]);

impl Block {
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [DVec3; 3] {
        self.0.map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]))
    }
}

/// Blocks that are filled cell by cell.
#[derive(Default)]
pub(super) struct Blocks {
    blocks: Vec<Block>,
    len: usize,
}

impl Blocks {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    /// Adds a cell by three of its corners. Lanes that are not filled yet hold a copy of the first cell of the block.
    pub(super) fn push(&mut self, corners: [DVec3; 3]) {
        let lane = self.len % LANES;
        self.len += 1;
        if lane == 0 {
            self.blocks.push(Block(corners.map(|p| p.to_array().map(|x| [x; LANES]))));
        } else if let Some(block) = self.blocks.last_mut() {
            for (coordinates, p) in block.0.iter_mut().zip(corners) {
                for (lanes, x) in coordinates.iter_mut().zip(p.to_array()) {
                    lanes[lane] = x;
                }
            }
        }
    }

    /// The corners of cell `i`.
    pub(super) fn corners(&self, i: usize) -> [DVec3; 3] {
        self.blocks[i / LANES].corners(i % LANES)
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    pub(super) fn iter(&self) -> std::slice::Iter<'_, Block> {
        self.blocks.iter()
    }
}

/// The smaller of two numbers, in one instruction.
#[inline(always)]
pub(super) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
