//! Error estimation by recovery: a continuous stress s* is made of the stresses s_h of the cells, and their difference
//! stands for the error, eta_K^2 = int_K (s* - s_h) : C^-1 : (s* - s_h).
//!
//! Of four-node cells s_h is constant and s* linear; with d_i the difference at vertex i the integral is
//! V/20 (sum_i d_i : C^-1 : d_i + (sum_i d_i) : C^-1 : (sum_i d_i)), exactly. Of ten-node cells they are linear and
//! quadratic (`quadratic.rs`).
//!
//! Where regions meet, stress is recovered for each region alone: across materials it may jump.

mod averaging;
mod locking;
mod patches;
mod quadratic;
mod residual;
mod spr;
#[cfg(test)]
mod tests;
mod unresolved;
mod unseen;

use super::options::Estimator;
use crate::fem::{Data, Material, Space, Stress, SymTensor};
use glam::DVec3;
use patches::Patches;
use rayon::prelude::*;

/// The estimated error of each cell, and the stress recovered on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct CellErrors {
    /// eta_K^2 for each cell: approximates a(e, e) on the cell (twice the energy of the error).
    pub squared: Vec<f64>,
    /// The part of each of them that stands for data which the elements do not see; empty if there is none.
    pub unseen: Vec<f64>,
    /// By how much the energy norm of the error in the cells of each region was raised above what recovery finds, as four-node
    /// cells lock there: one where they do not.
    pub raised: Vec<f64>,
    /// Four-node cells, ascending, that do not show the solution at all, so that what recovery or the residual finds there says
    /// nothing of the error.
    pub unresolved: Vec<u32>,
    /// Recovered stress at each node; where regions meet, the mean of theirs weighted by their volumes around it. For
    /// output. Zero at a node without cells.
    pub nodal_stress: Vec<SymTensor>,
    /// Recovered stress of each cell's own region.
    pub recovered: Recovered,
    /// Cells, ascending, that share no vertex with another cell of their region: there is no stress to compare theirs
    /// with, so their error is not known. Their entry of `squared` is zero.
    pub unestimated: Vec<u32>,
}

/// The stress that is recovered, from patches of cells of one region each: continuous in a region, with jumps between.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recovered {
    /// The patch at each vertex of each cell.
    pub(in crate::adapt) patches: Vec<[u32; 4]>,
    /// The stress at the vertex of each patch.
    pub(in crate::adapt) at_vertices: Vec<SymTensor>,
    /// That at the other nodes of ten-node cells, six a cell.
    between: Vec<[SymTensor; 6]>,
}

impl Recovered {
    /// The stress at the nodes of cell `t`: four, or ten.
    pub fn of_cell(&self, t: usize) -> impl Iterator<Item = SymTensor> {
        let corners = self.patches[t].map(|p| self.at_vertices[p as usize]);
        corners.into_iter().chain(self.between.get(t).into_iter().flatten().copied())
    }
}

impl CellErrors {
    /// eta = sqrt(sum eta_K^2), the estimated error in the energy norm sqrt(a(e, e)); NaN where the error of a cell is not
    /// known.
    #[must_use]
    pub fn energy(&self) -> f64 {
        if !self.unestimated.is_empty() {
            return f64::NAN;
        }
        self.squared.iter().sum::<f64>().sqrt()
    }

    /// The part of eta that stands for data which the elements do not see.
    #[must_use]
    pub fn unseen(&self) -> f64 {
        // From zero: the sum of nothing is -0.
        self.unseen.iter().fold(0.0, |sum, e| sum + e).sqrt()
    }

    /// eta / sqrt(2 U + eta^2) with the strain energy U = u.K.u / 2 of the solution; 0 where nothing is strained, NaN
    /// where the error of a cell is not known.
    #[must_use]
    pub fn relative(&self, strain_energy: f64) -> f64 {
        let eta = self.energy();
        let whole = (2.0 * strain_energy + eta * eta).sqrt();
        if whole == 0.0 { 0.0 } else { eta / whole }
    }
}

/// Estimates the error of each cell of a solved problem: by recovery, with a bound of what data make that the elements do not
/// see; or by the residual.
#[must_use]
pub fn estimate_solved(data: &Data<'_>, displacement: &[DVec3], stress: &Stress, estimator: Estimator) -> CellErrors {
    let mut errors = estimate(data.space, &data.model.materials, stress, estimator);
    errors.unresolved = unresolved::cells(data, stress, &errors.squared);
    if estimator == Estimator::Residual {
        errors.squared = residual::squared(data, displacement, stress);
        errors.unestimated.clear();
    } else {
        errors.raised = locking::factors(data, displacement, stress, &errors.squared);
        let regions = data.space.mesh().regions().iter();
        errors.squared.iter_mut().zip(regions).for_each(|(e, r)| *e *= errors.raised[r.0 as usize].powi(2));
    }
    errors.unseen = unseen::squared(data, estimator);
    errors.squared.iter_mut().zip(&errors.unseen).for_each(|(sum, unseen)| *sum += unseen);
    errors
}

/// Estimates the error of each cell from the stress of its elements alone, by recovery (SPR for the residual estimator, which
/// needs more than the stress: [`estimate_solved`]).
///
/// `materials` has one entry a region.
#[must_use]
pub fn estimate(space: &Space<'_>, materials: &[Material], stress: &Stress, estimator: Estimator) -> CellErrors {
    let mesh = space.mesh();
    let patches = Patches::new(mesh);
    let volumes: Vec<f64> = (0..mesh.tets().len()).into_par_iter().map(|t| mesh.cell_volume(t)).collect();
    let field = Field { space, stress, volumes: &volumes };
    let material = |t: usize| &materials[mesh.regions()[t].0 as usize];
    let Estimate { squared, nodal_stress, at_vertices, between } = if stress.is_linear() {
        quadratic::estimate(&field, &patches, material, estimator)
    } else {
        linear(&field, &patches, material, estimator)
    };
    let unestimated = patches.isolated();
    let recovered = Recovered { patches: patches.into_cells(), at_vertices, between };
    let raised = vec![1.0; materials.len()];
    CellErrors { squared, unseen: Vec::new(), raised, unresolved: Vec::new(), nodal_stress, recovered, unestimated }
}

/// What an estimate gives: squared errors of the cells, stress at the nodes, at the vertices of the patches, and between the
/// vertices of ten-node cells.
struct Estimate {
    squared: Vec<f64>,
    nodal_stress: Vec<SymTensor>,
    at_vertices: Vec<SymTensor>,
    between: Vec<[SymTensor; 6]>,
}

/// The estimate for a stress that is constant in each cell.
fn linear<'a>(
    field: &Field<'_>,
    patches: &Patches,
    material: impl Fn(usize) -> &'a Material + Sync,
    estimator: Estimator,
) -> Estimate {
    let mesh = field.space.mesh();
    let centroids: Vec<DVec3> = match estimator {
        Estimator::Spr | Estimator::Residual => {
            let cells = (0..mesh.tets().len()).into_par_iter();
            cells.map(|t| mesh.cell_points(t).into_iter().sum::<DVec3>() / 4.0).collect()
        }
        Estimator::Averaging => Vec::new(),
    };
    let recovered: Vec<SymTensor> = (0..patches.len())
        .into_par_iter()
        .map(|p| {
            let cells = patches.to_recover_from(p);
            match estimator {
                Estimator::Spr | Estimator::Residual => spr::recover(field, &centroids, patches.vertex(p), &cells),
                Estimator::Averaging => averaging::recover(field, &cells),
            }
        })
        .collect();
    let squared = (0..field.stress.cells())
        .into_par_iter()
        .map(|t| {
            if patches.is_isolated(t) {
                return 0.0;
            }
            let own = field.stress.mean(t);
            let differences = patches.of_cell(t).map(|p| minus(&recovered[p as usize], &own));
            squared_error(material(t), field.volumes[t], &differences)
        })
        .collect();
    let nodal_stress = at_vertices(field, patches, &recovered);
    Estimate { squared, nodal_stress, at_vertices: recovered, between: Vec::new() }
}

/// The stress of the elements.
struct Field<'a> {
    space: &'a Space<'a>,
    stress: &'a Stress,
    volumes: &'a [f64],
}

impl Field<'_> {
    fn volume_of(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&t| self.volumes[t as usize]).sum()
    }
}

/// Mean of the product of the shape functions of nodes `a` and `b` over a cell of four or ten nodes.
pub(super) fn mass(nodes: usize, a: usize, b: usize) -> f64 {
    match nodes {
        4 if a == b => 0.1,
        4 => 0.05,
        _ => quadratic::shape_product(a, b),
    }
}

fn minus(a: &SymTensor, b: &SymTensor) -> SymTensor {
    std::array::from_fn(|i| a[i] - b[i])
}

/// `sum += weight * s`.
fn add_scaled(sum: &mut SymTensor, weight: f64, s: &SymTensor) {
    for (total, x) in sum.iter_mut().zip(s) {
        *total += weight * x;
    }
}

/// Integral of the complementary product of the linear field with these values at the vertices.
fn squared_error(material: &Material, volume: f64, differences: &[SymTensor; 4]) -> f64 {
    let mut sum = [0.0; 6];
    differences.iter().for_each(|d| add_scaled(&mut sum, 1.0, d));
    let squares: f64 = differences.iter().map(|d| material.compliance_energy(*d)).sum();
    // Rounding may leave less than nothing where all differences vanish but for their trace at nu near 1/2.
    (volume / 20.0 * (squares + material.compliance_energy(sum))).max(0.0)
}

/// One stress a vertex: the mean over the regions there, weighted by volume.
fn at_vertices(field: &Field, patches: &Patches, recovered: &[SymTensor]) -> Vec<SymTensor> {
    let mean = |v: u32| {
        let (mut sum, mut weight) = ([0.0; 6], 0.0);
        for p in patches.at_vertex(v) {
            let volume = field.volume_of(patches.cells(p));
            add_scaled(&mut sum, volume, &recovered[p]);
            weight += volume;
        }
        if weight > 0.0 { sum.map(|x| x / weight) } else { sum }
    };
    (0..field.space.mesh().points().len() as u32).into_par_iter().map(mean).collect()
}
