//! Lines and fields of a text, with errors that say where.

use super::{error_at, finite, number_help};
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::path::Path;
use std::str::{FromStr, SplitAsciiWhitespace};

/// The lines of a file that are not blank.
pub(super) struct Lines<'a> {
    path: &'a Path,
    rest: &'a str,
    number: usize,
}

/// One line.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
    pub(super) at: Place,
}

/// What is left of a line, to be taken field by field.
pub(super) struct Fields<'a> {
    line: Line<'a>,
    tokens: SplitAsciiWhitespace<'a>,
}

/// A list whose length the file announces.
pub(super) struct Announced {
    /// What is listed, in the plural.
    pub(super) what: &'static str,
    pub(super) count: usize,
    /// Where the count stands.
    pub(super) at: Place,
}

impl Announced {
    /// Refuses a count of entries that the `bytes` left of the file cannot hold at `least` bytes each.
    pub(super) fn check(&self, path: &Path, bytes: u64, least: u64) -> Result<(), MeshError> {
        let Self { what, count, at } = self;
        if *count as u64 <= bytes / least + 1 {
            return Ok(());
        }
        let message = format!("{count} {what} are announced, but only {bytes} bytes of the file remain");
        Err(error_at(path, *at, message, "correct the count, or write the file again"))
    }
}

/// What to do about a file that ends too early.
pub(super) const TRUNCATED: &str = "the file seems to be cut off: write or copy it again";

impl<'a> Lines<'a> {
    pub(super) fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, rest: text.trim_start_matches('\u{feff}'), number: 0 }
    }

    /// The next line that is not blank.
    pub(super) fn next(&mut self) -> Option<Line<'a>> {
        while !self.rest.is_empty() {
            let (text, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
            self.rest = rest;
            self.number += 1;
            if !text.trim_ascii().is_empty() {
                return Some(Line { path: self.path, text: text.trim_ascii_end(), at: Place::Line(self.number) });
            }
        }
        None
    }

    /// The next line; an error saying that `what` was expected if there is none.
    pub(super) fn expect(&mut self, what: &str) -> Result<Line<'a>, MeshError> {
        self.next().ok_or_else(|| self.error_at_end(format!("expected {what}, found the end of the file"), TRUNCATED))
    }

    /// The next entry of an announced list, of which `index` were read before.
    pub(super) fn entry(&mut self, list: &Announced, index: usize) -> Result<Line<'a>, MeshError> {
        let Announced { what, count, at } = list;
        let announced = format!("expected {count} {what} (announced in {})", at.named());
        match self.next() {
            Some(entry) if !entry.text.trim_ascii_start().starts_with('$') => Ok(entry),
            Some(end) => {
                let message = format!("{announced}, found {index} before {}", end.quoted());
                Err(end.error(message, "correct the count, or write the file again"))
            }
            None => Err(self.error_at_end(format!("{announced}, found {index} before the end of the file"), TRUNCATED)),
        }
    }

    /// How many bytes are left.
    pub(super) fn remaining(&self) -> usize {
        self.rest.len()
    }

    /// An error at the last line.
    pub(super) fn error_at_end(&self, message: impl Into<String>, help: &str) -> MeshError {
        error_at(self.path, Place::Line(self.number.max(1)), message, help)
    }
}

impl<'a> Line<'a> {
    /// Number of the line, or the byte it begins with.
    pub(super) fn place(&self) -> u64 {
        let (Place::Line(at) | Place::Byte(at)) = self.at;
        at as u64
    }

    pub(super) fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        error_at(self.path, self.at, message, help)
    }

    /// The first word in lower case.
    pub(super) fn keyword(&self) -> String {
        self.text.split_ascii_whitespace().next().unwrap_or("").chars().take(40).collect::<String>().to_lowercase()
    }

    /// The beginning of the line as it may stand in a message.
    pub(super) fn quoted(&self) -> String {
        format!("{:?}", self.text.trim_ascii_start().chars().take(40).collect::<String>())
    }

    pub(super) fn fields(self) -> Fields<'a> {
        Fields { line: self, tokens: self.text.split_ascii_whitespace() }
    }

    /// The line's only field, the length of a list.
    pub(super) fn count(self, what: &'static str) -> Result<Announced, MeshError> {
        let mut fields = self.fields();
        let list = fields.count(what)?;
        fields.end()?;
        Ok(list)
    }
}

impl<'a> Fields<'a> {
    /// An error at the line.
    pub(super) fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        self.line.error(message, help)
    }

    /// Number of the line.
    pub(super) fn place(&self) -> u64 {
        self.line.place()
    }

    fn parse<T: FromStr>(&mut self, what: &str, kind: &str) -> Result<T, MeshError> {
        let Some(token) = self.tokens.next() else {
            let message = format!("expected {what} at the end of {}", self.line.quoted());
            return Err(self.line.error(message, "the line is too short, or the file is cut off here"));
        };
        token.parse().map_err(|_| self.unparsable(token, what, kind))
    }

    fn unparsable(&self, token: &str, what: &str, kind: &str) -> MeshError {
        let column = token.as_ptr() as usize - self.line.text.as_ptr() as usize + 1;
        let shown: String = token.chars().take(40).collect();
        self.line.error(format!("column {column}: {what} is {shown:?}, expected {kind}"), number_help(token))
    }

    /// An id: a whole number from 0.
    pub(super) fn id(&mut self, what: &str) -> Result<u32, MeshError> {
        self.parse(what, "a whole number")
    }

    /// A tag: a whole number.
    pub(super) fn tag(&mut self, what: &str) -> Result<i32, MeshError> {
        self.parse(what, "a whole number")
    }

    /// Several ids.
    pub(super) fn ids<const N: usize>(&mut self, what: &str) -> Result<[u32; N], MeshError> {
        let mut ids = [0; N];
        for id in &mut ids {
            *id = self.id(what)?;
        }
        Ok(ids)
    }

    /// The length of a list.
    pub(super) fn count(&mut self, what: &'static str) -> Result<Announced, MeshError> {
        let count: u32 = self.parse(&format!("the number of {what}"), "a whole number")?;
        Ok(Announced { what, count: count as usize, at: self.line.at })
    }

    /// Skips `count` fields.
    pub(super) fn skip(&mut self, count: usize, what: &str) -> Result<(), MeshError> {
        for _ in 0..count {
            let _: &str = self.tokens.next().ok_or_else(|| {
                let message = format!("expected {count} fields of {what} in {}", self.line.quoted());
                self.line.error(message, "the line is too short, or the file is cut off here")
            })?;
        }
        Ok(())
    }

    /// A position: three finite numbers.
    pub(super) fn position(&mut self, node: u32) -> Result<DVec3, MeshError> {
        let mut p = [0.0_f64; 3];
        for (x, name) in p.iter_mut().zip(["x", "y", "z"]) {
            *x = self.parse(name, "a number")?;
            finite(*x, name, node).map_err(|(message, help)| self.line.error(message, help))?;
        }
        Ok(DVec3::from_array(p))
    }

    /// A number that may follow.
    pub(super) fn optional_tag(&mut self, what: &str) -> Result<Option<i32>, MeshError> {
        if self.tokens.clone().next().is_none() { Ok(None) } else { self.tag(what).map(Some) }
    }

    /// Refuses fields that nobody asked for.
    pub(super) fn end(&mut self) -> Result<(), MeshError> {
        match self.tokens.next() {
            None => Ok(()),
            Some(extra) => {
                let shown: String = extra.chars().take(40).collect();
                let message = format!("unexpected {shown:?} after the last field of the line");
                Err(self.line.error(message, "the line is too long; correct it, or write the file again"))
            }
        }
    }
}
