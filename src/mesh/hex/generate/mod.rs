//! Hexahedral meshes made from a few numbers.

mod ball;
mod layers;
mod plans;
mod tets;

pub use ball::sphere_shell;
pub use plans::{cylinder, prism, tube, tunnel};
pub use tets::from_tets;

use super::{HexError, HexMesh};
use glam::DVec3;

/// Most cells a generator makes.
const MAX_CELLS: usize = 20_000_000;

/// A box with one corner at the origin, of `cells[0] x cells[1] x cells[2]` bricks, with the groups "x-min" to "z-max".
///
/// # Errors
/// [`HexError::Generator`] if a size is not positive and finite, a number of cells is zero, or there would be more than
/// 20 million cells.
pub fn box_hexes(size: [f64; 3], cells: [usize; 3]) -> Result<HexMesh, HexError> {
    let count = cells.into_iter().try_fold(1_usize, usize::checked_mul);
    if !count.is_some_and(|n| n > 0 && n <= MAX_CELLS) || !size.iter().all(|s| *s > 0.0 && s.is_finite()) {
        return Err(HexError::Generator(format!(
            "a box of size {size:?} and {cells:?} cells: sizes must be positive, and there must be 1 to {MAX_CELLS} cells"
        )));
    }
    let [nx, ny, nz] = cells;
    let at = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let place = |i: usize, axis: usize| size[axis] * i as f64 / cells[axis] as f64;
    let grid =
        |n: [usize; 3]| (0..n[2]).flat_map(move |k| (0..n[1]).flat_map(move |j| (0..n[0]).map(move |i| [i, j, k])));
    let points = grid([nx + 1, ny + 1, nz + 1]).map(|[i, j, k]| DVec3::new(place(i, 0), place(j, 1), place(k, 2)));
    let corner = |[i, j, k]: [usize; 3]| std::array::from_fn(|c| at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
    let lattice = |v: u32| {
        let v = v as usize;
        [v % (nx + 1), v / (nx + 1) % (ny + 1), v / (nx + 1) / (ny + 1)]
    };
    HexMesh::tagged(
        points.collect(),
        grid(cells).map(corner).collect(),
        &[
            ("x-min", &|v| lattice(v)[0] == 0),
            ("x-max", &|v| lattice(v)[0] == nx),
            ("y-min", &|v| lattice(v)[1] == 0),
            ("y-max", &|v| lattice(v)[1] == ny),
            ("z-min", &|v| lattice(v)[2] == 0),
            ("z-max", &|v| lattice(v)[2] == nz),
        ],
    )
}

/// Refuses measures that are not positive and finite.
fn check_measures(name: &str, measures: &[(&str, f64)]) -> Result<(), HexError> {
    match measures.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        Some((what, x)) => Err(HexError::Generator(format!("{name}: the {what} is {x}, it must be positive"))),
        None => Ok(()),
    }
}

/// Refuses numbers of cells of which one is zero, or whose product is too large.
fn check_cells(name: &str, factors: &[usize]) -> Result<(), HexError> {
    match factors.iter().try_fold(1_usize, |product, n| product.checked_mul(*n)) {
        Some(0) => Err(HexError::Generator(format!("{name}: each number of cells must be one at least"))),
        Some(count) if count <= MAX_CELLS => Ok(()),
        _ => Err(HexError::Generator(format!("{name}: more than {MAX_CELLS} cells"))),
    }
}

/// The share `i / n`.
fn unit(i: usize, n: usize) -> f64 {
    i as f64 / n as f64
}
