//! Analysis on smooth solids: the mesh of a step is the control mesh, and what is analysed is the mesh that smooth
//! tetrahedral/octahedral subdivision makes of it.

use crate::mesh::tet_oct::{OctSplit, TetOctMesh};
use crate::mesh::weights::WeightRows;
use crate::mesh::{MeshError, TetMesh};
use crate::subdiv::options::{Octahedra, Smooth, SmoothBasis};
use crate::subdiv::tet_oct::{composite, refine};

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
/// [`MeshError::NotPositive`] if that inverts cells.
pub(super) fn smoothed(control: &TetMesh, smooth: Smooth) -> Result<Smoothed, MeshError> {
    let split = match smooth.octahedra {
        Octahedra::Diagonal => OctSplit::Diagonal,
        Octahedra::Centroid => OctSplit::Centroid,
    };
    let start = TetOctMesh::from(control);
    if smooth.basis == SmoothBasis::Nodes {
        let fine = (0..smooth.steps).fold(start, |mesh, _| refine(&mesh));
        return Ok(Smoothed { mesh: fine.tetrahedra(split)?.mesh, basis: None });
    }
    let (fine, rows) = composite(&start, smooth.steps);
    let basis = if split == OctSplit::Centroid { with_centroids(&fine, &rows) } else { rows };
    Ok(Smoothed { mesh: fine.tetrahedra(split)?.mesh, basis: Some(basis) })
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
