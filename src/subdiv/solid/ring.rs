//! The cells around an edge.

use super::{Solid, has_vertex};
use crate::mesh::quality::FACES;
use smallvec::SmallVec;

/// Edges with more cells than this have no [`Ring`]: what is done with rings is cubic in their length.
const LONGEST_RING: usize = 32;

/// For a positive tetrahedron and two of its corners i, j: the corners k, l such that (i, j, k, l) is positive too.
const POSITIVE_REST: [[[usize; 2]; 4]; 4] = [
    [[0, 0], [2, 3], [3, 1], [1, 2]],
    [[3, 2], [0, 0], [0, 3], [2, 0]],
    [[1, 3], [3, 0], [0, 0], [0, 1]],
    [[2, 1], [0, 2], [1, 0], [0, 0]],
];

/// The cells around an edge in order, and the vertices of its link.
#[derive(Debug, Default, Clone)]
pub(in crate::subdiv) struct Ring {
    /// Link vertices, counter-clockwise seen from the second end of the edge towards the first.
    pub vertices: SmallVec<[u32; 12]>,
    /// Cell i holds link vertices i and i + 1 (cyclic if closed).
    pub cells: SmallVec<[u32; 12]>,
    /// False for an edge of the boundary, whose ring starts and ends with a boundary face.
    pub closed: bool,
}

/// What a cell (a, b, from, to), positive, is to the ring of edge (a, b).
#[derive(Clone, Copy, Default)]
struct Arc {
    from: u32,
    to: u32,
    cell: u32,
}

impl Solid {
    /// The ring of edge (a, b); `None` if the edge does not exist, its cells are not one fan, or more than
    /// [`LONGEST_RING`].
    pub(in crate::subdiv) fn ring(&self, a: u32, b: u32) -> Option<Ring> {
        // The shorter list is searched. Which cells are at the edge is as good as random: no branches on it.
        let (list, other) = if self.cells_at(a).len() <= self.cells_at(b).len() {
            (self.cells_at(a), b)
        } else {
            (self.cells_at(b), a)
        };
        let mut cells = [0; LONGEST_RING + 1];
        let mut count = 0;
        for &t in list {
            cells[count.min(LONGEST_RING)] = t;
            count += usize::from(has_vertex(self.tet(t), other));
        }
        if count > LONGEST_RING {
            return None;
        }
        let arc = |&t: &u32| {
            let tet = self.tet(t);
            let [k, l] = POSITIVE_REST[index_of(tet, a)][index_of(tet, b)];
            Arc { from: tet[k], to: tet[l], cell: t }
        };
        let mut arcs: SmallVec<[Arc; 12]> = cells[..count].iter().map(arc).collect();
        chain(&mut arcs)
    }

    /// Gives `each` the rings of the edges from `v` to vertices w with larger numbers, in ascending order of w, as far as they
    /// have one ([`Solid::ring`]) and a cell of it is `wanted`.
    pub(in crate::subdiv) fn rings_above(&self, v: u32, wanted: impl Fn(u32) -> bool, mut each: impl FnMut(u32, Ring)) {
        // All cells are fetched first: they are scattered in memory, and branches would keep the fetches apart.
        let cells: SmallVec<[(u32, [u32; 4]); 64]> = self.cells_at(v).iter().map(|&t| (t, self.tet(t))).collect();
        let mut arcs: SmallVec<[(u32, Arc); 64]> = SmallVec::new();
        for &(cell, tet) in &cells {
            let [p, q, r] = rest_of(tet, v);
            for (w, from, to) in [(p, q, r), (q, r, p), (r, p, q)] {
                if w > v {
                    arcs.push((w, Arc { from, to, cell }));
                }
            }
        }
        arcs.sort_unstable_by_key(|(w, arc)| u64::from(*w) << 32 | u64::from(arc.cell));
        for group in arcs.chunk_by(|(v, _), (w, _)| v == w) {
            if group.len() <= LONGEST_RING && group.iter().any(|(_, arc)| wanted(arc.cell)) {
                let mut ring: SmallVec<[Arc; 12]> = group.iter().map(|(_, arc)| *arc).collect();
                if let Some(ring) = chain(&mut ring) {
                    each(group[0].0, ring);
                }
            }
        }
    }
}

/// Orders arcs into one fan or cycle.
fn chain(arcs: &mut [Arc]) -> Option<Ring> {
    // In a cycle every vertex is met twice.
    let closed = arcs.iter().fold(0, |x, arc| x ^ arc.from ^ arc.to) == 0;
    if !closed {
        let first = (0..arcs.len()).find(|&i| arcs.iter().all(|a| a.to != arcs[i].from))?;
        arcs.swap(0, first);
    }
    let mut end = arcs.first()?.to;
    for i in 1..arcs.len() {
        let next = (i..arcs.len()).fold(usize::MAX, |next, j| if arcs[j].from == end { j } else { next });
        if next == usize::MAX {
            return None;
        }
        arcs.swap(i, next);
        end = arcs[i].to;
    }
    let mut vertices: SmallVec<[u32; 12]> = arcs.iter().map(|a| a.from).collect();
    if !closed {
        vertices.push(end);
    } else if end != arcs[0].from {
        return None;
    }
    Some(Ring { vertices, cells: arcs.iter().map(|a| a.cell).collect(), closed })
}

/// The other corners of a cell in an order that makes (v, rest) positive.
pub(in crate::subdiv) fn rest_of(tet: [u32; 4], v: u32) -> [u32; 3] {
    // Outward at the back is positive at the front.
    FACES[index_of(tet, v)].map(|k| tet[k])
}

/// Which corner of `tet` vertex `v` is; `v` is one of them.
fn index_of(tet: [u32; 4], v: u32) -> usize {
    usize::from(tet[1] == v) + 2 * usize::from(tet[2] == v) + 3 * usize::from(tet[3] == v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{generate, topology};

    #[test]
    fn rings_turn_once_around_their_edges() {
        let mesh = generate::box_tets([1.0; 3], [3; 3]).unwrap();
        let solid = Solid::new(&mesh);
        for [a, b] in topology::edges(mesh.tets()) {
            let ring = solid.ring(a, b).unwrap();
            let n = ring.vertices.len();
            assert_eq!(ring.closed, !solid.is_surface_edge([a, b]));
            for (i, &t) in ring.cells.iter().enumerate() {
                let cell = [a, b, ring.vertices[i], ring.vertices[(i + 1) % n]];
                assert_eq!(cell.len(), cell.iter().filter(|v| solid.tet(t).contains(v)).count());
                assert!(crate::mesh::quality::volume(cell.map(|v| solid.point(v))) > 0.0);
            }
        }
        assert!(solid.ring(0, mesh.points().len() as u32 - 1).is_none());
    }

    #[test]
    fn the_rings_at_a_vertex_are_those_of_its_edges() {
        let mesh = generate::box_tets([1.0; 3], [3; 3]).unwrap();
        let solid = Solid::new(&mesh);
        let mut found = Vec::new();
        for v in 0..mesh.points().len() as u32 {
            solid.rings_above(
                v,
                |_| true,
                |w, ring| {
                    let sorted = |cells: &[u32]| {
                        let mut cells = cells.to_vec();
                        cells.sort_unstable();
                        cells
                    };
                    let known = solid.ring(v, w).unwrap();
                    assert_eq!((ring.closed, sorted(&ring.cells)), (known.closed, sorted(&known.cells)));
                    // The same cycle, begun elsewhere.
                    let start = known.vertices.iter().position(|x| *x == ring.vertices[0]).unwrap();
                    let turned: Vec<u32> =
                        known.vertices.iter().cycle().skip(start).take(known.vertices.len()).copied().collect();
                    assert_eq!(ring.vertices[..], turned[..]);
                    found.push([v, w]);
                },
            );
        }
        assert_eq!(found, topology::edges(mesh.tets()));
        let mut of_a_cell = Vec::new();
        let a = solid.tet(7).into_iter().min().unwrap();
        solid.rings_above(a, |t| t == 7, |w, _| of_a_cell.push(w));
        assert_eq!(of_a_cell.len(), 3);
    }
}
