//! Meshes with fields as VTK unstructured grids (`.vtu`).

use super::atomic::write_atomic;
use super::options::{Compression, Units};
use super::{OutputError, field_data};
use crate::fem::Space;
use crate::fem::options::Element;
use crate::mesh::{TetMesh, quality};
use glam::DVec3;
use std::io::{self, Write};
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};
use vtkio::xml::Compressor;

/// One value for each point or for each cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values<'a> {
    /// Numbers.
    Scalars(&'a [f64]),
    /// Three components; the first such field is the active one, which "Warp By Vector" picks.
    Vectors(&'a [DVec3]),
    /// Symmetric tensors, XX YY ZZ XY YZ XZ.
    Tensors(&'a [[f64; 6]]),
    /// Yes or no, written as 1 or 0.
    Flags(&'a [bool]),
}

/// Fields on a mesh, by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields<'a> {
    /// What viewers show as the time of the file; the step number in a refinement run.
    pub time: f64,
    /// The units that were declared.
    pub units: Units,
    /// A value at each node.
    pub points: Vec<(&'a str, Values<'a>)>,
    /// A value in each cell.
    pub cells: Vec<(&'a str, Values<'a>)>,
}

/// Writes the elements and fields as a `.vtu` file, ten-node cells as VTK's quadratic tetrahedra, with the names of regions
/// and groups, the faces of the groups and the units as field data. The cell data `region` (index into the region names),
/// `refinement_level` and `quality` (minimum dihedral angle in degrees) are made from the mesh. The same mesh and fields
/// give the same bytes.
///
/// # Errors
/// [`OutputError`] if a field does not fit the mesh or holds a value that is not finite, or if the file cannot be written.
pub fn write_vtu(
    path: &Path,
    space: &Space<'_>,
    fields: &Fields<'_>,
    compression: Compression,
) -> Result<(), OutputError> {
    check(path, &fields.points, space.points().len())?;
    check(path, &fields.cells, space.mesh().tets().len())?;
    write_atomic(path, |w| {
        let text = encoded(grid(space, fields), compression).map_err(io::Error::other)?;
        annotate(w, &text, fields.time, &field_data::arrays(space.mesh(), &fields.units))
    })
}

/// A grid as the text of a file.
pub(super) fn encoded(piece: UnstructuredGridPiece, compression: Compression) -> Result<Vec<u8>, vtkio::Error> {
    let compressor = match compression {
        Compression::None => Compressor::None,
        Compression::Lz4 => Compressor::LZ4,
        Compression::Zlib => Compressor::ZLib,
    };
    let file = Vtk {
        // Version 1 of the XML format: 64-bit sizes.
        version: Version::new_xml(1, 0),
        byte_order: ByteOrder::LittleEndian,
        title: String::new(),
        file_path: None,
        data: DataSet::inline(piece),
    };
    let mut text = Vec::new();
    file.try_into_xml_format(compressor, COMPRESSION_LEVEL)?.write(&mut text)?;
    Ok(text)
}

/// Balance of speed and size for Zlib; LZ4 has no levels.
const COMPRESSION_LEVEL: u32 = 5;

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Values::Scalars(v) => v.len(),
            Values::Vectors(v) => v.len(),
            Values::Tensors(v) => v.len(),
            Values::Flags(v) => v.len(),
        }
    }

    /// Index of the first value that is not finite.
    fn not_finite(&self) -> Option<usize> {
        match self {
            Values::Scalars(v) => v.iter().position(|x| !x.is_finite()),
            Values::Vectors(v) => v.iter().position(|x| !x.is_finite()),
            Values::Tensors(v) => v.iter().position(|t| t.iter().any(|x| !x.is_finite())),
            Values::Flags(_) => None,
        }
    }

    pub(super) fn attribute(&self, name: &str) -> Attribute {
        match self {
            Values::Scalars(v) => Attribute::generic(name, 1).with_data(v.to_vec()),
            Values::Vectors(v) => Attribute::vectors(name).with_data(coordinates(v)),
            Values::Tensors(v) => Attribute::generic(name, 6).with_data(v.concat()),
            Values::Flags(v) => {
                Attribute::generic(name, 1).with_data(v.iter().map(|&b| u8::from(b)).collect::<Vec<_>>())
            }
        }
    }
}

pub(super) fn check(path: &Path, fields: &[(&str, Values<'_>)], want: usize) -> Result<(), OutputError> {
    for (name, values) in fields {
        let (path, field, got) = (path.to_owned(), (*name).to_owned(), values.len());
        if got != want {
            return Err(OutputError::Length { path, field, got, want });
        }
        if let Some(index) = values.not_finite() {
            return Err(OutputError::NotFinite { path, field, index });
        }
    }
    Ok(())
}

/// The places in VTK's ten-node cells: its edges are 01, 12, 02, 03, 13, 23.
const TEN_NODES: [usize; 10] = [0, 1, 2, 3, 4, 7, 5, 6, 8, 9];

fn grid(space: &Space<'_>, fields: &Fields<'_>) -> UnstructuredGridPiece {
    let mesh = space.mesh();
    let cells = mesh.tets().len();
    let (nodes, kind) = match space.element() {
        Element::Tet4 => (4, CellType::Tetra),
        Element::Tet10 => (10, CellType::QuadraticTetra),
    };
    let mut connectivity = Vec::with_capacity(nodes * cells);
    for t in 0..cells {
        let mut own = [0; 10];
        own.iter_mut().zip(space.cell(t)).for_each(|(place, node)| *place = u64::from(node));
        connectivity.extend(TEN_NODES[..nodes].iter().map(|&i| own[i]));
    }
    let offsets = (1..=cells as u64).map(|c| nodes as u64 * c).collect();
    let attributes = |fields: &[(&str, Values<'_>)]| fields.iter().map(|(name, v)| v.attribute(name)).collect();
    let mut data = Attributes { point: attributes(&fields.points), cell: attributes(&fields.cells) };
    data.cell.extend(mesh_fields(mesh));
    UnstructuredGridPiece {
        points: IOBuffer::F64(coordinates(space.points())),
        cells: Cells { cell_verts: VertexNumbers::XML { connectivity, offsets }, types: vec![kind; cells] },
        data,
    }
}

/// What the mesh itself says about each cell.
fn mesh_fields(mesh: &TetMesh) -> [Attribute; 3] {
    let regions: Vec<i32> = mesh.regions().iter().map(|r| i32::from(r.0)).collect();
    let angles = quality::min_dihedrals(mesh);
    [
        Attribute::generic("region", 1).with_data(regions),
        Attribute::generic("refinement_level", 1).with_data(mesh.levels().to_vec()),
        Attribute::generic("quality", 1).with_data(angles),
    ]
}

pub(super) fn coordinates(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(DVec3::to_array).collect()
}

/// Copies the file's text, adding what `vtkio` cannot express: the time, `more` field data and the names of the tensor components.
pub(super) fn annotate(w: &mut dyn Write, text: &[u8], time: f64, more: &str) -> io::Result<()> {
    let grid = "<UnstructuredGrid>";
    let time = format!(
        "{grid}<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}\
         </DataArray>{more}</FieldData>"
    );
    let six = "NumberOfComponents=\"6\"";
    let names: String = ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
        .iter()
        .enumerate()
        .map(|(i, name)| format!(" ComponentName{i}=\"{name}\""))
        .collect();
    let named = format!("{six}{names}");
    let text = std::str::from_utf8(text).map_err(io::Error::other)?;
    // Encoded data never holds a quote or a bracket, so only tags match.
    let (head, tail) = text.split_once(grid).ok_or_else(|| io::Error::other("no grid was encoded"))?;
    write!(w, "{head}{time}")?;
    let mut pieces = tail.split(six);
    w.write_all(pieces.next().unwrap_or_default().as_bytes())?;
    for piece in pieces {
        write!(w, "{named}{piece}")?;
    }
    Ok(())
}
