//! Vertex smoothing that improves the worst cell: Laplacian first, then optimisation.
//!
//! Burkhart, Hamann and Umlauf 2010, section 3.2, after Freitag 1997. The optimisation maximises the smallest dihedral
//! sine s_i(x) over the cells at the vertex by a proximal bundle step: with gradients g_i,
//! `max_d min_i (s_i + g_i . d) - |d|^2 / (2 t)`, whose dual is a quadratic over the simplex in as many unknowns as
//! there are sines near the smallest. The step length t adapts to how well the linear model predicts.

use super::super::solid::Solid;
use super::fan::Fan;
use super::freedom::Freedom;
use glam::DVec3;

/// Cells whose worst sine is above this are good enough (the paper's quality level).
pub(crate) const GOOD: f64 = 0.3;

/// Sines this much above the smallest do not shape the step.
const MARGIN: f64 = 0.2;

/// Bundle steps a vertex.
const STEPS: usize = 8;

/// A sine and its gradient with respect to the moving vertex.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub(super) sine: f64,
    pub(super) gradient: DVec3,
}

/// The most bundle steps a vertex, and work space kept between calls.
pub(crate) struct Smoother {
    steps: usize,
    pieces: Vec<Piece>,
    weights: Vec<f64>,
    neighbours: Vec<u32>,
    pub(super) fan: Fan,
}

impl Default for Smoother {
    fn default() -> Self {
        Self::with_steps(STEPS)
    }
}

impl Smoother {
    /// A smoother that takes at most so many bundle steps a vertex.
    pub(crate) fn with_steps(steps: usize) -> Self {
        Self { steps, pieces: Vec::new(), weights: Vec::new(), neighbours: Vec::new(), fan: Fan::default() }
    }

    /// Moves a vertex within its freedom if its worst cell is not better than `good` and that improves it; returns
    /// whether it moved.
    pub(crate) fn smooth(&mut self, solid: &mut Solid, v: u32, freedom: Freedom, good: f64) -> bool {
        let better = self.better(solid, v, freedom, good);
        if let Some(p) = better {
            solid.move_point(v, p);
        }
        better.is_some()
    }

    /// The position that [`Smoother::smooth`] would move the vertex to.
    pub(crate) fn better(&mut self, solid: &Solid, v: u32, freedom: Freedom, good: f64) -> Option<DVec3> {
        let start = solid.point(v);
        let old = solid.worst_sine(solid.cells_at(v));
        if old > good || freedom == Freedom::Fixed {
            return None;
        }
        let (mut p, mut worst) = (start, old);
        self.fan.gather(solid, v);
        let mean = match freedom {
            Freedom::Space => self.neighbour_mean(solid, v),
            _ => start + freedom.project(self.neighbour_mean(solid, v) - start),
        };
        let laplacian = self.fan.worst_sine(mean, worst);
        if laplacian > worst {
            (p, worst) = (mean, laplacian);
        }
        if worst <= good {
            (p, worst) = self.optimise(solid, freedom, p, worst);
        }
        (worst > old).then_some(p)
    }

    /// Mean of the vertices joined to `v`, summed in ascending order.
    fn neighbour_mean(&mut self, solid: &Solid, v: u32) -> DVec3 {
        self.neighbours.clear();
        for &t in solid.cells_at(v) {
            self.neighbours.extend(solid.tet(t).into_iter().filter(|&w| w != v));
        }
        self.neighbours.sort_unstable();
        self.neighbours.dedup();
        let sum: DVec3 = self.neighbours.iter().map(|&w| solid.point(w)).sum();
        sum / self.neighbours.len().max(1) as f64
    }

    /// Maximises the worst sine from position `p`; returns the best position found and its worst sine.
    fn optimise(&mut self, solid: &Solid, freedom: Freedom, mut p: DVec3, mut worst: f64) -> (DVec3, f64) {
        let scale =
            self.neighbours.iter().map(|&w| (solid.point(w) - p).length_squared()).fold(f64::INFINITY, f64::min);
        // Sines change by about one over an edge length, so t in squared lengths gives steps in lengths.
        let mut t = 0.1 * scale;
        self.collect(freedom, p, worst);
        for _ in 0..self.steps {
            let (d, predicted) = self.bundle_step(t);
            if predicted - worst < 1e-3 {
                break;
            }
            let needed = worst + 0.1 * (predicted - worst);
            let q = p + d;
            let actual = self.fan.worst_sine(q, needed);
            if actual > needed {
                (p, worst) = (q, actual);
                t *= 2.0;
                self.collect(freedom, p, worst);
            } else {
                t *= 0.25;
            }
        }
        (p, worst)
    }

    /// Collects the sines within the margin of the smallest at `p`, with their gradients.
    fn collect(&mut self, freedom: Freedom, p: DVec3, worst: f64) {
        self.pieces.clear();
        for (i, &sine) in self.fan.sines(p).iter().enumerate() {
            if sine < worst + MARGIN {
                let take = |piece: Piece| {
                    self.pieces.push(Piece { gradient: freedom.project(piece.gradient), ..piece });
                };
                sines_with_gradients(p, self.fan.corners(i), worst + MARGIN, take);
            }
        }
    }

    /// Solves the dual over the simplex by sequential minimal optimisation; returns the step and the predicted value.
    fn bundle_step(&mut self, t: f64) -> (DVec3, f64) {
        let n = self.pieces.len();
        if n == 0 {
            // Cells so small that their sines underflow say nothing about where to go.
            return (DVec3::ZERO, f64::NEG_INFINITY);
        }
        let start = (0..n).min_by(|&i, &j| self.pieces[i].sine.total_cmp(&self.pieces[j].sine)).unwrap_or(0);
        self.weights.clear();
        self.weights.resize(n, 0.0);
        self.weights[start] = 1.0;
        let mut sum = self.pieces[start].gradient;
        for _ in 0..4 * n.min(16) {
            // The linear model of each piece at the step t * sum.
            let model = |piece: &Piece| piece.sine + t * piece.gradient.dot(sum);
            let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
            for (i, piece) in self.pieces.iter().enumerate() {
                let value = model(piece);
                if value < low.0 {
                    low = (value, i);
                }
                if self.weights[i] > 0.0 && value > high.0 {
                    high = (value, i);
                }
            }
            let (i, j) = (low.1, high.1);
            let gap = high.0 - low.0;
            let difference = self.pieces[i].gradient - self.pieces[j].gradient;
            let curvature = t * difference.length_squared();
            if gap < 1e-4 || curvature <= 0.0 {
                break;
            }
            let shift = (gap / curvature).min(self.weights[j]);
            self.weights[i] += shift;
            self.weights[j] -= shift;
            sum += shift * difference;
        }
        let predicted = self.pieces.iter().map(|c| c.sine + t * c.gradient.dot(sum)).fold(f64::INFINITY, f64::min);
        (t * sum, predicted)
    }
}

/// Gives `take` the dihedral sines below `limit` of the positive cell (x, p, q, r), and their gradients with respect to x.
///
/// From s = 6 V |e| / (|N_1| |N_2|) by logarithmic differentiation; dV/dx and d|N|/dx are the classical ones.
fn sines_with_gradients(x: DVec3, [p, q, r]: [DVec3; 3], limit: f64, mut take: impl FnMut(Piece)) {
    let opposite = (q - p).cross(r - p);
    let volume = -opposite.dot(x - p);
    // Faces at x, opposite to p, q, r: (x, r, q), (x, p, r), (x, q, p).
    let normals = [(r - x).cross(q - x), (p - x).cross(r - x), (q - x).cross(p - x)];
    let lengths = normals.map(DVec3::length);
    let base = opposite.length();
    let across = [q - r, r - p, p - q];
    // d ln|N| for N = (u - x) x (w - x) is N x (w - u) / |N|^2.
    let log = |k: usize| normals[k].cross(across[k]) / (lengths[k] * lengths[k]);
    for (a, k, l) in [(p, 1, 2), (q, 0, 2), (r, 0, 1)] {
        let e = x - a;
        let ratio = e.length() / (lengths[k] * lengths[l]);
        let sine = volume * ratio;
        if sine < limit {
            let gradient = -ratio * opposite + sine * (e / e.length_squared() - log(k) - log(l));
            take(Piece { sine, gradient });
        }
    }
    for k in [2, 1, 0] {
        let ratio = across[k].length() / (lengths[k] * base);
        let sine = volume * ratio;
        if sine < limit {
            take(Piece { sine, gradient: -ratio * opposite - sine * log(k) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::quality;

    #[test]
    fn gradients_are_those_of_finite_differences_and_sines_those_of_the_measure() {
        let p = [DVec3::new(1.0, 0.1, 0.2), DVec3::new(0.3, 1.1, -0.1), DVec3::new(0.2, 0.4, 0.9)];
        let x = DVec3::new(-0.2, 0.1, 0.05);
        assert!(quality::volume([x, p[0], p[1], p[2]]) > 0.0);
        let pieces_at = |x: DVec3| {
            let mut pieces = Vec::new();
            sines_with_gradients(x, p, f64::INFINITY, |piece| pieces.push(piece));
            pieces
        };
        let pieces = pieces_at(x);
        let mut sines: Vec<f64> = pieces.iter().map(|c| c.sine).collect();
        let mut expected = quality::dihedral_sines([x, p[0], p[1], p[2]]).to_vec();
        sines.sort_by(f64::total_cmp);
        expected.sort_by(f64::total_cmp);
        for (s, e) in sines.iter().zip(&expected) {
            assert!((s - e).abs() < 1e-14, "{s} {e}");
        }
        let h = 1e-6;
        for (axis, direction) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let ahead = pieces_at(x + h * direction);
            let behind = pieces_at(x - h * direction);
            for i in 0..6 {
                let slope = (ahead[i].sine - behind[i].sine) / (2.0 * h);
                assert!((slope - pieces[i].gradient[axis]).abs() < 1e-8, "piece {i} axis {axis}");
            }
        }
    }
}
