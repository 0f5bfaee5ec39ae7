//! Where the control points of a deformation are.

use super::super::select::{UnknownGroup, outside, select, tolerance};
use super::DeformError;
use crate::mesh::{Tagged, TetMesh};
use crate::scenario::{ControlPoints, Pose, Selector};
use glam::DVec3;

/// The control points of a pose.
///
/// # Errors
/// [`DeformError`] if a move names a group or a point that does not exist, takes no points, or has a displacement that is not finite.
pub(super) fn posed(mesh: &TetMesh, pose: &Pose) -> Result<Vec<DVec3>, DeformError> {
    let mut points = mesh.points().to_vec();
    for (number, step) in (1..).zip(&pose.moves) {
        let name = || format!("move {number} of pose {:?}", pose.name);
        let chosen = chosen(mesh, &step.points).map_err(|problem| DeformError::Move { name: name(), problem })?;
        if !chosen.contains(&true) {
            return Err(DeformError::Move { name: name(), problem: "takes no control points".to_owned() });
        }
        for (v, at) in mesh.points().iter().enumerate().filter(|(v, _)| chosen[*v]) {
            let displacement = DVec3::from_array(step.displacement.each_ref().map(|field| field.at(*at)));
            if !displacement.is_finite() {
                let problem = format!("displaces control point {v} at {at} by {displacement}");
                return Err(DeformError::Move { name: name(), problem });
            }
            points[v] += displacement;
        }
    }
    Ok(points)
}

fn chosen(mesh: &TetMesh, points: &ControlPoints) -> Result<Vec<bool>, String> {
    let count = mesh.points().len();
    match points {
        ControlPoints::All => Ok(vec![true; count]),
        ControlPoints::Selected(selector) => by_selector(mesh, selector)
            .map_err(|UnknownGroup(group)| format!("names group {group:?}, which the mesh has not")),
        ControlPoints::Listed(numbers) => {
            let mut chosen = vec![false; count];
            for &v in numbers {
                let place = chosen.get_mut(v as usize);
                *place.ok_or_else(|| format!("names control point {v}, of {count} from 0"))? = true;
            }
            Ok(chosen)
        }
    }
}

/// Shapes take points; groups and normals take faces, with their corners.
fn by_selector(mesh: &TetMesh, selector: &Selector) -> Result<Vec<bool>, UnknownGroup> {
    let combine = |list: &[Selector], start: bool, join: fn(bool, bool) -> bool| {
        list.iter().try_fold(vec![start; mesh.points().len()], |chosen, s| {
            Ok(chosen.into_iter().zip(by_selector(mesh, s)?).map(|(a, b)| join(a, b)).collect())
        })
    };
    match selector {
        Selector::All(list) => combine(list, true, |a, b| a && b),
        Selector::Any(list) => combine(list, false, |a, b| a || b),
        Selector::Not(inner) => Ok(by_selector(mesh, inner)?.into_iter().map(|m| !m).collect()),
        Selector::Group(_) | Selector::Normal { .. } => {
            let mut chosen = vec![false; mesh.points().len()];
            for (face, _) in select(mesh, selector)?.into_iter().enumerate().filter(|(_, matches)| *matches) {
                mesh.face_corners(face).iter().for_each(|&v| chosen[v as usize] = true);
            }
            Ok(chosen)
        }
        shape => {
            let tolerance = tolerance(mesh, shape);
            Ok(mesh.points().iter().map(|p| outside(shape, *p) <= tolerance).collect())
        }
    }
}
