//! Which cell holds a place: cells by the boxes around some of their points, then Newton's method.

use super::HexSpace;
use glam::DVec3;

/// Points along each axis at which a cell is sampled.
const SAMPLES: usize = 4;

/// How much larger than around its samples the box of a cell is taken, as a part of its diagonal.
const MARGIN: f64 = 0.15;

/// Steps of Newton's method.
const STEPS: usize = 30;

/// A place as seen from the cell that holds it, or whose point is nearest to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HexPlace {
    /// The cell.
    pub cell: usize,
    /// Coordinates in its unit cube.
    pub at: DVec3,
    /// Distance from there: zero inside, but for rounding.
    pub distance: f64,
}

/// Finds cells by place.
#[derive(Debug)]
pub struct HexLocator<'a, 'm> {
    space: &'a HexSpace<'m>,
    samples: Vec<DVec3>,
    /// Sampled points of each cell.
    points: Vec<Vec<DVec3>>,
    boxes: Vec<[DVec3; 2]>,
}

impl<'a, 'm> HexLocator<'a, 'm> {
    /// Samples the cells.
    #[must_use]
    pub fn new(space: &'a HexSpace<'m>) -> Self {
        // Not at corners, where extraordinary cells are dear to evaluate.
        let line = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
        let samples: Vec<DVec3> = (0..SAMPLES.pow(3))
            .map(|i| DVec3::new(line(i % SAMPLES), line(i / SAMPLES % SAMPLES), line(i / SAMPLES / SAMPLES)))
            .collect();
        let tables = space.tables(samples.clone());
        let points = space.of_cells(|t| {
            let table = tables.of(space, t);
            (0..samples.len()).map(|q| space.frame(t, &table, q).0).collect::<Vec<_>>()
        });
        let around = |points: &Vec<DVec3>| {
            let lo = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let hi = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            let margin = DVec3::splat(MARGIN * lo.distance(hi));
            [lo - margin, hi + margin]
        };
        let boxes = points.iter().map(around).collect();
        Self { space, samples, points, boxes }
    }

    /// The cell that holds a place, the first of several; else the nearest point found.
    #[must_use]
    pub fn nearest(&self, x: DVec3) -> HexPlace {
        let outside = |[lo, hi]: &[DVec3; 2]| x.clamp(*lo, *hi).distance(x);
        let mut order: Vec<(f64, usize)> = self.boxes.iter().map(outside).zip(0..).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best = HexPlace { cell: 0, at: DVec3::splat(0.5), distance: f64::INFINITY };
        for (bound, cell) in order {
            if bound >= best.distance || best.distance <= 1e-12 * self.size(best.cell) {
                break;
            }
            let (at, distance) = self.newton(cell, x);
            if distance < best.distance {
                best = HexPlace { cell, at, distance };
            }
        }
        best
    }

    fn size(&self, cell: usize) -> f64 {
        let [lo, hi] = self.boxes[cell];
        lo.distance(hi)
    }

    /// The point of a cell nearest to a place, from the nearest sample: Newton's method, held inside the unit cube.
    fn newton(&self, cell: usize, x: DVec3) -> (DVec3, f64) {
        let near = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|i| self.points[cell][*i].distance_squared(x));
            a.total_cmp(&b)
        };
        let start = (0..self.samples.len()).min_by(near).map_or(DVec3::splat(0.5), |i| self.samples[i]);
        let (mut at, mut best) = (start, (start, f64::INFINITY));
        for _ in 0..STEPS {
            let table = self.space.table(self.space.class(cell), &[at]);
            let (place, jacobian) = self.space.frame(cell, &table, 0);
            let distance = place.distance(x);
            if distance < best.1 {
                best = (at, distance);
            }
            let next = (at + jacobian.inverse() * (x - place)).clamp(DVec3::ZERO, DVec3::ONE);
            if !next.is_finite() || next.distance(at) < 1e-15 {
                break;
            }
            at = next;
        }
        best
    }
}
