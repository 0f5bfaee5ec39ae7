//! Legacy VTK files (`.vtk`): keywords and arrays, the arrays as text or as big-endian numbers.

use super::super::raw::Raw;
use super::super::runs::Runs;
use super::super::words::{Words, shown};
use super::arrays::Type;
use super::grid::{Grid, is_tag};
use crate::mesh::MeshError;
use std::path::Path;

/// Points of a cell that is read, at most.
const MOST_POINTS: i64 = 27;

/// A file being read.
struct Legacy<'a> {
    words: Words<'a>,
    binary: bool,
    grid: Grid,
    /// Entries of attributes to come, and whether they belong to cells.
    count: usize,
    of_cells: bool,
}

/// Reads a file.
pub(super) fn read(path: &Path, bytes: &[u8], raw: &mut Raw) -> Result<&'static str, MeshError> {
    let mut words = Words::new(path, bytes, false);
    // The version, and a title of one line.
    words.expect("the version")?;
    words.rest_of_line();
    words.rest_of_line();
    let encoding = words.expect("ASCII or BINARY")?.to_ascii_uppercase();
    let binary = match encoding.as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => {
            let message = format!("expected ASCII or BINARY, found {}", shown(&encoding));
            return Err(words.error(message, "the third line of a legacy VTK file says which: write it again"));
        }
    };
    if binary {
        words.count_bytes();
        raw.binary = true;
    }
    let mut file = Legacy { words, binary, grid: Grid::default(), count: 0, of_cells: false };
    while let Some(keyword) = file.words.next() {
        file.section(&keyword.to_ascii_uppercase())?;
    }
    if file.grid.types.is_empty() || file.grid.ends.is_empty() {
        return Err(file.words.error("the cells (CELLS and CELL_TYPES) are missing", "write the file again"));
    }
    let skipped = file.grid.list(path, raw)?;
    if skipped > 0 {
        raw.notes.push(format!("{skipped} cells that are no solids, triangles or quadrilaterals are ignored."));
    }
    Ok(if binary { "VTK legacy binary" } else { "VTK legacy ASCII" })
}

impl Legacy<'_> {
    fn section(&mut self, keyword: &[u8]) -> Result<(), MeshError> {
        match keyword {
            b"DATASET" => {
                let kind = self.words.expect("the kind of the data set")?;
                if !kind.eq_ignore_ascii_case(b"UNSTRUCTURED_GRID") {
                    let message = format!("a data set of kind {}, not UNSTRUCTURED_GRID", shown(kind));
                    return Err(self.words.error(message, "save the volume mesh as an unstructured grid"));
                }
            }
            b"POINTS" => {
                let list = self.words.count("points")?;
                let kind = self.number_type()?;
                self.grid.place = self.words.place();
                let mut places = Runs::default();
                self.grid.points = self.numbers(list.count, 3, kind, "coordinates", &mut places)?;
                self.grid.point_places = places;
            }
            b"CELLS" => self.cells()?,
            b"CELL_TYPES" => {
                let list = self.words.count("cells")?;
                let int = self.named("int")?;
                self.grid.types = self.numbers(list.count, 1, int, "cell types", &mut Runs::default())?;
            }
            b"CELL_DATA" | b"POINT_DATA" => {
                self.count = self.words.count("entries")?.count;
                self.of_cells = keyword == b"CELL_DATA";
            }
            b"METADATA" => {
                // The rest of its own line, then lines up to a blank one.
                self.words.rest_of_line();
                while !self.words.rest_of_line().is_empty() {}
            }
            _ => return self.attribute(keyword),
        }
        Ok(())
    }

    /// `CELLS` has numbers of points and points mixed; from version 5 on two arrays.
    fn cells(&mut self) -> Result<(), MeshError> {
        let list = self.words.count("cells")?;
        let size = self.words.count("numbers of the cells")?.count;
        self.grid.place = self.words.place();
        if self.words.peek().is_some_and(|word| word.eq_ignore_ascii_case(b"OFFSETS")) {
            self.words.next();
            let kind = self.number_type()?;
            let offsets = self.numbers(list.count, 1, kind, "offsets", &mut Runs::default())?;
            self.check_order(offsets.get(1), kind, size)?;
            let keyword = self.words.expect("CONNECTIVITY")?;
            if !keyword.eq_ignore_ascii_case(b"CONNECTIVITY") {
                let message = format!("expected CONNECTIVITY, found {}", shown(keyword));
                return Err(self.words.error(message, "the file is damaged: write it again"));
            }
            let kind = self.number_type()?;
            self.grid.connectivity = self.numbers(size, 1, kind, "points of the cells", &mut Runs::default())?;
            // The first offset is 0, where the first cell begins.
            self.grid.ends = offsets.into_iter().skip(1).collect();
            return Ok(());
        }
        let int = self.named("int")?;
        let mut places = Runs::default();
        let mixed = self.numbers(size, 1, int, "numbers of the cells", &mut places)?;
        self.check_order(mixed.first(), int, size)?;
        let mut i = 0;
        for _ in 0..list.count {
            let points = mixed.get(i).filter(|n| **n >= 0.0).and_then(|n| mixed[i + 1..].get(..*n as usize));
            let points = points.ok_or_else(|| {
                let message = format!("{} cells are announced, but their numbers end after {i} of {size}", list.count);
                self.words.error(message, "the file is damaged, or not written whole: write it again")
            })?;
            self.grid.connectivity.extend(points);
            self.grid.ends.push(self.grid.connectivity.len() as f64);
            self.grid.cell_places.push(places.get(i));
            i += 1 + points.len();
        }
        Ok(())
    }

    /// Refuses a first cell that has more points than there are numbers, and a few with its bytes the other way round.
    fn check_order(&self, points: Option<&f64>, kind: Type, size: usize) -> Result<(), MeshError> {
        let Some(&points) = points.filter(|_| self.binary) else { return Ok(()) };
        let turned = (points as i64).swap_bytes() >> (64 - 8 * kind.size.min(8));
        if (0.0..=size as f64).contains(&points) || !(1..=MOST_POINTS).contains(&turned) {
            return Ok(());
        }
        let message = format!("the first cell has {points} points, or {turned} in the other order of bytes");
        Err(self.words.error(message, "legacy VTK files are big-endian: write the file again, or as text"))
    }

    /// An array of point or cell data.
    fn attribute(&mut self, keyword: &[u8]) -> Result<(), MeshError> {
        let components = match keyword {
            b"FIELD" => return self.field(),
            b"SCALARS" => return self.scalars(),
            b"COLOR_SCALARS" | b"LOOKUP_TABLE" => return self.colours(keyword),
            b"VECTORS" | b"NORMALS" => 3,
            b"TENSORS" => 9,
            b"TENSORS6" => 6,
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => 1,
            b"TEXTURE_COORDINATES" => 0,
            _ => {
                let message = format!("expected a keyword such as POINTS or CELL_DATA, found {}", shown(keyword));
                return Err(self.words.error(message, "a count is wrong, or the file is damaged: write it again"));
            }
        };
        self.words.expect("the name of an array")?;
        let components = if components == 0 { self.words.number("the dimension")? } else { components };
        let kind = self.number_type()?;
        self.pass(self.count, components, kind)
    }

    /// `name type [components]`, then perhaps `LOOKUP_TABLE name`.
    fn scalars(&mut self) -> Result<(), MeshError> {
        let name = String::from_utf8_lossy(self.words.expect("the name of an array")?).into_owned();
        let kind_name = String::from_utf8_lossy(self.words.expect("the type of an array")?).into_owned();
        let kind = self.named(&kind_name)?;
        let rest = String::from_utf8_lossy(self.words.rest_of_line()).into_owned();
        let components = if rest.is_empty() { 1 } else { rest.parse().unwrap_or(0) };
        if !(1..=4).contains(&components) {
            return Err(self.words.error(format!("{rest:?} components of {name:?}"), "1 to 4 are possible"));
        }
        self.words.skip_line_of(b"LOOKUP_TABLE");
        self.keep(name, self.count, components, kind)
    }

    /// Colours: bytes in binary files. Of a `LOOKUP_TABLE` it is the length that follows the name, not the components.
    fn colours(&mut self, keyword: &[u8]) -> Result<(), MeshError> {
        self.words.expect("the name of an array")?;
        let number = self.words.count("colours")?.count;
        let (count, components) = if keyword == b"LOOKUP_TABLE" { (number, 4) } else { (self.count, number) };
        let byte = self.named(if self.binary { "unsigned_char" } else { "float" })?;
        self.pass(count, components, byte)
    }

    /// Arrays with their own sizes.
    fn field(&mut self) -> Result<(), MeshError> {
        self.words.expect("the name of the field")?;
        let arrays = self.words.count("arrays")?.count;
        for _ in 0..arrays {
            let mut name = self.words.expect("the name of an array")?;
            while name.eq_ignore_ascii_case(b"METADATA") {
                self.section(b"METADATA")?;
                name = self.words.expect("the name of an array")?;
            }
            let name = String::from_utf8_lossy(name).into_owned();
            let components = self.words.number("the number of components")?;
            let count = self.words.number("the number of entries")?;
            let kind = self.number_type()?;
            self.keep(name, count, components, kind)?;
        }
        Ok(())
    }

    /// Keeps an array if it may be the tags of the cells.
    fn keep(&mut self, name: String, count: usize, components: usize, kind: Type) -> Result<(), MeshError> {
        if !self.of_cells || components != 1 || !is_tag(&name) {
            return self.pass(count, components, kind);
        }
        let values = self.numbers(count, 1, kind, "cell data", &mut Runs::default())?;
        self.grid.tags.push((name, values));
        Ok(())
    }

    fn named(&self, name: &str) -> Result<Type, MeshError> {
        Type::named(name).ok_or_else(|| {
            let message = format!("an array of type {}, which is not read", shown(name.as_bytes()));
            self.words.error(message, "write the mesh without this array")
        })
    }

    /// The next word as a type.
    fn number_type(&mut self) -> Result<Type, MeshError> {
        let name = String::from_utf8_lossy(self.words.expect("the type of an array")?).into_owned();
        self.named(&name)
    }

    /// The bytes of a binary array, which begins after the end of the line.
    fn block(&mut self, count: usize, components: usize, kind: Type, what: &str) -> Result<&[u8], MeshError> {
        self.words.end_line();
        self.words.take(count.saturating_mul(components), kind.size, what)
    }

    /// Reads an array; `places` gets the place of each entry of a text.
    fn numbers(
        &mut self,
        count: usize,
        components: usize,
        kind: Type,
        what: &str,
        places: &mut Runs,
    ) -> Result<Vec<f64>, MeshError> {
        if self.binary {
            return Ok(kind.numbers(self.block(count, components, kind, what)?, true));
        }
        let total = count.saturating_mul(components);
        // A number of a text takes two bytes at least.
        let mut numbers = Vec::with_capacity(total.min(self.words.remaining() / 2 + 1));
        for i in 0..total {
            numbers.push(self.words.number(what)?);
            if i % components == 0 {
                places.push(self.words.place() as i64);
            }
        }
        Ok(numbers)
    }

    /// Passes over an array.
    fn pass(&mut self, count: usize, components: usize, kind: Type) -> Result<(), MeshError> {
        if self.binary {
            return self.block(count, components, kind, "numbers").map(|_| ());
        }
        for _ in 0..count.saturating_mul(components) {
            self.words.expect("a number")?;
        }
        Ok(())
    }
}
