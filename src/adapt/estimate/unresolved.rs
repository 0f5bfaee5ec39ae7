//! Where four-node cells do not show the solution at all.
//!
//! In bending cells of constant strain store the energy of shear that is not there: with h along a part of thickness t about
//! `(h / t)^2` times what they should, so that they move too little by this factor. What is left is a solution of its own, of which
//! recovery finds an error of the usual size, and not of the one that is missing. But this error is always of the size of that
//! solution: on plates of 10:1 to 100:1 and beams with one to four cells through the thickness two thirds of it, with
//! effectivities of 0.8 down to 0.05, while they are above 0.8 where recovery finds less than 60 %. So where around all
//! vertices of a cell the estimated error has more than 60 % of the (energy norm of the) solution, nothing is known of the error.

use crate::fem::{Data, Stress};
use rayon::prelude::*;

/// Squared relative error around a vertex above which the solution is not seen there.
const RELATIVE: f64 = 0.36;

/// Share of the energy of the solution and of its error in such cells from which they matter. Around singular edges and corners
/// there is a little of it, up to a fiftieth on the first meshes of the bundled scenarios.
const SHARE: f64 = 0.05;

/// Cells, ascending, that do not show the solution, by recovery's squared errors; none if they do not matter.
pub(super) fn cells(data: &Data<'_>, stress: &Stress, squared: &[f64]) -> Vec<u32> {
    if stress.is_linear() {
        return Vec::new();
    }
    let mesh = data.space.mesh();
    let energy = |t: usize| mesh.cell_volume(t) * data.material(t).compliance_energy(stress.mean(t));
    let whole: Vec<f64> = squared.par_iter().enumerate().map(|(t, e)| energy(t) + e).collect();
    let sum: f64 = whole.iter().sum();
    // Each vertex of a cell found has an error above this share of what is around it: so they hold less than the whole error over it.
    if squared.iter().sum::<f64>() < RELATIVE * SHARE * sum {
        return Vec::new();
    }
    let mut around = vec![[0.0; 2]; mesh.points().len()];
    for ((tet, error), whole) in mesh.tets().iter().zip(squared).zip(&whole) {
        for v in tet {
            let sum = &mut around[*v as usize];
            *sum = [sum[0] + error, sum[1] + whole];
        }
    }
    let unseen = |v: &u32| around[*v as usize][0] > RELATIVE * around[*v as usize][1];
    let cells: Vec<u32> = (0..squared.len() as u32).filter(|t| mesh.tets()[*t as usize].iter().all(unseen)).collect();
    let share: f64 = cells.iter().map(|t| whole[*t as usize]).sum();
    if share >= SHARE * sum { cells } else { Vec::new() }
}
