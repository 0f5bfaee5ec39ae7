//! Hexahedral meshes without fields as VTK unstructured grids.

use super::atomic::write_atomic;
use super::options::{Compression, Units};
use super::vtk::{annotate, coordinates, encoded};
use super::{OutputError, field_data};
use crate::mesh::hex::{HexMesh, min_dihedral, to_vtk_order};
use std::io::Error;
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{Attribute, Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers};

/// Writes a mesh as a `.vtu` file of linear hexahedra, with the names of regions and groups and the faces of the groups as field
/// data, as the reader takes them. The cell data `region` and `quality` (minimum dihedral angle in degrees) are made from the
/// mesh.
///
/// # Errors
/// [`OutputError`] if the file cannot be written.
pub fn write_hex_mesh(path: &Path, mesh: &HexMesh, compression: Compression) -> Result<(), OutputError> {
    let cells = mesh.cells().len();
    let regions: Vec<i32> = mesh.regions().iter().map(|r| i32::from(r.0)).collect();
    let quality: Vec<f64> = (0..cells).map(|t| min_dihedral(&mesh.cell_points(t))).collect();
    let piece = UnstructuredGridPiece {
        points: IOBuffer::F64(coordinates(mesh.points())),
        cells: Cells {
            cell_verts: VertexNumbers::XML {
                connectivity: mesh.cells().iter().flat_map(|&cell| to_vtk_order(cell).map(u64::from)).collect(),
                offsets: (1..=cells as u64).map(|c| 8 * c).collect(),
            },
            types: vec![CellType::Hexahedron; cells],
        },
        data: Attributes {
            point: Vec::new(),
            cell: vec![
                Attribute::generic("region", 1).with_data(regions),
                Attribute::generic("quality", 1).with_data(quality),
            ],
        },
    };
    let text = encoded(piece, compression);
    let names = field_data::hex_arrays(mesh, &Units::default());
    write_atomic(path, |w| annotate(w, &text.map_err(Error::other)?, 0.0, &names))
}
