//! The import graph of `ARCHITECTURE.md`, checked against the sources.
//!
//! A room is a folder or file directly under `src/`. Every `crate::` path outside of comments and of unit tests (all
//! that follows a file's first `#[cfg(test)]`) must be allowed by the table in `ARCHITECTURE.md`. `src/lib.rs`, the
//! crate's front page, only lists the rooms and is left out.

#![allow(clippy::unwrap_used)] // a test fails by panicking, in its helper functions too

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What each room may import, as written in the table: paths, or `all`.
type Rules = BTreeMap<String, Vec<String>>;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The table under the heading "room | may import".
fn rules() -> Rules {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    page.lines()
        .skip_while(|line| *line != "| room | may import |")
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let mut columns = line.trim_matches('|').split('|').map(str::trim);
            let room = columns.next().unwrap().to_owned();
            let allowed = columns.next().unwrap_or("").split(',').map(|p| p.trim().to_owned());
            (room, allowed.filter(|p| !p.is_empty()).collect())
        })
        .collect()
}

/// All Rust files under a folder, sorted.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    let files = entries.into_iter().flat_map(|path| {
        if path.is_dir() { rust_files(&path) } else { vec![path] } // no symbolic links in src/
    });
    // Files of tests, like test modules, may look anywhere.
    let is_test = |path: &Path| path.ends_with("tests.rs") || path.parent().is_some_and(|p| p.ends_with("tests"));
    let is_code = |path: &PathBuf| path.extension().is_some_and(|e| e == "rs") && !is_test(path);
    files.filter(is_code).collect()
}

/// The segments of a file's path below `src/`, without `.rs`.
fn segments(file: &Path) -> Vec<String> {
    let below = file.strip_prefix(root().join("src")).unwrap().with_extension("");
    below.iter().map(|s| s.to_str().unwrap().to_owned()).collect()
}

/// Source text without comments and unit tests, line breaks kept.
fn production_code(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    // A test module ends the file; the declaration of one in a file of its own does not.
    let opens_tests =
        |i: &usize| lines[*i].trim() == "#[cfg(test)]" && !lines.get(i + 1).is_some_and(|l| l.ends_with(';'));
    let end = (0..lines.len()).find(opens_tests).unwrap_or(lines.len());
    lines[..end].iter().map(|line| line.split("//").next().unwrap_or("").to_owned() + "\n").collect()
}

/// Expands what follows `crate::` into full paths: `a::{b, c::d}` gives `a::b` and `a::c::d`.
fn expand(tree: &str, prefix: &str) -> Vec<String> {
    let Some(inner) = tree.trim_start().strip_prefix('{') else {
        let end = tree.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(tree.len());
        let path = format!("{prefix}{}", &tree[..end]);
        return match tree[end..].strip_prefix('{') {
            Some(_) if path.ends_with("::") => expand(&tree[end..], &path),
            _ => vec![path.trim_end_matches(':').to_owned()],
        };
    };
    top_level_items(inner).into_iter().flat_map(|item| expand(item, prefix)).collect()
}

/// The comma-separated items up to the brace that closes the group.
fn top_level_items(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                items.push(group[start..i].trim());
                start = i + 1;
            }
            _ => {}
        }
        if c == '}' && start == i + 1 {
            break;
        }
    }
    items.retain(|item| !item.is_empty());
    items
}

/// The crate's paths that a source mentions, each with its line number: `crate::`, `subsolid::` (the binary's name for
/// the library), and chains of `super::` that reach the crate's root (`depth` of them do).
fn imports(code: &str, depth: usize) -> Vec<(usize, String)> {
    let escape = "super::".repeat(depth);
    let mut found: Vec<(usize, String)> = ["crate::", "subsolid::", escape.as_str()]
        .into_iter()
        .flat_map(|start| code.match_indices(start).map(move |(at, _)| (at, start)))
        .filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$'))
        .flat_map(|(at, start)| {
            let line = code[..at].lines().count() + usize::from(code[..at].ends_with('\n') || at == 0);
            expand(&code[at + start.len()..], "").into_iter().map(move |path| (line, path))
        })
        .collect();
    found.sort();
    found
}

/// Whether the rule covers the path.
fn allows(rule: &str, path: &str) -> bool {
    rule == "all" || within(path, rule)
}

/// Whether `path` is `module` or lies in it.
fn within(path: &str, module: &str) -> bool {
    path == module || path.strip_prefix(module).is_some_and(|rest| rest.starts_with("::"))
}

/// The imports of a file that its room may not have, as "file:line: message".
fn violations(file: &str, segments: &[String], text: &str, rules: &Rules) -> Vec<String> {
    let room = &segments[0];
    let Some(allowed) = rules.get(room) else {
        return vec![format!("{file}:1: `{room}` has no row in the import table of ARCHITECTURE.md")];
    };
    let depth = segments.iter().filter(|name| *name != "mod").count();
    imports(&production_code(text), depth)
        .into_iter()
        .filter(|(_, path)| !within(path, room) && !allowed.iter().any(|rule| allows(rule, path)))
        .map(|(line, path)| format!("{file}:{line}: `{room}` imports `crate::{path}`; it may import: {allowed:?}"))
        .collect()
}

#[test]
fn rooms_import_only_what_the_architecture_allows() {
    let rules = rules();
    let files = rust_files(&root().join("src"));
    let found: Vec<String> = files
        .iter()
        .filter(|file| segments(file) != ["lib"])
        .flat_map(|file| {
            let text = std::fs::read_to_string(file).unwrap();
            let name = file.strip_prefix(root()).unwrap().display().to_string();
            violations(&name, &segments(file), &text, &rules)
        })
        .collect();
    assert!(found.is_empty(), "imports that ARCHITECTURE.md forbids:\n{}", found.join("\n"));
}

/// The promises that do not change with the table: whoever edits it must mean to break these.
#[test]
fn the_table_keeps_the_nevers() {
    let rules = rules();
    let allowed = |room: &str, path: &str| rules[room].iter().any(|rule| allows(rule, path));
    for room in ["mesh", "subdiv", "fem", "adapt", "output", "scenario"] {
        assert!(!allowed(room, "pipeline"), "{room} sees pipeline");
    }
    for other in ["subdiv", "fem", "adapt", "output", "scenario", "error"] {
        assert!(!allowed("mesh", other), "mesh sees {other}");
    }
    for (room, other) in [("subdiv", "fem"), ("fem", "subdiv"), ("fem", "adapt"), ("adapt", "subdiv")] {
        assert!(!allowed(room, other), "{room} sees {other}");
    }
    for other in ["mesh", "subdiv::refine", "fem::solve", "adapt::mark", "output"] {
        assert!(!allowed("scenario", other), "scenario sees {other}");
    }
}

#[test]
fn forbidden_imports_are_found_however_they_are_written() {
    let rules = rules();
    let check = |file: &str, text: &str| {
        let segments: Vec<String> = file.split('/').map(str::to_owned).collect();
        violations(file, &segments, text, &rules)
    };
    let forbidden = [
        ("mesh/mod", "use crate::fem::Model;"),
        ("subdiv/red", "\n\nuse crate::{mesh::{self, TetMesh}, fem::{Model, Load}};"),
        ("fem/mod", "fn f() { crate::adapt::mark(); }"),
        ("adapt/mark", "use super::super::subdiv;"),
        ("adapt/mod", "use super::subdiv;"),
        ("scenario/mod", "use crate::{\n    fem::{\n        options,\n        Model,\n    },\n};"),
        ("output/vtk", "pub(crate) use crate::pipeline::run;"),
        ("main", "use subsolid::fem;"),
        ("newroom/mod", "fn f() {}"),
    ];
    for (file, text) in forbidden {
        assert!(!check(file, text).is_empty(), "not found in {file}: {text}");
    }
    let allowed = [
        ("subdiv/red", "use crate::{mesh::{TetMesh, topology}, subdiv::Info};"),
        ("scenario/mod", "use crate::{adapt::options::Marking, fem::options};\nuse crate::scenario::error;"),
        ("mesh/mod", "// use crate::fem\nfn f() {}\n#[cfg(test)]\nmod tests { use crate::fem; }"),
        ("fem/solve/cg", "use super::super::System;"),
        ("fem/solve/mod", "use super::System;"),
        ("main", "use subsolid::pipeline;"),
    ];
    for (file, text) in allowed {
        assert_eq!(check(file, text), Vec::<String>::new(), "{text}");
    }
}

#[test]
fn a_violation_names_file_line_and_path() {
    let found = violations("src/mesh/mod.rs", &["mesh".into(), "mod".into()], "\n\nuse crate::fem::Model;\n", &rules());
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("src/mesh/mod.rs:3: `mesh` imports `crate::fem::Model`"), "{}", found[0]);
}
