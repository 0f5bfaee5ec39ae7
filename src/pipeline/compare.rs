//! `subsolid compare`: the same scenario refined globally and adaptively, and what adaptivity saved.

use super::doubts::ending;
use super::forecast;
use super::leftovers;
use super::page;
use super::passes::{self, Contestant};
use super::results::write_text;
use super::run::{failure, new_warnings, plot_curves, prepare, quantity_tables};
use super::{RunOptions, print};
use crate::error::Error;
use crate::output::atomic::ensure_writable_dir;
use crate::output::compare::{Comparison, ratios};
use crate::output::report::write_json;
use crate::output::table;
use crate::scenario::{Scenario, Strategy};
use crate::subdiv::options::Scheme;

/// What is said where a comparison shows little.
const NOTHING_REFINED: &str = "warning: the scenario refines nothing (refine.strategy = \"none\", or steps = 0 or absent); \
                               compare sets the strategies itself and takes refine.steps: try --set refine.steps=3\n";

/// Runs a scenario globally and adaptively from the same input mesh under the same stop rules, and writes both results
/// and the comparison. Where the whole is short, the phases are medians over `repeat` passes, or over nine if
/// steps are very short and `repeat` is not 1.
///
/// # Errors
/// [`Error`] with its exit code, as [`super::run::run`]; the tolerance and what is expected is asked of the adaptive run.
pub fn compare(scenario: &Scenario, options: &RunOptions, repeat: usize) -> Result<(), Error> {
    if scenario.refine.options.scheme == Scheme::Red {
        return Err(Error::NothingToCompare);
    }
    if scenario.hexes.is_some() {
        return Err(Error::NothingAdaptive);
    }
    let problem = prepare(scenario, options)?;
    for strategy in [Strategy::Global, Strategy::Adaptive] {
        forecast::refuse_too_large(scenario, strategy, &problem)?;
    }
    if !options.quiet && (scenario.refine.strategy == Strategy::None || scenario.refine.steps == 0) {
        print(NOTHING_REFINED)?;
    }
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_comparison(&folder, &["global", "adaptive"], scenario)?;
    let run = |name, strategy| Contestant { name, scenario, problem: &problem, strategy };
    let runs = [run("global", Strategy::Global), run("adaptive", Strategy::Adaptive)];
    let reports = passes::reports(scenario, &runs, options, repeat)?;
    let [(global, global_shown), (adaptive, adaptive_shown)] = &reports[..] else {
        return Err(Error::NothingToCompare);
    };
    let ratios = ratios(global, adaptive);
    let text =
        table::units(&scenario.units) + &table::comparison(global, adaptive, &ratios, scenario.published.as_ref());
    let comparison = Comparison { global, adaptive, ratios: &ratios };
    write_json(&folder.join("compare.json"), &comparison)?;
    write_text(&folder.join("compare.txt"), &text)?;
    let pages = [
        page::Run {
            name: "global",
            scenario,
            strategy: Strategy::Global,
            report: global,
            steps: global_shown.as_ref(),
        },
        page::Run {
            name: "adaptive",
            scenario,
            strategy: Strategy::Adaptive,
            report: adaptive,
            steps: adaptive_shown.as_ref(),
        },
    ];
    page::write(&folder, &scenario.title, &pages, &ratios)?;
    plot_curves(&folder, scenario.element, &[("global", global), ("adaptive", adaptive)])?;
    if let Some(path) = &options.json {
        write_json(path, &comparison)?;
    }
    if !options.quiet {
        let new = |name: &str, report| new_warnings(name, report, scenario, &problem.warnings);
        let mut doubts = new("global, ", global) + &new("adaptive, ", adaptive);
        for (name, strategy, report) in
            [("global", Strategy::Global, global), ("adaptive", Strategy::Adaptive, adaptive)]
        {
            doubts += &format!("{name}: {}\n{}", ending(scenario, strategy, report), quantity_tables(report));
        }
        print(&format!("{text}\n{doubts}results in {}\n", folder.display()))?;
    }
    failure(scenario, Strategy::Adaptive, adaptive).map_or(Ok(()), Err)
}
