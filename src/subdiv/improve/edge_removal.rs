//! Edge removal: the ring of an edge is filled again without the edge, in the best way.
//!
//! With link vertices v_0 .. v_(n-1), each triangulation of the link polygon gives a filling: every triangle makes one
//! cell with each end of the edge. The triangulation whose worst cell is best is found by Klincsek's dynamic program.
//! At the boundary the ring is open and the polygon is closed by the chord v_0 v_(n-1), which becomes the new boundary
//! edge (Burkhart, Hamann and Umlauf 2010, Figure 6 and section 4).

use super::super::options::QualityMeasure;
use super::super::solid::{Ring, Solid};
use super::star::Star;
use crate::mesh::Face;
use smallvec::SmallVec;

/// What makes one filling better than another: its worst cell.
#[derive(Clone, Copy)]
pub(crate) enum Measure {
    /// The worst sine is as large as possible, and above this.
    BestWorst(f64),
    /// The worst value of another measure ([`measured::value`]) is as large as possible, and above this.
    BestWorstBy(QualityMeasure, f64),
}

/// Work space of the dynamic program, kept between calls.
#[derive(Default)]
pub(crate) struct Filling {
    size: usize,
    star: Star,
    /// Best value of the polygon from i to j, and the vertex that makes the triangle with its chord; once it is known.
    best: Vec<Option<(f64, usize)>>,
    triangles: Vec<[usize; 3]>,
}

impl Filling {
    /// Finds the best filling of the ring of the edge; true if there is an admissible one.
    fn solve(&mut self, solid: &Solid, edge: [u32; 2], link: &[u32], measure: Measure) -> bool {
        let n = link.len();
        if n < 3 {
            return false;
        }
        self.star.gather(solid, edge, link);
        self.size = n;
        self.best.clear();
        self.best.resize(n * n, None);
        let bound = self.star.bound(measure);
        self.polygon([0, n - 1], measure, bound) > bound
    }

    /// Value of the best filling of the polygon from i to j; minus infinity if none is above `bound`.
    ///
    /// From the whole to its parts: most rings have no admissible filling, which few triangles at the first chord show.
    fn polygon(&mut self, [i, j]: [usize; 2], measure: Measure, bound: f64) -> f64 {
        if j - i < 2 {
            return f64::INFINITY;
        }
        if let Some((value, _)) = self.best[i * self.size + j] {
            return value;
        }
        let mut best = (bound, usize::MAX);
        for k in i + 1..j {
            let mut value = self.star.triangle(measure, [i, k, j], best.0);
            for side in [[i, k], [k, j]] {
                if value > best.0 {
                    value = value.min(self.polygon(side, measure, bound));
                }
            }
            if value > best.0 {
                best = (value, k);
            }
        }
        if best.1 == usize::MAX {
            best.0 = f64::NEG_INFINITY;
        }
        self.best[i * self.size + j] = Some(best);
        best.0
    }

    /// The triangles of the filling found, as positions in the link.
    fn triangles(&mut self) -> &[[usize; 3]] {
        self.triangles.clear();
        let mut open = vec![[0, self.size - 1]];
        while let Some([i, j]) = open.pop() {
            if let Some((_, k)) = self.best[i * self.size + j] {
                self.triangles.push([i, k, j]);
                open.extend([[i, k], [k, j]]);
            }
        }
        &self.triangles
    }
}

/// The corners and minimum sines of cells that take the place of a ring.
pub(super) type Cells = SmallVec<[([u32; 4], f64); 12]>;

/// Removes the edge if its ring has an admissible filling without it. A boundary edge is replaced by the chord of its
/// link; the caller has made sure that this is a change of the surface it wants. Returns whether it was done.
pub(crate) fn remove_edge(
    solid: &mut Solid,
    edge: [u32; 2],
    ring: &Ring,
    measure: Measure,
    filling: &mut Filling,
) -> bool {
    let found = best_filling(solid, edge, ring, measure, filling);
    if let Some(cells) = &found {
        replace_ring(solid, edge, ring, cells);
    }
    found.is_some()
}

/// The filling by which [`remove_edge`] would remove the edge.
pub(super) fn best_filling(
    solid: &Solid,
    edge: [u32; 2],
    ring: &Ring,
    measure: Measure,
    filling: &mut Filling,
) -> Option<Cells> {
    let found = filling.solve(solid, edge, &ring.vertices, measure) && may_replace(solid, edge, ring);
    found.then(|| cells_of(solid, edge, ring, filling.triangles()))
}

/// The cells that triangles of the link of an edge make with its ends.
pub(super) fn cells_of(solid: &Solid, [a, b]: [u32; 2], ring: &Ring, triangles: &[[usize; 3]]) -> Cells {
    let tets = triangles.iter().flat_map(|corners| {
        let [i, k, j] = corners.map(|c| ring.vertices[c]);
        [[i, k, j, b], [i, j, k, a]]
    });
    tets.map(|tet| (tet, solid.sine_of(tet))).collect()
}

/// Fills the ring by these cells, which do without the edge.
pub(super) fn replace_ring(solid: &mut Solid, edge: [u32; 2], ring: &Ring, cells: &Cells) {
    fill(solid, ring, cells);
    if !ring.closed {
        flip_surface(solid, edge, &ring.vertices);
    }
}

/// Replaces an edge between two regions by the chord of its link, if both parts of its ring have an admissible filling;
/// the part of the smaller region number comes first. Returns whether it was done.
pub(crate) fn flip_interface(
    solid: &mut Solid,
    edge: [u32; 2],
    parts: &[Ring; 2],
    measure: Measure,
    filling: &mut Filling,
) -> bool {
    let mut find = |part| best_filling(solid, edge, part, measure, filling);
    let (Some(first), Some(second)) = (find(&parts[0]), find(&parts[1])) else { return false };
    fill(solid, &parts[0], &first);
    fill(solid, &parts[1], &second);
    flip_surface(solid, edge, &parts[0].vertices);
    true
}

/// Puts the cells of a filling in the place of those of the ring.
fn fill(solid: &mut Solid, ring: &Ring, cells: &Cells) {
    let mut tag = solid.tag(ring.cells[0]);
    for &t in &ring.cells {
        tag.level = tag.level.max(solid.tag(t).level);
        solid.remove_cell(t);
    }
    for &(tet, sine) in cells {
        solid.add_cell_of(tet, sine, tag);
    }
}

/// True if the topology allows the ring to be filled again without the edge.
pub(super) fn may_replace(solid: &Solid, edge: [u32; 2], ring: &Ring) -> bool {
    let region = solid.tag(ring.cells[0]).region;
    ring.cells.iter().all(|&t| solid.tag(t).region == region) && (ring.closed || chord_is_free(solid, edge, ring))
}

/// A surface edge may be replaced by the chord if the chord is not an edge yet and both ends keep at least two cells of
/// the region.
pub(super) fn chord_is_free(solid: &Solid, [a, b]: [u32; 2], ring: &Ring) -> bool {
    let (first, last) = (ring.vertices[0], ring.vertices[ring.vertices.len() - 1]);
    let region = solid.tag(ring.cells[0]).region;
    let cells = |v: u32| solid.cells_at(v).iter().filter(|&&t| solid.tag(t).region == region).count();
    !solid.has_edge(first, last) && [a, b].iter().all(|&v| cells(v) > 2)
}

/// Replaces the surface triangles (a, first, b) and (a, b, last), with the ends of the link, by the two at its chord.
fn flip_surface(solid: &mut Solid, [a, b]: [u32; 2], link: &[u32]) {
    let (first, last) = (link[0], link[link.len() - 1]);
    let patch = solid.remove_face([a, first, b]).map(|f| f.patch);
    solid.remove_face([a, b, last]);
    if let Some(patch) = patch {
        solid.add_face(Face { vertices: [a, first, last], patch });
        solid.add_face(Face { vertices: [first, b, last], patch });
    }
}
