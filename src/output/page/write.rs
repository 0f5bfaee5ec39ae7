//! The page's text: the template with the data in it.

use super::pick::Steps;
use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use serde::Serialize;
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// The page without data; `report/build.mjs` makes it.
const TEMPLATE: &str = include_str!("../../../report/dist/page.html");

/// Where the data go, and the title.
const DATA: &str = "<!--DATA-->";
const TITLE: &str = "<title>Subsolid</title>";

/// A run on a page.
#[derive(Debug)]
pub struct PageRun<'a> {
    /// Its name among several; empty of one.
    pub name: &'a str,
    /// What `report.json` holds.
    pub report: Value,
    /// The scenario as it was run.
    pub scenario: Value,
    /// Overrides of the scenario's file that it was run with.
    pub overrides: &'a [String],
    /// What is drawn.
    pub steps: &'a Steps,
}

/// Writes the page of a run or of a comparison, of which `ratios` are told if there are any. The same values give the same bytes.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn write_page(path: &Path, title: &str, runs: &[PageRun<'_>], ratios: &impl Serialize) -> Result<(), OutputError> {
    let error = |e: serde_json::Error| OutputError::write(path, e.into());
    let of_run = |run: &PageRun<'_>| {
        let steps = serde_json::to_value(&run.steps.steps)?;
        Ok(json!({
            "name": run.name,
            "report": run.report,
            "scenario": run.scenario,
            "overrides": run.overrides,
            "marks": run.steps.marks,
            "feature_angle": run.steps.feature_angle,
            "steps": steps,
        }))
    };
    let list = runs.iter().map(of_run).collect::<Result<Vec<Value>, serde_json::Error>>().map_err(error)?;
    let ratios = serde_json::to_value(ratios).map_err(error)?;
    let head = json!({ "format": 1, "title": title, "runs": list, "ratios": ratios });
    let head = serde_json::to_string(&head).map_err(error)?;
    let Some((before, after)) = TEMPLATE.split_once(DATA) else {
        return Err(OutputError::write(path, io::Error::other("the page's template has no place for data")));
    };
    let before = before.replacen(TITLE, &format!("<title>{} · Subsolid</title>", escaped(title)), 1);
    write_atomic(path, |w| {
        w.write_all(before.as_bytes())?;
        // No text of the user ends the element.
        writeln!(w, "<script type=\"application/json\" id=\"data\">{}</script>", head.replace('<', "\\u003c"))?;
        for (r, run) in runs.iter().enumerate() {
            for (s, text) in run.steps.texts.iter().enumerate() {
                writeln!(w, "<script type=\"text/plain\" id=\"step-{r}-{s}\">{text}</script>")?;
            }
        }
        w.write_all(after.as_bytes())
    })
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
