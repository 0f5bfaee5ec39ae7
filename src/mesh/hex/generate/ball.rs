//! Spherical shells: a cube's surface, blown up.

use super::layers::{Layers, Takes, grid};
use super::{HexError, HexMesh, check_cells, check_measures, unit};
use glam::DVec3;
use std::f64::consts::FRAC_PI_4;

/// A spherical shell about the origin, or the eighth of it in x, y, z >= 0; `radii` inside and outside, `cells` along an edge
/// of the three squares of an eighth, and through the wall. Its surfaces are those of a cube, blown up: three cells meet at
/// the radial edges from its corners. Groups "inner", "outer", and of the eighth "x-min", "y-min", "z-min".
///
/// # Errors
/// [`HexError::Generator`] if a measure is not positive and finite, the radii do not grow, or a number of cells is zero
/// or too large.
pub fn sphere_shell(radii: [f64; 2], cells: [usize; 2], is_eighth: bool) -> Result<HexMesh, HexError> {
    const NAME: &str = "the shell";
    let ([inner, outer], [m, wall]) = (radii, cells);
    check_measures(NAME, &[("inner radius", inner), ("wall", outer - inner)])?;
    check_cells(NAME, &[24, m, m, wall])?;
    // Lattice coordinates run from 0 to 2 m; the eighth has the upper half.
    let n = 2 * m;
    let low = if is_eighth { m } else { 0 };
    let side = |axis: usize, level: usize| {
        grid([n - low, n - low]).map(move |quad| {
            let [a, b, c, d] = quad.map(|[u, v]| {
                let mut at = [level; 3];
                (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (low + u, low + v);
                at
            });
            if level == n { [a, b, c, d] } else { [a, d, c, b] }
        })
    };
    let levels = if is_eighth { &[n][..] } else { &[n, 0] };
    let groups: [(&str, Takes<'_, [usize; 3]>); 5] = [
        ("inner", &|_, k| k == 0),
        ("outer", &|_, k| k == wall),
        ("x-min", &|at, _| at[0] == m),
        ("y-min", &|at, _| at[1] == m),
        ("z-min", &|at, _| at[2] == m),
    ];
    Layers {
        name: NAME,
        quads: levels.iter().flat_map(|&level| (0..3).flat_map(move |axis| side(axis, level))).collect(),
        count: wall,
        place: &|at, k| {
            // Equal angles along great circles.
            let ahead = at.map(|i| match (i == 0, i == n, i == m) {
                (true, ..) => -1.0,
                (_, true, _) => 1.0,
                (.., true) => 0.0,
                _ => (FRAC_PI_4 * (unit(i, m) - 1.0)).tan(),
            });
            (inner + (outer - inner) * unit(k, wall)) * DVec3::from_array(ahead).normalize_or_zero()
        },
        groups: &groups[..if is_eighth { 5 } else { 2 }],
    }
    .mesh()
}
