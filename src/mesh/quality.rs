//! Shape of tetrahedra: volume, dihedral angles, and the statistics of a mesh.

use super::TetMesh;
use glam::DVec3;

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
    dihedral_angles(p).into_iter().fold(f64::INFINITY, f64::min)
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
        inverted: 0,
    };
    let mut q = (0..mesh.tets().len()).fold(start, |q, t| {
        let angle = min_dihedral(mesh.cell_points(t));
        Quality {
            worst: q.worst.min(angle),
            average: q.average + angle,
            best: q.best.max(angle),
            inverted: q.inverted + usize::from(mesh.cell_volume(t) <= 0.0),
            ..q
        }
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
