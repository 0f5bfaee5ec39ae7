//! Where axes carry numbers.

use crate::output::table::count;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// A linear axis with its numbers at the marks given. (The ready-made `with_key_points` cannot format floats.)
#[derive(Debug, Clone)]
pub(super) struct MarkedAxis {
    pub(super) range: Range<f64>,
    pub(super) marks: Vec<f64>,
}

impl Ranged for MarkedAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let t = (value - self.range.start) / (self.range.end - self.range.start);
        start + (t * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.marks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// Mantissas of the ticks in each decade, coarse to fine.
const LADDERS: [&[f64]; 5] = [
    &[1.0],
    &[1.0, 3.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
    &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 9.0],
];

/// Round numbers from `low` to `high` (both positive) for a logarithmic axis: those of the coarsest ladder that gives at
/// least four.
pub(super) fn logarithmic(low: f64, high: f64) -> Vec<f64> {
    let on = |ladder: &&[f64]| -> Vec<f64> {
        let decades = low.log10().floor() as i32..=high.log10().floor() as i32;
        let all = decades.flat_map(|d| ladder.iter().map(move |m| tidy(m * 10_f64.powi(d))));
        all.filter(|x| (low..=high).contains(x)).collect()
    };
    let [.., finest] = LADDERS;
    LADDERS.iter().map(on).find(|ticks| ticks.len() >= 4).unwrap_or_else(|| on(&finest))
}

/// The step of a linear axis from 0 to `high` with at most five steps: 1, 2 or 5 times a power of ten.
pub(super) fn linear_step(high: f64) -> f64 {
    let least = high / 5.0;
    let decade = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].iter().map(|m| tidy(m * decade)).find(|&step| step >= least).unwrap_or(high)
}

/// The number without the last digits that arithmetic left in it.
pub(super) fn tidy(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// The number as an axis shows it.
pub(super) fn number(x: f64) -> String {
    match tidy(x) {
        x if (1e3..1e7).contains(&x) => count(x as usize),
        x if (1e-4..1e3).contains(&x) => x.to_string(),
        x => format!("{x:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_unless_they_are_long() {
        let shown = [10_f64.powf(4.0), 10_f64.powf(-1.0), 0.30000000000000004, 1e-5, 2e9].map(number);
        assert_eq!(shown, ["10,000", "0.1", "0.3", "1e-5", "2e9"]);
    }

    #[test]
    fn wide_ranges_carry_decades_and_narrow_ones_at_least_a_few_numbers() {
        assert_eq!(logarithmic(0.5, 20_000.0), [1.0, 10.0, 100.0, 1000.0, 10_000.0]);
        assert_eq!(logarithmic(9.0, 110.0), [10.0, 20.0, 50.0, 100.0]);
        assert_eq!(logarithmic(0.02, 0.4), [0.02, 0.05, 0.1, 0.2]);
        assert!(logarithmic(0.29, 0.62).len() >= 4);
    }

    #[test]
    fn steps_are_round_and_few() {
        for (high, step) in [(0.61, 0.2), (1.0, 0.2), (6.0, 2.0), (37.0, 10.0), (100.0, 20.0)] {
            assert_eq!(linear_step(high), step, "{high}");
        }
    }
}
