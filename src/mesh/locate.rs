//! Which cell holds a point: a tree of boxes over the cells (a bounding volume hierarchy).

use super::{TetMesh, quality};
use glam::DVec3;

/// Cells in a leaf of the tree at most.
const LEAF: usize = 8;

/// Barycentric coordinates this little below zero are zero.
const ROUNDING: f64 = 1e-12;

/// A point as seen from the cell that holds it, or that is nearest to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// The cell.
    pub cell: usize,
    /// Barycentric coordinates of the cell's point nearest to the point asked for: not negative, their sum is 1.
    pub weights: [f64; 4],
    /// Distance to that point: zero inside, but for rounding.
    pub distance: f64,
}

/// Finds cells by place.
#[derive(Debug, Clone)]
pub struct Locator<'a> {
    mesh: &'a TetMesh,
    /// The cells in the order of the leaves.
    cells: Vec<u32>,
    /// Depth first: the left child follows its parent.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    lo: DVec3,
    hi: DVec3,
    kind: Kind,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// A range of the cells.
    Leaf(usize, usize),
    /// The right child.
    Branch(usize),
}

impl<'a> Locator<'a> {
    /// Builds the tree.
    #[must_use]
    pub fn new(mesh: &'a TetMesh) -> Self {
        let centroids: Vec<DVec3> =
            (0..mesh.tets().len()).map(|t| mesh.cell_points(t).into_iter().sum::<DVec3>() / 4.0).collect();
        let cells = (0..mesh.tets().len() as u32).collect();
        let mut locator = Self { mesh, cells, nodes: Vec::new() };
        locator.build(0, mesh.tets().len(), &centroids);
        locator
    }

    /// Builds the subtree of a range of the cells, and gives its root.
    fn build(&mut self, start: usize, end: usize, centroids: &[DVec3]) -> usize {
        let range = &mut self.cells[start..end];
        let (lo, hi) = bounds(range.iter().flat_map(|&t| self.mesh.cell_points(t as usize)));
        let root = self.nodes.len();
        self.nodes.push(Node { lo, hi, kind: Kind::Leaf(start, end) });
        if end - start <= LEAF {
            return root;
        }
        let (lo, hi) = bounds(range.iter().map(|&t| centroids[t as usize]));
        let axis = (hi - lo).max_position();
        // Ties are broken by the cell, so that the tree is the same everywhere.
        let key = |t: &u32| (centroids[*t as usize][axis], *t);
        range.select_nth_unstable_by((end - start) / 2, |a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let middle = start + (end - start) / 2;
        self.build(start, middle, centroids);
        let right = self.build(middle, end, centroids);
        self.nodes[root].kind = Kind::Branch(right);
        root
    }

    /// The cell that holds a finite point, or else the nearest cell.
    #[must_use]
    pub fn nearest(&self, p: DVec3) -> Located {
        if let Some(found) = self.containing(p) {
            return found;
        }
        let mut best = Located { cell: 0, weights: [0.25; 4], distance: f64::INFINITY };
        let mut stack = vec![0];
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n];
            if box_distance(node, p) > best.distance || best.distance == 0.0 {
                continue;
            }
            match node.kind {
                Kind::Leaf(start, end) => {
                    for &t in &self.cells[start..end] {
                        let (weights, distance) = nearest_in_cell(self.mesh.cell_points(t as usize), p);
                        if distance < best.distance {
                            best = Located { cell: t as usize, weights, distance };
                        }
                    }
                }
                Kind::Branch(right) => {
                    let (near, far) = (n + 1, right);
                    let swap = box_distance(&self.nodes[near], p) > box_distance(&self.nodes[far], p);
                    stack.extend(if swap { [near, far] } else { [far, near] });
                }
            }
        }
        best
    }
}

impl Locator<'_> {
    /// The first cell met that holds a point: much quicker than to measure distances.
    fn containing(&self, p: DVec3) -> Option<Located> {
        let mut stack = vec![0];
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n];
            if p.cmplt(node.lo).any() || p.cmpgt(node.hi).any() {
                continue;
            }
            match node.kind {
                Kind::Leaf(start, end) => {
                    for &t in &self.cells[start..end] {
                        if let Some(weights) = weights_inside(self.mesh.cell_points(t as usize), p) {
                            return Some(Located { cell: t as usize, weights, distance: 0.0 });
                        }
                    }
                }
                Kind::Branch(right) => stack.extend([right, n + 1]),
            }
        }
        None
    }
}

/// The barycentric coordinates of a point of a tetrahedron; `None` outside. Points on faces and at vertices, which are many,
/// are inside of the first cell that is met.
fn weights_inside(x: [DVec3; 4], p: DVec3) -> Option<[f64; 4]> {
    let volume = quality::volume(x);
    let mut weights = [0.0; 4];
    for i in 0..4 {
        let mut part = x;
        part[i] = p;
        let weight = quality::volume(part) / volume;
        // Not what NaN is.
        let inside = weight >= -ROUNDING;
        if !inside {
            return None;
        }
        weights[i] = weight.max(0.0);
    }
    let sum: f64 = weights.iter().sum();
    Some(weights.map(|w| w / sum))
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)))
}

fn box_distance(node: &Node, p: DVec3) -> f64 {
    (node.lo - p).max(p - node.hi).max(DVec3::ZERO).length()
}

/// Barycentric coordinates of the point of a tetrahedron nearest to `p`, and the distance.
fn nearest_in_cell(x: [DVec3; 4], p: DVec3) -> ([f64; 4], f64) {
    if let Some(weights) = weights_inside(x, p) {
        return (weights, 0.0);
    }
    let mut best = ([0.0; 4], f64::INFINITY);
    for face in quality::FACES {
        let on_face = nearest_in_triangle(face.map(|i| x[i]), p);
        let mut weights = [0.0; 4];
        face.iter().zip(on_face).for_each(|(&i, w)| weights[i] = w);
        let q: DVec3 = x.iter().zip(weights).map(|(x, w)| w * *x).sum();
        if p.distance(q) < best.1 {
            best = (weights, p.distance(q));
        }
    }
    best
}

/// Barycentric coordinates of the point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn nearest_in_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let from = |x: DVec3| (ab.dot(p - x), ac.dot(p - x));
    let ((d1, d2), (d3, d4), (d5, d6)) = (from(a), from(b), from(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn inside_a_box_the_weights_give_the_point_back_and_outside_the_distance_is_the_boxs(
            x in prop::array::uniform3(-1.0_f64..2.0), cells in prop::array::uniform3(1_usize..5)
        ) {
            let mesh = box_tets([1.0; 3], cells).unwrap();
            let p = DVec3::from_array(x);
            let found = Locator::new(&mesh).nearest(p);
            let q: DVec3 = mesh.cell_points(found.cell).into_iter().zip(found.weights).map(|(x, w)| w * x).sum();
            let nearest = p.clamp(DVec3::ZERO, DVec3::ONE);
            prop_assert!(found.weights.iter().all(|w| *w >= 0.0));
            prop_assert!(q.distance(nearest) < 1e-12, "{q} for {p}");
            prop_assert!((found.distance - p.distance(nearest)).abs() < 1e-12);
        }
    }
}
