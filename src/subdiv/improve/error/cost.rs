//! What a cell costs: the expected interpolation error of a random quadratic on it, and its gradient.
//!
//! Let q be a quadratic with a random Hessian H whose entries satisfy `E[H_ij H_kl] = d_ik d_jl + d_il d_jk` (no
//! direction is preferred), and I q its linear interpolant at the vertices. On a tetrahedron with volume V and the edges
//! e_1, e_2, e_3 from one of its vertices, let A be their Gram matrix `A_ij = e_i . e_j` and B its adjugate; the
//! gradients of the barycentric coordinates have the Gram matrix `B / det A`, and `det A = 36 V^2`. Then
//!
//! `E int |grad(q - I q)|^2 = V sum_edges |e|^2 / 20 + V (sum_ij B_ij A_ij^2 / (2 det A) - |e_1 + e_2 + e_3|^2 / 4)`:
//!
//! the first term is the part that varies linearly in the cell, the second the error of the interpolant's constant
//! gradient. It scales with length^5, and grows without bound when the cell flattens.
//!
//! Everything here is free of branches, so that loops over cells become vector instructions.

use super::super::lanes::least;
use glam::DVec3;

/// The cost of the tetrahedron; infinite unless its volume is positive.
pub fn cost(points: [DVec3; 4]) -> f64 {
    Shape::of(points).cost()
}

/// A tetrahedron by its edges from one vertex, positive if their triple product is.
pub(super) struct Shape {
    pub(super) edges: [DVec3; 3],
    /// Six times the volume.
    pub(super) six_volumes: f64,
    /// A_11, A_22, A_33.
    pub(super) squares: [f64; 3],
    /// A_23, A_13, A_12: the product without the first, second, third edge.
    pub(super) products: [f64; 3],
    /// B_11, B_22, B_33: the squared lengths of the normals of the faces at the vertex.
    pub(super) normals: [f64; 3],
    /// B_23, B_13, B_12.
    pub(super) cofactors: [f64; 3],
}

impl Shape {
    pub(super) fn of([p, a, b, c]: [DVec3; 4]) -> Self {
        Self::new([a - p, b - p, c - p])
    }

    #[inline(always)]
    pub(super) fn new(edges: [DVec3; 3]) -> Self {
        let [e, f, g] = edges;
        let (squares, products) = ([e.dot(e), f.dot(f), g.dot(g)], [f.dot(g), e.dot(g), e.dot(f)]);
        let ([a, b, c], [d, h, i]) = (squares, products);
        Self {
            edges,
            six_volumes: e.dot(f.cross(g)),
            squares,
            products,
            normals: [b * c - d * d, a * c - h * h, a * b - i * i],
            cofactors: [h * i - a * d, i * d - b * h, d * h - c * i],
        }
    }

    /// Sum of |e|^2 / 20 over the edges, less |e_1 + e_2 + e_3|^2 / 4.
    #[inline(always)]
    fn level(&self) -> f64 {
        let ([a, b, c], [d, h, i]) = (self.squares, self.products);
        let (trace, off) = (a + b + c, d + h + i);
        (3.0 * trace - 2.0 * off) / 20.0 - (trace + 2.0 * off) / 4.0
    }

    /// sum_ij B_ij A_ij^2.
    #[inline(always)]
    fn constant(&self) -> f64 {
        let ([a, b, c], [d, h, i]) = (self.squares, self.products);
        let ([ba, bb, bc], [bd, bh, bi]) = (self.normals, self.cofactors);
        ba * a * a + bb * b * b + bc * c * c + 2.0 * (bd * d * d + bh * h * h + bi * i * i)
    }

    /// The cost; infinite unless the volume is positive.
    #[inline(always)]
    pub(super) fn cost(&self) -> f64 {
        let value = self.six_volumes * self.level() / 6.0 + self.constant() / (12.0 * self.six_volumes);
        if self.six_volumes > 0.0 { value } else { f64::INFINITY }
    }

    /// Square of the smallest sine of the dihedral angles; for positive volumes.
    ///
    /// `sin = 6 V |e| / (|N_k| |N_l|)` at the edge between the faces k and l.
    #[inline(always)]
    pub(super) fn squared_sine(&self) -> f64 {
        let ([a, b, c], [d, h, i]) = (self.squares, self.products);
        let ([ba, bb, bc], [bd, bh, bi]) = (self.normals, self.cofactors);
        let opposite = ba + bb + bc + 2.0 * (bd + bh + bi);
        let at_vertex = least(a / (bb * bc), least(b / (ba * bc), c / (ba * bb)));
        let at_face = least((b + c - 2.0 * d) / ba, least((a + c - 2.0 * h) / bb, (a + b - 2.0 * i) / bc));
        self.six_volumes * self.six_volumes * least(at_vertex, at_face / opposite)
    }

    /// Gradient of the cost with respect to the vertex from which the edges start.
    ///
    /// By the product rule: all edges lose what the vertex gains, so `dA_ij = -(e_i + e_j) . dx`, and
    /// `d(6V) = -(e_2 x e_3 + e_3 x e_1 + e_1 x e_2) . dx`.
    #[inline(always)]
    pub(super) fn gradient(&self) -> DVec3 {
        let ([a, b, c], [d, h, i]) = (self.squares, self.products);
        let ([ba, bb, bc], [bd, bh, bi]) = (self.normals, self.cofactors);
        let [e, f, g] = self.edges;
        let (by_level, by_constant) = (self.six_volumes / 6.0, 1.0 / (12.0 * self.six_volumes));
        // Derivatives of `level` are -0.1 for each square and -0.6 for each product.
        let square = |b: f64, x: f64, y: f64, z: f64, p: f64| {
            by_constant * (2.0 * b * x + y * z * (y + z) - 2.0 * p * p * p) - 0.1 * by_level
        };
        let product = |b: f64, p: f64, x: f64, q: f64, r: f64| {
            by_constant * (4.0 * b * p - 2.0 * p * x * (p + x) + 2.0 * q * r * (q + r)) - 0.6 * by_level
        };
        let (ta, tb, tc) = (square(ba, a, b, c, d), square(bb, b, a, c, h), square(bc, c, a, b, i));
        let (td, th, ti) = (product(bd, d, a, h, i), product(bh, h, b, d, i), product(bi, i, c, d, h));
        let by_volume = self.level() / 6.0 - by_constant * self.constant() / self.six_volumes;
        let area = f.cross(g) + g.cross(e) + e.cross(f);
        -((2.0 * ta + th + ti) * e + (2.0 * tb + td + ti) * f + (2.0 * tc + td + th) * g + by_volume * area)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::quality;

    pub(in super::super) const CELL: [DVec3; 4] =
        [DVec3::new(-0.2, 0.1, 0.05), DVec3::new(1.0, 0.1, 0.2), DVec3::new(0.3, 1.1, -0.1), DVec3::new(0.2, 0.4, 0.9)];

    /// Integral of |grad(q - I q)|^2 for q = x.H.x / 2 by a rule exact for quadratics.
    pub(in super::super) fn exact_error(x: [DVec3; 4], h: glam::DMat3) -> f64 {
        let six_volumes = 6.0 * quality::volume(x);
        let normals = quality::face_normals(x);
        let value = |p: DVec3| 0.5 * p.dot(h * p);
        let interpolant = (0..4).fold(DVec3::ZERO, |g, k| g - normals[k] / six_volumes * value(x[k]));
        let (a, b) = ((5.0 + 3.0 * 5.0_f64.sqrt()) / 20.0, (5.0 - 5.0_f64.sqrt()) / 20.0);
        let at = |k: usize| (0..4).fold(DVec3::ZERO, |p, l| p + if k == l { a } else { b } * x[l]);
        (0..4).map(|k| six_volumes / 24.0 * (h * at(k) - interpolant).length_squared()).sum()
    }

    #[test]
    fn the_cost_is_the_mean_error_over_random_hessians() {
        // The expectation of a quadratic form in H is its sum over an orthonormal basis of covariance: the diagonal
        // entries have variance 2, the others 1.
        let mut expected = 0.0;
        for i in 0..3 {
            for j in i..3 {
                let mut h = glam::DMat3::ZERO;
                h.col_mut(j)[i] = 1.0;
                h.col_mut(i)[j] = 1.0;
                expected += if i == j { 2.0 } else { 1.0 } * exact_error(CELL, h);
            }
        }
        assert!((cost(CELL) / expected - 1.0).abs() < 1e-12, "{} {expected}", cost(CELL));
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let [p, a, b, c] = CELL;
        let shape = Shape::new([a - p, b - p, c - p]);
        let gradient = shape.gradient();
        assert!((shape.squared_sine().sqrt() - quality::min_sine(CELL)).abs() < 1e-14);
        let moved = |d: DVec3| cost([CELL[0] + d, CELL[1], CELL[2], CELL[3]]);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = (moved(1e-6 * axis) - moved(-1e-6 * axis)) / 2e-6;
            assert!((slope - gradient.dot(axis)).abs() < 1e-7 * gradient.length().max(1.0));
        }
    }

    #[test]
    fn flat_and_inverted_cells_are_infinitely_bad_and_scaling_is_by_the_fifth_power() {
        let [a, b, c, d] = CELL;
        assert!(cost([b, a, c, d]).is_infinite());
        assert!(cost([a, b, c, a + 0.3 * (b - a) + 0.3 * (c - a)]).is_infinite() || cost([a, b, c, a]).is_infinite());
        assert!((cost(CELL.map(|p| 3.0 * p)) / cost(CELL) / 243.0 - 1.0).abs() < 1e-12);
    }
}
