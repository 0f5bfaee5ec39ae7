//! Meshes that are generated, boxes apart: their measures and numbers of cells.

use super::error::Fault;
use super::numbers::{Checked, outside, positive};
use super::raw::{Number, RawMesh, Table};
use super::spanned::Spanned;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// Most cells along an edge of a generated mesh.
const MAX_CELLS: i64 = 10_000;

/// A body to be meshed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// The L-prism with so many cells along a unit length.
    LPrism(usize),
    /// The Fichera corner, likewise.
    Fichera(usize),
    /// A cylinder.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
        /// Rings around the axis, layers along it.
        cells: [usize; 2],
    },
    /// A thick tube.
    Tube {
        /// Inside and outside.
        radii: [f64; 2],
        /// Length.
        length: f64,
        /// Through the wall, around, along.
        cells: [usize; 3],
        /// Whether only the quarter in x, y >= 0 is made.
        is_quarter: bool,
    },
    /// An eighth of a spherical shell.
    SphereShell {
        /// Inside and outside.
        radii: [f64; 2],
        /// Along an edge of the inner surface, through the wall.
        cells: [usize; 2],
    },
    /// A quarter of a plate with a hole.
    PlateWithHole {
        /// Of the hole.
        radius: f64,
        /// Half the plate's edge.
        size: f64,
        /// Thickness.
        thickness: f64,
        /// From the hole outward, along half its arc, through the thickness.
        cells: [usize; 3],
    },
    /// A quarter of the elliptic plate of NAFEMS LE10.
    Le10 {
        /// From the inner to the outer ellipse, along them, through the thickness.
        cells: [usize; 3],
    },
    /// A regular prism.
    Prism {
        /// Corners of its ends.
        sides: usize,
        /// Distance of its edges from its axis.
        radius: f64,
        /// Length.
        length: f64,
        /// Rings around the axis, layers along it.
        cells: [usize; 2],
    },
}

impl Shape {
    /// The key of `[mesh]` that asks for it.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            Self::LPrism(_) => "l-prism",
            Self::Fichera(_) => "fichera",
            Self::Cylinder { .. } => "cylinder",
            Self::Tube { .. } => "tube",
            Self::SphereShell { .. } => "sphere-shell",
            Self::PlateWithHole { .. } => "plate-with-hole",
            Self::Le10 { .. } => "le10",
            Self::Prism { .. } => "prism",
        }
    }

    /// Whether it has curved sides.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        !matches!(self, Self::LPrism(_) | Self::Fichera(_) | Self::Prism { .. })
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawUnits {
    cells: Spanned<i64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCylinder {
    radius: Number,
    length: Number,
    cells: Spanned<Vec<i64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTube {
    radii: Spanned<Vec<f64>>,
    length: Number,
    cells: Spanned<Vec<i64>>,
    quarter: Option<bool>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawShell {
    radii: Spanned<Vec<f64>>,
    cells: Spanned<Vec<i64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPlate {
    radius: Number,
    size: Number,
    thickness: Number,
    cells: Spanned<Vec<i64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLe10 {
    cells: Spanned<Vec<i64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPrism {
    sides: Spanned<i64>,
    radius: Number,
    length: Number,
    cells: Spanned<Vec<i64>>,
}

/// The shapes that `[mesh]` names, each with the place of its table.
pub(super) fn all(raw: &mut RawMesh) -> Checked<Vec<(Range<usize>, Shape)>> {
    let shapes = [
        raw.l_prism.take().map(|t| (t.span.clone(), units(&t).map(Shape::LPrism))),
        raw.fichera.take().map(|t| (t.span.clone(), units(&t).map(Shape::Fichera))),
        raw.cylinder.take().map(|t| (t.span.clone(), cylinder(&t.value))),
        raw.tube.take().map(|t| (t.span.clone(), tube(&t.value))),
        raw.sphere_shell.take().map(|t| (t.span.clone(), shell(&t.value))),
        raw.plate_with_hole.take().map(|t| (t.span.clone(), plate(&t.value))),
        raw.le10.take().map(|t| (t.span.clone(), cells(&t.value.cells).map(|cells| Shape::Le10 { cells }))),
        raw.prism.take().map(|t| (t.span.clone(), prism(&t.value))),
    ];
    shapes.into_iter().flatten().map(|(span, shape)| Ok((span, shape?))).collect()
}

fn units(table: &Table<RawUnits>) -> Checked<usize> {
    super::numbers::integer(&table.value.cells, 1..=MAX_CELLS)
}

fn cylinder(raw: &RawCylinder) -> Checked<Shape> {
    let (radius, length) = (positive(&raw.radius)?, positive(&raw.length)?);
    Ok(Shape::Cylinder { radius, length, cells: cells(&raw.cells)? })
}

fn tube(raw: &RawTube) -> Checked<Shape> {
    let (radii, length, cells) = (radii(&raw.radii)?, positive(&raw.length)?, cells(&raw.cells)?);
    let is_quarter = raw.quarter.unwrap_or(false);
    if cells[1] < 3 && !is_quarter {
        return Err(outside(
            raw.cells.span(),
            &format!("{cells:?}"),
            "three cells around the tube at least (the second)",
        ));
    }
    Ok(Shape::Tube { radii, length, cells, is_quarter })
}

fn shell(raw: &RawShell) -> Checked<Shape> {
    Ok(Shape::SphereShell { radii: radii(&raw.radii)?, cells: cells(&raw.cells)? })
}

fn plate(raw: &RawPlate) -> Checked<Shape> {
    let (radius, size) = (positive(&raw.radius)?, positive(&raw.size)?);
    if radius >= size {
        return Err(outside(raw.radius.span(), &radius, &format!("below `size`, {size}")));
    }
    Ok(Shape::PlateWithHole { radius, size, thickness: positive(&raw.thickness)?, cells: cells(&raw.cells)? })
}

fn prism(raw: &RawPrism) -> Checked<Shape> {
    let (radius, length) = (positive(&raw.radius)?, positive(&raw.length)?);
    let sides = super::numbers::integer(&raw.sides, 3..=MAX_CELLS)?;
    Ok(Shape::Prism { sides, radius, length, cells: cells(&raw.cells)? })
}

fn radii(raw: &Spanned<Vec<f64>>) -> Checked<[f64; 2]> {
    match raw.get_ref()[..] {
        [inner, outer] if 0.0 < inner && inner < outer && outer.is_finite() => Ok([inner, outer]),
        _ => Err(outside(raw.span(), &format!("{:?}", raw.get_ref()), "two positive radii, the smaller first")),
    }
}

fn cells<const N: usize>(raw: &Spanned<Vec<i64>>) -> Checked<[usize; N]> {
    let given = raw.get_ref();
    let inside = given.iter().filter(|n| (1..=MAX_CELLS).contains(*n)).map(|&n| n as usize);
    <[usize; N]>::try_from(inside.collect::<Vec<_>>())
        .ok()
        .filter(|_| given.len() == N)
        .ok_or_else(|| outside(raw.span(), &format!("{given:?}"), &format!("{N} integers from 1 to {MAX_CELLS}")))
}

/// The fault of a second mesh beside the first.
pub(super) fn one_too_many(span: Range<usize>) -> Fault {
    Fault::new(span, "is a second mesh", "one mesh too many").help("keep one of mesh.file and the generators")
}
