//! Plane meshes of quadrilaterals, drawn out along the z axis.

use super::layers::{Layers, Takes, grid};
use super::{HexError, HexMesh, check_cells, check_measures, unit};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

fn direction(angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// A prism about the z axis from z = 0 whose ends are regular polygons of `sides` corners at distance `radius`, the first on
/// the x axis: `sides` kites meet at the axis, which is an edge of that valence in each layer. `cells` are those along a
/// side of a kite, and the layers. Groups "side", "z-min", "z-max".
///
/// # Errors
/// [`HexError::Generator`] if there are fewer than three sides, a measure is not positive and finite, or a number of
/// cells is zero or too large.
pub fn prism(sides: usize, radius: f64, length: f64, cells: [usize; 2]) -> Result<HexMesh, HexError> {
    const NAME: &str = "the prism";
    let [m, layers] = cells;
    check_measures(NAME, &[("radius", radius), ("length", length)])?;
    check_cells(NAME, &[sides, m, m, layers])?;
    if sides < 3 {
        return Err(HexError::Generator(format!("{NAME}: {sides} sides, it needs three at least")));
    }
    // The first side of a kite belongs to it, the other to the next one.
    let key = |s: usize, [i, j]: [usize; 2]| match (i, j) {
        (0, 0) => [0; 3],
        (0, _) => [(s + 1) % sides, j, 0],
        _ => [s, i, j],
    };
    Layers {
        name: NAME,
        quads: (0..sides).flat_map(|s| grid([m, m]).map(move |quad| quad.map(|at| key(s, at)))).collect(),
        count: layers,
        place: &|[s, i, j], k| {
            let middle = |s: f64| radius * (PI / sides as f64).cos() * direction(TAU * s / sides as f64);
            let corner = radius * direction(TAU * s as f64 / sides as f64);
            let (u, v) = (unit(i, m), unit(j, m));
            let (first, other) = (middle(s as f64 - 0.5), middle(s as f64 + 0.5));
            u * (1.0 - v) * first + (1.0 - u) * v * other + u * v * corner + length * unit(k, layers) * DVec3::Z
        },
        groups: &[
            ("side", &|[_, i, j], _| i == m || j == m),
            ("z-min", &|_, k| k == 0),
            ("z-max", &|_, k| k == layers),
        ],
    }
    .mesh()
}

/// A vertex of the disc: in the square core, or step `steps[1]` around ring `steps[0]` from 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum OGrid {
    Core([usize; 2]),
    Ring([usize; 2]),
}

/// A cylinder about the z axis from z = 0, as an O-grid: `cells` are those along a side of the square core, the rings around
/// it and the layers. Along four lines three cells meet. Groups "side", "z-min", "z-max".
///
/// # Errors
/// [`HexError::Generator`] if a measure is not positive and finite, or a number of cells is zero or too large.
pub fn cylinder(radius: f64, length: f64, cells: [usize; 3]) -> Result<HexMesh, HexError> {
    const NAME: &str = "the cylinder";
    let [n, rings, layers] = cells;
    check_measures(NAME, &[("radius", radius), ("length", length)])?;
    check_cells(NAME, &[n, n.saturating_add(rings.saturating_mul(4)), layers, rings])?;
    let around = 4 * n;
    // From the corner of the core below on the right, counter-clockwise.
    let rim = |step: usize| match (step % around / n, step % n) {
        (0, i) => [n, i],
        (1, i) => [n - i, n],
        (2, i) => [0, n - i],
        (_, i) => [i, 0],
    };
    let key = |[ring, step]: [usize; 2]| match ring {
        0 => OGrid::Core(rim(step)),
        _ => OGrid::Ring([ring, step % around]),
    };
    let core = |at: [usize; 2]| {
        let [u, v] = at.map(|i| 2.0 * unit(i, n) - 1.0);
        let size = u.abs().max(v.abs());
        let angle = match u.abs() > v.abs() {
            _ if size == 0.0 => 0.0,
            true => FRAC_PI_4 * v / u + if u < 0.0 { PI } else { 0.0 },
            false => FRAC_PI_2 * v.signum() - FRAC_PI_4 * u / v,
        };
        // Half way between a square and a disc.
        radius * (0.25 * DVec3::new(u, v, 0.0) + 0.275 * size * direction(angle))
    };
    Layers {
        name: NAME,
        quads: grid([n, n])
            .map(|quad| quad.map(OGrid::Core))
            .chain(grid([rings, around]).map(|quad| quad.map(key)))
            .collect(),
        count: layers,
        place: &|at, k| {
            let flat = match at {
                OGrid::Core(at) => core(at),
                OGrid::Ring([ring, step]) => {
                    let outside = radius * direction(TAU * unit(step, around) - FRAC_PI_4);
                    core(rim(step)).lerp(outside, unit(ring, rings))
                }
            };
            flat + length * unit(k, layers) * DVec3::Z
        },
        groups: &[
            ("side", &|at, _| matches!(at, OGrid::Ring([ring, _]) if ring == rings)),
            ("z-min", &|_, k| k == 0),
            ("z-max", &|_, k| k == layers),
        ],
    }
    .mesh()
}

/// A thick tube about the z axis from z = 0, or the quarter of it in x, y >= 0; `radii` inside and outside, `cells` through
/// its wall, around and along. Groups "inner", "outer", "z-min", "z-max", and of the quarter "y-min", "x-min".
///
/// # Errors
/// [`HexError::Generator`] if a measure is not positive and finite, the radii do not grow, there are fewer than three
/// cells around the whole tube, or a number of cells is zero or too large.
pub fn tube(radii: [f64; 2], length: f64, cells: [usize; 3], is_quarter: bool) -> Result<HexMesh, HexError> {
    const NAME: &str = "the tube";
    let ([inner, outer], [wall, around, layers]) = (radii, cells);
    check_measures(NAME, &[("inner radius", inner), ("wall", outer - inner), ("length", length)])?;
    check_cells(NAME, &cells)?;
    if around < 3 && !is_quarter {
        return Err(HexError::Generator(format!("{NAME}: {around} cells around it, it needs at least three")));
    }
    let key = |[i, j]: [usize; 2]| if is_quarter { [i, j] } else { [i, j % around] };
    let groups: [(&str, Takes<'_, [usize; 2]>); 6] = [
        ("inner", &|[i, _], _| i == 0),
        ("outer", &|[i, _], _| i == wall),
        ("z-min", &|_, k| k == 0),
        ("z-max", &|_, k| k == layers),
        ("y-min", &|[_, j], _| j == 0),
        ("x-min", &|[_, j], _| j == around),
    ];
    Layers {
        name: NAME,
        quads: grid([wall, around]).map(|quad| quad.map(key)).collect(),
        count: layers,
        place: &|[i, j], k| {
            let turn = if is_quarter { FRAC_PI_2 } else { TAU };
            // A quarter turn ends where it should, not a rounding beside it.
            let ahead = if is_quarter && j == around { DVec3::Y } else { direction(turn * unit(j, around)) };
            (inner + (outer - inner) * unit(i, wall)) * ahead + length * unit(k, layers) * DVec3::Z
        },
        groups: &groups[..if is_quarter { 6 } else { 4 }],
    }
    .mesh()
}

/// A box with one corner at the origin, of `cells` bricks, but for `hole[0] x hole[1]` of them in the middle of x and y, which
/// are a tunnel along z: three cells meet at each of its edges. Groups "x-min" to "z-max" and "tunnel".
///
/// # Errors
/// [`HexError::Generator`] if a size is not positive and finite, a number of cells is zero or too large, or the tunnel is
/// not inside the box.
pub fn tunnel(size: [f64; 3], cells: [usize; 3], hole: [usize; 2]) -> Result<HexMesh, HexError> {
    const NAME: &str = "the box with a tunnel";
    let [nx, ny, nz] = cells;
    check_measures(NAME, &[("size in x", size[0]), ("size in y", size[1]), ("size in z", size[2])])?;
    check_cells(NAME, &[nx, ny, nz, hole[0], hole[1]])?;
    if hole[0].saturating_add(2) > nx || hole[1].saturating_add(2) > ny {
        let problem = format!("a tunnel of {hole:?} cells leaves no wall of {nx} x {ny}");
        return Err(HexError::Generator(format!("{NAME}: {problem}")));
    }
    let first = [(nx - hole[0]) / 2, (ny - hole[1]) / 2];
    let inside = |at: [usize; 2], last: usize| (0..2).all(|a| at[a] >= first[a] && at[a] + last <= first[a] + hole[a]);
    Layers {
        name: NAME,
        quads: grid([nx, ny]).filter(|quad| !inside(quad[0], 1)).collect(),
        count: nz,
        place: &|[i, j], k| DVec3::from_array(size) * DVec3::new(unit(i, nx), unit(j, ny), unit(k, nz)),
        groups: &[
            ("x-min", &|[i, _], _| i == 0),
            ("x-max", &|[i, _], _| i == nx),
            ("y-min", &|[_, j], _| j == 0),
            ("y-max", &|[_, j], _| j == ny),
            ("z-min", &|_, k| k == 0),
            ("z-max", &|_, k| k == nz),
            ("tunnel", &|at, _| inside(at, 0)),
        ],
    }
    .mesh()
}
