//! Interpolating sqrt(3) subdivision of the surfaces (Labsik and Greiner 2000): where the centre of a face goes.
//!
//! Old vertices stay. The point of a face whose corners are regular (six faces around) is the 12-point stencil: 32/81 of
//! each corner, -1/81 of each vertex across an edge, -2/81 of each of the six vertices next to those around the corners.
//! On the regular lattice it reproduces cubics.
//!
//! A corner of valence n /= 6 gives the point by a rule on its own ring r_0 ... r_(n-1), where r_0 and r_1 belong to the
//! face; a face with several such corners takes the mean. With h = 2/3 cos(pi / n) and t_i = (2 i - 1) pi / n:
//!
//! ```text
//! (1 - h^2) v + sum_i w_i r_i,    w_i = (h^2 + 2 h cos(t_i) + 2 h^2 cos(2 t_i)) / n
//! ```
//!
//! without the last term for n = 3 and 4. The weights follow from the eigenvalues asked of one step: h is the distance
//! of the centroid of (v, r_0, r_1) from v in the symmetric unit ring, so the first harmonics reproduce linear functions;
//! the constant and the second harmonics shrink by h^2, as quadratic functions do; all others vanish.
//!
//! The surface ends at creases, where it is continued by parallelograms: around a corner c, the vertex after r and s is
//! c + s - r. Linear functions are reproduced there too, so flat parts stay flat. Corners on creases count as regular.

use super::OldMesh;
use crate::mesh::topology;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::f64::consts::PI;

/// The point of each surface face.
pub(super) fn face_points(old: &OldMesh) -> Vec<DVec3> {
    let faces: Vec<[u32; 3]> = old.surface.iter().map(|f| f.vertices).collect();
    // Where other than two faces meet, there is no way on.
    let odd = old.surface_edges.iter().filter(|(_, at)| at.len() != 2).map(|(e, _)| *e);
    let creases = old.mesh.creases().iter().map(|c| c.vertices).chain(odd).collect();
    let surface = Surface::new(old.mesh.points(), &faces, creases);
    faces.iter().map(|&f| surface.face_point(f)).collect()
}

/// The weight of a vertex of valence `n` (at least 3), and those of its ring, starting with the two vertices of the face.
fn irregular_weights(n: usize) -> (f64, Vec<f64>) {
    let h = 2.0 / 3.0 * (PI / n as f64).cos();
    let weight = |i: usize| {
        let t = (2.0 * i as f64 - 1.0) * PI / n as f64;
        let second = if n > 4 { 2.0 * h * h * (2.0 * t).cos() } else { 0.0 };
        (h * h + 2.0 * h * t.cos() + second) / n as f64
    };
    (1.0 - h * h, (0..n).map(weight).collect())
}

/// Boundary and interfaces, cut along the creases. A directed edge that is no crease has one face.
struct Surface<'a> {
    points: &'a [DVec3],
    /// The third vertex of the face with this directed edge.
    apexes: FxHashMap<[u32; 2], u32>,
    creases: FxHashSet<[u32; 2]>,
}

impl<'a> Surface<'a> {
    fn new(points: &'a [DVec3], faces: &[[u32; 3]], creases: FxHashSet<[u32; 2]>) -> Self {
        let sides = |&[a, b, c]: &[u32; 3]| [([a, b], c), ([b, c], a), ([c, a], b)];
        Self { points, apexes: faces.iter().flat_map(sides).collect(), creases }
    }

    fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// The vertex after `r` around `corner`, counter-clockwise or clockwise; `None` beyond a crease.
    fn next(&self, corner: u32, r: u32, forward: bool) -> Option<u32> {
        if self.creases.contains(&topology::sorted2([corner, r])) {
            return None;
        }
        let edge = if forward { [corner, r] } else { [r, corner] };
        self.apexes.get(&edge).copied()
    }

    /// The ring of `corner`, counter-clockwise from `first`; `None` if a crease cuts it.
    fn ring(&self, corner: u32, first: u32) -> Option<Vec<u32>> {
        let mut ring = vec![first];
        loop {
            match self.next(corner, ring[ring.len() - 1], true)? {
                next if next == first => return Some(ring),
                next => ring.push(next),
            }
        }
    }

    /// The two vertices after `from` and `to` around `corner`, or where parallelograms put them.
    fn beyond(&self, corner: u32, from: u32, to: u32, forward: bool) -> [DVec3; 2] {
        let centre = self.point(corner);
        let (mut before, mut last, mut vertex) = (self.point(from), self.point(to), Some(to));
        [(); 2].map(|()| {
            vertex = vertex.and_then(|r| self.next(corner, r, forward));
            let next = vertex.map_or(centre + last - before, |r| self.point(r));
            (before, last) = (last, next);
            next
        })
    }

    fn face_point(&self, [a, b, c]: [u32; 3]) -> DVec3 {
        let corners = [[a, b, c], [b, c, a], [c, a, b]];
        let irregular = corners.into_iter().filter_map(|[v, first, _]| self.irregular(v, first));
        let (count, sum) = irregular.fold((0, DVec3::ZERO), |(n, sum), p| (n + 1, sum + p));
        if count > 0 { sum / f64::from(count) } else { corners.into_iter().map(|f| self.regular(f)).sum() }
    }

    /// The rule of a corner that no crease passes, unless its valence is six; `first` is the next corner of the face.
    fn irregular(&self, corner: u32, first: u32) -> Option<DVec3> {
        let ring = self.ring(corner, first).filter(|ring| ring.len() != 6 && ring.len() > 2)?;
        let (centre, weights) = irregular_weights(ring.len());
        let around: DVec3 = ring.iter().zip(weights).map(|(&r, w)| w * self.point(r)).sum();
        Some(centre * self.point(corner) + around)
    }

    /// What the corner `v` of a face and its ring add to the 12-point stencil.
    fn regular(&self, [v, next, last]: [u32; 3]) -> DVec3 {
        let [tip, outer] = self.beyond(v, last, next, false);
        let [_, other] = self.beyond(v, next, last, true);
        (32.0 * self.point(v) - tip - 2.0 * (outer + other)) / 81.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// A disc of `n` sectors of the regular lattice around vertex 0, `rings` wide: plane positions (each sector an affine
    /// image of the lattice) and faces. Vertices of ring k have the numbers after those of ring k - 1.
    fn disc(n: u32, rings: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let id = |k: u32, i: u32, j: u32| {
            if k == 0 { 0 } else { 1 + n * k * (k - 1) / 2 + (i * k + j) % (n * k) }
        };
        let ray = |i: u32| DVec3::from((glam::DVec2::from_angle(2.0 * PI * f64::from(i) / f64::from(n)), 0.0));
        let (mut points, mut faces) = (vec![DVec3::ZERO], Vec::new());
        for k in 1..=rings {
            for (i, j) in (0..n).flat_map(|i| (0..k).map(move |j| (i, j))) {
                points.push(f64::from(k - j) * ray(i) + f64::from(j) * ray(i + 1));
            }
        }
        for (i, k) in (0..n).flat_map(|i| (0..rings).map(move |k| (i, k))) {
            faces.extend((0..=k).map(|j| [id(k, i, j), id(k + 1, i, j), id(k + 1, i, j + 1)]));
            faces.extend((0..k).map(|j| [id(k, i, j), id(k + 1, i, j + 1), id(k, i, j + 1)]));
        }
        (points, faces)
    }

    /// One step: the points and faces after it. The faces at the border are lost.
    fn step(points: &[DVec3], faces: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let surface = Surface::new(points, faces, FxHashSet::default());
        let centres = faces.iter().map(|&f| surface.face_point(f));
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        let numbered = faces.iter().zip(points.len() as u32..);
        let left: FxHashMap<[u32; 2], u32> = numbered.flat_map(|(f, m)| sides(f).map(|e| (e, m))).collect();
        let flipped = |[a, b]: [u32; 2]| Some([a, *left.get(&[b, a])?, *left.get(&[a, b])?]);
        (points.iter().copied().chain(centres).collect(), faces.iter().flat_map(sides).filter_map(flipped).collect())
    }

    /// The vertices up to `rings` rings around vertex 0, in an order that depends on the connectivity only.
    fn neighbourhood(faces: &[[u32; 3]], rings: usize) -> Vec<u32> {
        let surface = Surface::new(&[], faces, FxHashSet::default());
        let first = faces.iter().find(|f| f[0] == 0).unwrap()[1];
        let (mut order, mut seen) = (vec![0], FxHashSet::from_iter([0]));
        let mut layer = vec![(0, first)];
        for _ in 0..rings {
            let mut next = Vec::new();
            for (v, from) in layer {
                let fresh = surface.ring(v, from).unwrap().into_iter().filter(|&w| seen.insert(w));
                next.extend(fresh.map(|w| (w, v)));
            }
            order.extend(next.iter().map(|(w, _)| *w));
            layer = next;
        }
        order
    }

    /// The matrix that takes the positions of three rings around a vertex of valence `n` to those after two steps.
    fn two_steps(n: u32) -> DMatrix<f64> {
        let (points, faces) = disc(n, 7);
        let old = neighbourhood(&faces, 3);
        let mut matrix = DMatrix::zeros(old.len(), old.len());
        for (column, &v) in old.iter().enumerate() {
            let mut unit = vec![DVec3::ZERO; points.len()];
            unit[v as usize] = DVec3::X;
            let (once, middle) = step(&unit, &faces);
            let (twice, fine) = step(&once, &middle);
            for (row, w) in neighbourhood(&fine, 3).into_iter().enumerate() {
                matrix[(row, column)] = twice[w as usize].x;
            }
        }
        matrix
    }

    #[test]
    fn irregular_weights_reproduce_the_centroid_of_a_symmetric_ring() {
        for n in 3..=20 {
            let (centre, weights) = irregular_weights(n);
            assert!((centre + weights.iter().sum::<f64>() - 1.0).abs() < 1e-14, "valence {n}: not affine");
            let ring = |i: usize| glam::DVec2::from_angle(2.0 * PI * i as f64 / n as f64);
            let point: glam::DVec2 = weights.iter().enumerate().map(|(i, w)| *w * ring(i)).sum();
            assert!((point - (ring(0) + ring(1)) / 3.0).length() < 1e-14, "valence {n}");
        }
        let rounded = |n: usize| irregular_weights(n).1.iter().map(|w| (w * 27.0).round()).collect::<Vec<_>>();
        assert_eq!(rounded(3), [4.0, 4.0, -5.0]);
        assert_eq!(rounded(4), [6.0, 6.0, -3.0, -3.0]);
    }

    #[test]
    fn the_regular_stencil_reproduces_cubics_and_the_rule_for_six_quadratics() {
        let cubic = |p: DVec3| 1.0 + p.x - 2.0 * p.y + p.x * p.y + 0.5 * p.y.powi(3) - p.x.powi(3) + p.x * p.x * p.y;
        let (mut points, faces) = disc(6, 4);
        points.iter_mut().for_each(|p| p.z = cubic(*p));
        let surface = Surface::new(&points, &faces, FxHashSet::default());
        for &[a, b, c] in faces.iter().filter(|f| f.iter().all(|&v| v < 7)) {
            let p = surface.face_point([a, b, c]);
            assert!(
                (p.truncate() - (surface.point(a) + surface.point(b) + surface.point(c)).truncate() / 3.0).length()
                    < 1e-14
            );
            assert!((p.z - cubic(p)).abs() < 1e-13);
        }
        let (centre, weights) = irregular_weights(6);
        let quadratic = |p: DVec3| 1.0 + p.x * p.x - 3.0 * p.x * p.y - 0.5 * p.y * p.y + p.y;
        let ring = surface.ring(0, 1).unwrap();
        let at = |v: u32| quadratic(surface.point(v));
        let value = centre * at(0) + ring.iter().zip(weights).map(|(&r, w)| w * at(r)).sum::<f64>();
        assert!((value - quadratic((surface.point(ring[0]) + surface.point(ring[1])) / 3.0)).abs() < 1e-14);
    }

    #[test]
    fn a_surface_cut_by_creases_reproduces_linear_functions() {
        let (points, faces) = disc(6, 4);
        // A crease through vertex 0 and its opposite neighbours 1 and 4, and one that ends in the surface.
        let creases = FxHashSet::from_iter([[0, 1], [0, 4], [2, 9]]);
        let surface = Surface::new(&points, &faces, creases);
        for &f in faces.iter().filter(|f| f.iter().all(|&v| v < 19)) {
            let centroid = f.iter().map(|&v| surface.point(v)).sum::<DVec3>() / 3.0;
            assert!((surface.face_point(f) - centroid).length() < 1e-14, "{f:?}");
        }
    }

    /// Two steps keep the directions and shrink by three on the regular lattice. Around other vertices the limit has a
    /// tangent plane only if the eigenvalues are 1, then a double one, then smaller ones.
    #[test]
    fn two_steps_have_the_eigenvalues_of_a_smooth_surface() {
        for n in [3_u32, 4, 5, 6, 7, 8, 10, 12] {
            let matrix = two_steps(n);
            for row in matrix.row_iter() {
                assert!((row.sum() - 1.0).abs() < 1e-13, "valence {n}: three rings depend on others");
            }
            let mut sizes: Vec<f64> = matrix.complex_eigenvalues().iter().map(|e| e.norm()).collect();
            sizes.sort_by(|a, b| b.total_cmp(a));
            let tangent = (2.0 / 3.0 * (PI / f64::from(n)).cos()).powi(2);
            assert!((sizes[0] - 1.0).abs() < 1e-9, "valence {n}");
            assert!((sizes[1] - tangent).abs() < 1e-7 && (sizes[2] - tangent).abs() < 1e-7, "valence {n}: {sizes:?}");
            assert!(sizes[3] < 0.99 * tangent, "valence {n}: {sizes:?}");
            if n > 4 && n != 6 {
                let quadratic = &sizes[3..6];
                assert!(quadratic.iter().all(|s| (s - tangent * tangent).abs() < 1e-6), "valence {n}: {sizes:?}");
            }
        }
    }
}
