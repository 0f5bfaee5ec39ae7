//! What the cost of a cell is weighted with.

use super::super::lanes::{LANES, Lanes};
use super::cost::Shape;
use glam::DVec3;
use std::ops::{Add, Mul};

/// What is known of the error at a vertex and, by the mean over its vertices, in a cell.
pub(super) trait Weight: Copy + Send + Sync + Add<Output = Self> + Mul<f64, Output = Self> {
    /// Those of a block of cells.
    type Block: Copy + Default + Send;

    /// Whether it is finite and not negative.
    fn is_sound(self) -> bool;

    /// A number that is twice as large for a weight twice as large.
    fn size(self) -> f64;

    /// With a weight of size `least` without direction where it is smaller than that.
    fn raised(self, least: f64) -> Self;

    /// Puts it into a lane of a block.
    fn put(self, block: &mut Self::Block, lane: usize);

    /// Weighted cost of a cell; infinite unless its volume is positive.
    fn cost(shape: &Shape, block: &Self::Block, lane: usize) -> f64;

    /// Gradient of the weighted cost with respect to the vertex from which the edges start.
    fn gradient(shape: &Shape, block: &Self::Block, lane: usize) -> DVec3;
}

/// No direction is preferred: the weight is a factor.
impl Weight for f64 {
    type Block = Lanes;

    fn is_sound(self) -> bool {
        self.is_finite() && self >= 0.0
    }

    fn size(self) -> f64 {
        self
    }

    fn raised(self, least: f64) -> Self {
        self.max(least)
    }

    #[inline(always)]
    fn put(self, block: &mut Lanes, lane: usize) {
        block[lane] = self;
    }

    #[inline(always)]
    fn cost(shape: &Shape, block: &Lanes, lane: usize) -> f64 {
        block[lane] * shape.cost()
    }

    #[inline(always)]
    fn gradient(shape: &Shape, block: &Lanes, lane: usize) -> DVec3 {
        block[lane] * shape.gradient()
    }
}

/// A weight with directions: the matrix M (symmetric, no eigenvalue negative) of the expected error of quadratics whose
/// Hessians have the second moments `M M + tr(M) M`, by its entries XX YY ZZ XY YZ XZ. The error grows with the square of M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directions(pub [f64; 6]);

impl Add for Directions {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Mul<f64> for Directions {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl Weight for Directions {
    type Block = [Lanes; 6];

    fn is_sound(self) -> bool {
        self.0.iter().all(|x| x.is_finite()) && self.0[..3].iter().all(|x| *x >= 0.0)
    }

    fn size(self) -> f64 {
        self.0[..3].iter().sum()
    }

    fn raised(self, least: f64) -> Self {
        let missing = (least - self.size()).max(0.0) / 3.0;
        let Self([xx, yy, zz, xy, yz, xz]) = self;
        Self([xx + missing, yy + missing, zz + missing, xy, yz, xz])
    }

    #[inline(always)]
    fn put(self, block: &mut Self::Block, lane: usize) {
        for (lanes, x) in block.iter_mut().zip(self.0) {
            lanes[lane] = x;
        }
    }

    #[inline(always)]
    fn cost(shape: &Shape, block: &Self::Block, lane: usize) -> f64 {
        shape.cost_along(entries(block, lane))
    }

    #[inline(always)]
    fn gradient(shape: &Shape, block: &Self::Block, lane: usize) -> DVec3 {
        shape.gradient_along(entries(block, lane))
    }
}

#[inline(always)]
fn entries(block: &[[f64; LANES]; 6], lane: usize) -> [f64; 6] {
    std::array::from_fn(|i| block[i][lane])
}
