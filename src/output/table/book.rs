//! The table of `subsolid verify`.

use super::super::book::Book;
use super::{table, text};

/// Every expectation of every problem beside what came out.
#[must_use]
pub fn book(book: &Book) -> String {
    let mut rows = table("problem|quantity|reference|ours|deviation|slope|estimated\nerror|effec-\ntivity|");
    for problem in &book.problems {
        let mut name = problem.name().to_owned();
        let [mut error, mut effectivity] = problem.error_texts();
        for e in &problem.entries {
            let [reference, ours, deviation, slope] = e.texts();
            let verdict = if e.passes() { "pass" } else { "FAIL" }.to_owned();
            let quantity = e.quantity.clone();
            // The problem's own figures stand in its first row.
            let [name, error, effectivity] = [&mut name, &mut error, &mut effectivity].map(std::mem::take);
            rows.add_row([name, quantity, reference, ours, deviation, slope, error, effectivity, verdict]);
        }
        if problem.fault.is_some() {
            let blank = String::new;
            rows.add_row([name, blank(), blank(), blank(), blank(), blank(), error, effectivity, "FAIL".to_owned()]);
        }
    }
    text(rows) + "\n"
}
