//! Words of a text whose line breaks mean nothing, with binary data between them.

use super::lines::{Announced, TRUNCATED};
use super::{error_at, finite, number_help};
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::path::Path;
use std::str::FromStr;

/// What is left of a file.
pub(super) struct Words<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// The next byte.
    at: usize,
    /// Line of the next byte, from 1.
    line: usize,
    /// Place of the last word.
    word: Place,
    /// Whether `#` begins a comment.
    comments: bool,
    /// Whether places are bytes: lines mean nothing in binary data.
    binary: bool,
}

impl<'a> Words<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8], comments: bool) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { path, bytes, at: 0, line: 1, word: Place::Line(1), comments, binary: false }
    }

    /// Gives bytes for places from here on.
    pub(super) fn count_bytes(&mut self) {
        self.binary = true;
    }

    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Place of the next byte.
    fn here(&self) -> Place {
        if self.binary { Place::Byte(self.at) } else { Place::Line(self.line) }
    }

    /// Line or byte of the last word.
    pub(super) fn place(&self) -> u64 {
        let (Place::Line(at) | Place::Byte(at)) = self.word;
        at as u64
    }

    fn skip_blanks(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'\n' {
                self.line += 1;
            } else if byte == b'#' && self.comments {
                let rest = &self.bytes[self.at..];
                self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                continue;
            } else if !byte.is_ascii_whitespace() {
                return;
            }
            self.at += 1;
        }
    }

    /// The next word, not consumed.
    pub(super) fn peek(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        Some(&rest[..end]).filter(|word| !word.is_empty())
    }

    /// The next word.
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let word = self.peek()?;
        self.word = self.here();
        self.at += word.len();
        Some(word)
    }

    /// The next word; an error saying that `what` was expected if there is none.
    pub(super) fn expect(&mut self, what: &str) -> Result<&'a [u8], MeshError> {
        self.next().ok_or_else(|| self.ended(what))
    }

    fn ended(&self, what: &str) -> MeshError {
        error_at(self.path, self.here(), format!("expected {what}, found the end of the file"), TRUNCATED)
    }

    /// The rest of the line, without its end.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        rest[..length].trim_ascii()
    }

    /// Passes over the line if it begins with that word here.
    pub(super) fn skip_line_of(&mut self, word: &[u8]) {
        if self.bytes[self.at..].trim_ascii_start().starts_with(word) {
            self.skip_blanks();
            self.rest_of_line();
        }
    }

    /// Passes over the end of the line, unless that was done.
    pub(super) fn end_line(&mut self) {
        if self.at > 0 && self.bytes[self.at - 1] != b'\n' {
            self.rest_of_line();
        }
    }

    /// The next `count` times `size` bytes.
    pub(super) fn take(&mut self, count: usize, size: usize, what: &str) -> Result<&'a [u8], MeshError> {
        let taken = count.checked_mul(size).and_then(|bytes| self.bytes[self.at..].get(..bytes));
        let taken = taken.ok_or_else(|| {
            let message =
                format!("expected {count} {what} of {size} bytes, but only {} bytes remain", self.remaining());
            error_at(self.path, self.here(), message, TRUNCATED)
        })?;
        self.at += taken.len();
        Ok(taken)
    }

    /// An error at the last word.
    pub(super) fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        error_at(self.path, self.word, message, help)
    }

    /// The next word as a number.
    pub(super) fn number<T: FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        let word = self.expect(what)?;
        let parsed = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        parsed.ok_or_else(|| {
            let message = format!("{}{what} is {}, expected a number", self.column(word), shown(word));
            self.error(message, number_help(&String::from_utf8_lossy(word)))
        })
    }

    /// The column of the last word of a text, for a message.
    fn column(&self, word: &[u8]) -> String {
        if self.binary {
            return String::new();
        }
        let start = self.at - word.len();
        let line = self.bytes[..start].iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1);
        format!("column {}: ", start - line + 1)
    }

    /// The length of a list whose entries take at least two bytes each.
    pub(super) fn count(&mut self, what: &'static str) -> Result<Announced, MeshError> {
        let count: usize = self.number(&format!("the number of {what}"))?;
        let list = Announced { what, count, at: self.word };
        list.check(self.path, self.remaining() as u64, 2)?;
        Ok(list)
    }

    /// A position: three finite numbers.
    pub(super) fn position(&mut self, node: u32) -> Result<DVec3, MeshError> {
        let mut p = [0.0_f64; 3];
        for (x, name) in p.iter_mut().zip(["x", "y", "z"]) {
            *x = self.number(name)?;
            finite(*x, name, node).map_err(|(message, help)| self.error(message, help))?;
        }
        Ok(DVec3::from_array(p))
    }
}

/// The beginning of a word as it may stand in a message.
pub(super) fn shown(word: &[u8]) -> String {
    format!("{:?}", String::from_utf8_lossy(word).chars().take(40).collect::<String>())
}
