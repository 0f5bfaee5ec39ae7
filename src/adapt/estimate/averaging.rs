//! Averaging: the mean of the stresses around a vertex, weighted by volume (Zienkiewicz and Zhu 1987).

use super::{Field, add_scaled};
use crate::fem::SymTensor;

/// Recovers the stress at the vertex that the cells surround.
pub(super) fn recover(field: &Field, cells: &[u32]) -> SymTensor {
    let mut sum = [0.0; 6];
    for &t in cells {
        add_scaled(&mut sum, field.volumes[t as usize], &field.stress.mean(t as usize));
    }
    let volume = field.volume_of(cells);
    sum.map(|x| x / volume)
}
