//! Where a vertex may go without changing the solid or its features.

use super::super::solid::Solid;
use glam::{DMat3, DVec3};

/// Sine of the angle between faces that count as one plane, and between creases that count as one line.
const FLAT: f64 = 1e-10;

/// The displacements a vertex is free to make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Freedom {
    /// None: a corner, or a vertex of a curved surface or crease.
    Fixed,
    /// Along a straight crease between plane faces; a unit vector.
    Line(DVec3),
    /// In a plane part of the surface; its unit normal.
    Plane(DVec3),
    /// All: no surface passes through it.
    Free,
}

impl Freedom {
    /// The freedom of vertex `v`.
    pub(super) fn of(solid: &Solid, v: u32) -> Self {
        if solid.is_interior(v) {
            return Self::Free;
        }
        if solid.is_corner(v) {
            return Self::Fixed;
        }
        let mut normals = Vec::new();
        let mut creases: Vec<(u32, DVec3)> = Vec::new();
        let start = solid.point(v);
        for face in solid.faces_at(v) {
            let [a, b, c] = face.vertices.map(|w| solid.point(w));
            normals.push((b - a).cross(c - a).normalize_or_zero());
            for w in face.vertices.into_iter().filter(|&w| w != v && solid.is_crease([v, w])) {
                if creases.iter().all(|(other, _)| *other != w) {
                    creases.push((w, (solid.point(w) - start).normalize_or_zero()));
                }
            }
        }
        match creases[..] {
            [] if solid.is_pinned(v) => Self::Fixed,
            [] => plane(&normals),
            [(_, d), (_, e)] if d.cross(e).length() < FLAT && d.dot(e) < 0.0 => line(d, &normals),
            _ => Self::Fixed,
        }
    }

    /// The part of a vector that is free.
    pub(super) fn project(self, d: DVec3) -> DVec3 {
        match self {
            Self::Fixed => DVec3::ZERO,
            Self::Line(u) => u * u.dot(d),
            Self::Plane(n) => d - n * n.dot(d),
            Self::Free => d,
        }
    }

    /// The matrix of the projection onto what is not free.
    pub(super) fn complement(self) -> DMat3 {
        let outer = |u: DVec3| DMat3::from_cols(u * u.x, u * u.y, u * u.z);
        match self {
            Self::Fixed => DMat3::IDENTITY,
            Self::Line(u) => DMat3::IDENTITY - outer(u),
            Self::Plane(n) => outer(n),
            Self::Free => DMat3::ZERO,
        }
    }
}

/// The freedom of a surface vertex off the creases.
fn plane(normals: &[DVec3]) -> Freedom {
    match normals.first() {
        Some(&n) if normals.iter().all(|m| n.cross(*m).length() < FLAT) => Freedom::Plane(n),
        _ => Freedom::Fixed,
    }
}

/// The freedom of a vertex on a straight crease: the planes of all faces at it must contain the line.
fn line(direction: DVec3, normals: &[DVec3]) -> Freedom {
    if normals.iter().all(|n| n.dot(direction).abs() < FLAT) { Freedom::Line(direction) } else { Freedom::Fixed }
}
