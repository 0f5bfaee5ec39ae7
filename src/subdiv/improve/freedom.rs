//! Where a vertex may go without changing the solid: anywhere inside, in its plane on a flat part of the surface, along
//! its line on a straight crease.

use super::super::solid::Solid;
use glam::{DMat3, DVec3};

/// Faces whose normals differ by less than this (radians) are one plane. Rounding in mesh files tilts nominally flat
/// faces by up to 2e-4; on exactly flat ones nothing moves out of the plane whatever the tolerance.
const FLAT: f64 = 3e-4;

/// Creases whose directions differ by less than this (radians) are one line: lengths then keep to its square.
const STRAIGHT: f64 = 1e-8;

/// The directions in which a vertex may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Freedom {
    /// All of them.
    Space,
    /// Those at right angles to this unit normal.
    Plane(DVec3),
    /// Along this unit vector.
    Line(DVec3),
    /// None.
    Fixed,
}

impl Freedom {
    /// The part of a displacement that is allowed.
    pub(crate) fn project(self, d: DVec3) -> DVec3 {
        match self {
            Self::Space => d,
            Self::Plane(n) => d - n * n.dot(d),
            Self::Line(u) => u * u.dot(d),
            Self::Fixed => DVec3::ZERO,
        }
    }

    /// The matrix of the projection onto what is not allowed.
    pub(crate) fn complement(self) -> DMat3 {
        let outer = |u: DVec3| DMat3::from_cols(u * u.x, u * u.y, u * u.z);
        match self {
            Self::Space => DMat3::ZERO,
            Self::Plane(n) => outer(n),
            Self::Line(u) => DMat3::IDENTITY - outer(u),
            Self::Fixed => DMat3::IDENTITY,
        }
    }
}

/// The freedom of every vertex.
pub(crate) fn freedoms(solid: &Solid) -> Vec<Freedom> {
    let creases = crease_directions(solid);
    let count = solid.point_count() as u32;
    let of = |v: u32| {
        let ends = creases.partition_point(|c| c.0 < v)..creases.partition_point(|c| c.0 <= v);
        let ends = &creases[ends];
        // A feature ends where another crease goes on.
        if ends.iter().any(|c| c.3 != ends[0].3) {
            return Freedom::Fixed;
        }
        let directions: Vec<DVec3> = ends.iter().map(|c| c.2).collect();
        freedom(solid, v, &directions)
    };
    (0..count).map(of).collect()
}

/// The freedom of vertex `v`, given the unit directions of the creases at it.
pub(crate) fn freedom(solid: &Solid, v: u32, creases: &[DVec3]) -> Freedom {
    if solid.is_interior(v) {
        return Freedom::Space;
    }
    let mut normals = Vec::new();
    let mut patch = None;
    let mut one_patch = true;
    for face in solid.faces_at(v) {
        let [a, b, c] = face.vertices.map(|w| solid.point(w));
        normals.push((b - a).cross(c - a).normalize_or_zero());
        one_patch &= *patch.get_or_insert(face.patch) == face.patch;
    }
    match creases {
        [] if solid.is_pinned(v) || !one_patch => Freedom::Fixed,
        [] => plane(&normals),
        [d, e] if !solid.is_corner(v) && !normals.is_empty() => line(*d, *e, &normals),
        _ => Freedom::Fixed,
    }
}

/// The common plane of the normals, each of them with either sign.
fn plane(normals: &[DVec3]) -> Freedom {
    let Some(&first) = normals.first() else { return Freedom::Fixed };
    let sum: DVec3 = normals.iter().map(|n| *n * n.dot(first).signum()).sum();
    let mean = sum.normalize_or_zero();
    let flat = normals.iter().all(|n| n.cross(mean).length() < FLAT && *n != DVec3::ZERO);
    if flat { Freedom::Plane(mean) } else { Freedom::Fixed }
}

/// The common line of two creases, if it lies in all the faces.
fn line(d: DVec3, e: DVec3, normals: &[DVec3]) -> Freedom {
    let straight = d.cross(e).length() < STRAIGHT && d.dot(e) < 0.0;
    let along = (d - e).normalize_or_zero();
    // Every face contains the line, and those on one side of it form one plane: at most as many planes as faces at a crease.
    let in_faces = normals.iter().all(|n| n.dot(along).abs() < FLAT);
    if straight && in_faces { Freedom::Line(along) } else { Freedom::Fixed }
}

/// (vertex, other end, unit direction, whether it is a feature) of every crease, from both its ends, sorted.
fn crease_directions(solid: &Solid) -> Vec<(u32, u32, DVec3, bool)> {
    let mut ends: Vec<(u32, u32, bool)> =
        solid.crease_edges().flat_map(|([a, b], feature)| [(a, b, feature), (b, a, feature)]).collect();
    ends.sort_unstable();
    let direction = |(a, b, feature)| (a, b, (solid.point(b) - solid.point(a)).normalize_or_zero(), feature);
    ends.into_iter().map(direction).collect()
}
