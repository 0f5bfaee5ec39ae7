//! Several runs of one problem, each under other choices: what each paid for the error that all reach.

use super::compare::{Cost, costs, error_source, paid_at};
use super::report::Report;
use serde::Serialize;

/// Steps that a slope is fitted over at least: over fewer, one lucky step can make it steeper than theory allows.
const FEWEST: usize = 4;

/// A slope is fitted where a run has this part of its last unknowns and more: before, it has not found its rate yet.
const RANGE: f64 = 1.0 / 30.0;

/// Runs beside each other: `compare.json` of a comparison of variants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variants<'a> {
    /// The smallest relative error that all runs reach.
    pub error: Option<f64>,
    /// Where the errors come from.
    pub error_source: &'static str,
    /// The runs.
    pub variants: Vec<Variant<'a>>,
}

/// A run and what it paid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variant<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it overrides in the scenario.
    pub set: &'a [String],
    /// The run.
    pub report: &'a Report,
    /// Slope of the logarithm of the error over that of the unknowns, by least squares over the last steps; none over fewer
    /// than four.
    pub slope: Option<f64>,
    /// The steps of the slope.
    pub slope_steps: usize,
    /// What it had paid when it reached the common error.
    pub paid: Option<Paid>,
}

/// The price of an error, by linear interpolation of the logarithms between steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Paid {
    /// Unknowns.
    pub unknowns: f64,
    /// Seconds of computing from the start.
    pub seconds: f64,
    /// Most bytes held since the start.
    pub bytes: f64,
}

impl<'a> Variants<'a> {
    /// Puts runs beside each other: name, overrides and report of each.
    #[must_use]
    pub fn of(runs: &[(&'a str, &'a [String], &'a Report)]) -> Self {
        let curves: Vec<Vec<Cost>> = runs.iter().map(|(.., report)| costs(&report.steps)).collect();
        let least = |curve: &Vec<Cost>| curve.iter().map(|c| c.error).reduce(f64::min);
        let reached: Option<Vec<f64>> = curves.iter().map(least).collect();
        let error = reached.and_then(|all| all.into_iter().reduce(f64::max));
        let variant = |(&(name, set, report), curve): (&(&'a str, &'a [String], &'a Report), &Vec<Cost>)| {
            let paid = error.and_then(|error| paid_at(curve, error, name).ok());
            let paid = paid.map(|[_, unknowns, seconds, bytes]| Paid { unknowns, seconds, bytes });
            let late = late(curve);
            Variant { name, set, report, slope: slope(late), slope_steps: late.len(), paid }
        };
        let variants = runs.iter().zip(&curves).map(variant).collect();
        Self { error, error_source: error_source(runs.iter().map(|(.., report)| *report)), variants }
    }
}

/// The last part of a curve, where its rate is seen.
fn late(curve: &[Cost]) -> &[Cost] {
    let least = curve.last().map_or(0.0, |last| RANGE * last.paid[1]);
    &curve[curve.iter().position(|c| c.paid[1] >= least).unwrap_or_default()..]
}

/// The slope through the points, if they are enough.
fn slope(points: &[Cost]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|c| (c.paid[1].ln(), c.error.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
    (points.len() >= FEWEST && slope.is_finite()).then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::{report, step};
    use super::*;

    fn run(c: f64, rate: f64, unknowns: &[usize]) -> Report {
        let record = |(i, &n): (usize, &usize)| {
            let mut record = step(i);
            record.free_dofs = n;
            record.error.relative = c * (n as f64).powf(-rate);
            record.peak_memory_bytes = 100 * n as u64;
            record
        };
        report(unknowns.iter().enumerate().map(record).collect())
    }

    #[test]
    fn power_laws_have_their_slopes_and_pay_what_they_must() {
        let (a, b) =
            (run(2.0, 0.3, &[900, 10_000, 30_000, 100_000, 200_000]), run(5.0, 0.6, &[100, 500, 1_500, 2_000, 10_000]));
        let variants = Variants::of(&[("a", &[], &a), ("b", &[], &b)]);
        for (variant, rate) in variants.variants.iter().zip([0.3, 0.6]) {
            assert!((variant.slope.unwrap() + rate).abs() < 1e-12);
            // What has less than a thirtieth of the last unknowns does not count.
            assert_eq!(variant.slope_steps, 4);
        }
        let error = 2.0 * 200_000_f64.powf(-0.3);
        assert!((variants.error.unwrap() / error - 1.0).abs() < 1e-12);
        let paid = variants.variants[1].paid.unwrap();
        let expected = (5.0 / error).powf(1.0 / 0.6);
        assert!((paid.unknowns / expected - 1.0).abs() < 1e-12);
        assert!((paid.bytes / expected / 100.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn few_steps_have_no_slope_and_a_run_without_error_no_price() {
        let (a, mut b) = (run(2.0, 0.3, &[100, 300, 1_000]), run(5.0, 0.6, &[100]));
        b.steps[0].error.relative = 0.0;
        let variants = Variants::of(&[("a", &[], &a), ("b", &[], &b)]);
        assert_eq!((variants.error, variants.variants[0].slope, variants.variants[0].paid), (None, None, None));
    }
}
