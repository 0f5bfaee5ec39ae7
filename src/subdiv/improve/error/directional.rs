//! What a cell costs where the second derivatives have preferred directions, and its gradient.
//!
//! The Hessian of the random quadratic is now `L^T Z L` with the Z of [`super::cost`]; with the symmetric matrix `M = L^T L`
//! its entries have `E[H_ij H_kl] = M_ik M_jl + M_il M_jk`, and `E[H H] = M M + tr(M) M`. With the notation there, and
//! `N_ij = e_i . M e_j`, `s_i = sum_j N_ij`, `S = sum_i s_i`, `s = e_1 + e_2 + e_3`,
//!
//! `E int |grad(q - I q)|^2 = V / 20 (sum_i e_i . E[H H] e_i - s . E[H H] s / 4) + V / det A sum_ik B_ik R_ik`,
//! `R_ik = N_ik^2 / 2 - N_ik (s_i + s_k) / 4 + (N_ik S + s_i s_k) / 16`.
//!
//! R is the second moment of what the gradients of q at the centroid and of I q differ by along the edges,
//! `r_i = e_i . H e_i / 2 - e_i . H s / 4`. With M = I this is the cost there.

use super::cost::Shape;
use glam::DVec3;

/// Row sums of the symmetric 3x3 matrix with this diagonal and these entries 23, 13, 12.
#[inline(always)]
fn row_sums([a, b, c]: [f64; 3], [d, h, i]: [f64; 3]) -> [f64; 3] {
    [a + h + i, b + d + i, c + d + h]
}

/// What is needed of M and the edges.
struct Stretched {
    /// M e_i, and M s.
    images: [DVec3; 3],
    sum: DVec3,
    /// N_11, N_22, N_33 and N_23, N_13, N_12.
    squares: [f64; 3],
    products: [f64; 3],
    /// s_i, and S.
    rows: [f64; 3],
    total: f64,
    /// R_11, R_22, R_33 and R_23, R_13, R_12.
    moments: [f64; 3],
    mixed: [f64; 3],
}

/// M x for M by its entries XX YY ZZ XY YZ XZ.
#[inline(always)]
fn apply([xx, yy, zz, xy, yz, xz]: [f64; 6], v: DVec3) -> DVec3 {
    DVec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
}

impl Stretched {
    #[inline(always)]
    fn new(edges: [DVec3; 3], m: [f64; 6]) -> Self {
        let [e, f, g] = edges;
        let images @ [me, mf, mg] = edges.map(|x| apply(m, x));
        let squares @ [a, b, c] = [e.dot(me), f.dot(mf), g.dot(mg)];
        let products @ [d, h, i] = [f.dot(mg), e.dot(mg), e.dot(mf)];
        let rows @ [r, s, t] = row_sums(squares, products);
        let total = r + s + t;
        let moment = |n: f64, p: f64, q: f64| 0.5 * n * n - 0.25 * n * (p + q) + 0.0625 * (n * total + p * q);
        Self {
            images,
            sum: me + mf + mg,
            squares,
            products,
            rows,
            total,
            moments: [moment(a, r, r), moment(b, s, s), moment(c, t, t)],
            mixed: [moment(d, s, t), moment(h, r, t), moment(i, r, s)],
        }
    }

    /// sum_i e_i . (M M + tr(M) M) e_i - s . (M M + tr(M) M) s / 4.
    #[inline(always)]
    fn level(&self, trace: f64) -> f64 {
        let ([me, mf, mg], [a, b, c]) = (self.images, self.squares);
        let squares = me.dot(me) + mf.dot(mf) + mg.dot(mg) - 0.25 * self.sum.dot(self.sum);
        squares + trace * (a + b + c - 0.25 * self.total)
    }
}

impl Shape {
    /// sum_ik B_ik R_ik.
    #[inline(always)]
    fn moment(&self, stretched: &Stretched) -> f64 {
        let ([ba, bb, bc], [bd, bh, bi]) = (self.normals, self.cofactors);
        let ([a, b, c], [d, h, i]) = (stretched.moments, stretched.mixed);
        ba * a + bb * b + bc * c + 2.0 * (bd * d + bh * h + bi * i)
    }

    /// The cost with the matrix M, by its entries XX YY ZZ XY YZ XZ; infinite unless the volume is positive.
    #[inline(always)]
    pub(super) fn cost_along(&self, m: [f64; 6]) -> f64 {
        let stretched = Stretched::new(self.edges, m);
        let (level, moment) = (stretched.level(m[0] + m[1] + m[2]), self.moment(&stretched));
        let value = self.six_volumes * level / 120.0 + moment / (6.0 * self.six_volumes);
        if self.six_volumes > 0.0 { value } else { f64::INFINITY }
    }

    /// Gradient of [`Self::cost_along`] with respect to the vertex from which the edges start.
    ///
    /// As in [`Self::gradient`], `dA_ij = -(e_i + e_j) . dx`, `dN_ij = -(M e_i + M e_j) . dx`, and `ds = -3 dx`. B is the
    /// adjugate of A, so that the sum over `R_ik dB_ik` is that over `W_ik dA_ik` with the polar form W of the adjugate at
    /// A and R.
    #[inline(always)]
    pub(super) fn gradient_along(&self, m: [f64; 6]) -> DVec3 {
        let stretched = Stretched::new(self.edges, m);
        let trace = m[0] + m[1] + m[2];
        let [e, f, g] = self.edges;
        let by_level = -0.5 * (apply(m, stretched.sum) + trace * stretched.sum);
        let by_moment = -2.0 * combine(self.by_adjugate(&stretched), self.edges)
            - combine(self.by_moments(&stretched), stretched.images);
        let area = f.cross(g) + g.cross(e) + e.cross(f);
        let volumes = self.six_volumes;
        let by_volume = self.moment(&stretched) / (6.0 * volumes * volumes) - stretched.level(trace) / 120.0;
        volumes / 120.0 * by_level + by_moment / (6.0 * volumes) + by_volume * area
    }

    /// Row sums of W.
    #[inline(always)]
    fn by_adjugate(&self, stretched: &Stretched) -> [f64; 3] {
        let ([a, b, c], [d, h, i]) = (self.squares, self.products);
        let ([ra, rb, rc], [rd, rh, ri]) = (stretched.moments, stretched.mixed);
        let diagonal = |x: f64, rx: f64, y: f64, ry: f64, p: f64, rp: f64| x * ry + y * rx - 2.0 * p * rp;
        let other =
            |p: f64, rp: f64, q: f64, rq: f64, t: f64, rt: f64, x: f64, rx: f64| p * rq + q * rp - t * rx - x * rt;
        row_sums(
            [diagonal(b, rb, c, rc, d, rd), diagonal(a, ra, c, rc, h, rh), diagonal(a, ra, b, rb, i, ri)],
            [other(h, rh, i, ri, d, rd, a, ra), other(d, rd, i, ri, h, rh, b, rb), other(d, rd, h, rh, i, ri, c, rc)],
        )
    }

    /// Coefficients of -M e_i in the sum over `B_ik dR_ik`.
    #[inline(always)]
    fn by_moments(&self, stretched: &Stretched) -> [f64; 3] {
        let ([ba, bb, bc], [bd, bh, bi]) = (self.normals, self.cofactors);
        let ([a, b, c], [d, h, i]) = (stretched.squares, stretched.products);
        let [r, s, t] = stretched.rows;
        let rows = row_sums(self.normals, self.cofactors);
        let along = [ba * a + bh * h + bi * i, bb * b + bd * d + bi * i, bc * c + bd * d + bh * h];
        let across = [ba * r + bi * s + bh * t, bi * r + bb * s + bd * t, bh * r + bd * s + bc * t];
        let common = 0.125 * (across[0] + across[1] + across[2] - along[0] - along[1] - along[2]);
        let entry =
            |p: f64, q: f64, row: f64, s: f64| 0.5 * p - 0.125 * q + row * (0.125 * stretched.total - 0.5 * s) + common;
        [
            entry(along[0], across[0], rows[0], r),
            entry(along[1], across[1], rows[1], s),
            entry(along[2], across[2], rows[2], t),
        ]
    }
}

#[inline(always)]
fn combine([a, b, c]: [f64; 3], [x, y, z]: [DVec3; 3]) -> DVec3 {
    a * x + b * y + c * z
}

#[cfg(test)]
mod tests {
    use super::super::cost::{
        cost,
        tests::{CELL, exact_error},
    };
    use super::*;
    use glam::DMat3;

    const M: [f64; 6] = [1.3, 0.4, 0.9, -0.3, 0.2, 0.5];

    /// `L^T Z L` over an orthonormal basis of the covariance of Z, with Cholesky's L of M.
    #[test]
    fn the_cost_is_the_mean_error_over_random_hessians_with_these_moments() {
        let matrix = DMat3::from_cols_array_2d(&[[M[0], M[3], M[5]], [M[3], M[1], M[4]], [M[5], M[4], M[2]]]);
        let m = nalgebra::Matrix3::from_fn(|i, j| matrix.col(j)[i]);
        let lower = m.cholesky().unwrap().l();
        let factor = DMat3::from_cols_array(&std::array::from_fn(|k| lower[(k / 3, k % 3)]));
        let mut expected = 0.0;
        for i in 0..3 {
            for j in i..3 {
                let mut z = DMat3::ZERO;
                z.col_mut(j)[i] = 1.0;
                z.col_mut(i)[j] = 1.0;
                let h = factor.transpose() * z * factor;
                expected += if i == j { 2.0 } else { 1.0 } * exact_error(CELL, h);
            }
        }
        let got = Shape::of(CELL).cost_along(M);
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected}");
    }

    #[test]
    fn without_a_direction_it_is_the_cost_and_no_vertex_is_special() {
        let identity = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        assert!((Shape::of(CELL).cost_along(identity) / cost(CELL) - 1.0).abs() < 1e-13);
        let [a, b, c, d] = CELL;
        for same in [[b, a, d, c], [c, d, a, b], [d, c, b, a], [b, c, a, d]] {
            assert!((Shape::of(same).cost_along(M) / Shape::of(CELL).cost_along(M) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let gradient = Shape::of(CELL).gradient_along(M);
        let moved = |d: DVec3| Shape::of([CELL[0] + d, CELL[1], CELL[2], CELL[3]]).cost_along(M);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = (moved(1e-6 * axis) - moved(-1e-6 * axis)) / 2e-6;
            assert!((slope - gradient.dot(axis)).abs() < 1e-7 * gradient.length().max(1.0));
        }
        let identity = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        assert!((Shape::of(CELL).gradient_along(identity) - Shape::of(CELL).gradient()).length() < 1e-12);
    }
}
