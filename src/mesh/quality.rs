//! Shape of tetrahedra: volume, dihedral angles, and the statistics of a mesh.

use super::TetMesh;
use glam::DVec3;
use rayon::prelude::*;

/// Volume of the tetrahedron; positive if `d` is on the side of `(b - a) x (c - a)`.
#[must_use]
pub fn volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).cross(c - a).dot(d - a) / 6.0
}

/// Whether the volume is positive by more than rounding: above 1e-14 of the cube of the longest edge.
#[must_use]
pub fn is_positive(p: [DVec3; 4]) -> bool {
    let longest = EDGES.iter().map(|&[i, j]| p[i].distance_squared(p[j])).fold(0.0, f64::max).sqrt();
    volume(p) > 1e-14 * longest.powi(3)
}

/// Vertex pairs of the six edges of a tetrahedron; edge `i` is opposite to edge `5 - i`.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Vertices of the face opposite to each vertex, counter-clockwise seen from outside.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Sines of the six dihedral angles, in the order of [`EDGES`], signed by the volume.
///
/// With N_k the (unnormalised) normals of the two faces at edge e: `sin = 6 V |e| / (|N_1| |N_2|)`. All zero when a face
/// is degenerate.
#[must_use]
pub fn dihedral_sines(p: [DVec3; 4]) -> [f64; 6] {
    let normals = face_normals(p).map(DVec3::length);
    let six_volumes = 6.0 * volume(p);
    EDGES.map(|[i, j]| {
        // The faces at edge ij are those opposite to the two other vertices.
        let [k, l] = other_two(i, j);
        let denominator = normals[k] * normals[l];
        if denominator > 0.0 { six_volumes * (p[j] - p[i]).length() / denominator } else { 0.0 }
    })
}

/// The smallest signed sine of the dihedral angles: the quality measure of Burkhart, Hamann and Umlauf 2010, section
/// 2.3. Positive exactly for positively oriented cells; 0.943 for the regular tetrahedron.
#[must_use]
pub fn min_sine(p: [DVec3; 4]) -> f64 {
    let sine = positive_min_sine(p);
    // Inverted: the most negative sine belongs to the largest ratio.
    if sine > 0.0 { sine } else { dihedral_sines(p).into_iter().fold(f64::INFINITY, f64::min) }
}

/// [`min_sine`] of a positive cell, quickly; zero for others.
#[must_use]
pub fn positive_min_sine([a, b, c, d]: [DVec3; 4]) -> f64 {
    let (ab, ac, ad, bc, bd, cd) = (b - a, c - a, d - a, c - b, d - b, d - c);
    let opposite_d = ab.cross(ac);
    let six_volumes = opposite_d.dot(ad);
    if six_volumes <= 0.0 {
        return 0.0;
    }
    let [na, nb, nc, nd] = [bc.cross(bd), ac.cross(ad), ab.cross(ad), opposite_d].map(DVec3::length_squared);
    // |e|^2 / (n_k n_l) with both sides of the fraction multiplied by the two other n: one comparison an edge, no division.
    let least = (ab.length_squared() * (na * nb))
        .min(ac.length_squared() * (na * nc))
        .min(ad.length_squared() * (na * nd))
        .min(bc.length_squared() * (nb * nc))
        .min(bd.length_squared() * (nb * nd))
        .min(cd.length_squared() * (nc * nd));
    let sine = six_volumes * (least / (na * nb) / (nc * nd)).sqrt();
    if sine.is_finite() { sine } else { 0.0 }
}

/// The six dihedral angles in degrees, in the order of [`EDGES`].
#[must_use]
pub fn dihedral_angles(p: [DVec3; 4]) -> [f64; 6] {
    let n = face_normals(p);
    EDGES.map(|[i, j]| {
        let [k, l] = other_two(i, j);
        // Between outward normals lies the supplement of the dihedral angle.
        let sine = n[k].cross(n[l]).length();
        sine.atan2(-n[k].dot(n[l])).to_degrees()
    })
}

/// The smallest dihedral angle in degrees.
#[must_use]
pub fn min_dihedral(p: [DVec3; 4]) -> f64 {
    let six_volumes = 6.0 * volume(p);
    if six_volumes <= 0.0 {
        return dihedral_angles(p).into_iter().fold(f64::INFINITY, f64::min);
    }
    // The sine at edge e is 6 V |e| and the cosine -n_k . n_l, times the same length: the smallest angle has the largest
    // -n_k . n_l / |e|, and only that angle is computed.
    let n = face_normals(p);
    let mut least = (f64::NEG_INFINITY, 1.0, 0.0);
    for [i, j] in EDGES {
        let [k, l] = other_two(i, j);
        let (cosine, square) = (-n[k].dot(n[l]), p[i].distance_squared(p[j]));
        let signed = cosine * cosine.abs() / square;
        if signed > least.0 {
            least = (signed, cosine, square);
        }
    }
    let (_, cosine, square) = least;
    (six_volumes * square.sqrt()).atan2(cosine).to_degrees()
}

/// The smallest solid angle at a vertex, in steradians, signed by the volume: 0.551 for the regular tetrahedron, zero for a
/// flat one.
///
/// With edges a, b, c at a vertex, `tan(omega / 2) = det(a, b, c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)` (Van Oosterom
/// and Strackee 1983).
#[must_use]
pub fn min_solid_angle(p: [DVec3; 4]) -> f64 {
    let angle = |v: usize| {
        // Clockwise seen from the vertex: the determinant is six volumes.
        let [a, b, c] = FACES[v].map(|w| p[w] - p[v]);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(denominator)
    };
    (0..4).map(angle).fold(f64::INFINITY, f64::min)
}

/// The shortest over the longest edge: 1 for the regular tetrahedron, 0 where two vertices coincide. It says nothing of the
/// volume: flat cells may have ratios up to 0.707 (a square).
#[must_use]
pub fn edge_ratio(p: [DVec3; 4]) -> f64 {
    let squares = EDGES.map(|[i, j]| p[i].distance_squared(p[j]));
    let longest = squares.into_iter().fold(0.0, f64::max);
    let shortest = squares.into_iter().fold(f64::INFINITY, f64::min);
    if longest > 0.0 { (shortest / longest).sqrt() } else { 0.0 }
}

/// [`min_sine`] of the regular tetrahedron, sqrt(8) / 3.
pub const REGULAR_SINE: f64 = 0.942_809_041_582_063_4;

/// [`min_dihedral`] of the regular tetrahedron, acos(1/3) in degrees.
pub const REGULAR_DIHEDRAL: f64 = 70.528_779_365_509_3;

/// [`min_solid_angle`] of the regular tetrahedron, 3 acos(1/3) - pi.
pub const REGULAR_SOLID_ANGLE: f64 = 0.551_285_598_432_530_8;

/// A number for the shape of the tetrahedron of these corners.
pub type CellMeasure = fn([DVec3; 4]) -> f64;

/// The minimum dihedral angle of each cell.
#[must_use]
pub fn min_dihedrals(mesh: &TetMesh) -> Vec<f64> {
    (0..mesh.tets().len()).into_par_iter().with_min_len(1024).map(|t| min_dihedral(mesh.cell_points(t))).collect()
}

/// Numbers of cells by their minimum dihedral angle, in 36 bins of two degrees from 0.
#[must_use]
pub fn dihedral_counts(mesh: &TetMesh) -> Vec<usize> {
    let mut counts = vec![0; 36];
    for angle in min_dihedrals(mesh) {
        // No minimum dihedral angle exceeds that of the regular tetrahedron, 70.5 degrees.
        counts[((angle / 2.0) as usize).min(35)] += 1;
    }
    counts
}

/// The worst and the mean value of a measure over the cells of a mesh.
#[must_use]
pub fn worst_and_mean(mesh: &TetMesh, measure: CellMeasure) -> (f64, f64) {
    let values = (0..mesh.tets().len()).map(|t| measure(mesh.cell_points(t)));
    let (worst, sum) = values.fold((f64::INFINITY, 0.0), |(worst, sum), x| (x.min(worst), sum + x));
    (worst, sum / mesh.tets().len().max(1) as f64)
}

/// Outward normals (length twice the area) of the faces opposite to each vertex of a positive tetrahedron.
#[must_use]
pub fn face_normals(p: [DVec3; 4]) -> [DVec3; 4] {
    FACES.map(|[i, j, k]| (p[j] - p[i]).cross(p[k] - p[i]))
}

const fn other_two(i: usize, j: usize) -> [usize; 2] {
    match (i, j) {
        (0, 1) => [2, 3],
        (0, 2) => [1, 3],
        (0, 3) => [1, 2],
        (1, 2) => [0, 3],
        (1, 3) => [0, 2],
        _ => [0, 1],
    }
}

/// Statistics of a mesh: minimum dihedral angles of its cells (degrees) and valences (cells at a vertex).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Smallest over the cells.
    pub worst: f64,
    /// Mean over the cells.
    pub average: f64,
    /// Largest over the cells.
    pub best: f64,
    /// Most cells at a vertex.
    pub max_valence: usize,
    /// Mean number of cells at a vertex.
    pub average_valence: f64,
    /// Share of the vertices with more than 50 cells, which Burkhart, Hamann and Umlauf 2010 give too.
    pub valence_above_50: f64,
    /// Cells whose volume is not positive.
    pub inverted: usize,
}

/// Computes the statistics of a mesh.
#[must_use]
pub fn quality(mesh: &TetMesh) -> Quality {
    let mut valence = vec![0_usize; mesh.points().len()];
    for v in mesh.tets().iter().flatten() {
        valence[*v as usize] += 1;
    }
    let used = valence.iter().filter(|&&n| n > 0).count().max(1);
    let start = Quality {
        worst: f64::INFINITY,
        average: 0.0,
        best: 0.0,
        max_valence: valence.iter().copied().max().unwrap_or(0),
        average_valence: 4.0 * mesh.tets().len() as f64 / used as f64,
        valence_above_50: valence.iter().filter(|&&n| n > 50).count() as f64 / used as f64,
        inverted: (0..mesh.tets().len()).into_par_iter().filter(|&t| mesh.cell_volume(t) <= 0.0).count(),
    };
    let mut q = min_dihedrals(mesh).into_iter().fold(start, |q, angle| Quality {
        worst: q.worst.min(angle),
        average: q.average + angle,
        best: q.best.max(angle),
        ..q
    });
    q.average /= mesh.tets().len().max(1) as f64;
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGULAR: [DVec3; 4] = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(-1.0, -1.0, 1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(1.0, -1.0, -1.0),
    ];

    fn regular() -> [DVec3; 4] {
        let [a, b, c, d] = REGULAR;
        if volume(REGULAR) > 0.0 { REGULAR } else { [a, b, d, c] }
    }

    #[test]
    fn the_regular_tetrahedron_has_the_known_angle() {
        let angle = (1.0_f64 / 3.0).acos().to_degrees();
        for a in dihedral_angles(regular()) {
            assert!((a - angle).abs() < 1e-12, "{a}");
        }
        assert!((min_sine(regular()) - angle.to_radians().sin()).abs() < 1e-14);
    }

    const MEASURES: [(CellMeasure, f64); 4] = [
        (min_sine, REGULAR_SINE),
        (min_dihedral, REGULAR_DIHEDRAL),
        (min_solid_angle, REGULAR_SOLID_ANGLE),
        (edge_ratio, 1.0),
    ];

    #[test]
    fn measures_are_largest_for_the_regular_tetrahedron_whatever_its_place_and_size() {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let moved = |p: [DVec3; 4]| p.map(|x| 37.0 * (turn * x) + DVec3::new(3.0, -20.0, 0.5));
        for (measure, of_regular) in MEASURES {
            for p in [regular(), moved(regular())] {
                assert!((measure(p) / of_regular - 1.0).abs() < 1e-12, "{}", measure(p));
            }
            for i in 0..4 {
                for shift in [DVec3::X, DVec3::Y, DVec3::Z] {
                    let mut p = regular();
                    p[i] += 0.2 * shift;
                    assert!(measure(p) < of_regular - 1e-3, "vertex {i} by {shift}: {}", measure(p));
                    assert!((measure(moved(p)) - measure(p)).abs() < 1e-10 * of_regular);
                }
            }
        }
    }

    #[test]
    fn flat_cells_are_worth_nothing_to_all_measures_but_the_edge_ratio() {
        let square =
            |h: f64| [DVec3::ZERO, DVec3::new(1.0, 0.0, h), DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, h)];
        for h in [1e-4, 1e-6] {
            let [a, b, c, d] = square(h);
            let sliver = if volume([a, b, c, d]) > 0.0 { [a, b, c, d] } else { [a, b, d, c] };
            assert!(volume(sliver) > 0.0);
            for (measure, of_regular) in &MEASURES[..3] {
                let share = measure(sliver) / of_regular;
                assert!(share > 0.0 && share < 10.0 * h, "height {h}: {share}");
            }
            assert!((edge_ratio(sliver) - 0.5_f64.sqrt()).abs() < 1e-6);
        }
        let [a, b, c, _] = regular();
        assert_eq!(edge_ratio([a, b, c, c]), 0.0);
    }

    #[test]
    fn the_solid_angles_of_a_corner_of_a_cube_are_known() {
        // Three right angles: an octant at the origin; the other three are equal by symmetry.
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        // By Girard's theorem, with the dihedral angles 90, acos(1/sqrt(3)), acos(1/sqrt(3)) at such a vertex.
        let expected = 2.0 * (1.0_f64 / 3.0_f64.sqrt()).acos() - std::f64::consts::FRAC_PI_2;
        assert!((min_solid_angle(corner) - expected).abs() < 1e-14);
        let [a, b, c, d] = corner;
        assert!(min_solid_angle([a, b, d, c]) < 0.0);
    }

    #[test]
    fn the_smallest_angle_is_the_smallest_of_the_six() {
        let apex = |x: f64, h: f64| [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(x, 0.3, h)];
        for (x, h) in [(0.2, 1.0), (0.5, 1e-3), (-3.0, 0.1), (40.0, 2.0), (0.3, 1e-7), (0.3, -0.2)] {
            let p = apex(x, h);
            let least = dihedral_angles(p).into_iter().fold(f64::INFINITY, f64::min);
            assert!((min_dihedral(p) / least - 1.0).abs() < 1e-8, "{x} {h}: {} {least}", min_dihedral(p));
        }
    }

    #[test]
    fn sines_are_the_sines_of_the_angles_and_change_sign_with_orientation() {
        let p = [
            DVec3::new(0.1, 0.2, 0.0),
            DVec3::new(1.3, -0.1, 0.2),
            DVec3::new(0.2, 0.9, -0.3),
            DVec3::new(0.4, 0.1, 0.35),
        ];
        assert!(volume(p) > 0.0);
        for (s, a) in dihedral_sines(p).into_iter().zip(dihedral_angles(p)) {
            assert!((s - a.to_radians().sin()).abs() < 1e-13);
        }
        let least = dihedral_sines(p).into_iter().fold(f64::INFINITY, f64::min);
        assert!((min_sine(p) - least).abs() < 1e-14);
        let mirrored = [p[0], p[1], p[3], p[2]];
        assert!(min_sine(mirrored) < 0.0);
        // dihedral at edge 01 of a corner tetrahedron is a right angle
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert!((dihedral_angles(corner)[0] - 90.0).abs() < 1e-12);
    }
}
