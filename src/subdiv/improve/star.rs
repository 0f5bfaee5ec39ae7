//! The vertices around an edge, as what the cells of its fillings are measured by.

use super::super::solid::Solid;
use super::edge_removal::Measure;
use super::measured;
use glam::DVec3;

/// Positions of the ends of an edge, and of its link, with what several cells have in common.
#[derive(Default)]
pub(super) struct Star {
    ends: [DVec3; 2],
    points: Vec<DVec3>,
    /// Squared lengths of the lines from each link vertex to the two ends.
    spokes: Vec<[f64; 2]>,
    /// Of each two link vertices, once they are asked for.
    pairs: Vec<Option<Pair>>,
}

/// Squared length of the line between two link vertices, and of the normals of its triangles with the two ends.
#[derive(Clone, Copy)]
struct Pair {
    length: f64,
    normals: [f64; 2],
}

impl Star {
    /// Takes the star of an edge with its link.
    pub(super) fn gather(&mut self, solid: &Solid, edge: [u32; 2], link: &[u32]) {
        self.ends = edge.map(|v| solid.point(v));
        self.points.clear();
        self.points.extend(link.iter().map(|&v| solid.point(v)));
        self.spokes.clear();
        self.spokes.extend(self.points.iter().map(|p| self.ends.map(|e| p.distance_squared(e))));
        self.pairs.clear();
        self.pairs.resize(link.len() * link.len(), None);
    }

    /// The floor of the measure, as [`Star::triangle`] measures.
    pub(super) fn bound(&self, measure: Measure) -> f64 {
        match measure {
            Measure::BestWorst(floor) => floor * floor,
            Measure::BestWorstBy(_, floor) => floor,
        }
    }

    /// What the worse of the two cells is worth that the triangle i < k < j of the link makes with the ends, if that is above
    /// `best` (not negative): the square of its minimum sine, or another measure as it is. Minus infinity if not.
    pub(super) fn triangle(&mut self, measure: Measure, corners: [usize; 3], best: f64) -> f64 {
        match measure {
            Measure::BestWorst(_) => self.square_of_sine(corners, best),
            Measure::BestWorstBy(measure, _) => {
                let [i, k, j] = corners.map(|c| self.points[c]);
                let [a, b] = self.ends;
                let value = |points| measured::value(measure, points);
                let worst = value([i, k, j, b]);
                if worst > best { worst.min(value([i, j, k, a])) } else { f64::NEG_INFINITY }
            }
        }
    }

    /// The square of the smaller minimum sine ([`crate::mesh::quality::min_sine`]) of the two cells.
    fn square_of_sine(&mut self, [i, k, j]: [usize; 3], best: f64) -> f64 {
        let p = self.points[i];
        let normal = (self.points[k] - p).cross(self.points[j] - p);
        let six_volumes = [-normal.dot(self.ends[0] - p), normal.dot(self.ends[1] - p)];
        if six_volumes[0] <= 0.0 || six_volumes[1] <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let base = normal.length_squared();
        let (ik, kj, ij) = (self.pair(i, k), self.pair(k, j), self.pair(i, j));
        let mut worst = f64::INFINITY;
        for end in [0, 1] {
            let [si, sk, sj] = [i, k, j].map(|c| self.spokes[c][end]);
            let [nik, nkj, nij] = [ik, kj, ij].map(|pair| pair.normals[end]);
            // |e|^2 / (n_k n_l) with both sides of the fraction multiplied by the two other n, as for any cell.
            let at_link = (ik.length * (nkj * nij)).min(kj.length * (nik * nij)).min(ij.length * (nik * nkj));
            let at_end = (si * nkj).min(sk * nij).min(sj * nik) * base;
            let volume = six_volumes[end];
            let square = volume * volume / (base * nik) * (at_link.min(at_end) / (nkj * nij));
            // Not a number for cells so small that their normals underflow: not above.
            if square <= best || square.is_nan() {
                return f64::NEG_INFINITY;
            }
            worst = worst.min(square);
        }
        worst
    }

    fn pair(&mut self, i: usize, j: usize) -> Pair {
        let slot = &mut self.pairs[i * self.points.len() + j];
        *slot.get_or_insert_with(|| {
            let [p, q] = [self.points[i], self.points[j]];
            let normal = |end: DVec3| (p - end).cross(q - end).length_squared();
            Pair { length: p.distance_squared(q), normals: self.ends.map(normal) }
        })
    }
}
