//! What to say when a selector finds nothing.

use super::{select, span};
use crate::mesh::Tagged;
use crate::scenario::{Selector, suggest};

/// The first `own` groups, which are the mesh's own, with the nearest name first.
pub(super) fn unknown_group(mesh: &impl Tagged, own: usize, name: &str) -> String {
    if mesh.region_names().iter().any(|r| r == name) {
        return format!(
            "`{name}` is a region (of cells), but supports and loads act on boundary faces; {}",
            groups(mesh, own)
        );
    }
    let names: Vec<&str> = mesh.groups()[..own].iter().map(String::as_str).collect();
    if names.is_empty() { groups(mesh, own) } else { suggest::help(name, "groups of this mesh", &names) }
}

/// How far the parts of a selector miss the boundary, and what there is.
pub(super) fn empty_selection(mesh: &impl Tagged, own: usize, selector: &Selector) -> String {
    let mut misses = Vec::new();
    collect_misses(mesh, selector, &mut misses);
    if misses.is_empty() {
        misses.push("each part of the selector matches faces, but no face matches the whole".to_owned());
    }
    misses.push(format!("the model spans {}", span(mesh)));
    misses.push(groups(mesh, own));
    misses.join("\n")
}

fn groups(mesh: &impl Tagged, own: usize) -> String {
    match &mesh.groups()[..own] {
        [] => "the mesh has no groups of boundary faces".to_owned(),
        names => format!("groups of this mesh: {}", names.join(", ")),
    }
}

fn collect_misses(mesh: &impl Tagged, selector: &Selector, misses: &mut Vec<String>) {
    match selector {
        Selector::All(list) | Selector::Any(list) => list.iter().for_each(|s| collect_misses(mesh, s, misses)),
        Selector::Not(_) => {}
        part if select::select(mesh, part).is_ok_and(|m| m.contains(&true)) => {}
        Selector::Group(name) => misses.push(format!("group `{name}` has no faces")),
        Selector::Normal { direction, .. } => {
            let angle = |n: glam::DVec3| n.cross(*direction).length().atan2(n.dot(*direction)).to_degrees();
            let normals = (0..mesh.face_count()).map(|f| mesh.face_area(f));
            let nearest = normals.map(angle).fold(f64::INFINITY, f64::min);
            misses.push(format!("the nearest face normal is {nearest:.2} degrees off"));
        }
        shape => misses.push(shape_miss(mesh, shape)),
    }
}

fn shape_miss(mesh: &impl Tagged, shape: &Selector) -> String {
    let mut text = String::new();
    if let Selector::Plane { normal, offset, .. } = shape {
        let corners = (0..mesh.face_count()).flat_map(|f| mesh.face_corners(f));
        let along = corners.map(|&v| normal.dot(mesh.points()[v as usize]));
        let (lo, hi) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        text = format!("normal . x runs from {lo} to {hi} over the boundary, the plane asks for {offset}; ");
    }
    let (distance, tolerance) = (select::nearest(mesh, shape), select::tolerance(mesh, shape));
    text += &format!("the nearest face lies {distance:.2e} away, the tolerance is {tolerance:.2e}");
    // A near miss is a matter of rounding in the mesh file, a far one is not.
    let (lo, hi) = mesh.limits();
    if distance <= 1e-3 * lo.distance(hi) {
        text += &format!(": tolerance = {:.1e} would take it", 1.1 * distance);
    }
    text
}
