//! Variants beside each other.

use super::{count, figures, percent, table, text};
use crate::output::variants::Variants;

/// The runs of a comparison of variants; `degree` is that of the elements.
#[must_use]
pub fn variants(of: &Variants<'_>, degree: u8) -> String {
    let mut rows = table("variant|steps|cells|dofs|error %|worst\nangle|slope|dofs|seconds|MB");
    for v in &of.variants {
        let Some(last) = v.report.steps.last() else { continue };
        let error = last.error.true_relative.unwrap_or(last.error.relative);
        let mut row = vec![
            v.name.to_owned(),
            last.step.to_string(),
            count(last.mesh.cells),
            count(last.dofs),
            percent(error),
            format!("{:.1}", last.quality.worst),
            v.slope.map_or("-".to_owned(), |s| figures(s, 3)),
        ];
        match v.paid {
            Some(paid) => {
                row.extend([count(paid.dofs as usize), figures(paid.seconds, 3), figures(paid.bytes / 1e6, 3)])
            }
            None => row.extend(["-"; 3].map(str::to_owned)),
        }
        rows.add_row(row);
    }
    let common = match of.error {
        Some(error) => format!(
            "the last three columns: paid for {} % ({} error), which all reach",
            percent(error),
            of.error_source
        ),
        None => "no error that all reach".to_owned(),
    };
    format!(
        "{}\n{common}\n(log-log between steps; seconds of computing and memory from the start);\n\
         slope: of log error over log dofs in the last steps, at best -{degree}/3 for smooth solutions\n",
        text(rows)
    )
}
