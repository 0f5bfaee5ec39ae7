//! What recovery misses where four-node cells lock near nu = 1/2.
//!
//! Cells that cannot deform at constant volume hardly deform at all: their displacement is far too small, and smooth, while
//! their pressures jump by orders more than stresses do. Measured by `C^-1` these jumps are next to nothing, for it takes the
//! pressure to be of the size of the bulk modulus; so recovery finds a small error, a tenth or less of the true one. The
//! residual estimate measures them by the shear modulus, which makes it a bound whatever nu is (Verfuerth 1999; `residual.rs`).
//! It is two to three times the error where nothing locks: where it is more than five times what recovery finds, in the mean
//! over a region, the estimate is raised to a fifth of it. Of the true error it is then 0.9 to 3 times as much where loads
//! act on the outside, and up to six times for a displacement of constant volume, nu = 0.45 to 0.49999.

use super::residual;
use crate::fem::{Data, Stress};

/// Poisson's ratio from which four-node cells may lock.
const FROM: f64 = 0.4;

/// The energy norm of the residual estimate over that of recovery up to which nothing locks.
const RATIO: f64 = 5.0;

/// By how much the estimate of each region is to be raised (in the energy norm): one, or more. `squared` is what recovery finds.
pub(super) fn factors(data: &Data<'_>, displacement: &[glam::DVec3], stress: &Stress, squared: &[f64]) -> Vec<f64> {
    let materials = &data.model.materials;
    if stress.is_linear() || materials.iter().all(|m| m.poissons_ratio < FROM) {
        return vec![1.0; materials.len()];
    }
    let mut sums = vec![[0.0; 2]; materials.len()];
    let residuals = residual::squared(data, displacement, stress);
    for ((region, residual), recovered) in data.space.mesh().regions().iter().zip(residuals).zip(squared) {
        let sum = &mut sums[region.0 as usize];
        *sum = [sum[0] + residual, sum[1] + recovered];
    }
    let factor = |[residual, recovered]: [f64; 2]| (residual / recovered).sqrt() / RATIO;
    // Where there is no error the ratio is rounding, or no number.
    let locks = |nu: f64, sum: [f64; 2]| nu >= FROM && sum[1] > f64::EPSILON * sum[0];
    materials
        .iter()
        .zip(sums)
        .map(|(m, sum)| if locks(m.poissons_ratio, sum) { factor(sum).max(1.0) } else { 1.0 })
        .collect()
}
