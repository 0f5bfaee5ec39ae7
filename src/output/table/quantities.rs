//! Tables of named quantities.

use super::super::report::{ExpectationRecord, QuantityRecord, Report, StepRecord};
use super::{COLUMNS, figures, percent, short, table, text};

/// Figures printed of a quantity.
const FIGURES: usize = 6;

/// The quantities of each step, in as many tables as it takes for their width; empty if there are none.
#[must_use]
pub fn quantities(records: &[StepRecord]) -> String {
    let Some(first) = records.first().filter(|r| !r.quantities.is_empty()) else { return String::new() };
    let columns = first.quantities.iter().enumerate().map(|(i, (name, _))| {
        let values = records.iter().filter_map(|r| r.quantities.get(i)).map(|(_, q)| value(q));
        [name.clone()].into_iter().chain(values).collect::<Vec<String>>()
    });
    let mut tables: Vec<Vec<Vec<String>>> = Vec::new();
    let mut left = 0;
    for column in columns {
        let width = 1 + column.iter().map(|text| text.chars().count()).max().unwrap_or(0);
        match tables.last_mut() {
            Some(open) if width <= left => {
                open.push(column);
                left -= width;
            }
            _ => {
                tables.push(vec![column]);
                left = usize::from(COLUMNS).saturating_sub("step".len() + width);
            }
        }
    }
    let table_of = |columns: &Vec<Vec<String>>| {
        let names: Vec<&str> = columns.iter().map(|c| c[0].as_str()).collect();
        let mut rows = table(&format!("step|{}", names.join("|")));
        for (i, record) in records.iter().enumerate() {
            let values = columns.iter().filter_map(|c| c.get(i + 1)).cloned();
            rows.add_row([record.step.to_string()].into_iter().chain(values));
        }
        text(rows)
    };
    format!("Quantities\n{}\n", tables.iter().map(table_of).collect::<Vec<String>>().join("\n"))
}

/// A value, with its error bar if there is one.
pub(super) fn value(q: &QuantityRecord) -> String {
    let bar = q.error.map_or(String::new(), |bar| format!(" +- {}", figures(bar, 2)));
    figures(q.value, FIGURES) + &bar
}

/// What was expected beside what came out, empty if nothing was expected.
#[must_use]
pub fn expectations(report: &Report) -> String {
    if report.expectations.is_empty() {
        return String::new();
    }
    let mut rows = table("quantity|value|expected|deviation|allowed|");
    for (name, e) in &report.expectations {
        let [value, expected, share, allowed] = deviation(e);
        let verdict = if e.passed { "pass" } else { "FAIL" };
        rows.add_row([name.clone(), value, expected, share, allowed, verdict.to_owned()]);
    }
    text(rows) + "\n"
}

/// Value, what is expected, deviation and what is allowed as texts: relative ones where they can be; a range is expected as a
/// whole.
pub(super) fn deviation(e: &ExpectationRecord) -> [String; 4] {
    let [value, expected] = [e.value, e.expected].map(|x| figures(x, FIGURES));
    if let Some([low, high]) = e.between {
        return [value, format!("{} to {}", short(low, FIGURES), short(high, FIGURES)), String::new(), String::new()];
    }
    let share = |x: f64| match e.expected {
        0.0 => figures(x, 3),
        expected => format!("{} %", percent(x / expected.abs())),
    };
    [value, expected, share(e.deviation), share(e.allowed)]
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
