//! The part of a tetrahedron inside a box, cut into tetrahedra.
//!
//! All is said in barycentric coordinates of the cell, so that fields are interpolated without looking for the place.

use glam::DVec3;
use nalgebra::Matrix4;

/// Barycentric coordinates in a cell.
pub(super) type Weights = [f64; 4];

/// A tetrahedron inside a cell.
pub(super) type Piece = [Weights; 4];

/// The whole cell.
pub(super) const WHOLE: Piece =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The pieces of the cell with corners `x` that lie in the box from `min` to `max`.
pub(super) fn inside(x: [DVec3; 4], min: DVec3, max: DVec3) -> Vec<Piece> {
    let mut pieces = vec![WHOLE];
    for axis in 0..3 {
        for heights in [x.map(|x| x[axis] - min[axis]), x.map(|x| max[axis] - x[axis])] {
            if heights.iter().all(|h| *h >= 0.0) {
                continue;
            }
            let whole = std::mem::take(&mut pieces);
            whole.into_iter().for_each(|piece| cut(piece, &heights, &mut pieces));
        }
    }
    pieces
}

/// The eight pieces of a piece that is cut in the middle of its edges.
pub(super) fn halves([a, b, c, d]: Piece) -> [Piece; 8] {
    let middle = |p: Weights, q: Weights| -> Weights { std::array::from_fn(|i| 0.5 * (p[i] + q[i])) };
    let [ab, ac, ad] = [b, c, d].map(|p| middle(a, p));
    let [bc, bd, cd] = [middle(b, c), middle(b, d), middle(c, d)];
    let corners = [[a, ab, ac, ad], [ab, b, bc, bd], [ac, bc, c, cd], [ad, bd, cd, d]];
    // The octahedron between them, around its diagonal from ab to cd.
    let around = [[ac, ad], [ad, bd], [bd, bc], [bc, ac]].map(|[p, q]| [ab, cd, p, q]);
    std::array::from_fn(|k| if k < 4 { corners[k] } else { around[k - 4] })
}

/// Volume of a piece over that of its cell.
pub(super) fn share(piece: &Piece) -> f64 {
    Matrix4::from_fn(|i, j| piece[i][j]).determinant().abs()
}

/// The value of a linear function at a point, from its values at the corners.
pub(super) fn linear(values: &[f64; 4], at: &Weights) -> f64 {
    values.iter().zip(at).map(|(v, w)| v * w).sum()
}

/// Adds the part of a piece where the linear function `heights` is not negative.
fn cut(piece: Piece, heights: &[f64; 4], pieces: &mut Vec<Piece>) {
    let (above, below): (Vec<Weights>, Vec<Weights>) = piece.into_iter().partition(|w| linear(heights, w) >= 0.0);
    let between = |a: &Weights, b: &Weights| -> Weights {
        let (ha, hb) = (linear(heights, a), linear(heights, b));
        let s = ha / (ha - hb);
        std::array::from_fn(|i| a[i] + s * (b[i] - a[i]))
    };
    match (&above[..], &below[..]) {
        ([..], []) => pieces.push(piece),
        ([a], [p, q, r]) => pieces.push([*a, between(a, p), between(a, q), between(a, r)]),
        ([a, b], [p, q]) => {
            pieces.extend(prism([*a, between(a, p), between(a, q)], [*b, between(b, p), between(b, q)]));
        }
        ([a, b, c], [p]) => pieces.extend(prism([*a, *b, *c], [between(a, p), between(b, p), between(c, p)])),
        _ => {}
    }
}

/// The three tetrahedra of a prism.
fn prism([a, b, c]: [Weights; 3], [p, q, r]: [Weights; 3]) -> [Piece; 3] {
    [[a, b, c, p], [b, c, p, q], [c, p, q, r]]
}
