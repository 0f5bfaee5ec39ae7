//! XML unstructured grids (`.vtu`): arrays as text, in base64, or appended at the end of the file.

use super::super::raw::Raw;
use super::super::{error_at, number_help};
use super::arrays::Type;
use super::decode::{Compressor, Encoded, Encoding};
use super::grid::{Grid, is_tag};
use super::names::Names;
use crate::mesh::{MeshError, Place};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::path::Path;

const DAMAGED: &str = "the file is damaged, or not written whole: write it again";

/// What is said of arrays that are no texts.
const DAMAGED_ARRAY: &str =
    "the file is damaged, not written whole, or its byte_order is not the order of bytes of its arrays: write it again";

/// A file being read.
struct Xml<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    encoding: Encoding,
    appended: Option<Appended<'a>>,
    /// Byte of the tag being read.
    at: u64,
    section: Section,
    /// Arrays of the current piece.
    piece: Piece,
    array: Option<Array>,
    pieces: usize,
    names: Names,
    /// Where all arrays go, if they are wanted.
    all: Option<Vec<VtuArray>>,
}

/// Where in a file an array stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VtuPart {
    /// `Points`.
    Points,
    /// `Cells`: `connectivity`, `offsets` and `types`.
    Cells,
    /// `PointData`.
    PointData,
    /// `CellData`.
    CellData,
    /// `FieldData`; strings are their bytes, each with a zero at its end.
    FieldData,
}

/// An array of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct VtuArray {
    /// Where it stands.
    pub part: VtuPart,
    /// Its name.
    pub name: String,
    /// Its numbers, row by row.
    pub numbers: Vec<f64>,
}

/// The end of the file, to which arrays refer.
struct Appended<'a> {
    bytes: &'a [u8],
    base64: bool,
}

#[derive(Default)]
struct Piece {
    points: usize,
    cells: usize,
    arrays: Vec<(Section, Array)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Points,
    Cells,
    CellData,
    PointData,
    FieldData,
    Other,
}

/// An array as it stands in the file.
struct Array {
    name: String,
    kind: String,
    components: usize,
    format: String,
    offset: usize,
    text: Vec<u8>,
    /// Where the text begins.
    begin: usize,
    /// How many tags are open inside the array's: VTK puts information there.
    inside: usize,
    at: u64,
}

/// All arrays of a file of one piece.
pub(super) fn arrays(path: &Path, bytes: &[u8]) -> Result<Vec<VtuArray>, MeshError> {
    let all = parsed(path, bytes, &mut Raw::default(), Some(Vec::new()))?.0.all;
    Ok(all.unwrap_or_default())
}

/// Reads a file.
pub(super) fn read(path: &Path, bytes: &[u8], raw: &mut Raw) -> Result<&'static str, MeshError> {
    raw.binary = true;
    let (xml, skipped) = parsed(path, bytes, raw, None)?;
    if xml.pieces == 0 {
        return Err(xml.error("expected </Piece>, found the end of the grid", DAMAGED));
    }
    if xml.pieces == 1 {
        xml.names.apply(raw, xml.at);
    }
    if skipped > 0 {
        raw.notes.push(format!("{skipped} cells that are no solids, triangles or quadrilaterals are ignored."));
    }
    Ok("VTK XML unstructured grid")
}

/// Goes through a file; the lists of its pieces go into `raw`, or all arrays as they are to the file, if it has a place for
/// them. Gives the number of cells passed over too.
fn parsed<'a>(
    path: &'a Path,
    bytes: &'a [u8],
    raw: &mut Raw,
    all: Option<Vec<VtuArray>>,
) -> Result<(Xml<'a>, usize), MeshError> {
    // What is appended is no XML, if it is raw.
    let tag = b"<AppendedData";
    let head = bytes.windows(tag.len()).position(|word| word == tag).unwrap_or(bytes.len());
    let encoding = Encoding { big_endian: false, header_bytes: 4, compressor: Compressor::None };
    let appended = appended(&bytes[head..]);
    let (section, piece) = (Section::Other, Piece::default());
    let mut xml = Xml {
        path,
        bytes,
        encoding,
        appended,
        at: 0,
        section,
        piece,
        array: None,
        pieces: 0,
        names: Names::default(),
        all,
    };
    let mut reader = Reader::from_reader(&bytes[..head]);
    let mut skipped = 0;
    loop {
        xml.at = reader.buffer_position();
        match reader.read_event() {
            Ok(Event::Start(tag)) => xml.start(&tag)?,
            Ok(Event::Empty(tag)) => {
                xml.start(&tag)?;
                skipped += xml.end(tag.name().as_ref(), raw)?;
            }
            Ok(Event::Text(text)) => {
                let begin = xml.at as usize;
                if let Some(array) = xml.array.as_mut().filter(|array| array.inside == 0) {
                    if array.text.is_empty() {
                        array.begin = begin;
                    }
                    array.text.extend_from_slice(&text);
                }
            }
            Ok(Event::End(tag)) => skipped += xml.end(tag.name().as_ref(), raw)?,
            Ok(Event::Eof) => break,
            Ok(_) => {}
            Err(error) => return Err(xml.error(format!("the XML is damaged: {error}"), DAMAGED)),
        }
    }
    Ok((xml, skipped))
}

/// Takes the appended data after their tag and the sign `_`.
fn appended(bytes: &[u8]) -> Option<Appended<'_>> {
    let end = bytes.iter().position(|&b| b == b'>')?;
    let base64 = bytes[..end].windows(6).any(|word| word == b"base64");
    let begin = end + bytes[end..].iter().position(|&b| b == b'_')? + 1;
    Some(Appended { bytes: &bytes[begin..], base64 })
}

impl Xml<'_> {
    fn error(&self, message: impl Into<String>, help: &str) -> MeshError {
        error_at(self.path, Place::Byte(self.at as usize), message, help)
    }

    /// The value of an attribute, empty if it is not there.
    fn value(&self, tag: &BytesStart, name: &str) -> Result<String, MeshError> {
        let fail = |error: String| self.error(format!("the XML is damaged: {error}"), DAMAGED);
        match tag.try_get_attribute(name).map_err(|e| fail(e.to_string()))? {
            Some(attribute) => Ok(attribute.unescape_value().map_err(|e| fail(e.to_string()))?.into_owned()),
            None => Ok(String::new()),
        }
    }

    /// A whole number; `default` if the attribute is not there.
    fn number(&self, tag: &BytesStart, name: &str, default: usize) -> Result<usize, MeshError> {
        let value = self.value(tag, name)?;
        if value.is_empty() {
            return Ok(default);
        }
        value.trim().parse().map_err(|_| {
            self.error(
                format!("{name} is {:?}, expected a whole number", value.chars().take(40).collect::<String>()),
                DAMAGED,
            )
        })
    }

    fn start(&mut self, tag: &BytesStart) -> Result<(), MeshError> {
        match tag.name().as_ref() {
            b"VTKFile" => self.file(tag)?,
            b"Piece" => {
                let (points, cells) = (self.number(tag, "NumberOfPoints", 0)?, self.number(tag, "NumberOfCells", 0)?);
                self.piece = Piece { points, cells, arrays: Vec::new() };
            }
            b"Points" => self.section = Section::Points,
            b"Cells" => self.section = Section::Cells,
            b"CellData" => self.section = Section::CellData,
            b"FieldData" => self.section = Section::FieldData,
            b"PointData" => self.section = Section::PointData,
            b"DataArray" | b"Array" => {
                self.array = Some(Array {
                    name: self.value(tag, "Name")?,
                    kind: self.value(tag, "type")?,
                    components: self.number(tag, "NumberOfComponents", 1)?,
                    format: self.value(tag, "format")?,
                    offset: self.number(tag, "offset", 0)?,
                    text: Vec::new(),
                    begin: 0,
                    inside: 0,
                    at: self.at,
                });
            }
            _ => {
                if let Some(array) = &mut self.array {
                    array.inside += 1;
                }
            }
        }
        Ok(())
    }

    /// What the first tag says of the whole file.
    fn file(&mut self, tag: &BytesStart) -> Result<(), MeshError> {
        let kind = self.value(tag, "type")?;
        if kind != "UnstructuredGrid" {
            let kind: String = kind.chars().take(40).collect();
            let help = "save the volume mesh as an unstructured grid (.vtu); of a parallel file name one of its pieces";
            return Err(self.error(format!("a VTK file of type {kind:?}, not UnstructuredGrid"), help));
        }
        self.encoding.big_endian = self.value(tag, "byte_order")? == "BigEndian";
        self.encoding.header_bytes = if self.value(tag, "header_type")? == "UInt64" { 8 } else { 4 };
        self.encoding.compressor = match self.value(tag, "compressor")?.as_str() {
            "" => Compressor::None,
            "vtkZLibDataCompressor" => Compressor::Zlib,
            "vtkLZ4DataCompressor" => Compressor::Lz4,
            other => {
                let other: String = other.chars().take(40).collect();
                let message = format!("compressed by {other:?}; Zlib and LZ4 are read");
                return Err(self.error(message, "save the file without compression, or with Zlib or LZ4"));
            }
        };
        Ok(())
    }

    /// The end of a tag. Gives the number of cells passed over.
    fn end(&mut self, name: &[u8], raw: &mut Raw) -> Result<usize, MeshError> {
        match name {
            b"DataArray" | b"Array" => {
                let section = self.section;
                if self.all.is_some() {
                    return self.keep_all().map(|()| 0);
                }
                let wanted = |array: &Array| match section {
                    Section::Points | Section::Cells => true,
                    Section::CellData => array.components == 1 && is_tag(&array.name),
                    Section::PointData | Section::FieldData | Section::Other => false,
                };
                let array = self.array.take();
                if let (Section::FieldData, Some(array)) = (section, &array) {
                    self.keep_names(array)?;
                }
                self.piece.arrays.extend(array.filter(wanted).map(|array| (section, array)));
            }
            b"Points" | b"Cells" | b"CellData" | b"PointData" | b"FieldData" => self.section = Section::Other,
            b"Piece" if self.all.is_some() => self.pieces += 1,
            b"Piece" => {
                self.pieces += 1;
                return self.grid()?.list(self.path, raw);
            }
            _ => {
                if let Some(array) = &mut self.array {
                    array.inside = array.inside.saturating_sub(1);
                }
            }
        }
        Ok(0)
    }

    /// Keeps the array that has ended, whatever it holds.
    fn keep_all(&mut self) -> Result<(), MeshError> {
        let part = match self.section {
            Section::Points => VtuPart::Points,
            Section::Cells => VtuPart::Cells,
            Section::CellData => VtuPart::CellData,
            Section::PointData => VtuPart::PointData,
            Section::FieldData => VtuPart::FieldData,
            Section::Other => return Ok(()),
        };
        let Some(array) = self.array.take() else { return Ok(()) };
        let numbers = self.decode(&array).map_err(|message| {
            let message = format!("array {:?}: {message}", array.name);
            error_at(self.path, Place::Byte(array.at as usize), message, DAMAGED)
        })?;
        if let Some(all) = &mut self.all {
            all.push(VtuArray { part, name: array.name, numbers });
        }
        Ok(())
    }

    /// Keeps an array of the field data if it holds names.
    fn keep_names(&mut self, array: &Array) -> Result<(), MeshError> {
        let mut names = std::mem::take(&mut self.names);
        if let Some(slot) = names.slot(&array.name) {
            let numbers = self.decode(array);
            *slot = numbers.map_err(|message| {
                let message = format!("array {:?}: {message}", array.name);
                error_at(self.path, Place::Byte(array.at as usize), message, DAMAGED)
            })?;
        }
        self.names = names;
        Ok(())
    }

    /// The arrays of the piece that has ended.
    fn grid(&mut self) -> Result<Grid, MeshError> {
        let Piece { points, cells, arrays } = std::mem::take(&mut self.piece);
        let mut grid = Grid { place: self.at, ..Grid::default() };
        if cells == 0 {
            return Ok(grid);
        }
        let find = |section: Section, name: &str| {
            let found = arrays.iter().find(|(s, array)| *s == section && (name.is_empty() || array.name == name));
            let missing = || self.error(format!("the piece has no array {name:?} of {section:?}"), DAMAGED);
            found.map(|(_, array)| array).ok_or_else(missing)
        };
        let position = find(Section::Points, "")?;
        grid.points = self.numbers(position, points, 3)?;
        grid.ends = self.numbers(find(Section::Cells, "offsets")?, cells, 1)?;
        grid.types = self.numbers(find(Section::Cells, "types")?, cells, 1)?;
        let connectivity = find(Section::Cells, "connectivity")?;
        grid.place = connectivity.at;
        grid.connectivity = self.numbers(connectivity, grid.ends.last().map_or(0, |&end| end as usize), 1)?;
        for (_, array) in arrays.iter().filter(|(section, _)| *section == Section::CellData) {
            grid.tags.push((array.name.clone(), self.numbers(array, cells, 1)?));
        }
        Ok(grid)
    }

    /// The numbers of an array, which must be `count` entries.
    fn numbers(&self, array: &Array, count: usize, components: usize) -> Result<Vec<f64>, MeshError> {
        let fail = |message: String| {
            let name: String = array.name.chars().take(40).collect();
            let help = if array.format == "ascii" { DAMAGED } else { DAMAGED_ARRAY };
            error_at(self.path, Place::Byte(array.at as usize), format!("array {name:?}: {message}"), help)
        };
        let numbers = self.decode(array).map_err(fail)?;
        if Some(numbers.len()) == count.checked_mul(components) {
            return Ok(numbers);
        }
        Err(fail(format!("it holds {} numbers, expected {count} times {components}", numbers.len())))
    }

    /// Where a word of an array that is a text is no number.
    fn no_number(&self, array: &Array, word: &[u8]) -> String {
        let at = array.begin + (word.as_ptr() as usize - array.text.as_ptr() as usize);
        let before = &self.bytes[..at.min(self.bytes.len())];
        let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
        let column = before.len() - before.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1) + 1;
        let word: String = String::from_utf8_lossy(word).chars().take(40).collect();
        format!("line {line}: column {column}: it is {word:?}, expected a number ({})", number_help(&word))
    }

    fn decode(&self, array: &Array) -> Result<Vec<f64>, String> {
        // Strings, which only names are, are their bytes.
        let is_text = array.kind == "String" && self.section == Section::FieldData;
        let kind = Type::named(if is_text { "UInt8" } else { &array.kind });
        let kind = kind.ok_or_else(|| "its type is not read".to_owned())?;
        let mut encoded = match (array.format.as_str(), &self.appended) {
            ("ascii", _) => {
                let words = array.text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                let number = |word: &[u8]| std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                let wrong = |word: &[u8]| self.no_number(array, word);
                return words.map(|word| number(word).ok_or_else(|| wrong(word))).collect();
            }
            ("binary", _) => Encoded::new(array.text.trim_ascii(), true),
            ("appended", Some(appended)) => {
                let bytes = appended.bytes.get(array.offset..);
                Encoded::new(bytes.ok_or("its offset lies behind the end of the file")?, appended.base64)
            }
            ("appended", None) => return Err("the appended data are missing".to_owned()),
            _ => return Err("its format is none of ascii, binary and appended".to_owned()),
        };
        Ok(kind.numbers(&encoded.array(self.encoding)?, self.encoding.big_endian))
    }
}
