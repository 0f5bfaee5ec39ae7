//! The linear system of hexahedral elements.

use super::super::assembly::{Linear, System};
use super::super::block_matrix::BlockMatrix;
use super::super::numbering::Dofs;
use super::super::options::{HexElement, HexOptions};
use super::super::{FemError, Model, check, loads};
use super::{HexSpace, matrix, nitsche, prescribed_on_hexes};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Assembles stiffness, loads and supports of a model.
///
/// # Errors
/// A material, support or load that makes no sense on this mesh; see [`FemError`].
pub fn assemble_hexes(space: &HexSpace<'_>, model: &Model) -> Result<System, FemError> {
    check::check(space.mesh(), model)?;
    let prescribed = prescribed_on_hexes(space, model)?;
    let mut used = vec![false; space.points().len()];
    (0..space.mesh().cells().len()).flat_map(|t| space.cell(t)).for_each(|&v| used[v as usize] = true);
    let numbering = Dofs::from_used(used, prescribed);
    let mut loads = loads::nodal_forces(space, model)?;
    let stiffness = with_supports(space, model, Some(&mut loads))?;
    let linear = linear(space, model, &stiffness)?;
    Ok(System { stiffness, loads, numbering, points: space.whereabouts(), linear })
}

/// The stiffness of cells, elastic foundations and supports that hold in the mean, which add to loads as well.
fn with_supports(space: &HexSpace<'_>, model: &Model, loads: Option<&mut Vec<DVec3>>) -> Result<BlockMatrix, FemError> {
    let mut stiffness = matrix::stiffness(space, &model.materials)?;
    for support in model.supports.iter().filter(|s| s.stiffness != DVec3::ZERO) {
        super::loads::on_faces(space, support.group, &mut |functions, _, area| {
            for &(i, a) in functions {
                for &(j, b) in functions {
                    if let Some(block) = stiffness.block_mut(i, j) {
                        *block += DMat3::from_diagonal(area.length() * a * b * support.stiffness);
                    }
                }
            }
            Ok(())
        })?;
    }
    if model.supports.iter().any(|s| s.weakly.is_some()) {
        nitsche::add(space, model, &mut stiffness, loads)?;
    }
    Ok(stiffness)
}

/// What multigrid finds below the finest level: of higher Lagrange elements the trilinear one on the vertices, of
/// Catmull-Clark elements with bubbles the one without.
fn linear(space: &HexSpace<'_>, model: &Model, stiffness: &BlockMatrix) -> Result<Option<Linear>, FemError> {
    let mesh = space.mesh();
    Ok(match space.element() {
        HexElement::Hex8 | HexElement::CatmullClark => None,
        HexElement::Hex20 | HexElement::Hex27 => {
            let vertices = HexSpace::new(mesh, HexElement::Hex8, HexOptions::default());
            let topology = mesh.topology();
            let mut ends = topology.edges().to_vec();
            if space.element() == HexElement::Hex27 {
                // Between opposite corners: right for linear fields.
                ends.extend(topology.faces().iter().map(|f| [f[0], f[2]]));
                ends.extend(mesh.cells().iter().map(|c| [c[0], c[7]]));
            }
            Some(Linear { stiffness: with_supports(&vertices, model, None)?, ends })
        }
        HexElement::CatmullClarkPlus => {
            let vertices = mesh.points().len();
            let bubbles = space.points().len() - vertices;
            Some(Linear { stiffness: first_part(stiffness, vertices), ends: vec![[u32::MAX; 2]; bubbles] })
        }
    })
}

/// The first `count` rows and columns.
fn first_part(matrix: &BlockMatrix, count: usize) -> BlockMatrix {
    let kept = |i: usize| matrix.row(i).take_while(|(j, _)| *j < count).count();
    let lengths: Vec<usize> = (0..count).into_par_iter().map(kept).collect();
    let mut part = BlockMatrix { starts: vec![0], columns: Vec::new(), blocks: Vec::new() };
    for (i, length) in lengths.into_iter().enumerate() {
        let first = matrix.starts[i];
        part.columns.extend(&matrix.columns[first..first + length]);
        part.blocks.extend(&matrix.blocks[first..first + length]);
        part.starts.push(part.columns.len());
    }
    part
}
