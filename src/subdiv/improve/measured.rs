//! Other measures of a cell than the minimum sine, for the paper's operations, and smoothing that needs no gradients.

use super::super::options::QualityMeasure;
use super::super::solid::Solid;
use crate::mesh::quality;
use glam::DVec3;

/// Cells with a smaller sine are as good as flat, whatever the measure says.
const VALID: f64 = 1e-3;

/// Vertices whose worst cell has more than this share of the regular tetrahedron's value are left alone. For the angles
/// about that of the pyramid on a regular triangle whose dihedral angles have the paper's sine of 0.3.
fn good(measure: QualityMeasure) -> f64 {
    match measure {
        QualityMeasure::MinSine | QualityMeasure::EdgeRatio => 0.3,
        QualityMeasure::MinDihedral => 0.25,
        QualityMeasure::MinSolidAngle => 0.15,
    }
}

/// Steps of the compass search, the first as a share of the shortest edge, and what a step must gain.
const STEPS: usize = 12;
const FIRST_STEP: f64 = 0.25;
const GAIN: f64 = 1e-3;

/// The measure of a cell as a share of its value for the regular tetrahedron; zero or less for cells that are flat or
/// inverted.
pub(super) fn value(measure: QualityMeasure, p: [DVec3; 4]) -> f64 {
    let sine = quality::min_sine(p);
    if sine <= VALID {
        return sine.min(0.0);
    }
    match measure {
        QualityMeasure::MinSine => sine / quality::REGULAR_SINE,
        QualityMeasure::MinDihedral => quality::min_dihedral(p) / quality::REGULAR_DIHEDRAL,
        QualityMeasure::MinSolidAngle => quality::min_solid_angle(p) / quality::REGULAR_SOLID_ANGLE,
        QualityMeasure::EdgeRatio => quality::edge_ratio(p),
    }
}

/// The smallest value of the cells.
pub(super) fn worst(solid: &Solid, cells: &[u32], measure: QualityMeasure) -> f64 {
    cells.iter().map(|&t| value(measure, solid.cell_points(t))).fold(f64::INFINITY, f64::min)
}

/// Where the worst cell of an interior vertex is better, if that cell is bad: at the mean of its neighbours, then by
/// compass search, which knows nothing of the measure but its values.
pub(super) fn better(solid: &Solid, v: u32, measure: QualityMeasure) -> Option<DVec3> {
    let start = solid.point(v);
    let old = worst_with(solid, v, start, measure);
    let good = good(measure);
    if old > good {
        return None;
    }
    let neighbours = neighbours(solid, v);
    let mean = neighbours.iter().sum::<DVec3>() / neighbours.len().max(1) as f64;
    let laplacian = worst_with(solid, v, mean, measure);
    let mut best = if laplacian > old { (mean, laplacian) } else { (start, old) };
    let shortest = neighbours.iter().map(|q| q.distance(best.0)).fold(f64::INFINITY, f64::min);
    let mut step = FIRST_STEP * shortest;
    for _ in 0..STEPS {
        if best.1 > good {
            break;
        }
        let found = compass_step(solid, v, best, step, measure);
        if found.1 > best.1 + GAIN {
            best = found;
        } else {
            step *= 0.5;
        }
    }
    (best.1 > old).then_some(best.0)
}

/// The best of a position and its six neighbours along the axes, with the worst value there.
fn compass_step(solid: &Solid, v: u32, from: (DVec3, f64), step: f64, measure: QualityMeasure) -> (DVec3, f64) {
    let directions = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    directions.into_iter().map(|d| from.0 + step * d).fold(from, |best, p| {
        let worst = worst_with(solid, v, p, measure);
        if worst > best.1 { (p, worst) } else { best }
    })
}

/// The smallest value of the cells at `v` if it were at `p`.
fn worst_with(solid: &Solid, v: u32, p: DVec3, measure: QualityMeasure) -> f64 {
    let at = |t: u32| solid.tet(t).map(|w| if w == v { p } else { solid.point(w) });
    solid.cells_at(v).iter().map(|&t| value(measure, at(t))).fold(f64::INFINITY, f64::min)
}

/// Positions of the vertices joined to `v`, in ascending order of their numbers.
fn neighbours(solid: &Solid, v: u32) -> Vec<DVec3> {
    let corners = solid.cells_at(v).iter().flat_map(|&t| solid.tet(t));
    let mut vertices: Vec<u32> = corners.filter(|&w| w != v).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.into_iter().map(|w| solid.point(w)).collect()
}
