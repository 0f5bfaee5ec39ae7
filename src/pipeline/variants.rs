//! `subsolid compare --schemes` and `--variant`: one problem under several choices, on equal terms.

use super::doubts::ending;
use super::leftovers::{self, is_name};
use super::page;
use super::passes::{self, Contestant};
use super::resolve::Resolved;
use super::results::write_text;
use super::run::{failure, plot_curves, prepare, warnings};
use super::{RunOptions, print};
use crate::error::Error;
use crate::fem::options::Element;
use crate::output::atomic::ensure_writable_dir;
use crate::output::report::{Report, write_json};
use crate::output::table;
use crate::output::variants::Variants;
use crate::scenario::{MAX_STEPS, Scenario, Stop};
use std::str::FromStr;

/// A name, and the keys of the scenario that it overrides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    /// Names its row, its curve and its folder.
    pub name: String,
    /// As `--set` takes them.
    pub set: Vec<String>,
}

/// The schemes, each plain and with the error-driven optimiser: name, scheme, strategy, optimiser.
const SCHEMES: [(&str, &str, &str, &str); 7] = [
    ("sqrt3-paper", "sqrt3", "adaptive", "{ mode = \"paper\" }"),
    ("sqrt3-quality", "sqrt3", "adaptive", "{ mode = \"best\", objective = \"quality\" }"),
    ("sqrt3-error", "sqrt3", "adaptive", "{ mode = \"best\", objective = \"error\" }"),
    ("bisection", "longest-edge", "adaptive", "{ mode = \"paper\" }"),
    ("bisection-error", "longest-edge", "adaptive", "{ mode = \"best\", objective = \"error\" }"),
    ("red", "red", "global", "{ mode = \"paper\" }"),
    ("red-error", "red", "global", "{ mode = \"best\", objective = \"error\" }"),
];

/// The subdivision schemes with and without the error-driven optimiser: sqrt(3) as published, optimised for its angles, and
/// for the error; longest-edge bisection and uniform red refinement plain and optimised for the error.
///
/// # Errors
/// [`Error::NoStopRule`]: steps of different schemes differ in size, so something else has to end the runs.
pub fn schemes(scenario: &Scenario) -> Result<Vec<Variant>, Error> {
    if scenario.refine.stop == Stop::default() {
        return Err(Error::NoStopRule);
    }
    let variant = |(name, scheme, strategy, optimise): (&str, &str, &str, &str)| {
        let set = vec![
            format!("refine.scheme=\"{scheme}\""),
            format!("refine.strategy=\"{strategy}\""),
            format!("refine.optimise={optimise}"),
            format!("refine.steps={MAX_STEPS}"),
        ];
        Variant { name: name.to_owned(), set }
    };
    Ok(SCHEMES.map(variant).into())
}

impl FromStr for Variant {
    type Err = String;

    /// `NAME: KEY=VALUE; KEY=VALUE; ...`, or the name alone for the scenario as it is.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, keys) = text.split_once(':').unwrap_or((text, ""));
        let name = name.trim().to_owned();
        if !is_name(&name) {
            return Err("expected NAME: KEY=VALUE; KEY=VALUE with a name of letters, digits, - and _".to_owned());
        }
        let keys = keys.split(';').map(str::trim).filter(|key| !key.is_empty());
        Ok(Self { name, set: keys.map(str::to_owned).collect() })
    }
}

/// A variant ready to run.
struct Entry<'a> {
    variant: &'a Variant,
    scenario: Scenario,
    problem: Resolved,
}

/// Runs the variants of a scenario one after the other and writes their results, and what each paid for the error that all
/// reach. Short runs are repeated as [`super::compare::compare`] does.
///
/// # Errors
/// [`Error`] with its exit code, as [`super::run::run`]; [`Error::Variants`] for two of one name, and [`Error::VariantsFail`]
/// where some are not as expected or miss the error asked for.
pub fn compare(scenario: &Scenario, variants: &[Variant], options: &RunOptions, repeat: usize) -> Result<(), Error> {
    let names: Vec<&str> = variants.iter().map(|v| v.name.as_str()).collect();
    check_names(&names)?;
    let entries = variants.iter().map(|v| entry(scenario, v, options)).collect::<Result<Vec<Entry<'_>>, Error>>()?;
    let folder = options.folder(scenario);
    ensure_writable_dir(&folder)?;
    leftovers::for_comparison(&folder, &names, scenario)?;
    let runs: Vec<Contestant<'_>> = entries.iter().map(Entry::contestant).collect();
    let (reports, shown): (Vec<Report>, Vec<_>) =
        passes::reports(scenario, &runs, options, repeat)?.into_iter().unzip();
    let rows: Vec<_> =
        entries.iter().zip(&reports).map(|(e, report)| (e.variant.name.as_str(), &e.variant.set[..], report)).collect();
    let result = Variants::of(&rows);
    let degree = if scenario.element == Element::Tet4 { 1 } else { 2 };
    let text = table::units(&scenario.units) + &table::variants(&result, degree);
    write_json(&folder.join("compare.json"), &result)?;
    write_text(&folder.join("compare.txt"), &text)?;
    let curves: Vec<_> = rows.iter().map(|(name, _, report)| (*name, *report)).collect();
    plot_curves(&folder, scenario.element, &curves)?;
    let pages: Vec<page::Run<'_>> = (entries.iter().zip(&reports).zip(&shown))
        .map(|((entry, report), steps)| {
            let (name, scenario) = (&entry.variant.name, &entry.scenario);
            page::Run { name, scenario, strategy: scenario.refine.strategy, report, steps: steps.as_ref() }
        })
        .collect();
    page::write(&folder, &scenario.title, &pages, &())?;
    if let Some(path) = &options.json {
        write_json(path, &result)?;
    }
    if !options.quiet {
        let mut doubts = String::new();
        for (entry, report) in entries.iter().zip(&reports) {
            let name = &entry.variant.name;
            doubts += &warnings(&format!("{name}, "), report);
            doubts += &format!("{name}: {}\n", ending(&entry.scenario, entry.scenario.refine.strategy, report));
        }
        print(&format!("{text}\n{doubts}results in {}\n", folder.display()))?;
    }
    failures(&entries, &reports).map_or(Ok(()), Err)
}

/// Refuses names that are one folder where the case of letters does not count, as on many systems.
fn check_names(names: &[&str]) -> Result<(), Error> {
    let twin = |i: usize| names[..i].iter().find(|other| other.eq_ignore_ascii_case(names[i]));
    let clash = (0..names.len()).find_map(|i| Some((twin(i)?, names[i])));
    clash.map_or(Ok(()), |(first, second)| {
        Err(Error::Variants { first: (*first).to_owned(), second: second.to_owned() })
    })
}

/// The error to end with if variants are not as they expect or miss the error they ask for; the code of an expectation goes
/// before that of a tolerance.
fn failures(entries: &[Entry<'_>], reports: &[Report]) -> Option<Error> {
    let failed: Vec<(&str, Error)> = entries
        .iter()
        .zip(reports)
        .filter_map(|(e, report)| {
            Some((e.variant.name.as_str(), failure(&e.scenario, e.scenario.refine.strategy, report)?))
        })
        .collect();
    let code = failed.iter().map(|(_, error)| error.exit_code()).min()?;
    let sentences = failed.iter().map(|(name, error)| format!("{name}: {error}")).collect::<Vec<String>>().join("\n");
    Some(Error::VariantsFail { sentences, code })
}

/// Reads the scenario anew with the overrides of a variant; what it says is said once, by the first.
fn entry<'a>(scenario: &Scenario, variant: &'a Variant, options: &RunOptions) -> Result<Entry<'a>, Error> {
    let scenario = scenario.variant(&variant.name, &variant.set)?;
    if scenario.hexes.is_some() {
        return Err(Error::NothingAdaptive);
    }
    let problem = prepare(&scenario, &RunOptions { quiet: true, ..options.clone() })?;
    Ok(Entry { variant, scenario, problem })
}

impl Entry<'_> {
    fn contestant(&self) -> Contestant<'_> {
        let Self { variant, scenario, problem } = self;
        Contestant { name: &variant.name, scenario, problem, strategy: scenario.refine.strategy }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_in_case_alone_are_one_folder() {
        assert!(check_names(&["fine", "coarse", "fin"]).is_ok());
        for clash in [["Fine", "x", "fINE"], ["a", "b", "b"]] {
            assert!(matches!(check_names(&clash), Err(Error::Variants { .. })), "{clash:?}");
        }
    }

    #[test]
    fn variants_are_read_and_names_that_are_no_folders_refused() {
        let read: Variant = "coarse: mesh.box.cells=[1, 1, 1]; refine.steps=2".parse().unwrap();
        assert_eq!((read.name.as_str(), read.set.len()), ("coarse", 2));
        assert_eq!("as-it-is".parse::<Variant>().unwrap().set, Vec::<String>::new());
        for bad in ["", ": a=1", "../x: a=1", "a b: c=1"] {
            assert!(bad.parse::<Variant>().is_err(), "{bad:?}");
        }
    }
}
