//! The parsed TOML of a scenario with its overrides applied, and the way from a span back to file, line and key.
//!
//! An override is parsed as if it stood behind the text, so that each span belongs to the file or to one override.

use super::error::{Fault, Invalid};
use miette::NamedSource;
use std::ops::Range;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// The text of a scenario and the overrides behind it.
pub(super) struct Sources {
    name: String,
    text: String,
    overrides: Vec<Override>,
}

/// A key and its value from the command line.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    /// `key.path=value`.
    pub(super) text: String,
    /// The option that it came by, as messages name it.
    option: String,
}

impl Setting {
    /// Those that came by an option.
    pub(super) fn all(option: &str, texts: &[String]) -> Vec<Self> {
        texts.iter().map(|text| Self { text: text.clone(), option: option.to_owned() }).collect()
    }
}

/// A line `key = value`, padded to stand behind the text.
struct Override {
    option: String,
    /// Offset of its first byte.
    start: usize,
    /// Number of names in the key.
    depth: usize,
    padded: String,
}

impl Override {
    fn line(&self) -> &str {
        &self.padded[self.start..]
    }
}

impl Sources {
    /// Takes the text of the file `name` and overrides `key.path=value`; a value that is not TOML stands for a string.
    pub(super) fn new(name: &str, text: &str, overrides: &[Setting]) -> Result<Self, Box<Invalid>> {
        let mut sources = Self { name: name.to_owned(), text: text.to_owned(), overrides: Vec::new() };
        for Setting { text: argument, option } in overrides {
            let start = sources.overrides.last().map_or(text.len(), |o| o.padded.len()) + 1;
            let (line, depth) = normalise(argument).map_err(|(problem, help)| {
                let (place, span) = (format!("{option} {argument}"), (0, argument.len()).into());
                let source_code = NamedSource::new(option, argument.clone());
                let (message, label) = (problem.to_owned(), "here".to_owned());
                Box::new(Invalid { place, key: String::new(), message, source_code, span, label, help })
            })?;
            let (option, padded) = (option.clone(), " ".repeat(start) + &line);
            sources.overrides.push(Override { option, start, depth, padded });
        }
        Ok(sources)
    }

    /// Parses the text and puts the overrides in their places.
    pub(super) fn parse(&self) -> Result<Document<'_>, Box<Invalid>> {
        let root = DeTable::parse(&self.text).map_err(|e| self.explain(syntax(&e), String::new()))?;
        let mut document = Document { sources: self, root };
        for o in &self.overrides {
            let patch = DeTable::parse(&o.padded).map_err(|e| self.explain(syntax(&e), String::new()))?;
            merge(document.root.get_mut(), patch.into_inner(), o.depth).map_err(|fault| document.explain(fault))?;
        }
        Ok(document)
    }

    /// The override that holds a span.
    fn overriding(&self, span: &Range<usize>) -> Option<&Override> {
        self.overrides.iter().rfind(|o| o.start <= span.start)
    }

    /// `file:line:column` of a span, or the override.
    fn place(&self, span: &Range<usize>) -> String {
        if let Some(o) = self.overriding(span) {
            return format!("{} {}", o.option, o.line());
        }
        let before = self.text.get(..span.start).unwrap_or(&self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        format!("{}:{line}:{column}", self.name)
    }

    fn explain(&self, fault: Fault, key: String) -> Box<Invalid> {
        let Fault { span, problem, label, help } = fault;
        let place = self.place(&span);
        let message = if key.is_empty() { problem } else { format!("`{key}` {problem}") };
        let (source_code, start) = match self.overriding(&span) {
            Some(o) => (NamedSource::new(&o.option, o.line().to_owned()), span.start - o.start),
            None => (NamedSource::new(&self.name, self.text.clone()), span.start),
        };
        let span = (start, span.len()).into();
        Box::new(Invalid { place, key, message, source_code, span, label, help })
    }
}

/// The override as a line of TOML, and the number of names in its key; otherwise what is wrong with it.
fn normalise(argument: &str) -> Result<(String, usize), (&'static str, Option<String>)> {
    let help = || Some("write key.path=value, for example refine.steps=3".to_owned());
    let (key, value) = argument.split_once('=').ok_or(("an override needs `=`", help()))?;
    let name = format!("{key} = 0");
    let table = DeTable::parse(&name).map_err(|_| ("what stands before `=` is not a key", help()))?;
    let depth = depth(table.get_ref());
    let value = value.trim();
    match DeValue::parse(value) {
        Ok(_) => Ok((argument.to_owned(), depth)),
        Err(_) => Ok((format!("{key}={}", toml::Value::String(value.to_owned())), depth)),
    }
}

/// A parsed scenario.
pub(super) struct Document<'a> {
    sources: &'a Sources,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// The root table.
    pub(super) fn root(&self) -> &Spanned<DeTable<'a>> {
        &self.root
    }

    /// `file:line:column` of a span, or the override.
    pub(super) fn place(&self, span: &Range<usize>) -> String {
        self.sources.place(span)
    }

    /// Adds place and key to a fault.
    pub(super) fn explain(&self, fault: Fault) -> Box<Invalid> {
        let key = self.key(&fault.span).unwrap_or_default();
        self.sources.explain(fault, key)
    }

    /// Path of the innermost key or value around a span.
    pub(super) fn key(&self, span: &Range<usize>) -> Option<String> {
        let mut best = None;
        search(self.root.get_ref(), "", span, &mut best);
        best.map(|(_, key)| key)
    }
}

/// Number of names in a dotted key, from the table that `key = 0` makes.
fn depth(table: &DeTable<'_>) -> usize {
    match table.values().next().map(Spanned::get_ref) {
        Some(DeValue::Table(inner)) => 1 + depth(inner),
        _ => 1,
    }
}

/// Puts the one value that lies `depth` keys down in `patch` at the same place in `table`.
fn merge<'a>(table: &mut DeTable<'a>, patch: DeTable<'a>, depth: usize) -> Result<(), Fault> {
    for (key, value) in patch {
        let name = key.get_ref().clone();
        match table.get_mut(name.as_ref()).map(Spanned::get_mut) {
            Some(DeValue::Table(inner)) if depth > 1 => {
                if let DeValue::Table(rest) = value.into_inner() {
                    merge(inner, rest, depth - 1)?;
                }
            }
            Some(_) if depth > 1 => {
                return Err(Fault::new(key.span(), "holds a value, not a table", "has no keys below it"));
            }
            _ => {
                // `insert` alone would keep the old key with the old span.
                table.remove(name.as_ref());
                table.insert(key, value);
            }
        }
    }
    Ok(())
}

/// Remembers the path of the narrowest key or value that contains `span`; the deeper wins a tie.
fn search(table: &DeTable<'_>, prefix: &str, span: &Range<usize>, best: &mut Option<(usize, String)>) {
    for (key, value) in table {
        let path = join(prefix, key.get_ref());
        consider(&key.span(), &path, span, best);
        search_value(value, &path, span, best);
    }
}

fn search_value(value: &Spanned<DeValue<'_>>, path: &str, span: &Range<usize>, best: &mut Option<(usize, String)>) {
    consider(&value.span(), path, span, best);
    match value.get_ref() {
        DeValue::Table(inner) => search(inner, path, span, best),
        DeValue::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                // The first of an array of tables `[[path]]` has the span of the array: it stands for the array.
                let item_path = if item.span() == value.span() { path.to_owned() } else { format!("{path}[{i}]") };
                search_value(item, &item_path, span, best);
            }
        }
        _ => {}
    }
}

fn consider(candidate: &Range<usize>, path: &str, span: &Range<usize>, best: &mut Option<(usize, String)>) {
    let contains = candidate.start <= span.start && span.end <= candidate.end && !candidate.is_empty();
    if contains && best.as_ref().is_none_or(|(len, _)| candidate.len() <= *len) {
        *best = Some((candidate.len(), path.to_owned()));
    }
}

fn join(prefix: &str, key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    let key = if bare { key.to_owned() } else { format!("{key:?}") };
    if prefix.is_empty() { key } else { format!("{prefix}.{key}") }
}

fn syntax(error: &toml::de::Error) -> Fault {
    Fault::new(error.span().unwrap_or(0..0), error.message(), "here")
}
