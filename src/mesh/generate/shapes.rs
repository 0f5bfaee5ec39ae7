//! Bodies with known solutions, and other standard shapes.

use super::Curved;
use super::lattice::{At, Lattice};
use crate::mesh::{MeshError, TetMesh};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// A lattice in which nothing is closed or turned round.
const PLAIN: ([bool; 3], At) = ([false; 3], [0; 3]);

/// `[-1, 1]^2` without `x, y < 0`, times `[0, 1]`; `n` bricks along a unit length. Groups "x-min", "x-max", "y-min",
/// "y-max", "z-min", "z-max" and, at the re-entrant edge, "notch-x" (in the plane x = 0) and "notch-y".
///
/// # Errors
/// [`MeshError::Generator`] if `n` is zero or too large.
pub fn l_prism(n: usize) -> Result<TetMesh, MeshError> {
    let (closed, mirror) = PLAIN;
    Lattice {
        name: "the L-prism",
        cells: [n.saturating_mul(2), n.saturating_mul(2), n],
        closed,
        mirror,
        keep: &|[i, j, _]| i >= n || j >= n,
        place: &|[i, j, k]| DVec3::new(unit(i, n) - 1.0, unit(j, n) - 1.0, unit(k, n)),
        groups: &[
            ("x-min", &|[i, ..]| i == 0),
            ("x-max", &|[i, ..]| i == 2 * n),
            ("y-min", &|[_, j, _]| j == 0),
            ("y-max", &|[_, j, _]| j == 2 * n),
            ("z-min", &|[.., k]| k == 0),
            ("z-max", &|[.., k]| k == n),
            ("notch-x", &|[i, ..]| i == n),
            ("notch-y", &|[_, j, _]| j == n),
        ],
    }
    .mesh()
}

/// `[-1, 1]^3` without `[0, 1]^3`; `n` bricks along a unit length. Groups "x-min", ..., "z-max" and "notch-x", "notch-y",
/// "notch-z" in the planes through the re-entrant corner.
///
/// # Errors
/// [`MeshError::Generator`] if `n` is zero or too large.
pub fn fichera(n: usize) -> Result<TetMesh, MeshError> {
    let (closed, mirror) = PLAIN;
    Lattice {
        name: "the Fichera corner",
        cells: [n.saturating_mul(2); 3],
        closed,
        mirror,
        keep: &|at| at.iter().any(|&i| i < n),
        place: &|at| DVec3::from_array(at.map(|i| unit(i, n) - 1.0)),
        groups: &[
            ("x-min", &|[i, ..]| i == 0),
            ("x-max", &|[i, ..]| i == 2 * n),
            ("y-min", &|[_, j, _]| j == 0),
            ("y-max", &|[_, j, _]| j == 2 * n),
            ("z-min", &|[.., k]| k == 0),
            ("z-max", &|[.., k]| k == 2 * n),
            ("notch-x", &|[i, ..]| i == n),
            ("notch-y", &|[_, j, _]| j == n),
            ("notch-z", &|[.., k]| k == n),
        ],
    }
    .mesh()
}

/// A cylinder about the z axis from z = 0: `cells` are the rings around the axis and the layers. Groups "side", "z-min",
/// "z-max".
///
/// # Errors
/// [`MeshError::Generator`] if a measure is not positive and finite, or a number of cells is zero or too large.
pub fn cylinder(radius: f64, length: f64, cells: [usize; 2]) -> Result<Curved, MeshError> {
    check("the cylinder", &[("radius", radius), ("length", length)])?;
    let [n, layers] = cells;
    // Squares around the axis become circles.
    let ring = move |i: usize, j: usize| i.abs_diff(n).max(j.abs_diff(n));
    Lattice {
        name: "the cylinder",
        cells: [n.saturating_mul(2), n.saturating_mul(2), layers],
        closed: [false; 3],
        mirror: [n, n, 0],
        keep: &|_| true,
        place: &|[i, j, k]| {
            let flat = DVec3::new(i - n as f64, j - n as f64, 0.0);
            radius * unit(flat.abs().max_element(), n) * flat.normalize_or_zero() + length * unit(k, layers) * DVec3::Z
        },
        groups: &[
            ("side", &|[i, j, _]| ring(i, j) == n),
            ("z-min", &|[.., k]| k == 0),
            ("z-max", &|[.., k]| k == layers),
        ],
    }
    .curved()
}

/// A thick tube about the z axis from z = 0, or the quarter of it in x, y >= 0; `radii` inside and outside, `cells` through
/// its wall, around and along. Groups "inner", "outer", "z-min", "z-max", and of the quarter "y-min", "x-min".
///
/// # Errors
/// [`MeshError::Generator`] if a measure is not positive and finite, the radii do not grow, there are fewer than three
/// cells around the whole tube, or a number of cells is zero or too large.
pub fn tube(radii: [f64; 2], length: f64, cells: [usize; 3], is_quarter: bool) -> Result<Curved, MeshError> {
    let [inner, outer] = radii;
    check("the tube", &[("inner radius", inner), ("wall", outer - inner), ("length", length)])?;
    let [wall, around, layers] = cells;
    if around < 3 && !is_quarter {
        return Err(MeshError::Generator(format!("the tube: {around} cells around it, it needs at least three")));
    }
    let groups: [(&str, &dyn Fn(At) -> bool); 6] = [
        ("inner", &|[i, ..]| i == 0),
        ("outer", &|[i, ..]| i == wall),
        ("z-min", &|[.., k]| k == 0),
        ("z-max", &|[.., k]| k == layers),
        ("y-min", &|[_, j, _]| j == 0),
        ("x-min", &|[_, j, _]| j == around),
    ];
    Lattice {
        name: "the tube",
        cells,
        closed: [false, !is_quarter, false],
        mirror: [0; 3],
        keep: &|_| true,
        place: &|[i, j, k]| {
            let turn = 4.0 * FRAC_PI_2 * unit(j, around);
            let (sin, cos) = if is_quarter { quarter(j, around) } else { turn.sin_cos() };
            let r = inner + (outer - inner) * unit(i, wall);
            DVec3::new(r * cos, r * sin, length * unit(k, layers))
        },
        groups: &groups[..if is_quarter { 6 } else { 4 }],
    }
    .curved()
}

/// The eighth of a spherical shell in x, y, z >= 0; `radii` inside and outside, `cells` along an edge of the inner surface
/// and through the wall. Groups "inner", "outer", "x-min", "y-min", "z-min".
///
/// # Errors
/// [`MeshError::Generator`] if a measure is not positive and finite, the radii do not grow, or a number of cells is zero
/// or too large.
pub fn sphere_shell(radii: [f64; 2], cells: [usize; 2]) -> Result<Curved, MeshError> {
    let [inner, outer] = radii;
    check("the shell", &[("inner radius", inner), ("wall", outer - inner)])?;
    let [m, wall] = cells;
    if m == 0 || wall == 0 {
        return Err(MeshError::Generator(format!("the shell: {cells:?} cells, it needs at least one each")));
    }
    let n = m.saturating_add(wall);
    // Cubes around the centre become spheres.
    let level = |at: At| at.into_iter().max().unwrap_or(0);
    Lattice {
        name: "the shell",
        cells: [n; 3],
        closed: [false; 3],
        mirror: [0; 3],
        keep: &|low| level(low) >= m,
        place: &|at| {
            let at = DVec3::from_array(at);
            let r = inner + (outer - inner) * (at.max_element() - m as f64) / wall as f64;
            r * at.normalize_or_zero()
        },
        groups: &[
            ("inner", &|at| level(at) == m),
            ("outer", &|at| level(at) == n),
            ("x-min", &|[i, ..]| i == 0),
            ("y-min", &|[_, j, _]| j == 0),
            ("z-min", &|[.., k]| k == 0),
        ],
    }
    .curved()
}

/// A quarter of a square plate with a round hole in its middle: x, y from 0 to `size`, z from 0 to `thickness`; `cells` from
/// the hole outward (smaller towards it), along half the arc of the hole, and through the thickness. Groups "hole", "x-min",
/// "x-max", "y-min", "y-max", "z-min", "z-max".
///
/// # Errors
/// [`MeshError::Generator`] if a measure is not positive and finite, the hole is not smaller than the plate, or a number of
/// cells is zero or too large.
pub fn plate_with_hole(radius: f64, size: f64, thickness: f64, cells: [usize; 3]) -> Result<Curved, MeshError> {
    check("the plate", &[("radius", radius), ("size minus the radius", size - radius), ("thickness", thickness)])?;
    let [outward, half, layers] = cells;
    Lattice {
        name: "the plate",
        cells: [outward, half.saturating_mul(2), layers],
        closed: [false; 3],
        mirror: [0; 3],
        keep: &|_| true,
        place: &|[i, j, k]| {
            // A quarter turn ends where it should, not a rounding beside it.
            let (sin, cos) = quarter(j, 2 * half);
            let s = unit(j, half);
            let edge = if s <= 1.0 { DVec3::new(1.0, s, 0.0) } else { DVec3::new(2.0 - s, 1.0, 0.0) };
            let t = unit(i, outward);
            let graded = t * (1.0 + t) / 2.0;
            let flat = (radius * DVec3::new(cos, sin, 0.0)).lerp(size * edge, graded);
            flat + thickness * unit(k, layers) * DVec3::Z
        },
        groups: &[
            ("hole", &|[i, ..]| i == 0),
            ("x-max", &|[i, j, _]| i == outward && j <= half),
            ("y-max", &|[i, j, _]| i == outward && j >= half),
            ("y-min", &|[_, j, _]| j == 0),
            ("x-min", &|[_, j, _]| j == 2 * half),
            ("z-min", &|[.., k]| k == 0),
            ("z-max", &|[.., k]| k == layers),
        ],
    }
    .curved()
}

/// The thick elliptic plate of the NAFEMS benchmark LE10, a quarter of it: inner ellipse 2 x 1, outer ellipse 3.25 x 2.75, z
/// from 0 to 0.6; `cells` from the inner to the outer ellipse, along them and through the thickness. Groups "inner", "outer",
/// "x-min", "y-min", "z-min", "z-max".
///
/// # Errors
/// [`MeshError::Generator`] if a number of cells is zero or too large.
pub fn le10(cells: [usize; 3]) -> Result<Curved, MeshError> {
    let [outward, along, layers] = cells;
    Lattice {
        name: "the LE10 plate",
        cells,
        closed: [false; 3],
        mirror: [0; 3],
        keep: &|_| true,
        place: &|[i, j, k]| {
            let (sin, cos) = quarter(j, along);
            let t = unit(i, outward);
            DVec3::new((2.0 + 1.25 * t) * cos, (1.0 + 1.75 * t) * sin, 0.6 * unit(k, layers))
        },
        groups: &[
            ("inner", &|[i, ..]| i == 0),
            ("outer", &|[i, ..]| i == outward),
            ("y-min", &|[_, j, _]| j == 0),
            ("x-min", &|[_, j, _]| j == along),
            ("z-min", &|[.., k]| k == 0),
            ("z-max", &|[.., k]| k == layers),
        ],
    }
    .curved()
}

fn unit(i: f64, n: usize) -> f64 {
    i / n as f64
}

/// Sine and cosine after `j` of `n` parts of a quarter turn, exact at its ends.
fn quarter(j: f64, n: usize) -> (f64, f64) {
    let share = unit(j, n);
    if share >= 1.0 { (1.0, 0.0) } else { (FRAC_PI_2 * share).sin_cos() }
}

fn check(name: &str, measures: &[(&str, f64)]) -> Result<(), MeshError> {
    match measures.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        Some((what, x)) => Err(MeshError::Generator(format!("{name}: the {what} is {x}, it must be positive"))),
        None => Ok(()),
    }
}
