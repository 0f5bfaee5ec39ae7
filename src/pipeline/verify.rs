//! `subsolid verify`: the scenarios of a folder against what they expect, in one table.

use super::quantities::expectations;
use super::results::{relative, write_text};
use super::run::{execute, failure, prepare};
use super::simulate::{Plan, simulate};
use super::{MemoryProbe, RunOptions, interrupt, print, wrapped};
use crate::error::Error;
use crate::output::atomic::{ensure_parent, ensure_writable_dir};
use crate::output::book::{Book, Entry, Problem, SCHEMA, Solved};
use crate::output::progress::Progress;
use crate::output::report::{ExpectationRecord, PROGRAM, Report, write_json};
use crate::output::table;
use crate::scenario::Scenario;
use miette::Diagnostic as _;
use std::path::{Path, PathBuf};

/// What the command line says about a verification.
#[derive(Debug, Clone)]
pub struct Verification {
    /// The folder of the scenarios.
    pub folder: PathBuf,
    /// Where the page goes.
    pub markdown: Option<PathBuf>,
    /// The folder in which each scenario's results get a folder; if absent none are written.
    pub output: Option<PathBuf>,
    /// Where the figures go.
    pub json: Option<PathBuf>,
    /// Print errors only.
    pub quiet: bool,
    /// The memory counter.
    pub memory: MemoryProbe,
}

/// Share of what is allowed below which a deviation need not fall from mesh to mesh.
const SMALL: f64 = 0.1;

/// Share of what is allowed below which a deviation has no slope: it may be rounding.
const TINY: f64 = 1e-3;

/// Runs every scenario of a folder, whether or not others fail, and tells which meet what they expect.
///
/// # Errors
/// [`Error::NoScenarios`], [`Error::Output`]; after everything is written, [`Error::Unverified`] if something is not as
/// expected or could not be run.
pub fn verify(options: &Verification) -> Result<(), Error> {
    let files = scenarios(&options.folder)?;
    if let Some(folder) = &options.output {
        ensure_writable_dir(folder)?;
    }
    // Before minutes are spent.
    options.markdown.iter().chain(&options.json).try_for_each(|path| ensure_parent(path))?;
    let progress = Progress::new(options.quiet).bar("verify", files.len());
    let mut problems: Vec<Problem> = Vec::new();
    for path in &files {
        if interrupt::is_asked() {
            let ending = format!("interrupted after {} of {} scenarios", problems.len(), files.len());
            return Err(Error::Interrupted { ending });
        }
        progress.say(path.display().to_string());
        let problem = problem(path, options, problems.last());
        problems.push(problem);
        progress.advance();
    }
    drop(progress);
    let book = Book { schema: SCHEMA, program: PROGRAM.to_owned(), problems };
    write(&book, options)?;
    let failed = book.failures();
    if failed.is_empty() {
        return Ok(());
    }
    let faults: String = if options.quiet {
        book.problems.iter().flat_map(Problem::failures).map(|f| format!("\n{f}")).collect()
    } else {
        String::new()
    };
    Err(Error::Unverified { failed: failed.join(", "), faults })
}

/// Prints the table and writes the page and the figures.
fn write(book: &Book, options: &Verification) -> Result<(), Error> {
    if let Some(path) = &options.markdown {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let link = relative(&options.folder, folder).to_string_lossy().replace('\\', "/");
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        write_text(path, &book.page(&link, &name))?;
    }
    if let Some(path) = &options.json {
        write_json(path, book)?;
    }
    if options.quiet {
        return Ok(());
    }
    let faults = book.problems.iter().filter_map(|p| Some(format!("\n{}: {}\n", p.file, p.fault.as_ref()?)));
    let (count, passed) = (book.problems.len(), book.problems.iter().filter(|p| p.passes()).count());
    let notes = book.problems.iter().filter_map(|p| Some(wrapped(&format!("note: {}", p.note.as_ref()?))));
    let text = table::book(book) + &notes.chain(faults).collect::<String>();
    print(&format!("{text}\n{passed} of {count} scenarios pass\n"))
}

/// The scenarios of a folder, by name; those of one name by the number behind it.
fn scenarios(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let none = |source| Error::NoScenarios { folder: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let paths = entries.map_err(|e| none(Some(e)))?.into_iter().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    let key = |path: &PathBuf| {
        let (name, number) = numbered(&path.file_stem().unwrap_or_default().to_string_lossy());
        (name, number, path.clone())
    };
    files.sort_by_cached_key(key);
    if files.is_empty() { Err(none(None)) } else { Ok(files) }
}

/// One scenario; `before` is the problem before it, which may be the same on a coarser mesh.
fn problem(path: &Path, options: &Verification, before: Option<&Problem>) -> Problem {
    let name = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (sequence, _) = numbered(&name(path.file_stem()));
    let mut problem = Problem {
        file: name(path.file_name()),
        title: sequence.clone(),
        sequence,
        description: String::new(),
        solved: None,
        entries: Vec::new(),
        note: None,
        fault: None,
    };
    let before = before.filter(|b| b.sequence == problem.sequence);
    if let Err(error) = solve(path, options, before, &mut problem) {
        problem.fault = Some(told(&error));
    }
    problem
}

/// The name of a scenario without the number at its end, and that number.
fn numbered(stem: &str) -> (String, Option<u64>) {
    let counted = stem.rsplit_once('-').and_then(|(name, n)| {
        let digits = !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
        Some((name.to_owned(), Some(n.parse().ok().filter(|_| digits)?)))
    });
    counted.unwrap_or((stem.to_owned(), None))
}

/// Runs a scenario and enters what came out.
fn solve(path: &Path, options: &Verification, before: Option<&Problem>, problem: &mut Problem) -> Result<(), Error> {
    let scenario = Scenario::from_file(path, &[])?;
    problem.title.clone_from(&scenario.title);
    problem.description.clone_from(&scenario.description);
    if scenario.expectations.is_empty() {
        return Err(Error::NothingExpected);
    }
    let report = simulated(&scenario, options)?;
    let unknowns = report.steps.last().map_or(0, |last| last.free_dofs);
    let coarser = |b: &&Problem| b.solved.as_ref().is_none_or(|solved| solved.free_dofs < unknowns);
    problem.note = before.filter(|b| !coarser(b)).map(|b| {
        let (own, other) = (scenario.name(), b.name());
        format!("{own} has no more unknowns than {other}, so it is not taken for the same problem on a finer mesh")
    });
    let before = before.filter(coarser);
    problem.entries = entries(&scenario, &report, before);
    problem.solved = report.steps.last().map(|last| Solved {
        element: scenario.element.name(),
        meshes: report.steps.len(),
        cells: last.mesh.cells,
        free_dofs: last.free_dofs,
        relative_error: last.error.relative,
        effectivity: last.error.effectivity,
    });
    // An expectation that failed stands in the table.
    match failure(&scenario, scenario.refine.strategy, &report) {
        None | Some(Error::Unexpected { .. }) => Ok(()),
        Some(error) => Err(error),
    }
}

/// The report of a run, which writes its results only if asked to.
fn simulated(scenario: &Scenario, options: &Verification) -> Result<Report, Error> {
    let output = options.output.as_ref().map(|folder| folder.join(scenario.name()));
    let run = RunOptions { output, quiet: true, json: None, resume: false, memory: options.memory };
    if run.output.is_some() {
        return execute(scenario, &run);
    }
    let plan =
        Plan { scenario, strategy: scenario.refine.strategy, memory: options.memory, progress: Progress::new(true) };
    simulate(&prepare(scenario, &run)?, &plan, &mut |_| Ok(()))
}

/// What was expected of the last step, with what became of the deviation since a coarser mesh: that of an earlier step, or of
/// the problem before, in which case it has to fall.
fn entries(scenario: &Scenario, report: &Report, before: Option<&Problem>) -> Vec<Entry> {
    let Some(last) = report.steps.last() else { return Vec::new() };
    let earlier = report.steps.iter().rfind(|s| 2 * s.free_dofs <= last.free_dofs);
    let earlier = earlier.map(|step| (step.free_dofs, expectations(scenario, step)));
    let before = before.and_then(|problem| {
        let found = problem.entries.iter().map(|e| (e.quantity.clone(), e.found.clone()));
        Some((problem.solved.as_ref()?.free_dofs, found.collect()))
    });
    let must_fall = before.is_some();
    let coarser: Option<(usize, Vec<(String, ExpectationRecord)>)> = before.or(earlier);
    let entry = |(quantity, found): &(String, ExpectationRecord)| {
        let slope = coarser.as_ref().and_then(|(dofs, all)| {
            let (_, coarse) = all.iter().find(|(name, _)| name == quantity)?;
            slope((*dofs, coarse), (last.free_dofs, found))
        });
        let error = last.quantities.iter().find(|(name, _)| name == quantity).and_then(|(_, q)| q.error);
        let grows = slope.is_some_and(|s| s >= 0.0) && found.deviation.abs() > SMALL * found.allowed;
        Entry { quantity: quantity.clone(), found: found.clone(), error, slope, falls: !(must_fall && grows) }
    };
    report.expectations.iter().map(entry).collect()
}

/// d log |deviation| / d log unknowns between two meshes, where both deviations are from one value and above rounding.
fn slope(coarse: (usize, &ExpectationRecord), fine: (usize, &ExpectationRecord)) -> Option<f64> {
    let [(few, a), (many, b)] = [coarse, fine];
    let same = a.expected == b.expected && a.between.is_none() && b.between.is_none();
    let above = |e: &ExpectationRecord| e.deviation.abs() > TINY * b.allowed;
    let slope = (b.deviation / a.deviation).abs().ln() / (many as f64 / few as f64).ln();
    (same && above(a) && above(b) && many > few && slope.is_finite()).then_some(slope)
}

/// An error with its causes and what to do about it.
fn told(error: &Error) -> String {
    let causes = std::iter::successors(std::error::Error::source(error), |e| e.source());
    let message = causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"));
    error.help().map_or(message.clone(), |help| format!("{message}\nhelp: {help}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_at_the_end_count_the_meshes_of_one_problem() {
        assert!(numbered("kirsch-10").1 > numbered("kirsch-9").1);
        for (stem, name) in [("kirsch-2", "kirsch"), ("lame-sphere", "lame-sphere"), ("le10", "le10"), ("a-", "a-")] {
            assert_eq!(numbered(stem).0, name);
        }
    }

    #[test]
    fn the_slope_is_that_of_a_power() {
        let found = |deviation| ExpectationRecord {
            value: 1.0 + deviation,
            expected: 1.0,
            deviation,
            allowed: 0.5,
            between: None,
            passed: true,
            source: None,
        };
        let between = |a: f64, b: f64| slope((1000, &found(a)), (8000, &found(b)));
        assert!((between(-0.1, 0.025).unwrap() + 2.0 / 3.0).abs() < 1e-12);
        assert!(between(0.1, 0.2).unwrap() > 0.0);
        // What may be rounding has none.
        assert_eq!(between(1e-5, 1e-4), None);
        assert_eq!(slope((8000, &found(0.1)), (8000, &found(0.2))), None);
    }
}
