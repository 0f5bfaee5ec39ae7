//! The page of a run or of a comparison, from what the commands have.

use crate::error::Error;
use crate::fem::{LoadKind, Model};
use crate::output::page::{Mark, PageRun, Steps, write_page};
use crate::output::report::Report;
use crate::scenario::{Scenario, Strategy};
use serde::Serialize;
use std::path::Path;

/// The page's name.
pub(super) const PAGE: &str = "report.html";

/// The page's part of a run, to be filled step by step.
pub(super) fn begin(scenario: &Scenario, model: &Model) -> Option<Steps> {
    scenario.output.report.then(|| Steps::new(marks(model), scenario.features.sharp_angle()))
}

/// Supports and loads that act on faces.
fn marks(model: &Model) -> Vec<Mark> {
    // Where groups meet there are edges and vertices only.
    let supports = model.supports.iter().filter(|s| s.meets.is_none());
    let supports = supports.map(|s| Mark { name: s.name.clone(), what: "support", group: s.group.0 });
    let loads = model.loads.iter().filter_map(|load| match load.kind {
        LoadKind::Traction(group, _) | LoadKind::Pressure(group, _) | LoadKind::Force(group, _) => {
            Some(Mark { name: load.name.clone(), what: "load", group: group.0 })
        }
        LoadKind::PointForce(..) | LoadKind::BodyForce(_) | LoadKind::Gravity(_) => None,
    });
    supports.chain(loads).collect()
}

/// A run with what is drawn of it.
pub(super) struct Run<'a> {
    /// Its name among several.
    pub name: &'a str,
    pub scenario: &'a Scenario,
    pub strategy: Strategy,
    pub report: &'a Report,
    pub steps: Option<&'a Steps>,
}

/// Writes the page into a folder, with the runs of which something is drawn; none if there is no such run.
pub(super) fn write(folder: &Path, title: &str, runs: &[Run<'_>], ratios: &impl Serialize) -> Result<(), Error> {
    let runs: Vec<PageRun<'_>> = runs.iter().filter_map(of_run).collect();
    if runs.is_empty() { Ok(()) } else { Ok(write_page(&folder.join(PAGE), title, &runs, ratios)?) }
}

/// What the page has of a run; nothing if nothing of it is drawn.
fn of_run<'a>(run: &Run<'a>) -> Option<PageRun<'a>> {
    let mut scenario = serde_json::to_value(&run.scenario.document).unwrap_or_default();
    scenario["refine"]["strategy"] = serde_json::to_value(run.strategy).unwrap_or_default();
    let report = serde_json::to_value(run.report).unwrap_or_default();
    Some(PageRun { name: run.name, report, scenario, overrides: &run.scenario.overrides, steps: run.steps? })
}
