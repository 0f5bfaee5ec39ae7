//! What a user chooses in a mesh without a simulation: the cells to refine, the edges and corners to keep.

use crate::mesh::{MeshError, Place, TetMesh, features, read::read_list, topology};
use std::path::{Path, PathBuf};

/// Which cells to refine, chosen again in each step.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// All.
    All,
    /// Those whose numbers (from 0, one a line) a file lists; in later steps those that the steps before refined.
    Listed(PathBuf),
    /// Those with a face on the boundary.
    Boundary,
    /// Those at an edge of the boundary that turns by more than `above` and at most `below` degrees.
    Curvature {
        /// Edges that turn less are flat.
        above: f64,
        /// Edges that turn more are sharp.
        below: f64,
    },
}

impl Cells {
    /// The cells of `mesh` to refine in a step; steps are counted from 1.
    ///
    /// # Errors
    /// [`MeshError`] with the line of the file that lists a cell that does not exist, or that cannot be read.
    pub fn choose(&self, mesh: &TetMesh, step: usize) -> Result<Vec<bool>, MeshError> {
        let mut chosen = vec![matches!(self, Self::All); mesh.tets().len()];
        match self {
            Self::All => {}
            // What was refined in every step so far: the cells of the list, and what was drawn in with them.
            Self::Listed(_) if step > 1 => {
                chosen = mesh.levels().iter().map(|&level| usize::from(level) + 1 >= step).collect();
            }
            Self::Listed(path) => {
                for (line, [t]) in read_list(path, "a cell number")? {
                    *chosen.get_mut(t as usize).ok_or_else(|| no_cell(path, line, t, mesh))? = true;
                }
            }
            Self::Boundary => topology::boundary_cells(mesh.tets()).into_iter().for_each(|t| chosen[t as usize] = true),
            Self::Curvature { above, below } => {
                curved_cells(mesh, *above, *below).into_iter().for_each(|t| chosen[t as usize] = true);
            }
        }
        Ok(chosen)
    }
}

/// The cells at boundary edges that turn by more than `above` and at most `below` degrees.
fn curved_cells(mesh: &TetMesh, above: f64, below: f64) -> Vec<u32> {
    let cells_at = topology::VertexCells::new(mesh.points().len(), mesh.tets());
    let turn = |faces: &[usize]| match *faces {
        [f, g] => features::angle_between(mesh, f, g),
        _ => f64::INFINITY,
    };
    let edges = features::boundary_edges(mesh.faces());
    let curved = edges.into_iter().filter(|(_, faces)| turn(faces) > above && turn(faces) <= below);
    let at = |[a, b]: [u32; 2]| cells_at.at(a).iter().copied().filter(move |&t| mesh.tets()[t as usize].contains(&b));
    curved.flat_map(|(edge, _)| at(edge)).collect()
}

/// The mesh with its creases found, and with the edges and corners that the files list; vertices are numbered from 0 in
/// the order of the mesh.
///
/// # Errors
/// [`MeshError`] with the line that names a vertex or an edge that does not exist, or that cannot be read.
pub fn with_features(
    mesh: TetMesh,
    angle: f64,
    edges: Option<&Path>,
    corners: Option<&Path>,
) -> Result<TetMesh, MeshError> {
    let edges = edges.map(|path| tagged_edges(&topology::edges(mesh.tets()), path)).transpose()?.unwrap_or_default();
    let corners = corners.map(|path| tagged_corners(mesh.points().len(), path)).transpose()?.unwrap_or_default();
    let mut parts = features::with_creases(mesh, angle, &edges).into_parts();
    parts.corners.extend(corners);
    TetMesh::new(parts)
}

/// The edges that a file lists, which must be among the `known` ones (sorted).
pub(super) fn tagged_edges(known: &[[u32; 2]], path: &Path) -> Result<Vec<[u32; 2]>, MeshError> {
    let mut tagged = Vec::new();
    for (line, edge) in read_list(path, "a vertex of an edge")? {
        if known.binary_search(&topology::sorted2(edge)).is_err() {
            let message = format!("{edge:?} is not an edge of the mesh");
            return Err(refused(path, line, message, "name two vertices that an edge joins, from 0"));
        }
        tagged.push(edge);
    }
    Ok(tagged)
}

/// The vertices that a file lists, of `count`.
pub(super) fn tagged_corners(count: usize, path: &Path) -> Result<Vec<u32>, MeshError> {
    let mut corners = Vec::new();
    for (line, [v]) in read_list(path, "a vertex number")? {
        if v as usize >= count {
            let message = format!("vertex {v} does not exist: the mesh has {count}");
            return Err(refused(path, line, message, "vertices are numbered from 0"));
        }
        corners.push(v);
    }
    Ok(corners)
}

fn no_cell(path: &Path, line: usize, cell: u32, mesh: &TetMesh) -> MeshError {
    let message = format!("cell {cell} does not exist: the mesh has {}", mesh.tets().len());
    refused(path, line, message, "cells are numbered from 0")
}

fn refused(path: &Path, line: usize, message: String, help: &str) -> MeshError {
    MeshError::Syntax { path: path.to_owned(), at: Place::Line(line), message, help: help.to_owned() }
}
