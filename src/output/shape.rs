//! Shapes as VTK unstructured grids: frames of a deformation.

use super::OutputError;
use super::atomic::write_atomic;
use super::options::Compression;
use super::vtk::{annotate, coordinates, encoded};
use crate::mesh::read::Shape;
use glam::DVec3;
use std::io::Error;
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{Attribute, Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers};

/// Writes a shape with its points at `places` as a `.vtu` file; the point data `displacement` is from where they are in the shape.
/// Points without polygons and cells are written as vertices.
///
/// # Errors
/// [`OutputError`] if the file cannot be written.
pub fn write_shape(
    path: &Path,
    shape: &Shape,
    places: &[DVec3],
    time: f64,
    compression: Compression,
) -> Result<(), OutputError> {
    let (mut connectivity, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
    let mut put = |kind: CellType, corners: &[u32]| {
        connectivity.extend(corners.iter().map(|v| u64::from(*v)));
        offsets.push(connectivity.len() as u64);
        types.push(kind);
    };
    for polygon in &shape.polygons {
        let kind = match polygon.len() {
            3 => CellType::Triangle,
            4 => CellType::Quad,
            _ => CellType::Polygon,
        };
        put(kind, polygon);
    }
    shape.tets.iter().for_each(|tet| put(CellType::Tetra, tet));
    if shape.polygons.is_empty() && shape.tets.is_empty() {
        (0..places.len() as u32).for_each(|v| put(CellType::Vertex, &[v]));
    }
    let displacement: Vec<DVec3> = places.iter().zip(&shape.points).map(|(p, q)| *p - *q).collect();
    let piece = UnstructuredGridPiece {
        points: IOBuffer::F64(coordinates(places)),
        cells: Cells { cell_verts: VertexNumbers::XML { connectivity, offsets }, types },
        data: Attributes {
            point: vec![Attribute::vectors("displacement").with_data(coordinates(&displacement))],
            cell: Vec::new(),
        },
    };
    let text = encoded(piece, compression);
    write_atomic(path, |w| annotate(w, &text.map_err(Error::other)?, time, ""))
}
