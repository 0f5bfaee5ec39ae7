//! Cards: a line `*KEYWORD, PARAMETER=VALUE, ...` and the data lines below it. `**` begins a comment.

use super::super::lines::{Line, Lines};
use super::super::{finite, number_help};
use crate::mesh::MeshError;
use glam::DVec3;
use std::path::Path;
use std::str::FromStr;

/// The cards of a file.
pub(super) struct Cards<'a> {
    lines: Lines<'a>,
    /// A keyword line that ended the data before it.
    pending: Option<Line<'a>>,
}

/// A keyword line.
pub(super) struct Card<'a> {
    line: Line<'a>,
    /// In capitals, without blanks and star.
    pub(super) keyword: String,
    /// Names in capitals, and values, empty where there are none.
    parameters: Vec<(String, &'a str)>,
}

/// What is left of a data line.
pub(super) struct Data<'a> {
    line: Line<'a>,
    rest: Option<&'a str>,
}

impl<'a> Cards<'a> {
    pub(super) fn new(path: &'a Path, text: &'a str) -> Self {
        Self { lines: Lines::new(path, text), pending: None }
    }

    fn line(&mut self) -> Option<Line<'a>> {
        let mut line = self.pending.take().or_else(|| self.lines.next());
        while line.is_some_and(|line| line.text.trim_ascii_start().starts_with("**")) {
            line = self.lines.next();
        }
        line
    }

    /// The next card; data lines before it are passed over.
    pub(super) fn next(&mut self) -> Result<Option<Card<'a>>, MeshError> {
        while let Some(line) = self.line() {
            if let Some(text) = line.text.trim_ascii_start().strip_prefix('*') {
                return self.card(line, text).map(Some);
            }
        }
        Ok(None)
    }

    /// A card whose parameters may go on in the lines after it.
    fn card(&mut self, line: Line<'a>, text: &'a str) -> Result<Card<'a>, MeshError> {
        let mut words: Vec<&str> = text.split(',').map(str::trim_ascii).collect();
        while words.last().is_some_and(|word| word.is_empty()) {
            words.pop();
            let Some(more) = self.line() else { break };
            if more.text.trim_ascii_start().starts_with('*') {
                self.pending = Some(more);
                break;
            }
            words.extend(more.text.split(',').map(str::trim_ascii));
        }
        let capitals = |word: &str| word.split_ascii_whitespace().collect::<String>().to_ascii_uppercase();
        let mut words = words.into_iter();
        let keyword = capitals(words.next().unwrap_or("")).chars().take(40).collect();
        let parameter = |word: &'a str| {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            (capitals(name), value.trim_ascii().trim_matches('"'))
        };
        Ok(Card { line, keyword, parameters: words.map(parameter).collect() })
    }

    /// The next data line of the card; `None` at the next card.
    pub(super) fn data(&mut self) -> Option<Data<'a>> {
        let line = self.line()?;
        if line.text.trim_ascii_start().starts_with('*') {
            self.pending = Some(line);
            return None;
        }
        Some(Data { line, rest: Some(line.text) })
    }

    /// `count` node ids of the element `id`, which may go on in the lines after `data`.
    pub(super) fn ids(&mut self, mut data: Data<'a>, count: usize, id: u32) -> Result<Vec<u32>, MeshError> {
        let mut ids = Vec::with_capacity(count);
        while ids.len() < count {
            if data.is_empty() {
                let found = ids.len();
                data = self.data().ok_or_else(|| {
                    let message = format!("element {id} has {found} nodes, its type {count}");
                    data.error(message, "the line is too short, or the file is cut off here")
                })?;
            }
            ids.push(data.id("a node of the element")?);
        }
        if !data.is_empty() {
            let message = format!("element {id} has more than the {count} nodes of its type");
            return Err(data.error(message, "correct the line, or the element's type"));
        }
        Ok(ids)
    }

    pub(super) fn error_at_end(&self, message: String, help: &str) -> MeshError {
        self.lines.error_at_end(message, help)
    }
}

impl Card<'_> {
    pub(super) fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        self.line.error(message, help)
    }

    /// The value of a parameter, if it is there.
    pub(super) fn find(&self, name: &str) -> Option<&str> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// The value of a parameter that must be there.
    pub(super) fn value(&self, name: &str) -> Result<&str, MeshError> {
        self.find(name).filter(|value| !value.is_empty()).ok_or_else(|| {
            let message = format!("*{} without {name}= in {}", self.keyword, self.line.quoted());
            self.error(message, "name it, or remove the card")
        })
    }
}

impl<'a> Data<'a> {
    pub(super) fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        self.line.error(message, help)
    }

    /// Number of the line.
    pub(super) fn place(&self) -> u64 {
        self.line.place()
    }

    /// Whether nothing follows, or a comma only.
    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_none_or(|rest| rest.trim_ascii().is_empty())
    }

    /// The next field, empty if there is none.
    pub(super) fn word(&mut self) -> &'a str {
        let Some(rest) = self.rest else { return "" };
        let (word, rest) = rest.split_once(',').map_or((rest, None), |(word, rest)| (word, Some(rest)));
        self.rest = rest;
        word.trim_ascii().trim_matches('"')
    }

    fn number<T: FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        let word = self.word();
        word.parse().map_err(|_| {
            let shown: String = word.chars().take(40).collect();
            // Where nothing is left of a line, its end is what should be a number.
            let column = (word.as_ptr() as usize).checked_sub(self.line.text.as_ptr() as usize);
            let column = column.filter(|&c| c < self.line.text.len()).map(|c| format!("column {}: ", c + 1));
            let message = format!("{}{what} is {shown:?}, expected a number", column.unwrap_or_default());
            self.error(message, number_help(word))
        })
    }

    /// The id of a node or an element.
    pub(super) fn id(&mut self, what: &str) -> Result<u32, MeshError> {
        self.number(what)
    }

    /// A position; coordinates left out are 0.
    pub(super) fn position(&mut self, node: u32) -> Result<DVec3, MeshError> {
        let mut p = [0.0_f64; 3];
        for (x, name) in p.iter_mut().zip(["x", "y", "z"]) {
            if !self.is_empty() {
                *x = self.number(name)?;
            }
            finite(*x, name, node).map_err(|(message, help)| self.error(message, help))?;
        }
        if !self.is_empty() {
            let message = format!("more than three coordinates of node {node} in {}", self.line.quoted());
            return Err(self.error(message, "decimal commas? export with decimal points, and without normals at nodes"));
        }
        Ok(DVec3::from_array(p))
    }
}
