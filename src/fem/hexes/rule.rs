//! Gauss-Legendre quadrature on the unit interval, square and cube.

use super::HexSpace;
use super::shared::Shared;
use crate::limit::{Part, Table};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// Points of the unit cube with weights of sum one.
#[derive(Debug, Clone, Default)]
pub struct Rule {
    /// Points.
    pub points: Vec<DVec3>,
    /// Weights.
    pub weights: Vec<f64>,
}

impl Rule {
    /// `n` Gauss points a direction in the cube, exact for polynomials of degree `2 n - 1` in each coordinate.
    #[must_use]
    pub fn cube(n: usize) -> Self {
        let line = gauss(n);
        let mut rule = Self::default();
        for [z, wz] in &line {
            for [y, wy] in &line {
                for [x, wx] in &line {
                    rule.points.push(DVec3::new(*x, *y, *z));
                    rule.weights.push(wx * wy * wz);
                }
            }
        }
        rule
    }

    /// The rule on each of these parts of the cube.
    #[must_use]
    pub fn in_parts(&self, parts: &[Part]) -> Self {
        let mut rule = Self::default();
        for &(corner, size) in parts {
            rule.points.extend(self.points.iter().map(|p| corner + size * *p));
            rule.weights.extend(self.weights.iter().map(|w| w * size.powi(3)));
        }
        rule
    }

    /// The rule of face `k` on each of the parts that lie at it.
    fn in_parts_of_face(&self, k: usize, parts: &[Part]) -> Self {
        let (mut rule, axis, end) = (Self::default(), k / 2, (k % 2) as f64);
        for &(corner, size) in parts.iter().filter(|(corner, size)| corner[axis] + end * size == end) {
            rule.points.extend(self.points.iter().map(|p| corner + size * *p));
            rule.weights.extend(self.weights.iter().map(|w| w * size.powi(2)));
        }
        rule
    }

    /// `n` Gauss points a direction on face `k` of the cube (see [`crate::mesh::hex::FACES`]).
    #[must_use]
    pub fn face(k: usize, n: usize) -> Self {
        let (line, axis) = (gauss(n), k / 2);
        let mut rule = Self::default();
        for [v, wv] in &line {
            for [u, wu] in &line {
                let mut point = DVec3::ZERO;
                point[axis] = (k % 2) as f64;
                point[(axis + 1) % 3] = *u;
                point[(axis + 2) % 3] = *v;
                rule.points.push(point);
                rule.weights.push(wu * wv);
            }
        }
        rule
    }
}

/// A rule for each class of cells, with the functions at its points.
#[derive(Debug)]
pub(super) struct Quadrature {
    rules: Vec<Rule>,
    tables: Shared<Table>,
}

impl Quadrature {
    /// `n` Gauss points a direction, in parts of cells that are no polynomials.
    pub fn new(space: &HexSpace<'_>, n: usize) -> Self {
        Self::of_rules(space, |class| Rule::cube(n).in_parts(&space.parts(class, space.options().splits)))
    }

    /// The points of the stiffness, so many a direction at least, in parts that are halved so often at least.
    pub fn of_stiffness(space: &HexSpace<'_>, points: usize, splits: u32) -> Self {
        let depth = space.options().splits.max(splits);
        let rule = |class| Rule::cube(space.gauss_points(class).max(points)).in_parts(&space.parts(class, depth));
        Self::of_rules(space, rule)
    }

    /// `n` Gauss points a direction on face `k` of the cells, in parts where they are no polynomials.
    pub fn on_face(space: &HexSpace<'_>, k: usize, n: usize) -> Self {
        let depth = space.options().splits;
        Self::of_rules(space, |class| Rule::face(k, n).in_parts_of_face(k, &space.parts(class, depth)))
    }

    fn of_rules(space: &HexSpace<'_>, rule: impl Fn(usize) -> Rule + Sync + Send) -> Self {
        let rules: Vec<Rule> = (0..space.classes()).into_par_iter().map(rule).collect();
        Self { rules, tables: Shared::new(space) }
    }

    /// The weights and the functions of cell `t`.
    pub fn of(&self, space: &HexSpace<'_>, t: usize) -> (&[f64], Cow<'_, Table>) {
        let class = space.class(t);
        let rule = &self.rules[class];
        (&rule.weights, self.tables.of(space, class, || space.table(class, &rule.points)))
    }
}

/// Points and weights on [0, 1], by Newton's method on Legendre's polynomial.
fn gauss(n: usize) -> Vec<[f64; 2]> {
    let point = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Quadratic convergence from a good start: four steps suffice.
        for _ in 0..8 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            slope = n as f64 * (x * value - last) / (x * x - 1.0);
            x -= value / slope;
        }
        [0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..n).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for n in 1..=8 {
            let line = gauss(n);
            for degree in 0..2 * n as i32 {
                let sum: f64 = line.iter().map(|[x, w]| w * x.powi(degree)).sum();
                assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "{n} points, degree {degree}: {sum}");
            }
        }
    }
}
