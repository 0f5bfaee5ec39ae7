//! Symmetric quadrature, exact to degree five: with linear shape functions, for fields up to degree four.

use glam::DVec3;

/// Two barycentric coordinates of [`FOUR_POINTS`]: one of the first, three of the second.
pub(super) const FOUR_POINTS_OF: [f64; 2] = [0.585_410_196_624_968_5, 0.138_196_601_125_010_5];

/// The points of the rule of degree two on a tetrahedron, of equal weight; one near each vertex.
pub const FOUR_POINTS: [[f64; 4]; 4] = {
    let [a, b] = FOUR_POINTS_OF;
    [[a, b, b, b], [b, a, b, b], [b, b, a, b], [b, b, b, a]]
};

/// Points and weights on a triangle, as fractions of its area. Radon 1948; Stroud, Approximate Calculation of Multiple
/// Integrals, 1971, T2: 5-1.
pub(super) fn triangle([p, q, r]: [DVec3; 3]) -> [([f64; 3], f64, DVec3); 7] {
    let root = 15.0_f64.sqrt();
    let [a, b] = [(6.0 - root) / 21.0, (6.0 + root) / 21.0];
    let [wa, wb] = [(155.0 - root) / 1200.0, (155.0 + root) / 1200.0];
    let third = 1.0 / 3.0;
    let barycentric = [
        ([third; 3], 0.225),
        ([1.0 - 2.0 * a, a, a], wa),
        ([a, 1.0 - 2.0 * a, a], wa),
        ([a, a, 1.0 - 2.0 * a], wa),
        ([1.0 - 2.0 * b, b, b], wb),
        ([b, 1.0 - 2.0 * b, b], wb),
        ([b, b, 1.0 - 2.0 * b], wb),
    ];
    barycentric.map(|(n, w)| (n, w, n[0] * p + n[1] * q + n[2] * r))
}

/// Points and weights on a tetrahedron, as fractions of its volume. Walkington, Quadrature on simplices of arbitrary
/// dimension, 2000: 14 points.
pub(super) fn tetrahedron(p: [DVec3; 4]) -> [([f64; 4], f64, DVec3); 14] {
    let (a, wa) = (0.310_885_919_263_300_6, 0.112_687_925_718_015_85);
    let (b, wb) = (0.092_735_250_310_891_23, 0.073_493_043_116_361_95);
    let (c, wc) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_466);
    std::array::from_fn(|k| {
        let mut n = [a; 4];
        let w = match k {
            0..4 => {
                n[k] = 1.0 - 3.0 * a;
                wa
            }
            4..8 => {
                n = [b; 4];
                n[k - 4] = 1.0 - 3.0 * b;
                wb
            }
            _ => {
                let [i, j] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]][k - 8];
                n = [0.5 - c; 4];
                (n[i], n[j]) = (c, c);
                wc
            }
        };
        (n, w, (0..4).map(|i| n[i] * p[i]).sum())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// The mean of `l0^a l1^b l2^c l3^d` over a simplex of dimension d is `d! a! b! c! .. / (a + b + c + .. + d)!`.
    #[test]
    fn monomials_up_to_degree_five_are_exact() {
        let powers = |degree: i32| {
            let all = (0..=degree).flat_map(move |a| (0..=degree - a).map(move |b| (a, b)));
            all.flat_map(move |(a, b)| (0..=degree - a - b).map(move |c| [a, b, c]))
        };
        for [a, b, c] in powers(5) {
            let moments = [factorial(a), factorial(b), factorial(c)].iter().product::<f64>();
            let solid: f64 = tetrahedron([DVec3::ZERO; 4])
                .iter()
                .map(|(n, w, _)| w * n[0].powi(a) * n[1].powi(b) * n[2].powi(c))
                .sum();
            assert!((solid - 6.0 * moments / factorial(a + b + c + 3)).abs() < 1e-15, "{a} {b} {c}: {solid}");
            let flat: f64 =
                triangle([DVec3::ZERO; 3]).iter().map(|(n, w, _)| w * n[0].powi(a) * n[1].powi(b) * n[2].powi(c)).sum();
            assert!((flat - 2.0 * moments / factorial(a + b + c + 2)).abs() < 1e-15, "{a} {b} {c}: {flat}");
        }
    }
}
