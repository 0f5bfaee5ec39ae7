//! Marking that looks ahead: as few steps to the tolerance as one step may mark at most, all of the same growth.
//!
//! The error falls as `dofs^-r`, with the rate r of the last step. To the tolerance the mesh has to grow `g`-fold; a step
//! grows it at most `G`-fold, if it marks as much as it may. Then `m = ceil(ln g / ln G)` steps are needed, and each of
//! them marks what makes it grow by `g^(1/m)`: the last mesh, which takes most of the time, is as small as the tolerance
//! allows, and few are before it. Errors and counts decide, never the clock.

use super::forecast;
use crate::adapt::options::Marking;
use crate::fem::options::Element;
use crate::scenario::{Scenario, Strategy};

/// What is aimed at, as a share of the tolerance: a mesh that misses it by little costs a step more.
const AIM: f64 = 0.97;

/// A step of the loop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub cells: f64,
    pub dofs: f64,
    /// Estimated relative error.
    pub error: f64,
    /// Cells selected.
    pub selected: f64,
}

/// The marking of the step `now`, whose selection is not known yet, so that the relative error falls to `tolerance`.
/// `most` cells may be marked; `before` is the step before.
pub(super) fn marking(scenario: &Scenario, tolerance: f64, most: f64, now: Seen, before: Option<Seen>) -> Marking {
    let growth = (now.error / (AIM * tolerance)).powf(1.0 / rate(scenario.element, now, before));
    let added = added(scenario, now, before);
    let largest = 1.0 + added * most / now.cells;
    let steps = (growth.ln() / largest.ln()).ceil().max(1.0);
    let cells = (growth.powf(1.0 / steps) - 1.0) * now.cells / added;
    // Of what is not a number, as where an error is not known, the most.
    let cells = if cells.is_finite() { cells.clamp(1.0, most.max(1.0)) } else { most.max(1.0) };
    Marking::Fraction((cells / now.cells).min(1.0))
}

/// The power of the degrees of freedom with which the error falls: that of the last step, kept within what elements of
/// this degree p do, whose best is p/3 on smooth solutions.
fn rate(element: Element, now: Seen, before: Option<Seen>) -> f64 {
    let degree = match element {
        Element::Tet4 => 1.0,
        Element::Tet10 => 2.0,
    };
    let best = degree / 3.0;
    let seen = before.map(|b| (b.error / now.error).ln() / (now.dofs / b.dofs).ln());
    // Before there are two meshes, the rate that a singular edge leaves.
    seen.filter(|r| r.is_finite()).map_or(0.8 * best, |r| r.clamp(0.5 * best, 1.2 * best))
}

/// Cells that a marked cell adds: as in the last step, else as schemes do in the mean.
fn added(scenario: &Scenario, now: Seen, before: Option<Seen>) -> f64 {
    let rings = 1.0 + 2.0 * scenario.adapt.grow as f64;
    let mean = forecast::cells_after(scenario.refine.options.scheme, Strategy::Adaptive, 0.0, 1.0);
    let seen = before.map(|b| (now.cells - b.cells) / b.selected);
    rings * seen.filter(|a| a.is_finite()).map_or(mean, |a| a.clamp(0.5 * mean, 2.0 * mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scenario(element: &str) -> Scenario {
        let text = format!(
            "[mesh.fichera]\ncells = 2\n[materials.a]\nyoungs_modulus = 1\npoissons_ratio = 0.3\n\
             [supports.a]\ngroup = \"z-min\"\nfix = [\"x\", \"y\", \"z\"]\n[analysis]\nelement = \"{element}\"\n"
        );
        Scenario::from_text(&text, Path::new("case.toml"), &[]).unwrap()
    }

    /// Steps and the largest mesh of a run whose error is `dofs^-rate` and whose marked cells add five.
    fn run(rate: f64, start: f64, tolerance: f64) -> (usize, f64) {
        let scenario = scenario(if rate < 0.4 { "tet4" } else { "tet10" });
        let error = |cells: f64| start * (cells / 1000.0).powf(-rate);
        let (mut cells, mut before, mut steps) = (1000.0, None, 0);
        while error(cells) > tolerance {
            let now = Seen { cells, dofs: 4.0 * cells, error: error(cells), selected: 0.0 };
            let Marking::Fraction(share) = marking(&scenario, tolerance, 0.4 * cells, now, before) else { panic!() };
            before = Some(Seen { selected: share * cells, ..now });
            cells += 5.0 * share * cells;
            steps += 1;
        }
        (steps, cells)
    }

    #[test]
    fn the_tolerance_is_reached_in_the_fewest_steps_without_overshooting() {
        for rate in [0.28, 0.33, 0.5, 0.6] {
            for factor in [1.1_f64, 1.5, 3.0, 10.0] {
                let (steps, cells) = run(rate, 0.2, 0.2 / factor);
                let needed = factor.powf(1.0 / rate);
                // A step makes at most three meshes of one. The first goes by a rate that is not that of this run.
                assert!(steps as f64 <= (needed.ln() / 3.0_f64.ln()).ceil() + 1.0, "{rate} {factor}: {steps} steps");
                assert!(cells < 1000.0 * needed * 1.35, "{rate} {factor}: {cells} for {}", 1000.0 * needed);
            }
        }
    }

    #[test]
    fn what_is_not_known_marks_the_most() {
        let now = Seen { cells: 100.0, dofs: 400.0, error: f64::NAN, selected: 0.0 };
        assert_eq!(marking(&scenario("tet10"), 0.1, 40.0, now, None), Marking::Fraction(0.4));
    }
}
