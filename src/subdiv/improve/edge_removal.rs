//! Edge removal: the ring of an edge is filled again without the edge, in the best way.
//!
//! With link vertices v_0 .. v_(n-1), each triangulation of the link polygon gives a filling: every triangle makes one
//! cell with each end of the edge. The triangulation whose worst cell is best is found by Klincsek's dynamic program.
//! At the boundary the ring is open and the polygon is closed by the chord v_0 v_(n-1), which becomes the new boundary
//! edge (Burkhart, Hamann and Umlauf 2010, Figure 6 and section 4).

use super::super::solid::{Ring, Solid};
use crate::mesh::{Face, quality};
use glam::DVec3;

/// Rings longer than this are left alone: the dynamic program is cubic.
const LONGEST_RING: usize = 32;

/// Work space of the dynamic program, kept between calls.
#[derive(Default)]
pub(crate) struct Filling {
    size: usize,
    /// Best worst sine of the polygon from i to j, and the vertex that makes the triangle with its chord.
    best: Vec<(f64, usize)>,
    triangles: Vec<[usize; 3]>,
}

impl Filling {
    /// Finds the best filling of the ring of (a, b); true if there is one whose worst sine exceeds `floor`.
    fn solve(&mut self, solid: &Solid, [a, b]: [u32; 2], link: &[u32], floor: f64) -> bool {
        let n = link.len();
        if !(3..=LONGEST_RING).contains(&n) {
            return false;
        }
        let (pa, pb) = (solid.point(a), solid.point(b));
        let p: smallvec::SmallVec<[DVec3; LONGEST_RING]> = link.iter().map(|&v| solid.point(v)).collect();
        self.size = n;
        self.best.clear();
        self.best.resize(n * n, (f64::INFINITY, 0));
        for span in 2..n {
            for i in 0..n - span {
                let j = i + span;
                let mut best = (floor, usize::MAX);
                for k in i + 1..j {
                    let sides = self.best[i * n + k].0.min(self.best[k * n + j].0);
                    if sides <= best.0 {
                        continue;
                    }
                    let worst = sides.min(quality::min_sine([p[i], p[k], p[j], pb]));
                    if worst <= best.0 {
                        continue;
                    }
                    let worst = worst.min(quality::min_sine([p[i], p[j], p[k], pa]));
                    if worst > best.0 {
                        best = (worst, k);
                    }
                }
                // No filling above the floor: whatever contains this polygon has none either.
                self.best[i * n + j] = if best.1 == usize::MAX { (f64::NEG_INFINITY, 0) } else { best };
            }
        }
        self.best[n - 1].0 > floor
    }

    /// The triangles of the filling found, as positions in the link.
    fn triangles(&mut self) -> &[[usize; 3]] {
        self.triangles.clear();
        let mut open = vec![(0, self.size - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i < 2 {
                continue;
            }
            let k = self.best[i * self.size + j].1;
            self.triangles.push([i, k, j]);
            open.extend([(i, k), (k, j)]);
        }
        &self.triangles
    }
}

/// Removes the edge if a filling of its ring has a worst sine above `floor`. A boundary edge is replaced by the chord of
/// its link; the caller has made sure that this is a change of the surface it wants. Returns whether it was done.
pub(crate) fn remove_edge(solid: &mut Solid, edge: [u32; 2], ring: &Ring, floor: f64, filling: &mut Filling) -> bool {
    if !can_remove(solid, edge, ring, floor, filling) {
        return false;
    }
    let [a, b] = edge;
    let link = &ring.vertices;
    let mut tag = solid.tag(ring.cells[0]);
    for &t in &ring.cells {
        tag.level = tag.level.max(solid.tag(t).level);
        solid.remove_cell(t);
    }
    for [i, k, j] in filling.triangles().iter().copied() {
        let [vi, vk, vj] = [link[i], link[k], link[j]];
        solid.add_cell([vi, vk, vj, b], tag);
        solid.add_cell([vi, vj, vk, a], tag);
    }
    if !ring.closed {
        flip_surface(solid, edge, link[0], link[link.len() - 1]);
    }
    true
}

/// Finds the filling by which [`remove_edge`] would remove the edge; true if there is one.
pub(super) fn can_remove(solid: &Solid, edge: [u32; 2], ring: &Ring, floor: f64, filling: &mut Filling) -> bool {
    let region = solid.tag(ring.cells[0]).region;
    ring.cells.iter().all(|&t| solid.tag(t).region == region)
        && (ring.closed || chord_is_free(solid, edge, &ring.vertices))
        && filling.solve(solid, edge, &ring.vertices, floor)
}

/// A boundary edge may be replaced by the chord if the chord is not an edge yet and both ends keep at least two cells.
fn chord_is_free(solid: &Solid, [a, b]: [u32; 2], link: &[u32]) -> bool {
    let (first, last) = (link[0], link[link.len() - 1]);
    !solid.has_edge(first, last) && [a, b].iter().all(|&v| solid.cells_at(v).len() > 2)
}

/// Replaces the surface triangles (a, first, b) and (a, b, last) by the two at the chord.
fn flip_surface(solid: &mut Solid, [a, b]: [u32; 2], first: u32, last: u32) {
    let patch = solid.remove_face([a, first, b]).map(|f| f.patch);
    solid.remove_face([a, b, last]);
    if let Some(patch) = patch {
        solid.add_face(Face { vertices: [a, first, last], patch });
        solid.add_face(Face { vertices: [first, b, last], patch });
    }
}
