//! Hexahedral meshes with fields as VTK unstructured grids, curved as the elements are.

use super::atomic::write_atomic;
use super::options::Compression;
use super::vtk::{Fields, check, coordinates, encoded};
use super::{OutputError, field_data};
use crate::fem::hexes::{HexSpace, Lattice};
use crate::mesh::hex::{min_dihedral, to_vtk_order};
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{Attribute, Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers};

/// Writes the elements at the points of a lattice, and fields there, as a `.vtu` file: VTK's Lagrange hexahedra of the
/// lattice's order, or linear ones for order 1. Lagrange cells of order three are the same polynomials as Catmull-Clark cells in
/// regular grids, so that viewers show these exactly. The cell data `region`, `quality` (the smallest angle between faces at
/// the corners of the straight cell, in degrees) and `regular` (whether a cell is such a polynomial) are made from the mesh; all
/// cells have the same `refinement_level`.
///
/// # Errors
/// [`OutputError`] if a field does not fit or holds a value that is not finite, or if the file cannot be written.
pub fn write_hexes(
    path: &Path,
    space: &HexSpace<'_>,
    lattice: &Lattice,
    fields: &Fields<'_>,
    (level, compression): (u8, Compression),
) -> Result<(), OutputError> {
    let cells = space.mesh().cells().len();
    check(path, &fields.points, lattice.sources.len())?;
    check(path, &fields.cells, cells)?;
    let (order, each) = (lattice.order, (lattice.order + 1).pow(3));
    let mut connectivity = Vec::with_capacity(each * cells);
    let places = vtk_places(order);
    for own in lattice.cells.chunks_exact(each) {
        connectivity.extend(places.iter().map(|&q| u64::from(own[q])));
    }
    let kind = if order == 1 { CellType::Hexahedron } else { CellType::LagrangeHexahedron };
    let attributes = |fields: &[(&str, super::vtk::Values<'_>)]| fields.iter().map(|(n, v)| v.attribute(n)).collect();
    let mut data = Attributes { point: attributes(&fields.points), cell: attributes(&fields.cells) };
    let regions: Vec<i32> = space.mesh().regions().iter().map(|r| i32::from(r.0)).collect();
    let regular: Vec<u8> = (0..cells).map(|t| u8::from(space.is_regular(space.class(t)))).collect();
    data.cell.push(Attribute::generic("region", 1).with_data(regions));
    data.cell.push(Attribute::generic("regular", 1).with_data(regular));
    data.cell.push(Attribute::generic("refinement_level", 1).with_data(vec![level; cells]));
    let quality: Vec<f64> = (0..cells).map(|t| min_dihedral(&space.mesh().cell_points(t))).collect();
    data.cell.push(Attribute::generic("quality", 1).with_data(quality));
    let piece = UnstructuredGridPiece {
        points: IOBuffer::F64(coordinates(&lattice.places(space))),
        cells: Cells {
            cell_verts: VertexNumbers::XML {
                connectivity,
                offsets: (1..=cells as u64).map(|c| each as u64 * c).collect(),
            },
            types: vec![kind; cells],
        },
        data,
    };
    let text = encoded(piece, compression);
    let names = field_data::names(space.mesh(), &fields.units);
    write_atomic(path, |w| super::vtk::annotate(w, &text.map_err(std::io::Error::other)?, fields.time, &names))
}

/// The places of the lattice (x fastest) in the order of VTK's Lagrange hexahedra: corners, edges, faces, inside
/// (`vtkHigherOrderHexahedron::PointIndexFromIJK`, as files before version 2.1 have it).
fn vtk_places(order: usize) -> Vec<usize> {
    let side = order + 1;
    let at = |x: [usize; 3]| x[0] + side * (x[1] + side * x[2]);
    let inner = 1..order;
    let corner = |c: u32| [c & 1, c >> 1 & 1, c >> 2].map(|b| b as usize * order);
    let mut places: Vec<usize> = to_vtk_order(std::array::from_fn(|c| c as u32)).map(|c| at(corner(c))).to_vec();
    for z in [0, order] {
        places.extend(inner.clone().map(|i| at([i, 0, z])));
        places.extend(inner.clone().map(|i| at([order, i, z])));
        places.extend(inner.clone().map(|i| at([i, order, z])));
        places.extend(inner.clone().map(|i| at([0, i, z])));
    }
    for [x, y] in [[0, 0], [order, 0], [0, order], [order, order]] {
        places.extend(inner.clone().map(|i| at([x, y, i])));
    }
    let square = |point: &dyn Fn(usize, usize) -> usize| -> Vec<usize> {
        (1..order).flat_map(|v| (1..order).map(move |u| (u, v))).map(|(u, v)| point(u, v)).collect()
    };
    for x in [0, order] {
        places.extend(square(&|u, v| at([x, u, v])));
    }
    for y in [0, order] {
        places.extend(square(&|u, v| at([u, y, v])));
    }
    for z in [0, order] {
        places.extend(square(&|u, v| at([u, v, z])));
    }
    places.extend(inner.clone().flat_map(|z| square(&|u, v| at([u, v, z]))));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_place_of_the_lattice_is_written_once() {
        for order in 1..5 {
            let mut places = vtk_places(order);
            places.sort_unstable();
            assert_eq!(places, (0..(order + 1).pow(3)).collect::<Vec<_>>());
        }
    }
}
