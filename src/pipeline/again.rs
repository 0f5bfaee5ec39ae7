//! `subsolid report`: the page of results that are there.

use super::leftovers::{contestants, listed_steps};
use super::page::PAGE;
use super::print;
use crate::error::Error;
use crate::output::OutputError;
use crate::output::page::{Mark, OldStep, PageRun, Steps, write_page};
use crate::scenario::{LoadKind, Scenario, Selector};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A run that has left its files.
struct OldRun {
    name: String,
    report: Value,
    scenario: Scenario,
    overrides: Vec<String>,
    steps: Steps,
}

/// Writes `report.html` into a folder of results, of a run or of a comparison, from the files there: `report.json`,
/// `scenario.toml` and the VTK files.
///
/// # Errors
/// [`Error`] with its exit code: the folder holds no results, or their files cannot be read or shown.
pub fn report(folder: &Path, quiet: bool) -> Result<(), Error> {
    let has_report = |name: &String| folder.join(name).join("report.json").is_file();
    let mut names = if folder.join("compare.json").is_file() { contestants(folder) } else { vec![String::new()] };
    names.retain(has_report);
    names.dedup();
    let runs = names.into_iter().map(|name| old_run(folder, name)).collect::<Result<Vec<OldRun>, Error>>()?;
    let Some(first) = runs.first() else { return Err(refused(folder, "no results of a run are there").into()) };
    let ratios = json(&folder.join("compare.json")).map(|comparison| comparison["ratios"].clone());
    let page = |run: &'_ OldRun| serde_json::to_value(&run.scenario.document).unwrap_or_default();
    let documents: Vec<Value> = runs.iter().map(page).collect();
    let pages: Vec<PageRun<'_>> = runs
        .iter()
        .zip(documents)
        .map(|(run, scenario)| PageRun {
            name: &run.name,
            report: run.report.clone(),
            scenario,
            overrides: &run.overrides,
            steps: &run.steps,
        })
        .collect();
    let file = folder.join(PAGE);
    write_page(&file, &first.scenario.title, &pages, &ratios.unwrap_or_default())?;
    if quiet { Ok(()) } else { print(&format!("{}\n", file.display())) }
}

fn old_run(folder: &Path, name: String) -> Result<OldRun, Error> {
    let folder = folder.join(&name);
    let file = folder.join("report.json");
    let report = json(&file).ok_or_else(|| refused(&file, "it cannot be read"))?;
    let copy = folder.join("scenario.toml");
    let scenario = Scenario::from_file(&copy, &[])?;
    let listed = fs::read_to_string(folder.join("results.pvd")).unwrap_or_default();
    let files: Vec<PathBuf> = listed_steps(&listed).iter().map(|step| folder.join(step)).collect();
    if files.is_empty() {
        return Err(refused(&folder, "no VTK files are listed there (results.pvd); were they switched off?").into());
    }
    let mut steps = None;
    for file in files {
        let old = OldStep::read(&file)??;
        let steps = steps.get_or_insert_with(|| Steps::new(marks(&scenario, &old), scenario.features.sharp_angle()));
        steps.add(&folder.join(PAGE), &old.shown, &old.solved())?;
    }
    let steps = steps.unwrap_or_else(|| Steps::new(Vec::new(), scenario.features.sharp_angle()));
    let head = fs::read_to_string(&copy).unwrap_or_default();
    let overrides = head.lines().next().unwrap_or_default().split(", --set ").skip(1).map(str::to_owned).collect();
    Ok(OldRun { name, report, scenario, overrides, steps })
}

/// Supports and loads whose groups the files of a run have.
fn marks(scenario: &Scenario, old: &OldStep) -> Vec<Mark> {
    let mark = |what: &'static str, name: &str, selector: &Selector| {
        let own = match selector {
            Selector::Group(group) => old.group(group),
            _ => None,
        };
        let group = own.or_else(|| old.group(&format!("{what} {name}")))?;
        Some(Mark { name: name.to_owned(), what, group })
    };
    let supports = scenario.supports.iter().filter(|s| s.meets.is_none());
    let supports = supports.filter_map(|s| mark("support", &s.name, &s.selector));
    let loads = scenario.loads.iter().filter_map(|load| match &load.kind {
        LoadKind::Traction(at, _) | LoadKind::Pressure(at, _) | LoadKind::Force(at, _) => mark("load", &load.name, at),
        LoadKind::PointForce(..) | LoadKind::BodyForce(_) | LoadKind::Gravity(_) => None,
    });
    supports.chain(loads).collect()
}

fn json(path: &Path) -> Option<Value> {
    serde_json::from_str(&fs::read_to_string(path).ok()?).ok()
}

fn refused(path: &Path, why: &str) -> OutputError {
    OutputError::NotShown { path: path.to_owned(), why: why.to_owned() }
}
