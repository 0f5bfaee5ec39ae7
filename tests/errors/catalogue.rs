//! `docs/errors.md` lists every class, and each names tests that exist.

use std::collections::BTreeSet;
use std::path::Path;

/// Classes there are.
const CLASSES: usize = 63;

/// What a command can end with.
const CODES: [&str; 9] = ["0", "1", "2", "3", "4", "5", "6", "7", "130"];

/// The names of all functions that are tests of a class, in the sources and the tests.
fn tests(folder: &Path, names: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            tests(&path, names);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            let after = text.split("\nfn class_").chain(text.split("\n    fn class_")).skip(1);
            let own = after.filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            names.extend(own.filter_map(|rest| Some(format!("class_{}", rest.split_once('(')?.0))));
        }
    }
}

#[test]
fn the_page_of_errors_lists_all_classes_and_their_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/errors.md")).unwrap();
    let mut there = BTreeSet::new();
    ["src", "tests"].iter().for_each(|folder| tests(&root.join(folder), &mut there));
    let rows =
        page.lines().filter(|line| line.starts_with("| ") && line[2..].starts_with(|c: char| c.is_ascii_digit()));
    let rows: Vec<Vec<&str>> = rows.map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect()).collect();
    let numbers: Vec<usize> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    assert_eq!(numbers, (1..=CLASSES).collect::<Vec<_>>());
    let mut listed = BTreeSet::new();
    for row in &rows {
        let [number, class, message, codes, names] = row[..] else { panic!("{row:?}") };
        assert!(!class.is_empty() && !message.is_empty(), "{row:?}");
        assert!(codes.split(", ").all(|code| CODES.contains(&code)), "{row:?}");
        for name in names.split(", ").map(|name| name.trim_matches('`')) {
            assert!(there.contains(name), "there is no test {name}");
            assert_eq!(name[6..8].parse(), number.parse::<usize>(), "{name}");
            listed.insert(name.to_owned());
        }
    }
    assert_eq!(there, listed, "tests of classes that the page does not list");
}
