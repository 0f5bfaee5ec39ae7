//! Numbers in which the hierarchy is kept.

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// Single or double precision. The preconditioner needs no more than single, which halves what a cycle reads; slender
/// bodies, whose softest motions drown in its rounding, need double.
pub(in super::super) trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + AddAssign
    + SubAssign
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
{
    /// The nearest number; zero for what is so small that its products are subnormal, which processors are slow with.
    fn new(x: f64) -> Self;

    /// The number in double precision.
    fn get(self) -> f64;

    /// The number, or zero as [`Real::new`] has it.
    fn cleaned(self) -> Self;
}

/// Magnitude below which an entry of a matrix, scaled to have its largest near one, is rounding.
const NEGLIGIBLE: f64 = 1e-15;

impl Real for f32 {
    fn new(x: f64) -> Self {
        if x.abs() < NEGLIGIBLE { 0.0 } else { x as Self }
    }

    fn get(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn cleaned(self) -> Self {
        if self.abs() < NEGLIGIBLE as Self { 0.0 } else { self }
    }
}

impl Real for f64 {
    fn new(x: f64) -> Self {
        x
    }

    fn get(self) -> f64 {
        self
    }

    #[inline(always)]
    fn cleaned(self) -> Self {
        self
    }
}
