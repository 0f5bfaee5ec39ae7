//! Uniform cubic B-splines on an interval, with the natural end condition of Catmull-Clark boundaries.
//!
//! A side without neighbour has a phantom control point c0 = 2 c1 - c2, which is the rule of boundary, crease and corner.

/// The four B-splines on [0, 1] and their derivatives.
pub(super) fn cubic(t: f64) -> [[f64; 2]; 4] {
    let s = 1.0 - t;
    [
        [s * s * s / 6.0, -0.5 * s * s],
        [(3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0, 1.5 * t * t - 2.0 * t],
        [(-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0, -1.5 * t * t + t + 0.5],
        [t * t * t / 6.0, 0.5 * t * t],
    ]
}

/// Values and derivatives of the control points -1, 0, 1, 2 at `t` in the interval from 0 to 1; those of phantoms are zero.
pub(super) fn ended(t: f64, lower: bool, upper: bool) -> [[f64; 2]; 4] {
    let mut b = cubic(t);
    let [first, .., last] = b;
    let mut add = |i: usize, times: f64, end: [f64; 2]| (0..2).for_each(|d| b[i][d] += times * end[d]);
    if !lower {
        add(0, -1.0, first);
        add(1, 2.0, first);
        add(2, -1.0, first);
    }
    if !upper {
        add(3, -1.0, last);
        add(2, 2.0, last);
        add(1, -1.0, last);
    }
    b
}
