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

/// Points of even spread in a simplex of `N` corners, in barycentric coordinates: the centres of those of the `parts^(N-1)` like parts
/// it is cut into that are not turned.
pub(super) fn lattice<const N: usize>(parts: usize) -> Vec<[f64; N]> {
    let centre = |corner: &[usize; N]| corner.map(|i| (i as f64 + 1.0 / N as f64) / parts as f64);
    let mut corners = vec![[0; N]];
    for k in 0..N {
        let left = |c: &[usize; N]| parts - 1 - c.iter().sum::<usize>();
        let next = |c: [usize; N]| {
            let range = if k + 1 == N { left(&c)..left(&c) + 1 } else { 0..left(&c) + 1 };
            range.map(move |i| std::array::from_fn(|j| if j == k { i } else { c[j] }))
        };
        corners = corners.into_iter().flat_map(next).collect();
    }
    corners.iter().map(centre).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// As many as there are, inside, and with the mean of all linear functions.
    #[test]
    fn lattices_are_spread_evenly() {
        for parts in [1, 2, 5] {
            let [solid, flat] = [lattice::<4>(parts).len(), lattice::<3>(parts).len()];
            assert_eq!([solid, flat], [parts * (parts + 1) * (parts + 2) / 6, parts * (parts + 1) / 2]);
            for l in lattice::<4>(parts) {
                assert!(l.iter().all(|l| *l > 0.0) && (l.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{l:?}");
            }
            for i in 0..3 {
                let mean = lattice::<3>(parts).iter().map(|l| l[i]).sum::<f64>() / flat as f64;
                assert!((mean - 1.0 / 3.0).abs() < 1e-14, "{mean}");
            }
        }
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
