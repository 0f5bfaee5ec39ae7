//! Tables of named quantities.

use super::super::report::{Report, StepRecord};
use super::{figures, percent, short, table, text};

/// Figures printed of a quantity.
const FIGURES: usize = 6;

/// The quantities of each step, empty if there are none.
#[must_use]
pub fn quantities(records: &[StepRecord]) -> String {
    let Some(first) = records.first().filter(|r| !r.quantities.is_empty()) else { return String::new() };
    let names: Vec<&str> = first.quantities.iter().map(|(name, _)| name.as_str()).collect();
    let mut rows = table(&format!("step|{}", names.join("|")));
    for record in records {
        let mut row = vec![record.step.to_string()];
        row.extend(record.quantities.iter().map(|(_, q)| figures(q.value, FIGURES)));
        rows.add_row(row);
    }
    format!("Quantities\n{}\n", text(rows))
}

/// What was expected beside what came out, empty if nothing was expected.
#[must_use]
pub fn expectations(report: &Report) -> String {
    if report.expectations.is_empty() {
        return String::new();
    }
    let mut rows = table("quantity|value|expected|deviation|allowed|");
    for (name, e) in &report.expectations {
        let share = if e.expected == 0.0 {
            figures(e.deviation, 3)
        } else {
            format!("{} %", percent(e.deviation / e.expected.abs()))
        };
        let allowed = if e.expected == 0.0 {
            figures(e.allowed, 3)
        } else {
            format!("{} %", percent(e.allowed / e.expected.abs()))
        };
        let [value, expected] = [e.value, e.expected].map(|x| figures(x, FIGURES));
        let (expected, share, allowed) = match e.between {
            Some([low, high]) => {
                (format!("{} to {}", short(low, FIGURES), short(high, FIGURES)), String::new(), String::new())
            }
            None => (expected, share, allowed),
        };
        let verdict = if e.passed { "pass" } else { "FAIL" };
        rows.add_row([name.clone(), value, expected, share, allowed, verdict.to_owned()]);
    }
    text(rows) + "\n"
}

/// The estimated error of each step beside the true one, empty where that is not known.
#[must_use]
pub fn true_errors(records: &[StepRecord]) -> String {
    let mut rows = table("step|estimated\nerror|true\nerror|effectivity|true relative\nerror %");
    for record in records {
        let e = &record.error;
        let (Some(energy), Some(relative), Some(effectivity)) = (e.true_energy, e.true_relative, e.effectivity) else {
            return String::new();
        };
        rows.add_row([
            record.step.to_string(),
            figures(e.energy, 4),
            figures(energy, 4),
            figures(effectivity, 3),
            percent(relative),
        ]);
    }
    format!("Error in the energy norm\n{}\n", text(rows))
}
