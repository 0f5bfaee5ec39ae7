//! Global against adaptive refinement: the ratios of two runs of one scenario.

use super::report::{Report, StepRecord};
use serde::Serialize;

/// Two runs and what the second saved: `compare.json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison<'a> {
    /// All cells refined at every step.
    pub global: &'a Report,
    /// Selected cells refined.
    pub adaptive: &'a Report,
    /// Global over adaptive.
    pub ratios: &'a Ratios,
}

/// Ratios global over adaptive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratios {
    /// At each step both runs made.
    pub equal_step: Vec<StepRatio>,
    /// Where both runs have the same error.
    pub equal_error: EqualError,
}

/// Ratios global over adaptive at one step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepRatio {
    /// The step, the same of both runs.
    pub step: usize,
    /// Ratio of the cells.
    pub cells: f64,
    /// Ratio of the unknowns.
    pub unknowns: f64,
    /// Ratio of the seconds that computing took in this step alone: refine, assemble, solve, estimate, mark.
    pub seconds: f64,
    /// Ratio of the strain energies.
    pub energy: f64,
}

/// Ratios global over adaptive at the larger of the two final relative errors, by linear interpolation of the logarithms
/// between the steps where each run first reaches that error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EqualError {
    /// The relative error.
    pub error: Option<f64>,
    /// Where the errors come from.
    pub error_source: &'static str,
    /// Ratio of the cells.
    pub cells: Option<f64>,
    /// Ratio of the unknowns.
    pub unknowns: Option<f64>,
    /// Ratio of the seconds of computing from the start until that error is reached, earlier steps included.
    pub seconds: Option<f64>,
    /// Ratio of the most memory held until then.
    pub memory: Option<f64>,
    /// Why there is no ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Compares two runs of the same scenario.
#[must_use]
pub fn ratios(global: &Report, adaptive: &Report) -> Ratios {
    let equal_step = global.steps.iter().zip(&adaptive.steps).map(|(g, a)| step_ratio(g, a)).collect();
    let error_source = error_source([global, adaptive]);
    let equal_error = equal_error(&costs(&global.steps), &costs(&adaptive.steps), error_source);
    let equal_error = equal_error.unwrap_or_else(|reason| EqualError {
        error: None,
        error_source,
        cells: None,
        unknowns: None,
        seconds: None,
        memory: None,
        reason: Some(reason),
    });
    Ratios { equal_step, equal_error }
}

/// What [`error_source`] says of errors that are known exactly.
pub const TRUE: &str = "true";

/// Where the errors of runs come from: they are estimated unless the true ones of all are known.
#[must_use]
pub fn error_source<'a>(runs: impl IntoIterator<Item = &'a Report>) -> &'static str {
    let known = runs.into_iter().flat_map(|r| &r.steps).all(|s| s.error.true_relative.is_some());
    if known { TRUE } else { "estimated" }
}

fn step_ratio(global: &StepRecord, adaptive: &StepRecord) -> StepRatio {
    StepRatio {
        step: global.step,
        cells: global.mesh.cells as f64 / adaptive.mesh.cells as f64,
        unknowns: global.free_dofs as f64 / adaptive.free_dofs as f64,
        seconds: global.seconds.computing() / adaptive.seconds.computing(),
        energy: global.strain_energy / adaptive.strain_energy,
    }
}

/// What a run had paid when it had an error: a point of its curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// The relative error: the true one where it is known.
    pub error: f64,
    /// Cells, unknowns, seconds of computing since the start, most bytes held since the start.
    pub paid: [f64; 4],
}

/// The curve of a run. Steps without an error that has a logarithm are left out.
#[must_use]
pub fn costs(steps: &[StepRecord]) -> Vec<Cost> {
    let mut seconds = 0.0;
    let all = steps.iter().map(|s| {
        seconds += s.seconds.computing();
        Cost {
            error: s.error.true_relative.unwrap_or(s.error.relative),
            paid: [s.mesh.cells as f64, s.free_dofs as f64, seconds, s.peak_memory_bytes as f64],
        }
    });
    all.filter(|c| c.error.is_finite() && c.error > 0.0).collect()
}

fn equal_error(global: &[Cost], adaptive: &[Cost], error_source: &'static str) -> Result<EqualError, String> {
    let last =
        |run: &[Cost], name: &str| run.last().map(|c| c.error).ok_or(format!("the {name} run has no error above 0"));
    let error = last(global, "global")?.max(last(adaptive, "adaptive")?);
    let [global, adaptive] = [paid_at(global, error, "global")?, paid_at(adaptive, error, "adaptive")?];
    let ratio = |i: usize| Some(global[i] / adaptive[i]).filter(|r: &f64| r.is_finite());
    Ok(EqualError {
        error: Some(error),
        error_source,
        cells: ratio(0),
        unknowns: ratio(1),
        seconds: ratio(2),
        memory: ratio(3),
        reason: None,
    })
}

/// What a run had paid when its error first fell to `error`.
pub(super) fn paid_at(run: &[Cost], error: f64, name: &str) -> Result<[f64; 4], String> {
    let (before, after) = match run.iter().position(|c| c.error <= error) {
        Some(0) if run[0].error < error => {
            return Err(format!(
                "the {name} run starts with the error {:.4e}, already below {error:.4e}, where the other run ends",
                run[0].error
            ));
        }
        Some(0) => return Ok(run[0].paid),
        Some(i) => (run[i - 1], run[i]),
        None => return Err(format!("the {name} run never reaches the error {error:.4e}")),
    };
    let t = (error / before.error).ln() / (after.error / before.error).ln();
    Ok([0, 1, 2, 3].map(|i| before.paid[i] * (after.paid[i] / before.paid[i]).powf(t)))
}

#[cfg(test)]
mod tests {
    use super::super::report::PhaseSeconds;
    use super::super::report::tests::{report, step};
    use super::*;

    /// A run whose error is `c * unknowns^-rate`, and whose seconds from the start are `unknowns / 1000`.
    fn power_law(c: f64, rate: f64, unknowns: &[usize]) -> Report {
        let mut paid = 0.0;
        let steps = unknowns.iter().enumerate().map(|(i, &n)| {
            let mut record = step(i);
            record.free_dofs = n;
            record.mesh.cells = 2 * n;
            record.error.relative = c * (n as f64).powf(-rate);
            // Writing differs from run to run, it must not count.
            let (solve, write) = (n as f64 / 1000.0 - paid, 7.0 * c * i as f64);
            record.seconds = PhaseSeconds { solve, write, total: solve + write, ..PhaseSeconds::default() };
            paid = n as f64 / 1000.0;
            record
        });
        report(steps.collect())
    }

    #[test]
    fn power_laws_give_the_exact_ratio_at_equal_error() {
        let global = power_law(3.0, 0.2, &[300, 2_000, 15_000, 120_000]);
        let adaptive = power_law(3.0, 1.0 / 3.0, &[300, 700, 1_500, 5_000]);
        let e = ratios(&global, &adaptive).equal_error;
        let target = 3.0 * 120_000_f64.powf(-0.2);
        assert_eq!(e.error, Some(target));
        let expected = 120_000.0 / 120_000_f64.powf(0.6);
        for ratio in [e.cells, e.unknowns, e.seconds] {
            assert!((ratio.unwrap() / expected - 1.0).abs() < 1e-12, "{ratio:?} {expected}");
        }
        assert_eq!(e.reason, None);
        let turned = ratios(&adaptive, &global).equal_error;
        assert!((turned.unknowns.unwrap() * expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn equal_steps_compare_only_steps_both_runs_made() {
        let global = power_law(1.0, 0.2, &[300, 2_400]);
        let adaptive = power_law(1.0, 0.3, &[300, 600, 900]);
        let steps = ratios(&global, &adaptive).equal_step;
        assert_eq!(steps.iter().map(|s| s.step).collect::<Vec<_>>(), [0, 1]);
        assert_eq!((steps[1].cells, steps[1].unknowns), (4.0, 4.0));
        // 2,400 - 300 against 600 - 300 unknowns were paid for by the step alone.
        assert!((steps[1].seconds - 7.0).abs() < 1e-12);
        assert_eq!(steps[1].energy, 1.0);
    }

    #[test]
    fn a_curve_that_is_not_monotone_counts_where_it_first_reaches_the_error() {
        let mut global = power_law(1.0, 0.2, &[300, 600, 900]);
        for (record, error) in global.steps.iter_mut().zip([0.4, 0.1, 0.2]) {
            record.error.relative = error;
        }
        let mut adaptive = power_law(1.0, 0.2, &[300, 600]);
        for (record, error) in adaptive.steps.iter_mut().zip([0.4, 0.1]) {
            record.error.relative = error;
        }
        let e = ratios(&global, &adaptive).equal_error;
        // Both reach 0.2, the larger final error, halfway (in logarithms) between 300 and 600 unknowns.
        assert_eq!(e.error, Some(0.2));
        assert!((e.unknowns.unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_ratio_without_a_common_error_and_the_reason_is_said() {
        let one = power_law(1.0, 0.2, &[300]);
        let same = ratios(&one, &one).equal_error;
        assert_eq!((same.cells, same.unknowns, same.seconds, same.reason), (Some(1.0), Some(1.0), Some(1.0), None));

        let better = power_law(0.5, 0.2, &[300, 600]);
        let apart = ratios(&one, &better).equal_error;
        assert_eq!((apart.error, apart.cells), (None, None));
        assert!(apart.reason.unwrap().starts_with("the adaptive run starts with the error"));

        for bad in [0.0, f64::NAN, f64::INFINITY] {
            let mut exact = one.clone();
            exact.steps[0].error.relative = bad;
            let none = ratios(&exact, &one).equal_error;
            assert_eq!(none.reason.as_deref(), Some("the global run has no error above 0"));
        }
        let empty = ratios(&report(Vec::new()), &one);
        assert!(empty.equal_step.is_empty() && empty.equal_error.reason.is_some());
    }

    #[test]
    fn ratios_that_are_not_finite_are_null_in_json() {
        let mut global = power_law(1.0, 0.2, &[300]);
        let mut adaptive = global.clone();
        adaptive.steps[0].seconds = PhaseSeconds::default();
        adaptive.steps[0].strain_energy = 0.0;
        global.steps[0].strain_energy = 0.0;
        let r = ratios(&global, &adaptive);
        let json = serde_json::to_value(Comparison { global: &global, adaptive: &adaptive, ratios: &r }).unwrap();
        assert!(json["ratios"]["equal_step"][0]["seconds"].is_null());
        assert!(json["ratios"]["equal_step"][0]["energy"].is_null());
        assert!(json["ratios"]["equal_error"]["seconds"].is_null());
        assert_eq!(json["ratios"]["equal_error"]["error_source"], "estimated");
    }
}
