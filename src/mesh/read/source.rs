//! Where the Gmsh readers take their fields from: a text or a binary file.

use super::lines::{Announced, Fields, Line, Lines, TRUNCATED};
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::path::Path;

/// A file of sections, which hold entries, which hold fields. In a text an entry is a line.
pub(super) trait Source {
    /// Whether entries are binary.
    const BINARY: bool;

    /// The next line that is not blank.
    fn next_line(&mut self) -> Result<Option<Line<'_>>, MeshError>;

    /// Begins the next entry, which is `what`.
    fn begin(&mut self, what: &str) -> Result<(), MeshError>;

    /// Begins the next entry of an announced list, of which `index` were read before.
    fn entry(&mut self, list: &Announced, index: usize) -> Result<(), MeshError>;

    /// Refuses fields of the entry that nobody asked for.
    fn end_entry(&mut self) -> Result<(), MeshError>;

    /// Line or byte of the entry.
    fn place(&self) -> u64;

    /// The id of a node or an element.
    fn id(&mut self, what: &str) -> Result<u32, MeshError>;

    /// A small whole number: a tag, a dimension, a type.
    fn int(&mut self, what: &str) -> Result<i32, MeshError>;

    /// The length of a list; refused if the file is too small to hold it.
    fn count(&mut self, what: &'static str) -> Result<Announced, MeshError>;

    /// A position: three finite numbers.
    fn position(&mut self, node: u32) -> Result<DVec3, MeshError>;

    /// Passes over fields of `bytes` bytes each.
    fn skip(&mut self, count: usize, bytes: usize, what: &str) -> Result<(), MeshError>;

    /// How many bytes are left.
    fn remaining(&self) -> u64;

    /// An error at the entry.
    fn error(&self, message: String, help: &str) -> MeshError;

    /// An error at the end of what was read.
    fn error_at_end(&self, message: String, help: &str) -> MeshError;

    /// The name of the file.
    fn path(&self) -> &Path;

    /// The next line; an error saying that `what` was expected if there is none.
    fn line(&mut self, what: &str) -> Result<Line<'_>, MeshError> {
        // Made before it is needed: the line borrows the source.
        let end = self.error_at_end(format!("expected {what}, found the end of the file"), TRUNCATED);
        self.next_line()?.ok_or(end)
    }

    /// A line that holds the length of a list and nothing else.
    fn line_count(&mut self, what: &'static str) -> Result<Announced, MeshError> {
        let list = self.line(&format!("the number of {what}"))?.count(what)?;
        list.check(self.path(), self.remaining(), 2)?;
        Ok(list)
    }

    /// Several ids.
    fn ids<const N: usize>(&mut self, what: &str) -> Result<[u32; N], MeshError> {
        let mut ids = [0; N];
        for id in &mut ids {
            *id = self.id(what)?;
        }
        Ok(ids)
    }
}

/// A text.
pub(super) struct Text<'a> {
    path: &'a Path,
    lines: Lines<'a>,
    fields: Fields<'a>,
}

impl<'a> Text<'a> {
    pub(super) fn new(path: &'a Path, lines: Lines<'a>) -> Self {
        let none = Line { path, text: "", at: Place::Line(1) };
        Self { path, lines, fields: none.fields() }
    }
}

impl Source for Text<'_> {
    const BINARY: bool = false;

    fn next_line(&mut self) -> Result<Option<Line<'_>>, MeshError> {
        Ok(self.lines.next())
    }

    fn begin(&mut self, what: &str) -> Result<(), MeshError> {
        self.fields = self.lines.expect(what)?.fields();
        Ok(())
    }

    fn entry(&mut self, list: &Announced, index: usize) -> Result<(), MeshError> {
        self.fields = self.lines.entry(list, index)?.fields();
        Ok(())
    }

    fn end_entry(&mut self) -> Result<(), MeshError> {
        self.fields.end()
    }

    fn place(&self) -> u64 {
        self.fields.place()
    }

    fn id(&mut self, what: &str) -> Result<u32, MeshError> {
        self.fields.id(what)
    }

    fn int(&mut self, what: &str) -> Result<i32, MeshError> {
        self.fields.tag(what)
    }

    fn count(&mut self, what: &'static str) -> Result<Announced, MeshError> {
        let list = self.fields.count(what)?;
        list.check(self.path, self.remaining(), 2)?;
        Ok(list)
    }

    fn position(&mut self, node: u32) -> Result<DVec3, MeshError> {
        self.fields.position(node)
    }

    fn skip(&mut self, count: usize, _bytes: usize, what: &str) -> Result<(), MeshError> {
        self.fields.skip(count, what)
    }

    fn remaining(&self) -> u64 {
        self.lines.remaining() as u64
    }

    fn error(&self, message: String, help: &str) -> MeshError {
        self.fields.error(message, help)
    }

    fn error_at_end(&self, message: String, help: &str) -> MeshError {
        self.lines.error_at_end(message, help)
    }

    fn path(&self) -> &Path {
        self.path
    }
}
