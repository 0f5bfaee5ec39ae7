//! The documentation's examples: whole scenarios run and meet what they expect, parts run within the first scenario of their
//! page, and the scenario page has an example of every key and names every word.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use toml::Table;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Tables that hold tables by name.
const NAMED: [&str; 6] = ["materials", "supports", "loads", "quantities", "probes", "expect"];

/// A TOML block of a page.
struct Example {
    page: String,
    line: usize,
    table: Table,
}

impl Example {
    /// Parts of scenarios lack some of these.
    fn is_whole(&self) -> bool {
        ["mesh", "materials", "supports"].iter().all(|key| self.table.contains_key(*key))
    }

    /// The scenario to run: itself, or put into the first one of its page.
    fn scenario(&self, first: &Table) -> Table {
        if self.is_whole() {
            return self.table.clone();
        }
        let mut scenario = first.clone();
        scenario.remove("expect");
        scenario.remove("quantities");
        for (key, value) in &self.table {
            match (scenario.get_mut(key).and_then(toml::Value::as_table_mut), value.as_table()) {
                (Some(old), Some(new)) if NAMED.contains(&key.as_str()) => old.extend(new.clone()),
                _ => drop(scenario.insert(key.clone(), value.clone())),
            }
        }
        scenario
    }
}

/// The README and the pages of `docs/`, by name.
fn pages() -> Vec<(String, String)> {
    let docs = std::fs::read_dir(Path::new(ROOT).join("docs")).unwrap().map(|e| e.unwrap().path());
    let mut paths: Vec<PathBuf> = docs.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    paths.push(Path::new(ROOT).join("README.md"));
    paths.sort();
    let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
    paths.iter().map(|p| (name(p), std::fs::read_to_string(p).unwrap())).collect()
}

/// The TOML blocks of a page.
fn examples(page: &str, text: &str) -> Vec<Example> {
    let lines: Vec<&str> = text.lines().collect();
    let starts = (0..lines.len()).filter(|&i| lines[i].trim() == "```toml");
    let example = |start: usize| {
        let block: Vec<&str> = lines[start + 1..].iter().take_while(|l| l.trim() != "```").copied().collect();
        let table = block.join("\n").parse().unwrap_or_else(|e| panic!("{page}:{}: {e}", start + 1));
        Example { page: page.to_owned(), line: start + 1, table }
    };
    starts.map(example).collect()
}

/// Runs a scenario on the bundled meshes; gives its report.
fn run(example: &Example, scenario: &Table) -> Value {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("example.toml"), toml::to_string(scenario).unwrap()).unwrap();
    std::fs::copy(Path::new(ROOT).join("docs/first-steps/lever.msh"), folder.path().join("lever.msh")).unwrap();
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(["run", "example.toml", "--json", "-"]).current_dir(folder.path());
    let output = command.env("SUBSOLID_DATA", Path::new(ROOT).join("scenarios")).output().unwrap();
    let (page, line) = (&example.page, example.line);
    assert!(output.status.success(), "{page}:{line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_example_runs_and_whole_scenarios_meet_what_they_expect() {
    let mut count = 0;
    for (page, text) in pages() {
        let examples = examples(&page, &text);
        let Some(first) = examples.first() else { continue };
        assert!(first.is_whole(), "{page}: the first example has to be a whole scenario");
        for example in &examples {
            let report = run(example, &example.scenario(&first.table));
            count += 1;
            if !example.is_whole() {
                continue;
            }
            // A run with a failed expectation does not succeed.
            let at = format!("{page}:{}", example.line);
            let expectations = report["expectations"].as_object().unwrap();
            let sourced = expectations.values().filter(|e| e["source"].is_string()).count();
            assert!(sourced > 0, "{at}: expects nothing of an independent source");
        }
    }
    assert!(count > 30, "{count} examples");
}

/// The keys of a table, each with the path to it without the names that users choose and without lists.
fn used(table: &Table, at: &str, keys: &mut BTreeSet<String>) {
    for (key, value) in table {
        let path = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
        keys.insert(path.clone());
        let inner = value.as_array().map_or(vec![value], |list| list.iter().collect());
        for table in inner.into_iter().filter_map(toml::Value::as_table) {
            if at.is_empty() && NAMED.contains(&key.as_str()) {
                table.values().filter_map(toml::Value::as_table).for_each(|t| used(t, &path, keys));
            } else {
                used(table, &path, keys);
            }
        }
    }
}

/// What the first steps say of their run is what the run says.
#[test]
fn the_first_steps_quote_their_run() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/first-steps.md")).unwrap();
    let report = run(&examples("first-steps.md", &text)[0], &examples("first-steps.md", &text)[0].table);
    let steps = report["steps"].as_array().unwrap();
    let energies: Vec<String> = steps.iter().map(|s| format!("{:.3}", s["strain_energy"].as_f64().unwrap())).collect();
    let percent = |s: &Value| format!("{:.1}", 100.0 * s["error"]["relative"].as_f64().unwrap());
    let last = steps.last().unwrap();
    let more = last["quantities"]["deflection"]["value"].as_f64().unwrap() / -0.026_937 - 1.0;
    for quoted in [
        format!("grows and settles: {}.", energies.join(", ")),
        format!("falls from {} to {}.", percent(&steps[0]), percent(last)),
        format!(
            "the pin goes {:.5} mm, {:.2} % more",
            -last["quantities"]["deflection"]["value"].as_f64().unwrap(),
            100.0 * more
        ),
        format!("{} faces are held, {} are loaded", report["selections"][0]["faces"], report["selections"][1]["faces"]),
    ] {
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(&quoted), "the page does not say: {quoted}");
    }
}

/// What a schema allows: keys as paths, as [`used`] writes them, and the words of choices.
#[derive(Default)]
struct Language {
    keys: BTreeSet<String>,
    words: BTreeSet<String>,
}

impl Language {
    /// Adds a part of the schema that stands at a path; `seen` are the definitions around it.
    fn add(&mut self, root: &Value, schema: &Value, at: &str, seen: &[&str]) {
        if let Some(path) = schema["$ref"].as_str() {
            if !seen.contains(&path) {
                let seen = [seen, &[path]].concat();
                self.add(root, root.pointer(path.trim_start_matches('#')).unwrap(), at, &seen);
            }
            return;
        }
        let lists = ["anyOf", "oneOf"].iter().filter_map(|list| schema[*list].as_array()).flatten();
        let inside = [&schema["items"], &schema["additionalProperties"]].into_iter().filter(|s| s.is_object());
        lists.chain(inside).for_each(|inner| self.add(root, inner, at, seen));
        let choices = schema["enum"].as_array().into_iter().flatten().chain([&schema["const"]]);
        self.words.extend(choices.filter_map(|word| word.as_str().map(str::to_owned)));
        for (key, inner) in schema["properties"].as_object().into_iter().flatten() {
            let path = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            self.add(root, inner, &path, seen);
            self.keys.insert(path);
        }
    }
}

/// The path without the tables that a selector stands in: selectors are the same language everywhere.
fn of_selector(path: &str) -> Option<String> {
    const SELECTORS: [&str; 9] = ["group", "plane", "box", "sphere", "cylinder", "normal", "all", "any", "not"];
    let parts: Vec<&str> = path.split('.').collect();
    let table = ["supports", "loads", "quantities", "exact"].contains(&parts[0]);
    let first = (1..parts.len()).rev().find(|&i| SELECTORS.contains(&parts[i]))?;
    table.then(|| parts[first..].join("."))
}

#[test]
fn the_scenario_page_has_an_example_of_every_key_and_every_word() {
    let schema = subsolid::scenario::schema();
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/scenario.md")).unwrap();
    let mut found = BTreeSet::new();
    examples("scenario.md", &text).iter().for_each(|e| used(&e.table, "", &mut found));
    let selectors: BTreeSet<String> = found.iter().filter_map(|path| of_selector(path)).collect();
    let mut language = Language::default();
    language.add(&schema, &schema, "", &[]);
    let Language { keys, words } = language;
    assert!(keys.len() > 100 && words.len() > 30, "{keys:?} {words:?}");
    let lacking = |path: &&String| match of_selector(path) {
        Some(selector) => !selectors.contains(&selector),
        None => !found.contains(*path),
    };
    let lacking: Vec<&String> = keys.iter().filter(lacking).collect();
    assert!(lacking.is_empty(), "keys without an example: {lacking:?}");

    let unnamed: Vec<&String> = words.iter().filter(|w| !text.contains(&format!("\"{w}\""))).collect();
    assert!(unnamed.is_empty(), "words that the page does not name: {unnamed:?}");
}

/// All keys of a JSON value, without the names that users choose.
fn json_keys(value: &Value, keys: &mut BTreeSet<String>) {
    const NAMED: [&str; 3] = ["expectations", "reactions", "quantities"];
    for (key, inner) in value.as_object().into_iter().flatten() {
        keys.insert(key.clone());
        if NAMED.contains(&key.as_str()) && inner.is_object() {
            inner.as_object().into_iter().flatten().for_each(|(_, entry)| json_keys(entry, keys));
        } else {
            json_keys(inner, keys);
        }
    }
    value.as_array().into_iter().flatten().for_each(|entry| json_keys(entry, keys));
}

/// The values of an attribute in the tags of an XML file that begin so.
fn attributes(xml: &str, tag: &str, name: &str) -> BTreeSet<String> {
    let begin = format!("<{tag} ");
    let tags = xml.split(&begin).skip(1).filter_map(|rest| rest.split_once('>'));
    let value = |tag: &str| Some(tag.split_once(&format!("{name}=\""))?.1.split_once('"')?.0.to_owned());
    tags.filter_map(|(tag, _)| value(tag)).collect()
}

/// Every file of a run, every key of its report, every field of its VTK files and every column of its probes is told.
#[test]
fn the_formats_page_tells_all_that_a_run_writes() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/formats.md")).unwrap();
    let tells = |name: &str| text.contains(&format!("`{name}`")) || text.contains(&format!("`\"{name}\"`"));
    let folder = tempfile::tempdir().unwrap();
    let scenario = examples("scenario.md", &std::fs::read_to_string(Path::new(ROOT).join("docs/scenario.md")).unwrap());
    let mut whole = scenario[0].table.clone();
    let more = "[probes.axis]\nfrom = [0, 0.5, 0.5]\nto = [4, 0.5, 0.5]\npoints = 3\n[units]\nlength = \"mm\"\n";
    whole.extend(more.parse::<Table>().unwrap());
    std::fs::write(folder.path().join("all.toml"), toml::to_string(&whole).unwrap()).unwrap();
    let command = |arguments: &[&str]| {
        let output =
            Command::cargo_bin("subsolid").unwrap().args(arguments).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let mut keys = BTreeSet::new();
    json_keys(&command(&["run", "all.toml", "--json", "-"]), &mut keys);
    json_keys(&command(&["check", "all.toml", "--json", "-"])["forecast"], &mut keys);
    assert!(keys.len() > 60, "{keys:?}");
    let untold: Vec<&String> = keys.iter().filter(|key| !tells(key) && *key != "length").collect();
    assert!(untold.is_empty(), "keys that the page does not tell: {untold:?}");

    let results = folder.path().join("results/all");
    let files = std::fs::read_dir(&results).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let untold: Vec<String> = files.filter(|f| !tells(&f.replace("axis", "<name>"))).collect();
    assert!(untold.is_empty(), "files that the page does not tell: {untold:?}");

    let vtu = String::from_utf8_lossy(&std::fs::read(results.join("step_000.vtu")).unwrap()).into_owned();
    let fields = &attributes(&vtu, "DataArray", "Name") | &attributes(&vtu, "Array", "Name");
    let own = ["connectivity", "offsets", "types", "Points"];
    assert!(fields.len() > 12, "{fields:?}");
    let untold: Vec<&String> = fields.iter().filter(|f| !own.contains(&f.as_str()) && !tells(f)).collect();
    assert!(untold.is_empty(), "fields that the page does not tell: {untold:?}");

    let columns = std::fs::read_to_string(results.join("probe_axis.csv")).unwrap();
    assert!(columns.lines().next().unwrap().split(',').all(tells), "{columns}");
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut count = 0;
    for (page, text) in pages() {
        let folder = Path::new(ROOT).join(if page == "README.md" { "" } else { "docs" });
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            if link.contains("://") {
                continue;
            }
            count += 1;
            let target = if path.is_empty() { folder.join(&page) } else { folder.join(path) };
            assert!(target.exists(), "{page}: {link}");
            let anchor = |line: &str| {
                let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
                line.trim_start_matches('#')
                    .trim()
                    .to_lowercase()
                    .chars()
                    .filter(kept)
                    .collect::<String>()
                    .replace(' ', "-")
            };
            let found = || {
                std::fs::read_to_string(&target).unwrap().lines().any(|l| l.starts_with('#') && anchor(l) == heading)
            };
            assert!(heading.is_empty() || found(), "{page}: {link}");
        }
    }
    assert!(count > 20, "{count} links");
}
