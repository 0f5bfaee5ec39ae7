//! The tables of `subsolid verify`.

use super::super::book::{Book, Problem};
use super::{count, table, text};

/// Figures of references, which the page tells in full.
const DIGITS: usize = 7;

/// Every expectation of every problem beside what came out, and how the problems were solved.
#[must_use]
pub fn book(book: &Book) -> String {
    let mut rows = table("problem\n quantity|reference|ours|deviation|allowed|slope|");
    for problem in &book.problems {
        let blank = || [(); 5].map(|()| String::new());
        let fault = if problem.fault.is_some() { "FAIL" } else { "" };
        let mut row = |name: String, texts: [String; 5], verdict: &str| {
            rows.add_row([name].into_iter().chain(texts).chain([verdict.to_owned()]));
        };
        row(problem.name().to_owned(), blank(), fault);
        for e in &problem.entries {
            let verdict = if e.passes() { "pass" } else { "FAIL" };
            row(format!(" {}", e.quantity), e.texts(DIGITS), verdict);
        }
    }
    format!("{}\n\n{}\n", text(rows), solved(&book.problems))
}

/// The last meshes, and the errors there.
fn solved(problems: &[Problem]) -> String {
    let mut rows = table("problem|element|meshes|cells|unknowns|estimated\nerror|effec-\ntivity|");
    for problem in problems {
        let [element, meshes, cells, unknowns] =
            problem.solved.as_ref().map_or([(); 4].map(|()| "-".to_owned()), |s| {
                [s.element.to_owned(), s.meshes.to_string(), count(s.cells), count(s.free_dofs)]
            });
        let [error, effectivity] = problem.error_texts();
        let (name, verdict) = (problem.name().to_owned(), if problem.passes() { "pass" } else { "FAIL" });
        rows.add_row([name, element, meshes, cells, unknowns, error, effectivity, verdict.to_owned()]);
    }
    text(rows)
}
