//! Binary Gmsh files, read as they come: the file is never in memory as a whole.

use super::lines::{Announced, Line, TRUNCATED};
use super::source::Source;
use super::{error_at, finite, unreadable};
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::io::{BufRead, ErrorKind};
use std::path::Path;

/// A binary file with lines of text between its blocks.
pub(super) struct Binary<'a, R> {
    path: &'a Path,
    reader: R,
    /// How many bytes were read, and how many there are.
    at: u64,
    length: u64,
    /// The byte the current entry begins with.
    entry: u64,
    big_endian: bool,
    /// Bytes of an id or a count: 4 in MSH 2.2, 8 in MSH 4.1.
    id_bytes: usize,
    /// The last line read.
    line: String,
}

impl<'a, R: BufRead> Binary<'a, R> {
    /// A file of `length` bytes from its beginning.
    pub(super) fn new(path: &'a Path, reader: R, length: u64) -> Self {
        Self { path, reader, at: 0, length, entry: 0, big_endian: false, id_bytes: 8, line: String::new() }
    }

    /// Reads the number 1, which tells the order of bytes.
    pub(super) fn read_byte_order(&mut self) -> Result<(), MeshError> {
        self.begin("the number that tells the order of bytes")?;
        let bytes = self.take("the number that tells the order of bytes")?;
        self.big_endian = match (i32::from_le_bytes(bytes), i32::from_be_bytes(bytes)) {
            (1, _) => false,
            (_, 1) => true,
            (other, _) => {
                let message = format!("expected the number 1, which tells the order of bytes, found {other}");
                return Err(self.error(message, "the file is damaged: write it again"));
            }
        };
        Ok(())
    }

    /// Sets how many bytes an id has.
    pub(super) fn set_id_bytes(&mut self, bytes: usize) {
        self.id_bytes = bytes;
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], MeshError> {
        let mut bytes = [0; N];
        match self.reader.read_exact(&mut bytes) {
            Ok(()) => {
                self.at += N as u64;
                Ok(bytes)
            }
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => {
                self.at = self.length;
                Err(self.error_at_end(format!("expected {what}, found the end of the file"), TRUNCATED))
            }
            Err(e) => Err(unreadable(self.path, e)),
        }
    }

    /// A whole number of as many bytes as an id has.
    fn size(&mut self, what: &str) -> Result<u64, MeshError> {
        if self.id_bytes == 4 {
            let bytes = self.take(what)?;
            return Ok(u64::from(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }));
        }
        let bytes = self.take(what)?;
        Ok(if self.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    fn real(&mut self, what: &str) -> Result<f64, MeshError> {
        let bytes = self.take(what)?;
        Ok(if self.big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }
}

impl<R: BufRead> Source for Binary<'_, R> {
    const BINARY: bool = true;

    fn next_line(&mut self) -> Result<Option<Line<'_>>, MeshError> {
        let mut bytes = Vec::new();
        while bytes.trim_ascii().is_empty() {
            bytes.clear();
            self.entry = self.at;
            let count = self.reader.read_until(b'\n', &mut bytes).map_err(|e| unreadable(self.path, e))?;
            if count == 0 {
                return Ok(None);
            }
            self.at += count as u64;
        }
        self.line = String::from_utf8_lossy(bytes.trim_ascii_end()).into_owned();
        Ok(Some(Line { path: self.path, text: &self.line, at: Place::Byte(self.entry as usize) }))
    }

    fn begin(&mut self, _what: &str) -> Result<(), MeshError> {
        self.entry = self.at;
        Ok(())
    }

    fn entry(&mut self, list: &Announced, index: usize) -> Result<(), MeshError> {
        self.entry = self.at;
        if self.at < self.length {
            return Ok(());
        }
        let Announced { what, count, at } = list;
        let announced = format!("expected {count} {what} (announced in {})", at.named());
        Err(self.error_at_end(format!("{announced}, found {index} before the end of the file"), TRUNCATED))
    }

    fn end_entry(&mut self) -> Result<(), MeshError> {
        Ok(())
    }

    fn place(&self) -> u64 {
        self.entry
    }

    fn id(&mut self, what: &str) -> Result<u32, MeshError> {
        let id = self.size(what)?;
        u32::try_from(id).map_err(|_| {
            let message = format!("{what} is {id}, which is too large");
            self.error(message, "ids are at most 4294967295; if yours are not, the file is damaged: write it again")
        })
    }

    fn int(&mut self, what: &str) -> Result<i32, MeshError> {
        let bytes = self.take(what)?;
        Ok(if self.big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) })
    }

    fn count(&mut self, what: &'static str) -> Result<Announced, MeshError> {
        let at = Place::Byte(self.at as usize);
        let count = self.size(&format!("the number of {what}"))?;
        let list = Announced { what, count: usize::try_from(count).unwrap_or(usize::MAX), at };
        list.check(self.path, self.remaining(), 4)?;
        Ok(list)
    }

    fn position(&mut self, node: u32) -> Result<DVec3, MeshError> {
        let mut p = [0.0; 3];
        for (x, name) in p.iter_mut().zip(["x", "y", "z"]) {
            *x = self.real(name)?;
            finite(*x, name, node).map_err(|(message, help)| self.error(message, help))?;
        }
        Ok(DVec3::from_array(p))
    }

    fn skip(&mut self, count: usize, bytes: usize, what: &str) -> Result<(), MeshError> {
        for _ in 0..count {
            match bytes {
                4 => drop(self.take::<4>(what)?),
                _ => drop(self.take::<8>(what)?),
            }
        }
        Ok(())
    }

    fn remaining(&self) -> u64 {
        self.length.saturating_sub(self.at)
    }

    fn error(&self, message: String, help: &str) -> MeshError {
        error_at(self.path, Place::Byte(self.entry as usize), message, help)
    }

    fn error_at_end(&self, message: String, help: &str) -> MeshError {
        error_at(self.path, Place::Byte(self.at as usize), message, help)
    }

    fn path(&self) -> &Path {
        self.path
    }
}
