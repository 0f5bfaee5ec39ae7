//! Where the surface of a mesh touches cells that it should not: hanging nodes, and cells that overlap.

use super::{quality, topology};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Distance from an edge or face, over its length, within which a node lies on it: above the rounding of files that keep seven digits.
const ON: f64 = 1e-6;

/// Barycentric coordinates above which a point lies inside a cell, and not on its surface.
const INSIDE: f64 = 1e-6;

/// Buckets a point of a grid.
const BUCKETS: f64 = 8.0;

/// A node that lies on an edge or a face of a cell that does not have it for a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Hanging {
    /// The node.
    pub vertex: u32,
    /// Ends of the edge, or corners of the face, ascending; of an edge the last one is named twice.
    pub on: [u32; 3],
}

/// What lies inside a cell of another place in the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Overlap {
    /// The cell.
    pub cell: u32,
    /// A cell at the boundary whose centroid it holds, or `None` where it holds a vertex of the boundary.
    pub other: Option<u32>,
    /// That vertex, or the first one of the other cell.
    pub vertex: u32,
}

/// The nodes of the boundary that lie on a boundary edge or triangle without belonging to a cell of it, and share an edge with one of its
/// ends: cells of different size that do not fit together. Bodies that merely touch have no edge in common. Sorted.
///
/// `edges` are those of the boundary, sorted; `triangles` may be none, where faces are not flat; `cells` gives the corners of each cell.
pub fn hanging<'a>(
    points: &[DVec3],
    edges: &[[u32; 2]],
    triangles: &[[u32; 3]],
    cells: impl Iterator<Item = &'a [u32]>,
) -> Vec<Hanging> {
    let mut vertices: Vec<u32> = edges.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let grid = Grid::new(vertices.iter().map(|&v| points[v as usize]).collect());
    let at = |v: u32| points[v as usize];
    let do_meet = |v: u32, w: u32| edges.binary_search(&topology::sorted2([v, w])).is_ok();
    let near = |corners: [u32; 3], lies_on: &(dyn Fn(DVec3) -> bool + Sync)| {
        let mut found = Vec::new();
        let mut on = corners;
        on.sort_unstable();
        let [a, b, c] = corners.map(at);
        let margin = DVec3::splat(ON * a.distance(b).max(b.distance(c)));
        grid.visit(a.min(b).min(c) - margin, a.max(b).max(c) + margin, |i| {
            let v = vertices[i];
            if !corners.contains(&v) && lies_on(at(v)) && corners.iter().any(|&w| do_meet(v, w)) {
                found.push(Hanging { vertex: v, on });
            }
        });
        found
    };
    let on_edges = edges.par_iter().flat_map_iter(|&[a, b]| near([a, b, b], &|p| is_on_edge(at(a), at(b), p)));
    let mut found: Vec<Hanging> = on_edges.collect();
    let on_faces = triangles.par_iter().flat_map_iter(|&face| near(face, &|p| is_on_face(face.map(at), p)));
    found.par_extend(on_faces);
    without_own(found, cells)
}

/// Those that no cell has together: flat cells have corners close to their edges.
fn without_own<'a>(mut found: Vec<Hanging>, cells: impl Iterator<Item = &'a [u32]>) -> Vec<Hanging> {
    if found.is_empty() {
        return found;
    }
    found.sort_unstable();
    let mut of_vertex: FxHashMap<u32, Vec<(usize, [u32; 3])>> = FxHashMap::default();
    for (i, hanging) in found.iter().enumerate() {
        of_vertex.entry(hanging.vertex).or_default().push((i, hanging.on));
    }
    let mut own = vec![false; found.len()];
    for cell in cells {
        for (i, on) in cell.iter().filter_map(|v| of_vertex.get(v)).flatten() {
            own[*i] |= on.iter().all(|v| cell.contains(v));
        }
    }
    let mut own = own.into_iter();
    found.retain(|_| own.next() == Some(false));
    found
}

fn is_on_edge(a: DVec3, b: DVec3, p: DVec3) -> bool {
    let along = b - a;
    let s = (p - a).dot(along) / along.length_squared();
    (ON..=1.0 - ON).contains(&s) && p.distance(a + s * along) <= ON * along.length()
}

fn is_on_face([a, b, c]: [DVec3; 3], p: DVec3) -> bool {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let weights = [(c - b).cross(p - b), (a - c).cross(p - c), (b - a).cross(p - a)].map(|n| n.dot(normal) / area);
    let size = a.distance(b).max(b.distance(c));
    weights.iter().all(|w| *w > ON) && (p - a).dot(normal).abs() <= ON * size * normal.length()
}

/// The cells that hold a vertex of the boundary or the centroid of a cell at the boundary, other than their own, sorted: parts of the mesh
/// lie within each other. `faces` are the boundary's; a cell is at the boundary if three of its vertices are.
#[must_use]
pub fn overlaps(points: &[DVec3], tets: &[[u32; 4]], faces: impl Iterator<Item = [u32; 3]>) -> Vec<Overlap> {
    let mut is_outer = vec![false; points.len()];
    faces.flatten().for_each(|v| is_outer[v as usize] = true);
    let vertices: Vec<u32> = (0..points.len() as u32).filter(|&v| is_outer[v as usize]).collect();
    let is_at_boundary = |t: &u32| tets[*t as usize].iter().filter(|v| is_outer[**v as usize]).count() >= 3;
    let others: Vec<u32> = (0..tets.len() as u32).into_par_iter().filter(is_at_boundary).collect();
    let corners = |t: u32| tets[t as usize].map(|v| points[v as usize]);
    let centroids = others.iter().map(|&t| corners(t).into_iter().sum::<DVec3>() / 4.0);
    let samples: Vec<DVec3> = vertices.iter().map(|&v| points[v as usize]).chain(centroids).collect();
    let grid = Grid::new(samples.clone());
    let of_cell = |t: u32| {
        let x = corners(t);
        let (lo, hi) = x.iter().fold((x[0], x[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let mut found = None;
        grid.visit(lo, hi, |i| {
            let other = i.checked_sub(vertices.len()).map(|k| others[k]);
            if found.is_none() && other != Some(t) && is_inside(x, samples[i]) {
                let vertex = other.map_or_else(|| vertices[i], |other| tets[other as usize][0]);
                found = Some(Overlap { cell: t, other, vertex });
            }
        });
        found
    };
    (0..tets.len() as u32).into_par_iter().filter_map(of_cell).collect()
}

fn is_inside(x: [DVec3; 4], p: DVec3) -> bool {
    let volume = quality::volume(x);
    (0..4).all(|i| {
        let mut part = x;
        part[i] = p;
        quality::volume(part) > INSIDE * volume
    })
}

/// Points in the buckets of a regular grid over their box.
struct Grid {
    points: Vec<DVec3>,
    lo: DVec3,
    /// Buckets a length, and their number, in x, y, z.
    scale: DVec3,
    size: [usize; 3],
    /// Where the points of each bucket begin in `order`.
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl Grid {
    fn new(points: Vec<DVec3>) -> Self {
        let (lo, hi) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let extent = if points.is_empty() { DVec3::ONE } else { (hi - lo).max(DVec3::splat(f64::MIN_POSITIVE)) };
        // Cubes, as many as there are to be if the box were full of them.
        let side = (extent.x.max(extent.y).max(extent.z)) / (BUCKETS * points.len() as f64).cbrt().max(1.0);
        let size = (extent / side).to_array().map(|n| (n as usize).max(1));
        let scale = DVec3::from_array(size.map(|n| n as f64)) / extent;
        let mut grid = Self { points, lo, scale, size, starts: Vec::new(), order: Vec::new() };
        let bucket = |p: &DVec3| grid.number(grid.place(*p));
        let mut keyed: Vec<(usize, u32)> = grid.points.iter().map(bucket).zip(0..).collect();
        keyed.sort_unstable();
        let mut starts = vec![0; size[0] * size[1] * size[2] + 1];
        keyed.iter().for_each(|(bucket, _)| starts[bucket + 1] += 1);
        for b in 1..starts.len() {
            starts[b] += starts[b - 1];
        }
        grid.order = keyed.into_iter().map(|(_, i)| i).collect();
        grid.starts = starts;
        grid
    }

    fn place(&self, p: DVec3) -> [usize; 3] {
        let place = ((p - self.lo) * self.scale).to_array();
        std::array::from_fn(|c| (place[c].max(0.0) as usize).min(self.size[c] - 1))
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    /// Visits the points in a box, bucket by bucket.
    fn visit(&self, lo: DVec3, hi: DVec3, mut visit: impl FnMut(usize)) {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.place(lo), self.place(hi));
        for (y, z) in (z0..=z1).flat_map(|z| (y0..=y1).map(move |y| (y, z))) {
            let row = self.starts[self.number([x0, y, z])]..self.starts[self.number([x1, y, z]) + 1];
            for &i in &self.order[row.start as usize..row.end as usize] {
                let p = self.points[i as usize];
                if p.cmpge(lo).all() && p.cmple(hi).all() {
                    visit(i as usize);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TetMesh;
    use crate::mesh::generate::box_tets;

    fn overlapping(mesh: &TetMesh) -> Vec<Overlap> {
        overlaps(mesh.points(), mesh.tets(), mesh.faces().iter().map(|f| f.vertices))
    }

    fn hung(mesh: &TetMesh) -> Vec<Hanging> {
        let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| f.vertices).collect();
        let edges: Vec<[u32; 2]> = topology::triangle_edges(faces.iter().copied()).into_iter().map(|e| e.0).collect();
        hanging(mesh.points(), &edges, &faces, mesh.tets().iter().map(|t| &t[..]))
    }

    /// A brick and a copy of it, moved, each with its own vertices.
    fn with_copy(offset: DVec3) -> TetMesh {
        let brick = box_tets([1.0; 3], [3; 3]).unwrap();
        let count = brick.points().len() as u32;
        let points = brick.points().iter().copied().chain(brick.points().iter().map(|&p| p + offset)).collect();
        let tets = brick.tets().iter().copied().chain(brick.tets().iter().map(|t| t.map(|v| v + count))).collect();
        TetMesh::from_cells(points, tets, "solid").unwrap()
    }

    #[test]
    fn bodies_overlap_if_their_interiors_meet() {
        for (offset, expected) in [(0.0, true), (0.4, true), (0.999, true), (1.0, false), (1.5, false)] {
            let mesh = with_copy(DVec3::new(offset, 0.1, 0.2));
            assert_eq!(!overlapping(&mesh).is_empty(), expected, "{offset}");
        }
        // Cell by cell the same: only centroids tell.
        let all = overlapping(&with_copy(DVec3::ZERO));
        assert!(all.iter().any(|o| o.other == Some(o.cell + 162)), "{all:?}");
        assert!(overlapping(&box_tets([1.0, 2.0, 1e-3], [4, 3, 2]).unwrap()).is_empty());
    }

    #[test]
    fn touching_bodies_have_no_hanging_nodes_and_a_split_edge_has_one() {
        assert_eq!(hung(&with_copy(DVec3::new(1.0, 0.1, 0.1))), []);
        // Two cells on either side of z = 0, the lower one split at the middle of the edge they share: vertex 5.
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.5, 0.5, 0.0]];
        let tets = vec![[0, 1, 2, 3], [0, 5, 1, 4], [0, 2, 5, 4]];
        let mesh = TetMesh::from_cells(points.map(DVec3::from_array).to_vec(), tets, "solid").unwrap();
        assert_eq!(hung(&mesh), [Hanging { vertex: 5, on: [1, 2, 2] }]);
    }

    #[test]
    fn a_node_inside_a_face_hangs_and_a_flat_cell_does_not() {
        let points =
            [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 1.0, 0.0]];
        let tets = vec![[0, 1, 2, 3], [0, 5, 1, 4], [1, 5, 2, 4], [2, 5, 0, 4]];
        let mesh = TetMesh::from_cells(points.map(DVec3::from_array).to_vec(), tets, "solid").unwrap();
        assert_eq!(hung(&mesh), [Hanging { vertex: 5, on: [0, 1, 2] }]);
        // The apex is close to the middle of an edge of its own cell.
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.0, 1e-7]];
        let flat = TetMesh::from_cells(flat.map(DVec3::from_array).to_vec(), vec![[0, 1, 2, 3]], "solid").unwrap();
        assert_eq!(hung(&flat), []);
    }
}
