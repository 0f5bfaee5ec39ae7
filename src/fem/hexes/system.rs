//! The linear system of hexahedral elements.

use super::super::assembly::System;
use super::super::numbering::Dofs;
use super::super::{FemError, Model, check, loads};
use super::{HexSpace, matrix, prescribed_on_hexes};
use glam::DMat3;

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
    let loads = loads::nodal_forces(space, model)?;
    let mut stiffness = matrix::stiffness(space, &model.materials)?;
    for support in model.supports.iter().filter(|s| s.stiffness != glam::DVec3::ZERO) {
        super::loads::on_faces(space, support.group, &mut |functions, _, area| {
            for &(i, a) in functions {
                for &(j, b) in functions {
                    if let Some(block) = stiffness.block_mut(i, j) {
                        *block += DMat3::from_diagonal(area.length() * a * b * support.stiffness);
                    }
                }
            }
            Ok::<(), FemError>(())
        })?;
    }
    Ok(System { stiffness, loads, numbering, points: space.points().to_vec(), linear: None })
}
