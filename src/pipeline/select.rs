//! Selectors on the boundary of a mesh.

use crate::mesh::Tagged;
use crate::scenario::Selector;
use glam::DVec3;

/// Tolerance of geometric selectors, as a fraction of the diagonal of the bounding box.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// A selector names a group that the mesh has not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownGroup(pub String);

/// For each of `mesh.faces()` whether it matches: all its corners lie in the shape or within the tolerance of it; for
/// `normal`, its outward normal is within the angle of the direction. `all`, `any` and `not` combine faces, not corners.
///
/// # Errors
/// [`UnknownGroup`] names the first group that does not exist.
pub fn select(mesh: &impl Tagged, selector: &Selector) -> Result<Vec<bool>, UnknownGroup> {
    let combine = |list: &[Selector], start: bool, join: fn(bool, bool) -> bool| {
        list.iter().try_fold(vec![start; mesh.face_count()], |chosen, s| {
            Ok(chosen.into_iter().zip(select(mesh, s)?).map(|(a, b)| join(a, b)).collect())
        })
    };
    match selector {
        Selector::Group(name) => group(mesh, name),
        Selector::Normal { direction, angle } => Ok(by_normal(mesh, *direction, *angle)),
        Selector::All(list) => combine(list, true, |a, b| a && b),
        Selector::Any(list) => combine(list, false, |a, b| a || b),
        Selector::Not(inner) => Ok(select(mesh, inner)?.into_iter().map(|m| !m).collect()),
        shape => {
            let tolerance = tolerance(mesh, shape);
            let near = |f| face_distance(mesh, shape, f) <= tolerance;
            Ok((0..mesh.face_count()).map(near).collect())
        }
    }
}

/// The tolerance of a geometric selector on a mesh.
#[must_use]
pub fn tolerance(mesh: &impl Tagged, selector: &Selector) -> f64 {
    let given = match selector {
        Selector::Plane { tolerance, .. }
        | Selector::Box { tolerance, .. }
        | Selector::Sphere { tolerance, .. }
        | Selector::Cylinder { tolerance, .. } => *tolerance,
        _ => None,
    };
    given.unwrap_or_else(|| {
        let (lo, hi) = mesh.limits();
        DEFAULT_TOLERANCE * lo.distance(hi)
    })
}

/// The smallest tolerance with which a geometric selector would match a face of the boundary.
#[must_use]
pub fn nearest(mesh: &impl Tagged, selector: &Selector) -> f64 {
    (0..mesh.face_count()).map(|f| face_distance(mesh, selector, f)).fold(f64::INFINITY, f64::min)
}

/// How far the farthest corner of a face lies outside the shape.
fn face_distance(mesh: &impl Tagged, selector: &Selector, face: usize) -> f64 {
    mesh.face_corners(face)
        .iter()
        .map(|&v| outside(selector, mesh.points()[v as usize]))
        .fold(f64::NEG_INFINITY, f64::max)
}

/// How far a point lies outside a shape; not positive inside. Infinite for selectors that are no shapes.
pub(super) fn outside(selector: &Selector, x: DVec3) -> f64 {
    match selector {
        Selector::Plane { normal, offset, .. } => (normal.dot(x) - offset).abs() / normal.length(),
        Selector::Box { min, max, .. } => (*min - x).max(x - *max).max_element(),
        Selector::Sphere { center, radius, .. } => x.distance(*center) - radius,
        Selector::Cylinder { point, axis, radius, .. } => (x - point).reject_from(*axis).length() - radius,
        _ => f64::INFINITY,
    }
}

fn group(mesh: &impl Tagged, name: &str) -> Result<Vec<bool>, UnknownGroup> {
    let id = mesh.group_named(name).ok_or_else(|| UnknownGroup(name.to_owned()))?;
    Ok((0..mesh.face_count()).map(|f| mesh.face_groups(f).contains(&id)).collect())
}

fn by_normal(mesh: &impl Tagged, direction: DVec3, angle: f64) -> Vec<bool> {
    // The slack takes in faces exactly at the angle whatever their rounding.
    let within = |n: DVec3| n.cross(direction).length().atan2(n.dot(direction)).to_degrees() <= angle + 1e-9;
    (0..mesh.face_count()).map(|f| within(mesh.face_area(f))).collect()
}

/// Total area of faces.
#[must_use]
pub fn area(mesh: &impl Tagged, faces: impl IntoIterator<Item = usize>) -> f64 {
    faces.into_iter().map(|f| mesh.face_area(f).length()).sum()
}
