//! Catmull-Clark subdivision of solids of hexahedra (Burkhart, Hamann and Umlauf 2011, section 3; Bajaj, Schaefer, Warren and
//! Xu 2002; Joy and MacCracken 1996).
//!
//! A step splits each cell into eight. New points are affine combinations of old ones, by masks that depend on connectivity
//! and tags only, so the limit is a solid whose basis functions the room `limit` evaluates.

mod limits;
mod masks;
mod split;

pub use limits::interpolated;
pub use masks::{Control, VertexKind};
pub use split::{Split, child_lattice};

use super::options::CatmullClark;
use crate::mesh::hex::curved::split_middles;
use crate::mesh::hex::{HexError, HexMesh, HexMeshParts};
use crate::mesh::weights::WeightRows;
use glam::DVec3;

/// A refined solid.
#[derive(Debug, Clone)]
pub struct RefinedSolid {
    /// The finer control mesh: the vertices of the old one keep their numbers, then come the points of edges, faces and cells;
    /// the children of cell `t` are `8 t` to `8 t + 7`, in the order of its corners.
    pub mesh: HexMesh,
    /// Each of its vertices as a combination of the old ones: control values of fields are carried over by the same rows.
    pub stencils: WeightRows,
}

/// One step of subdivision. Regions, groups, creases and corners follow.
///
/// # Errors
/// [`HexMesh::check_smoothable`]'s.
pub fn refine(mesh: &HexMesh, variant: CatmullClark) -> Result<RefinedSolid, HexError> {
    mesh.check_smoothable()?;
    let control = Control::of(mesh);
    let stencils = control.stencils(variant);
    Ok(RefinedSolid { mesh: finer(mesh, stencils.apply(mesh.points()))?, stencils })
}

/// One step of plain splitting: each cell into eight at the middles of its edges, faces and of itself, in which trilinear
/// cells lie exactly, and curved ones too. Regions, groups, creases and corners follow. (The stencils are those of straight cells.)
///
/// # Errors
/// None on a valid mesh.
pub fn split_linearly(mesh: &HexMesh) -> Result<RefinedSolid, HexError> {
    let stencils = Control::of(mesh).linear_stencils();
    if mesh.middles().is_empty() {
        return Ok(RefinedSolid { mesh: finer(mesh, stencils.apply(mesh.points()))?, stencils });
    }
    // New vertices are numbered as the middles are.
    let straight = finer(mesh, [mesh.points(), mesh.middles()].concat())?;
    let middles = split_middles(mesh, straight.cells(), straight.topology());
    Ok(RefinedSolid { mesh: straight.with_middles(middles), stencils })
}

/// The mesh split once, with these points.
fn finer(mesh: &HexMesh, points: Vec<DVec3>) -> Result<HexMesh, HexError> {
    let split = Split::new(mesh.cells(), mesh.topology(), mesh.points().len());
    let faces = split.faces(mesh);
    let creases = split.creases(mesh);
    HexMesh::refined(HexMeshParts {
        points,
        regions: mesh.regions().iter().flat_map(|r| [*r; 8]).collect(),
        cells: split.cells,
        faces,
        creases,
        corners: mesh.corners().to_vec(),
        middles: Vec::new(),
        region_names: mesh.region_names().to_vec(),
        groups: mesh.groups().to_vec(),
        patches: mesh.patch_groups().to_vec(),
    })
}
