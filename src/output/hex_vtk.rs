//! Hexahedral meshes with fields as VTK unstructured grids, curved as the elements are.

use super::atomic::write_atomic;
use super::hex_cells::Shown;
use super::options::{Compression, HexCells};
use super::vtk::{Fields, check, coordinates, encoded};
use super::{OutputError, field_data};
use crate::fem::hexes::{HexSpace, Lattice};
use crate::mesh::hex::min_dihedral;
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{Attribute, Attributes, Cells, UnstructuredGridPiece, VertexNumbers};

/// Writes the elements at the points of a lattice, and fields there, as a `.vtu` file of cells as asked for. Lagrange and Bezier
/// cells of order three are the same polynomials as Catmull-Clark cells in regular grids, so that viewers show these exactly. The
/// cell data `region`, `quality` (the smallest angle between faces at the corners of the straight cell, in degrees) and
/// `regular` (whether a cell is such a polynomial) are made from the mesh; all cells have the same `refinement_level`. If several
/// cells show an element, `element` is its number.
///
/// # Errors
/// [`OutputError`] if a field does not fit or holds a value that is not finite, or if the file cannot be written.
pub fn write_hexes(
    path: &Path,
    space: &HexSpace<'_>,
    lattice: &Lattice,
    fields: &Fields<'_>,
    (level, how, compression): (u8, HexCells, Compression),
) -> Result<(), OutputError> {
    let cells = space.mesh().cells().len();
    check(path, &fields.points, lattice.sources.len())?;
    check(path, &fields.cells, cells)?;
    let shown = Shown::new(space, lattice, how);
    let mut data = Attributes {
        point: fields.points.iter().map(|(name, v)| shown.point_attribute(lattice, name, *v)).collect(),
        cell: fields.cells.iter().map(|(name, v)| shown.cell_attribute(name, *v)).collect(),
    };
    let regions: Vec<i32> = space.mesh().regions().iter().map(|r| i32::from(r.0)).collect();
    let regular: Vec<u8> = (0..cells).map(|t| u8::from(space.is_regular(space.class(t)))).collect();
    let quality: Vec<f64> = (0..cells).map(|t| min_dihedral(&space.mesh().cell_points(t))).collect();
    data.cell.push(Attribute::generic("region", 1).with_data(shown.in_cells(&regions)));
    data.cell.push(Attribute::generic("regular", 1).with_data(shown.in_cells(&regular)));
    data.cell.push(Attribute::generic("refinement_level", 1).with_data(vec![level; shown.kinds.len()]));
    data.cell.push(Attribute::generic("quality", 1).with_data(shown.in_cells(&quality)));
    if shown.each > 1 {
        let elements: Vec<u32> = (0..cells as u32).collect();
        data.cell.push(Attribute::generic("element", 1).with_data(shown.in_cells(&elements)));
    }
    let places = shown.at_points(lattice, &coordinates(&lattice.places(space)), 3);
    let piece = UnstructuredGridPiece {
        points: IOBuffer::F64(places),
        cells: Cells {
            cell_verts: VertexNumbers::XML { connectivity: shown.connectivity, offsets: shown.offsets },
            types: shown.kinds,
        },
        data,
    };
    let text = encoded(piece, compression);
    let names = field_data::names(space.mesh(), &fields.units);
    write_atomic(path, |w| super::vtk::annotate(w, &text.map_err(std::io::Error::other)?, fields.time, &names))
}
