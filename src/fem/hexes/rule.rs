//! Gauss-Legendre quadrature on the unit interval, square and cube.

use super::HexSpace;
use crate::limit::Table;
use glam::DVec3;
use rayon::prelude::*;

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

    /// The rule on each of the `8^times` parts of the halved cube.
    #[must_use]
    pub fn split(self, times: u32) -> Self {
        if times == 0 {
            return self;
        }
        let finer = self.split(times - 1);
        let mut rule = Self::default();
        for child in 0..8 {
            let corner = DVec3::from_array([0, 1, 2].map(|axis| f64::from(child >> axis & 1)));
            rule.points.extend(finer.points.iter().map(|p| 0.5 * (*p + corner)));
            rule.weights.extend(finer.weights.iter().map(|w| w / 8.0));
        }
        rule
    }

    /// The rule of a face on each of the `4^times` parts of the halved face.
    fn split_face(self, k: usize, times: u32) -> Self {
        if times == 0 {
            return self;
        }
        let finer = self.split_face(k, times - 1);
        let (mut rule, axis) = (Self::default(), k / 2);
        for child in 0..4 {
            let mut corner = DVec3::ZERO;
            // Across the face points stay where they are: (s + s) / 2.
            corner[axis] = (k % 2) as f64;
            corner[(axis + 1) % 3] = f64::from(child & 1);
            corner[(axis + 2) % 3] = f64::from(child >> 1);
            rule.points.extend(finer.points.iter().map(|p| 0.5 * (*p + corner)));
            rule.weights.extend(finer.weights.iter().map(|w| w / 4.0));
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
    tables: Vec<Table>,
}

impl Quadrature {
    /// `n` Gauss points a direction, in parts of cells that are no polynomials.
    pub fn new(space: &HexSpace<'_>, n: usize) -> Self {
        Self::halved(space, n, 0)
    }

    /// As before, with parts that are halved so often at least.
    pub fn halved(space: &HexSpace<'_>, n: usize, least: u32) -> Self {
        let splits = |class| if space.is_regular(class) { 0 } else { space.options().splits.max(least) };
        Self::of_rules(space, (0..space.classes()).map(|class| Rule::cube(n).split(splits(class))).collect())
    }

    /// `n` Gauss points a direction on face `k` of the cells, in parts where they are no polynomials.
    pub fn on_face(space: &HexSpace<'_>, k: usize, n: usize) -> Self {
        let splits = |class| if space.is_regular(class) { 0 } else { space.options().splits };
        Self::of_rules(space, (0..space.classes()).map(|class| Rule::face(k, n).split_face(k, splits(class))).collect())
    }

    fn of_rules(space: &HexSpace<'_>, rules: Vec<Rule>) -> Self {
        let tables = rules.par_iter().enumerate().map(|(class, rule)| space.table(class, &rule.points)).collect();
        Self { rules, tables }
    }

    /// Something of the weights and the functions of each class.
    pub fn each_class<T: Send>(&self, of: impl Fn(&[f64], &Table) -> T + Sync) -> Vec<T> {
        self.rules.par_iter().zip(&self.tables).map(|(rule, table)| of(&rule.weights, table)).collect()
    }

    /// The weights and the functions of cell `t`.
    pub fn of(&self, space: &HexSpace<'_>, t: usize) -> (&[f64], &Table) {
        let class = space.class(t);
        (&self.rules[class].weights, &self.tables[class])
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
