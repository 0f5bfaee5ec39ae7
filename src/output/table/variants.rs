//! Variants beside each other.

use super::quantities::{deviation, value};
use super::{count, figures, percent, table, text};
use crate::output::variants::{Variant, Variants};

/// The runs of a comparison of variants; `degree` is that of the elements.
#[must_use]
pub fn variants(of: &Variants<'_>, degree: u8) -> String {
    let mut rows = table("variant|steps|cells|unknowns|error %|worst\nangle|slope");
    for v in &of.variants {
        let Some(last) = v.report.steps.last() else { continue };
        let error = last.error.true_relative.unwrap_or(last.error.relative);
        rows.add_row([
            v.name.to_owned(),
            last.step.to_string(),
            count(last.mesh.cells),
            count(last.free_dofs),
            percent(error),
            format!("{:.1}", last.quality.worst),
            v.slope.map_or("too few".to_owned(), |s| format!("{} ({})", figures(s, 3), v.slope_steps)),
        ]);
    }
    format!(
        "{}\n\
         slope: of log error over log unknowns in the last steps (how many), at best\n\
         -{degree}/3 for smooth solutions; none over fewer than four steps\n\n{}{}{}",
        text(rows),
        paid(of),
        goals(of),
        expectations(of)
    )
}

/// What the runs paid for the error that all reach.
fn paid(of: &Variants<'_>) -> String {
    let Some(error) = of.error else { return "no error that all reach\n".to_owned() };
    let mut rows = table("variant|unknowns|seconds|MB");
    for v in &of.variants {
        let paid = v.paid.map_or(["-"; 3].map(str::to_owned), |p| {
            [count(p.unknowns as usize), figures(p.seconds, 3), figures(p.bytes / 1e6, 3)]
        });
        rows.add_row([v.name.to_owned()].into_iter().chain(paid));
    }
    format!(
        "Paid for {} % ({} error), which all reach\n{}\n\
         log-log between steps; seconds of computing and memory from the start\n",
        percent(error),
        of.error_source,
        text(rows)
    )
}

/// The quantity aimed at, of the last steps; nothing where no run aims at one.
fn goals(of: &Variants<'_>) -> String {
    let mut rows = table("variant|quantity|value");
    let aimed = |v: &Variant<'_>| {
        let (name, q) = v.report.steps.last()?.quantities.iter().find(|(_, q)| q.error.is_some())?;
        Some([v.name.to_owned(), name.clone(), value(q)])
    };
    of.variants.iter().filter_map(aimed).for_each(|row| {
        rows.add_row(row);
    });
    if rows.is_empty() { String::new() } else { format!("\nThe quantity aimed at\n{}\n", text(rows)) }
}

/// What was expected beside what came out; nothing where nothing was expected.
fn expectations(of: &Variants<'_>) -> String {
    let mut rows = table("variant|quantity|value|expected|deviation|allowed|");
    for v in &of.variants {
        for (name, e) in &v.report.expectations {
            let [value, expected, share, allowed] = deviation(e);
            let verdict = if e.passed { "pass" } else { "FAIL" }.to_owned();
            rows.add_row([v.name.to_owned(), name.clone(), value, expected, share, allowed, verdict]);
        }
    }
    if rows.is_empty() { String::new() } else { format!("\nExpected\n{}\n", text(rows)) }
}
