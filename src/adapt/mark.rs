//! Marking: an error per cell in, the cells to refine out.

use super::options::Marking;
use super::{AdaptError, CellErrors};

/// Selects cells by their estimated errors, one entry a cell; and those whose error is not known, as their children's
/// will be.
///
/// # Errors
/// As [`mark_values`].
pub fn mark(errors: &CellErrors, marking: Marking) -> Result<Vec<bool>, AdaptError> {
    let mut selected = mark_values(&errors.squared, marking)?;
    errors.unestimated.iter().for_each(|&t| selected[t as usize] = true);
    Ok(selected)
}

/// Selects cells by squared errors eta_K^2. A cell without error is never selected.
///
/// - Doerfler 1996: the smallest set with sum eta_K^2 >= theta sum over all cells; of equal errors the lower cell first.
/// - Maximum: eta_K >= theta max eta.
/// - Fraction: the worst theta n of n cells, rounded, at least one.
/// - Threshold: eta_K > t.
/// - Look-ahead: as Doerfler; to mark fewer is for those who know the steps before.
///
/// # Errors
/// [`AdaptError`] if theta is outside (0, 1], the threshold is negative or not finite, or an error is negative or not
/// finite.
pub fn mark_values(squared: &[f64], marking: Marking) -> Result<Vec<bool>, AdaptError> {
    check_parameter(marking)?;
    if let Some((cell, &value)) = squared.iter().enumerate().find(|(_, e)| !(e.is_finite() && **e >= 0.0)) {
        return Err(AdaptError::NotAnError { cell, value });
    }
    let largest = squared.iter().copied().fold(0.0, f64::max);
    Ok(match marking {
        Marking::Doerfler(theta) | Marking::LookAhead(theta) => doerfler(squared, theta),
        Marking::Maximum(theta) => {
            let bound = theta * largest.sqrt();
            squared.iter().map(|e| *e > 0.0 && e.sqrt() >= bound).collect()
        }
        Marking::Fraction(theta) => {
            let count = (theta * squared.len() as f64).round().max(1.0) as usize;
            select(squared, worst_first(squared).into_iter().take(count))
        }
        Marking::Threshold(bound) => squared.iter().map(|e| e.sqrt() > bound).collect(),
    })
}

fn check_parameter(marking: Marking) -> Result<(), AdaptError> {
    let (name, value) = match marking {
        Marking::Doerfler(theta) => ("doerfler", theta),
        Marking::Maximum(theta) => ("maximum", theta),
        Marking::Fraction(theta) => ("fraction", theta),
        Marking::LookAhead(theta) => ("look_ahead", theta),
        Marking::Threshold(value) if value >= 0.0 && value.is_finite() => return Ok(()),
        Marking::Threshold(value) => {
            return Err(AdaptError::Parameter { name: "threshold", value, range: "finite and not negative" });
        }
    };
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    Err(AdaptError::Parameter { name, value, range: "above 0 and at most 1" })
}

/// Cells by descending error, equal errors by cell.
fn worst_first(squared: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..squared.len()).collect();
    order.sort_unstable_by(|&a, &b| squared[b].total_cmp(&squared[a]).then(a.cmp(&b)));
    order
}

fn select(squared: &[f64], cells: impl Iterator<Item = usize>) -> Vec<bool> {
    let mut selected = vec![false; squared.len()];
    for cell in cells.filter(|&cell| squared[cell] > 0.0) {
        selected[cell] = true;
    }
    selected
}

fn doerfler(squared: &[f64], theta: f64) -> Vec<bool> {
    let order = worst_first(squared);
    // Summed in the order of selection, so that theta = 1 is reached exactly.
    let bound = theta * order.iter().map(|&cell| squared[cell]).sum::<f64>();
    let mut sum = 0.0;
    let enough = order.iter().take_while(|&&cell| {
        let wanted = sum < bound;
        sum += squared[cell];
        wanted
    });
    select(squared, enough.copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cells(squared: &[f64], marking: Marking) -> Vec<usize> {
        let selected = mark_values(squared, marking).unwrap();
        (0..squared.len()).filter(|&t| selected[t]).collect()
    }

    #[test]
    fn doerfler_takes_the_fewest_cells() {
        let squared = [1.0, 4.0, 2.0, 3.0];
        assert_eq!(cells(&squared, Marking::Doerfler(0.4)), [1]);
        assert_eq!(cells(&squared, Marking::Doerfler(0.41)), [1, 3]);
        assert_eq!(cells(&squared, Marking::Doerfler(1.0)), [0, 1, 2, 3]);
        assert_eq!(cells(&[1.0; 4], Marking::Doerfler(0.5)), [0, 1]);
    }

    #[test]
    fn maximum_and_threshold_compare_errors_not_squares() {
        let squared = [1.0, 4.0, 16.0];
        assert_eq!(cells(&squared, Marking::Maximum(0.5)), [1, 2]);
        assert_eq!(cells(&squared, Marking::Maximum(1.0)), [2]);
        assert_eq!(cells(&squared, Marking::Threshold(1.0)), [1, 2]);
        assert_eq!(cells(&squared, Marking::Threshold(0.0)), [0, 1, 2]);
    }

    #[test]
    fn fraction_counts_cells() {
        let squared: Vec<f64> = (1..=30).map(f64::from).collect();
        assert_eq!(cells(&squared, Marking::Fraction(0.1)), [27, 28, 29]);
        assert_eq!(cells(&squared, Marking::Fraction(1e-9)), [29]);
    }

    #[test]
    fn without_error_nothing_is_marked() {
        for marking in [Marking::Doerfler(1.0), Marking::Maximum(0.1), Marking::Fraction(1.0), Marking::Threshold(0.0)]
        {
            assert!(cells(&[0.0; 5], marking).is_empty());
            assert!(cells(&[], marking).is_empty());
        }
    }

    #[test]
    fn bad_parameters_and_bad_errors_are_refused() {
        for theta in [0.0, -0.5, 1.1, f64::NAN, f64::INFINITY] {
            for marking in [Marking::Doerfler(theta), Marking::Maximum(theta), Marking::Fraction(theta)] {
                assert!(matches!(mark_values(&[1.0], marking), Err(AdaptError::Parameter { .. })), "{marking:?}");
            }
        }
        for bound in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(mark_values(&[1.0], Marking::Threshold(bound)), Err(AdaptError::Parameter { .. })));
        }
        for bad in [f64::NAN, -1e-300, f64::INFINITY] {
            let error = mark_values(&[1.0, bad], Marking::Doerfler(0.5));
            assert!(matches!(error, Err(AdaptError::NotAnError { cell: 1, .. })), "{error:?}");
        }
    }

    proptest! {
        /// Whole numbers, so that sums are exact: the set reaches theta, and no set with one cell less does.
        #[test]
        fn doerfler_reaches_theta_and_is_minimal(
            squared in prop::collection::vec((0_u32..1000).prop_map(f64::from), 1..60), theta in 0.01_f64..=1.0
        ) {
            let marked = cells(&squared, Marking::Doerfler(theta));
            let bound = theta * squared.iter().sum::<f64>();
            prop_assert!(marked.iter().map(|&t| squared[t]).sum::<f64>() >= bound);
            let mut sorted = squared.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let best_of_fewer: f64 = sorted.iter().rev().take(marked.len().saturating_sub(1)).sum();
            prop_assert!(marked.is_empty() || best_of_fewer < bound);
        }

        /// The same errors in another order mark the same errors.
        #[test]
        fn marking_follows_a_relabelling(
            squared in prop::collection::vec(0.0_f64..1.0, 1..60), theta in 0.01_f64..=1.0, shift in 0_usize..60
        ) {
            let shift = shift % squared.len();
            for marking in [Marking::Doerfler(theta), Marking::Maximum(theta), Marking::Fraction(theta)] {
                let mut rotated = squared.clone();
                rotated.rotate_left(shift);
                let mut expected = mark_values(&squared, marking).unwrap();
                expected.rotate_left(shift);
                prop_assert_eq!(mark_values(&rotated, marking).unwrap(), expected);
            }
        }
    }
}
