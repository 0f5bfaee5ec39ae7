//! The verification book: known problems, what they should give and what they gave, as records and as a page.

use super::report::ExpectationRecord;
use super::table::{count, figures, percent, short};
use serde::Serialize;
use std::fmt::Write as _;

/// Version of the layout of the book's JSON.
pub const SCHEMA: u32 = 1;

/// Below this a number may be rounding, which is another on every machine.
const ROUNDING: f64 = 1e-9;

/// What is printed then, of a number and of a share.
const ROUNDED: [&str; 2] = ["< 1e-9", "< 1e-7 %"];

/// Figures of references: they are printed as they are written.
const DIGITS: usize = 15;

/// All problems of a folder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Book {
    /// Version of this layout, [`SCHEMA`].
    pub schema: u32,
    /// Name and version of the program.
    pub program: String,
    /// One for each scenario, by file name.
    pub problems: Vec<Problem>,
}

/// A scenario and what came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Problem {
    /// Name of its file in the folder.
    pub file: String,
    /// The file's name without its extension, and without the number behind it that counts the meshes of one problem.
    pub sequence: String,
    /// Its title.
    pub title: String,
    /// What it says of itself.
    pub description: String,
    /// How it was solved; absent if it was not.
    pub solved: Option<Solved>,
    /// What was expected of it.
    pub entries: Vec<Entry>,
    /// What deserves a word though it is no fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Why it failed, if not by an entry.
    pub fault: Option<String>,
}

/// The last step of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solved {
    /// The finite element.
    pub element: &'static str,
    /// Meshes that were solved.
    pub meshes: usize,
    /// Cells of the last.
    pub cells: usize,
    /// Its unknowns.
    pub free_dofs: usize,
    /// Estimated relative error in the energy norm.
    pub relative_error: f64,
    /// Estimated over true error, where that is known.
    pub effectivity: Option<f64>,
}

/// Something that was expected.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Of what.
    pub quantity: String,
    /// What, and what came out.
    #[serde(flatten)]
    pub found: ExpectationRecord,
    /// The estimated error of the quantity, where there is an estimate.
    pub error: Option<f64>,
    /// d log |deviation| / d log unknowns since a coarser mesh, where there is one.
    pub slope: Option<f64>,
    /// Whether the deviation is smaller than in the file before, where it has to be.
    pub falls: bool,
}

impl Entry {
    /// Whether it is as expected.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.found.passed && self.falls
    }

    /// Reference, ours, deviation, what is allowed of it, and slope as texts; `digits` are those of references.
    pub(super) fn texts(&self, digits: usize) -> [String; 5] {
        let e = &self.found;
        let number = |x: f64| if x.abs() < ROUNDING { ROUNDED[0].to_owned() } else { figures(x, 6) };
        let mut ours = number(e.value);
        if let Some(error) = self.error {
            ours += &format!(" ± {}", figures(error, 2));
        }
        let slope = self.slope.map_or(String::new(), |s| figures(s, 2));
        if let Some([low, high]) = e.between {
            let range = format!("{} to {}", short(low, digits), short(high, digits));
            return [range, ours, String::new(), String::new(), slope];
        }
        if e.expected == 0.0 {
            return ["0".to_owned(), ours, number(e.deviation), short(e.allowed, 3), slope];
        }
        let share = e.deviation / e.expected.abs();
        let deviation = if share.abs() < ROUNDING { ROUNDED[1].to_owned() } else { format!("{} %", percent(share)) };
        let allowed = format!("{} %", short(100.0 * e.allowed / e.expected.abs(), 3));
        [short(e.expected, digits), ours, deviation, allowed, slope]
    }

    /// What is wrong with it, in a sentence.
    fn sentence(&self) -> String {
        let [reference, ours, deviation, allowed, _] = self.texts(DIGITS);
        let name = &self.quantity;
        match self.found.between {
            _ if self.found.passed => {
                format!("{name}: the deviation {deviation} is not below that on the coarser mesh")
            }
            Some(_) => format!("{name} is {ours}, expected {reference}"),
            None => format!("{name} is {ours}, expected {reference}: {deviation} off, {allowed} allowed"),
        }
    }
}

impl Problem {
    /// The name of its file without the extension.
    #[must_use]
    pub fn name(&self) -> &str {
        self.file.trim_end_matches(".toml")
    }

    /// What is wrong, in sentences with its name.
    pub fn failures(&self) -> impl Iterator<Item = String> {
        let entries = self.entries.iter().filter(|e| !e.passes()).map(Entry::sentence);
        entries.chain(self.fault.clone()).map(|sentence| format!("{}: {sentence}", self.name()))
    }

    /// Whether everything is as expected.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.fault.is_none() && self.entries.iter().all(Entry::passes)
    }

    /// Estimated error and effectivity as texts.
    pub(super) fn error_texts(&self) -> [String; 2] {
        let Some(solved) = &self.solved else { return [String::new(), String::new()] };
        let error = solved.relative_error;
        let error = if error < ROUNDING { ROUNDED[1].to_owned() } else { format!("{} %", percent(error)) };
        // Rounding over rounding says nothing.
        let told = solved.effectivity.filter(|_| solved.relative_error >= ROUNDING);
        [error, told.map_or(String::new(), |e| figures(e, 3))]
    }
}

impl Book {
    /// The names of the problems that fail.
    #[must_use]
    pub fn failures(&self) -> Vec<&str> {
        self.problems.iter().filter(|p| !p.passes()).map(Problem::name).collect()
    }

    /// The page, a file called `name`; `link` is the way from it to the folder of the scenarios.
    #[must_use]
    pub fn page(&self, link: &str, name: &str) -> String {
        let mut page = HEAD.replace("NAME", name).replace("FOLDER", link);
        let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
        for p in &self.problems {
            let [error, effectivity] = p.error_texts();
            for (i, e) in p.entries.iter().enumerate() {
                let [reference, ours, deviation, allowed, slope] = e.texts(DIGITS);
                let first = |text: &str| if i == 0 { text.to_owned() } else { String::new() };
                let verdict = if e.passes() { "pass" } else { "**FAIL**" };
                let row = [
                    p.name(),
                    &cell(&e.quantity),
                    &reference,
                    &ours,
                    &deviation,
                    &allowed,
                    &slope,
                    &first(&error),
                    &first(&effectivity),
                    verdict,
                ];
                let _ = writeln!(page, "| {} |", row.map(|text: &str| text.trim()).join(" | "));
            }
            if p.fault.is_some() {
                let _ = writeln!(page, "| {} | | | | | | | | | **FAIL** |", p.name());
            }
        }
        page += "\n## Problems\n";
        for group in self.problems.chunk_by(|a, b| a.title == b.title) {
            page += &chapter(group, link);
        }
        page
    }
}

/// What the page says of the scenarios of one title.
fn chapter(group: &[Problem], link: &str) -> String {
    let Some(first) = group.first() else { return String::new() };
    let mut text = format!("\n### {}\n", first.title);
    for p in group.iter().filter(|p| !p.description.is_empty()) {
        let _ = write!(text, "\n{}\n", p.description.trim());
    }
    text += "\n";
    for p in group {
        let solved = p.solved.as_ref().map_or("not solved".to_owned(), |s| {
            let meshes = if s.meshes == 1 { String::new() } else { format!("{} meshes, the last of ", s.meshes) };
            format!("{}, {meshes}{} cells, {} unknowns", s.element, count(s.cells), count(s.free_dofs))
        });
        let fault = p.fault.as_ref().map_or(String::new(), |f| format!("; {}", f.replace('\n', " ")));
        let note = p.note.as_ref().map_or(String::new(), |n| format!("; {n}"));
        let _ = writeln!(text, "- [{}]({link}/{}): {solved}{note}{fault}", p.name(), p.file);
    }
    let mut told = Vec::new();
    for (quantity, source) in group.iter().flat_map(|p| &p.entries).map(|e| (&e.quantity, &e.found.source)) {
        if let Some(source) = source.as_ref().filter(|s| !told.contains(&(quantity, *s))) {
            told.push((quantity, source));
            let _ = writeln!(text, "- {quantity}: {source}");
        }
    }
    text
}

const HEAD: &str = "\
# Verification

What the scenarios of [FOLDER](FOLDER) expect, and what Subsolid gives. Written by `subsolid verify FOLDER --markdown NAME`, run where this
page is; it ends with exit code 1 if one of them fails. Any folder of scenarios with `[expect]` can be verified so.

- *Allowed* is the largest deviation allowed.
- Files that differ by a number at the end of their names are one problem on finer meshes, if their unknowns grow: there each deviation has
  to be smaller than the one before, unless it is below a tenth of what is allowed already.
- *Unknowns* are displacement components that no support prescribes. *Slope* is d log |deviation| / d log unknowns, since the file before, or since the last step with at most half as many unknowns.
- *Estimated error* is that of the solution in the energy norm, beside which *effectivity* is the estimated over the true one, where the
  solution is known in closed form.
- Where the reference is a range, ours has to lie in it.

| scenario | quantity | reference | ours | deviation | allowed | slope | estimated error | effectivity | |
|---|---|---:|---:|---:|---:|---:|---:|---:|---|
";

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(expected: f64, deviation: f64) -> Entry {
        let value = expected + deviation;
        let found =
            ExpectationRecord { value, expected, deviation, allowed: 0.1, between: None, passed: true, source: None };
        Entry { quantity: "tip".to_owned(), found, error: None, slope: None, falls: true }
    }

    #[test]
    fn deviations_are_relative_where_they_can_be_and_rounding_is_called_that() {
        let texts = |expected, deviation| entry(expected, deviation).texts(DIGITS);
        assert_eq!(texts(-2.0, 0.01), ["-2", "-1.99000", "0.500 %", "5 %", ""]);
        assert_eq!(texts(0.0, 0.01), ["0", "0.0100000", "0.0100000", "0.1", ""]);
        assert_eq!(texts(0.0, 1e-13), ["0", "< 1e-9", "< 1e-9", "0.1", ""]);
        assert_eq!(texts(3.0, -1e-13), ["3", "3.00000", "< 1e-7 %", "3.33 %", ""]);
    }

    #[test]
    fn what_does_not_fall_fails_though_it_is_allowed() {
        let growing = Entry { falls: false, ..entry(1.0, 0.05) };
        let problem = |entries| Problem {
            file: "a-2.toml".to_owned(),
            sequence: "a".to_owned(),
            title: "A".to_owned(),
            description: String::new(),
            solved: None,
            entries,
            note: None,
            fault: None,
        };
        let book = |problem| Book { schema: SCHEMA, program: String::new(), problems: vec![problem] };
        assert_eq!(problem(vec![growing.clone()]).failures().count(), 1);
        assert_eq!(book(problem(vec![growing])).failures(), ["a-2"]);
        assert!(book(problem(vec![entry(1.0, 0.05)])).failures().is_empty());
        let broken = Problem { fault: Some("no mesh".to_owned()), ..problem(Vec::new()) };
        assert_eq!(book(broken).failures(), ["a-2"]);
    }
}
