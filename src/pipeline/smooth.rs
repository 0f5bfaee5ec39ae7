//! Analysis on smooth solids: the mesh of a step is the control mesh, and what is analysed is the mesh that smooth
//! tetrahedral/octahedral subdivision makes of it.

use super::tet_oct::check_count;
use crate::error::Error;
use crate::mesh::tet_oct::{OctSplit, TetOctMesh};
use crate::mesh::weights::WeightRows;
use crate::mesh::{MeshError, TetMesh};
use crate::subdiv::options::{Octahedra, Smooth, SmoothBasis};
use crate::subdiv::tet_oct::{EmbedError, composite, refine};

/// Bytes that a cell takes at least when it is analysed, with the nodes or the control points as unknowns.
const BYTES: [usize; 2] = [800, 1200];

/// A control mesh subdivided for analysis.
#[derive(Debug)]
pub(super) struct Smoothed {
    /// The mesh that is analysed; its groups and regions have the numbers that those of the control mesh have.
    pub mesh: TetMesh,
    /// Its vertices as combinations of the control points, where these are the unknowns.
    pub basis: Option<WeightRows>,
}

/// Subdivides a control mesh as the scenario says.
///
/// # Errors
/// [`EmbedError::Folded`] if that inverts cells, [`MeshError::Generator`] if there would be too many.
pub(super) fn smoothed(control: &TetMesh, smooth: Smooth) -> Result<Smoothed, Error> {
    let split = match smooth.octahedra {
        Octahedra::Diagonal => OctSplit::Diagonal,
        Octahedra::Centroid => OctSplit::Centroid,
    };
    check_size(control, smooth)?;
    let start = TetOctMesh::from(control);
    if smooth.basis == SmoothBasis::Nodes {
        let fine = (0..smooth.steps).fold(start, |mesh, _| refine(&mesh));
        let mesh = fine.tetrahedra(split).map_err(EmbedError::Folded)?.mesh;
        return Ok(Smoothed { mesh, basis: None });
    }
    let (fine, rows) = composite(&start, smooth.steps);
    let basis = if split == OctSplit::Centroid { with_centroids(&fine, &rows) } else { rows };
    Ok(Smoothed { mesh: fine.tetrahedra(split).map_err(EmbedError::Folded)?.mesh, basis: Some(basis) })
}

/// Refuses steps that make too many cells, or more than fit into the memory that is free.
///
/// # Errors
/// [`MeshError::Generator`].
pub(super) fn check_size(control: &TetMesh, smooth: Smooth) -> Result<(), MeshError> {
    check_count(control.tets().len(), smooth.steps, BYTES[usize::from(smooth.basis == SmoothBasis::Control)])
}

/// The rows of the vertices, and after them those of the centroids of octahedra.
fn with_centroids(mesh: &TetOctMesh, rows: &WeightRows) -> WeightRows {
    let vertices = rows.rows();
    WeightRows::collect(vertices + mesh.octs().len(), rows.width(), |i, row| match i.checked_sub(vertices) {
        None => row.extend(rows.row(i)),
        Some(o) => {
            for v in mesh.octs()[o] {
                row.extend(rows.row(v as usize).map(|(column, weight)| (column, weight / 6.0)));
            }
        }
    })
}
