//! Selectors: which boundary faces a support or a load acts on.

use super::error::Fault;
use super::numbers::{Checked, direction, finite, not_negative, outside, positive, vector, within};
use super::raw::{Number, RawSelector, Table, Vector};
use super::spanned::Spanned;
use glam::DVec3;
use std::ops::Range;

/// Boundary faces, by name or by place. A face matches a geometric selector if all its corners lie in the shape, or
/// within `tolerance` of it (`None`: 1e-6 of the diagonal of the mesh's bounding box).
#[derive(Debug, Clone, PartialEq)]
pub enum Selector {
    /// A named group of the mesh.
    Group(String),
    /// The plane `normal . x = offset`.
    Plane {
        /// Normal, of any length but zero.
        normal: DVec3,
        /// `normal . x` on the plane.
        offset: f64,
        /// Distance.
        tolerance: Option<f64>,
    },
    /// An axis-parallel box, inside included.
    Box {
        /// Smallest coordinates.
        min: DVec3,
        /// Largest coordinates.
        max: DVec3,
        /// Distance along an axis.
        tolerance: Option<f64>,
    },
    /// A ball, inside included.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
        /// Distance.
        tolerance: Option<f64>,
    },
    /// A cylinder without ends, inside included.
    Cylinder {
        /// A point of the axis.
        point: DVec3,
        /// Direction of the axis, of any length but zero.
        axis: DVec3,
        /// Radius.
        radius: f64,
        /// Distance.
        tolerance: Option<f64>,
    },
    /// Faces whose outward normal is within an angle of a direction.
    Normal {
        /// Direction, of any length but zero.
        direction: DVec3,
        /// Degrees.
        angle: f64,
    },
    /// Faces that match all.
    All(Vec<Selector>),
    /// Faces that match at least one.
    Any(Vec<Selector>),
    /// Faces that do not match.
    Not(Box<Selector>),
}

/// The keys of a selector.
pub(super) const KINDS: &str = "group, plane, box, sphere, cylinder, normal, all, any, not";

/// The selector written in a table at `span`, which must hold exactly one.
pub(super) fn one(raw: RawSelector, span: &Range<usize>) -> Checked<Selector> {
    at_most_one(raw)?.ok_or_else(|| no_selector(span))
}

/// The fault of a table at `span` without a selector.
pub(super) fn no_selector(span: &Range<usize>) -> Fault {
    Fault::new(span.clone(), "has no selector", "acts on which faces?").help(format!(
        "add one of {KINDS}; for example group = \"x-min\" or plane = {{ normal = [0, 1, 0], offset = -10 }}"
    ))
}

/// The selector written in a table, if there is one.
pub(super) fn at_most_one(raw: RawSelector) -> Checked<Option<Selector>> {
    let mut found: Vec<(&str, Range<usize>, Selector)> = Vec::new();
    if let Some(name) = raw.group {
        found.push(("group", name.span(), Selector::Group(name.into_inner())));
    }
    let shapes = [
        raw.plane.map(|t| ("plane", t.span.clone(), plane(&t.value))),
        raw.brick.map(|t| ("box", t.span.clone(), brick(&t))),
        raw.sphere.map(|t| ("sphere", t.span.clone(), sphere(&t.value))),
        raw.cylinder.map(|t| ("cylinder", t.span.clone(), cylinder(&t.value))),
        raw.normal.map(|t| ("normal", t.span.clone(), normal(&t.value))),
        raw.all.map(|list| ("all", list.span(), many(list).map(Selector::All))),
        raw.any.map(|list| ("any", list.span(), many(list).map(Selector::Any))),
        raw.not.map(|t| ("not", t.span.clone(), one(t.value, &t.span).map(Box::new).map(Selector::Not))),
    ];
    for (kind, span, selector) in shapes.into_iter().flatten() {
        found.push((kind, span, selector?));
    }
    if let [(first, ..), (second, span, _), ..] = &found[..] {
        let problem = format!("is a second selector beside `{first}`: a table takes one");
        let help = format!("faces in both: all = [{{ {first} = .. }}, {{ {second} = .. }}]; in either: any = [..]");
        return Err(Fault::new(span.clone(), problem, "the second selector").help(help));
    }
    Ok(found.pop().map(|(_, _, selector)| selector))
}

fn tolerance(x: Option<&Number>) -> Checked<Option<f64>> {
    x.map(not_negative).transpose()
}

fn plane(raw: &super::raw::RawPlane) -> Checked<Selector> {
    let (normal, offset) = (direction(&raw.normal)?, finite(&raw.offset)?);
    Ok(Selector::Plane { normal, offset, tolerance: tolerance(raw.tolerance.as_ref())? })
}

fn brick(table: &Table<super::raw::RawBox>) -> Checked<Selector> {
    let (min, max) = brick_corners(&table.value.min, &table.value.max)?;
    Ok(Selector::Box { min, max, tolerance: tolerance(table.value.tolerance.as_ref())? })
}

/// The smallest and the largest coordinates of a box.
pub(super) fn brick_corners(lowest: &Vector, highest: &Vector) -> Checked<(DVec3, DVec3)> {
    let (min, max) = (vector(lowest)?, vector(highest)?);
    if min.cmpgt(max).any() {
        return Err(outside(highest.span(), &max, &format!("at least `min`, {min}, in each coordinate")));
    }
    Ok((min, max))
}

fn sphere(raw: &super::raw::RawSphere) -> Checked<Selector> {
    let (center, radius) = (vector(&raw.center)?, positive(&raw.radius)?);
    Ok(Selector::Sphere { center, radius, tolerance: tolerance(raw.tolerance.as_ref())? })
}

fn cylinder(raw: &super::raw::RawCylinder) -> Checked<Selector> {
    let (point, axis, radius) = (vector(&raw.point)?, direction(&raw.axis)?, positive(&raw.radius)?);
    Ok(Selector::Cylinder { point, axis, radius, tolerance: tolerance(raw.tolerance.as_ref())? })
}

fn normal(raw: &super::raw::RawNormal) -> Checked<Selector> {
    let direction = direction(&raw.direction)?;
    let angle = within(&raw.angle, "an angle from 0 to 180 degrees", |a| (0.0..=180.0).contains(&a))?;
    Ok(Selector::Normal { direction, angle })
}

fn many(list: Spanned<Vec<Table<RawSelector>>>) -> Checked<Vec<Selector>> {
    if list.get_ref().is_empty() {
        return Err(Fault::new(list.span(), "is empty", "add selectors"));
    }
    list.into_inner().into_iter().map(|t| one(t.value, &t.span)).collect()
}
