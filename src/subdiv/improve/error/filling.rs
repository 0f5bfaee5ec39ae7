//! The filling of an edge's ring without the edge that costs least: Klincsek's dynamic program over the triangulations of
//! the link polygon (see [`super::super::edge_removal`]), with the cells of all polygons of one size evaluated at once.

use super::mean;
use super::weight::Weight;
use super::weighted::Batch;
use crate::subdiv::solid::{Ring, Solid};

/// Rings longer than this are left alone: the dynamic program is cubic.
const LONGEST_RING: usize = 32;

/// Marks polygons without an admissible filling.
const NONE: usize = usize::MAX;

/// Work space of the dynamic program, kept between calls.
pub(super) struct Filling<W: Weight> {
    size: usize,
    /// Least cost of the polygon from i to j, and the vertex that makes the triangle with its chord.
    best: Vec<(f64, usize)>,
    candidates: Vec<[usize; 3]>,
    cells: Batch<W>,
}

impl<W: Weight> Default for Filling<W> {
    fn default() -> Self {
        Self { size: 0, best: Vec::new(), candidates: Vec::new(), cells: Batch::default() }
    }
}

impl<W: Weight> Filling<W> {
    /// Finds the filling of the ring of `edge` that costs least; true if it costs less than `share` of what the ring
    /// costs now and has no sine below both `floor` and the smallest of the ring.
    pub(super) fn solve(
        &mut self,
        solid: &Solid,
        weights: &[W],
        edge: [u32; 2],
        ring: &Ring,
        (share, floor): (f64, f64),
    ) -> bool {
        let n = ring.vertices.len();
        if !(3..=LONGEST_RING).contains(&n) {
            return false;
        }
        let bound = share * self.cost_of(solid, weights, &ring.cells);
        let floor = solid.worst_sine(&ring.cells).min(floor);
        self.size = n;
        self.best.clear();
        self.best.resize(n * n, (f64::INFINITY, NONE));
        for i in 1..n {
            self.best[(i - 1) * n + i].0 = 0.0;
        }
        for span in 2..n {
            self.gather(solid, weights, edge, &ring.vertices, span, bound);
            self.choose(bound, floor * floor);
        }
        self.best[n - 1].1 != NONE
    }

    fn cost_of(&mut self, solid: &Solid, weights: &[W], cells: &[u32]) -> f64 {
        self.cells.clear();
        for &t in cells {
            self.cells.push(solid.cell_points(t), mean(weights, solid.tet(t)));
        }
        self.cells.evaluate();
        (0..cells.len()).map(|i| self.cells.result(i).0).sum()
    }

    /// Evaluates the two cells of each triangle (i, k, j) with j = i + span whose sides do not cost too much already.
    fn gather(&mut self, solid: &Solid, weights: &[W], [a, b]: [u32; 2], link: &[u32], span: usize, bound: f64) {
        self.candidates.clear();
        self.cells.clear();
        for i in 0..self.size - span {
            let j = i + span;
            for k in i + 1..j {
                if self.sides([i, k, j]) < bound {
                    self.candidates.push([i, k, j]);
                    let [vi, vk, vj] = [link[i], link[k], link[j]];
                    for tet in [[vi, vk, vj, b], [vi, vj, vk, a]] {
                        self.cells.push(tet.map(|v| solid.point(v)), mean(weights, tet));
                    }
                }
            }
        }
        self.cells.evaluate();
    }

    /// Keeps the best triangle of each polygon.
    fn choose(&mut self, bound: f64, squared_floor: f64) {
        for (c, &[i, k, j]) in self.candidates.iter().enumerate() {
            let [(above, sine), (below, other_sine)] = [2 * c, 2 * c + 1].map(|cell| self.cells.result(cell));
            let cost = self.sides([i, k, j]) + above + below;
            let best = &mut self.best[i * self.size + j];
            if cost < best.0.min(bound) && sine >= squared_floor && other_sine >= squared_floor {
                *best = (cost, k);
            }
        }
    }

    /// Cost of the polygons at the two sides of a triangle.
    fn sides(&self, [i, k, j]: [usize; 3]) -> f64 {
        self.best[i * self.size + k].0 + self.best[k * self.size + j].0
    }

    /// The triangles of the filling found, as positions in the link.
    pub(super) fn triangles(&self) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(self.size - 2);
        let mut open = vec![(0, self.size - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i >= 2 {
                let k = self.best[i * self.size + j].1;
                triangles.push([i, k, j]);
                open.extend([(i, k), (k, j)]);
            }
        }
        triangles
    }
}
