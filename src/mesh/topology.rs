//! Connectivity: faces, edges, neighbours. Nothing here but the volume check looks at positions.

use super::face_rows::{FaceRows, FaceUse};
use super::rows::Rows;
use super::{Crease, Face, MeshError, Victim, quality};
use glam::DVec3;
use rayon::prelude::*;

/// The three indices in ascending order.
#[must_use]
pub fn sorted3(mut v: [u32; 3]) -> [u32; 3] {
    v.sort_unstable();
    v
}

/// The two indices in ascending order.
#[must_use]
pub fn sorted2([a, b]: [u32; 2]) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The four outward faces of a positive tetrahedron; face `i` is opposite to vertex `i`.
#[must_use]
pub fn tet_faces(t: [u32; 4]) -> [[u32; 3]; 4] {
    quality::FACES.map(|f| f.map(|i| t[i]))
}

/// The six edges of a tetrahedron, each sorted, in the order of [`quality::EDGES`].
#[must_use]
pub fn tet_edges(t: [u32; 4]) -> [[u32; 2]; 6] {
    quality::EDGES.map(|[i, j]| sorted2([t[i], t[j]]))
}

/// How many rows a thread takes at a time.
const ROWS: usize = 1 << 12;

/// All edges of the cells, sorted, each once.
#[must_use]
pub fn edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let rows = Rows::new(vertex_count(tets), tets.len(), |t| tet_edges(tets[t]).map(|[a, b]| (a, b)));
    let of_rows = |first: usize| {
        let (mut edges, mut row) = (Vec::new(), Vec::new());
        for a in first..rows.len().min(first + ROWS) {
            row.clear();
            row.extend_from_slice(rows.row(a));
            row.sort_unstable();
            row.dedup();
            edges.extend(row.iter().map(|&b| [a as u32, b]));
        }
        edges
    };
    let firsts: Vec<usize> = (0..rows.len()).step_by(ROWS).collect();
    let edges: Vec<Vec<[u32; 2]>> = firsts.into_par_iter().map(of_rows).collect();
    edges.concat()
}

/// One more than the largest vertex of the cells.
pub(super) fn vertex_count(tets: &[[u32; 4]]) -> usize {
    tets.par_iter().with_min_len(ROWS).flatten_iter().max().map_or(0, |&v| v as usize + 1)
}

/// The edges of triangles, sorted by vertices, with the indices of the triangles at each.
#[must_use]
pub fn triangle_edges(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<([u32; 2], Vec<usize>)> {
    let sides = |(i, [a, b, c]): (usize, [u32; 3])| [[a, b], [b, c], [c, a]].map(|e| (sorted2(e), i));
    let mut uses: Vec<([u32; 2], usize)> = triangles.enumerate().flat_map(sides).collect();
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|u| u.1).collect())).collect()
}

/// Boundary faces of the cells, outward, sorted by their sorted vertices.
#[must_use]
pub fn boundary_faces(tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let rows = FaceRows::new(tets);
    let mut faces = Vec::new();
    rows.visit(|_, uses| only(uses).map(|face| rows.face(face)), |face| faces.push(face));
    faces
}

/// The cell of each boundary face, in the order of [`boundary_faces`] and of [`super::TetMesh::faces`].
#[must_use]
pub fn boundary_cells(tets: &[[u32; 4]]) -> Vec<u32> {
    let mut cells = Vec::new();
    FaceRows::new(tets).visit(|_, uses| only(uses).map(|face| face / 4), |cell| cells.push(cell));
    cells
}

/// The use of a face that has no other.
fn only(uses: &[FaceUse]) -> Option<u32> {
    if let [(_, face)] = uses { Some(*face) } else { None }
}

/// The two uses of a face between two cells.
fn pair(uses: &[FaceUse]) -> Option<[u32; 2]> {
    if let [(_, a), (_, b)] = uses { Some([*a, *b]) } else { None }
}

/// For each cell the neighbour across the face opposite to each vertex; `None` at the boundary.
#[must_use]
pub fn face_neighbours(tets: &[[u32; 4]]) -> Vec<[Option<u32>; 4]> {
    let mut neighbours = vec![[None; 4]; tets.len()];
    FaceRows::new(tets).visit(
        |_, uses| pair(uses),
        |[a, b]| {
            neighbours[a as usize / 4][a as usize % 4] = Some(b / 4);
            neighbours[b as usize / 4][b as usize % 4] = Some(a / 4);
        },
    );
    neighbours
}

/// What one look at all faces tells of distinct cells.
#[derive(Debug)]
pub(super) struct Connection {
    /// As [`boundary_faces`] gives them.
    pub(super) faces: Vec<[u32; 3]>,
    /// As [`parts`] gives them.
    pub(super) parts: (Vec<u32>, usize),
    /// [`MeshError::OvercrowdedFace`] of the first face with more than two cells.
    pub(super) crowded: Option<MeshError>,
}

/// The boundary and the parts, unless two cells have the same four vertices: then these, the second after the first.
pub(super) fn connect(tets: &[[u32; 4]]) -> Result<Connection, [usize; 2]> {
    enum Found {
        Boundary([u32; 3]),
        Between([u32; 2]),
        Same([usize; 2]),
        Crowded([u32; 3], usize),
    }
    let rows = FaceRows::new(tets);
    let (mut faces, mut roots, mut repeated, mut crowded) = (Vec::new(), Roots::new(tets.len()), None, None);
    rows.visit(
        |key, uses| {
            Some(match (only(uses), same_cells(tets, uses), pair(uses)) {
                (Some(face), ..) => Found::Boundary(rows.face(face)),
                (_, Some(cells), _) => Found::Same(cells),
                (.., Some(uses)) => Found::Between(uses),
                (.., None) => Found::Crowded(key, uses.len()),
            })
        },
        |found| match found {
            Found::Boundary(face) => faces.push(face),
            Found::Between(uses) => roots.join(uses),
            Found::Same(cells) => repeated = repeated.or(Some(cells)),
            Found::Crowded(face, count) => crowded = crowded.or(Some((face, count))),
        },
    );
    let crowded = crowded.map(|(key, count)| overcrowded(&rows, key, count));
    repeated.map_or_else(|| Ok(Connection { faces, parts: roots.number(), crowded }), Err)
}

/// Two cells at one face that are the same: so is the vertex opposite to it.
fn same_cells(tets: &[[u32; 4]], uses: &[FaceUse]) -> Option<[usize; 2]> {
    let opposite = |&(_, face): &FaceUse| (tets[face as usize / 4][face as usize % 4], face as usize / 4);
    if let [a, b] = uses {
        // Most faces have two cells: no list for them.
        let [a, b] = [opposite(a), opposite(b)];
        return (a.0 == b.0).then_some([a.1, b.1]);
    }
    let mut opposite: Vec<(u32, usize)> = uses.iter().map(opposite).collect();
    opposite.sort_unstable();
    opposite.windows(2).find(|two| two[0].0 == two[1].0).map(|two| [two[0].1, two[1].1])
}

/// Lists of cells by node, in one array (compressed rows).
#[derive(Debug, Clone)]
pub struct NodeCells(Rows);

/// Lists of cells by vertex.
pub type VertexCells = NodeCells;

impl NodeCells {
    /// Collects the cells at each of `count` nodes, in ascending order; `nodes` gives those of a cell.
    #[must_use]
    pub fn of<I: Iterator<Item = u32>>(count: usize, cells: usize, nodes: impl Fn(usize) -> I + Sync) -> Self {
        Self(Rows::new(count, cells, |t| nodes(t).map(move |v| (v, t as u32))))
    }

    /// Collects the cells at each of `vertex_count` vertices, in ascending order.
    #[must_use]
    pub fn new(vertex_count: usize, tets: &[[u32; 4]]) -> Self {
        Self::of(vertex_count, tets.len(), |t| tets[t].into_iter())
    }

    /// Cells at node `v`, ascending.
    #[must_use]
    pub fn at(&self, v: u32) -> &[u32] {
        self.0.row(v as usize)
    }
}

/// The connected part of each cell (cells are connected through faces), numbered by first cell, and the number of parts. A
/// mesh keeps its own: [`super::TetMesh::connected_parts`].
#[must_use]
pub fn parts(tets: &[[u32; 4]]) -> (Vec<u32>, usize) {
    let mut roots = Roots::new(tets.len());
    FaceRows::new(tets).visit(|_, uses| pair(uses), |uses| roots.join(uses));
    roots.number()
}

/// Cells being connected: each points to an earlier one of its part, the first to itself.
struct Roots(Vec<u32>);

impl Roots {
    fn new(cells: usize) -> Self {
        Self((0..cells as u32).collect())
    }

    /// The first cell of the part of `t`, as far as it is known; halves the path to it.
    fn find(&mut self, mut t: u32) -> u32 {
        let root = &mut self.0;
        while root[t as usize] != t {
            root[t as usize] = root[root[t as usize] as usize];
            t = root[t as usize];
        }
        t
    }

    /// Connects the cells of two uses `4 t + i` of a face.
    fn join(&mut self, uses: [u32; 2]) {
        let [a, b] = uses.map(|face| self.find(face / 4));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The number of each cell's part, and how many there are.
    fn number(self) -> (Vec<u32>, usize) {
        let mut part = self.0;
        let mut count = 0;
        for t in 0..part.len() {
            // An earlier cell has the number of its part already.
            part[t] = if part[t] as usize == t {
                count += 1;
                count - 1
            } else {
                part[part[t] as usize]
            };
        }
        (part, count as usize)
    }
}

/// Checks positions and indices: finite, in range, no repeated vertex.
pub(super) fn check_cells(points: &[DVec3], tets: &[[u32; 4]]) -> Result<(), MeshError> {
    if tets.is_empty() {
        return Err(MeshError::NoCells);
    }
    if let Some(vertex) = points.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { vertex, position: points[vertex] });
    }
    let outside = |v: &&u32| **v as usize >= points.len();
    let bad = |t: &[u32; 4]| t.iter().any(|v| outside(&v)) || tet_edges(*t).iter().any(|[a, b]| a == b);
    let Some(cell) = tets.par_iter().with_min_len(ROWS).position_first(bad) else { return Ok(()) };
    let vertices = tets[cell];
    Err(match vertices.iter().find(outside) {
        Some(&vertex) => MeshError::VertexOutOfRange { cell, vertices, vertex, count: points.len() },
        None => MeshError::RepeatedVertex(victim(points, tets, cell)),
    })
}

/// Checks that every cell has a positive volume ([`quality::is_positive`]); names the worst.
pub(super) fn check_volumes(points: &[DVec3], tets: &[[u32; 4]]) -> Result<(), MeshError> {
    let corners = |cell: usize| tets[cell].map(|v| points[v as usize]);
    let volume = |cell: usize| quality::volume(corners(cell));
    let cells = (0..tets.len()).into_par_iter().with_min_len(ROWS);
    let bad: Vec<usize> = cells.filter(|&t| !quality::is_positive(corners(t))).collect();
    let worst = bad.iter().copied().min_by(|&a, &b| volume(a).total_cmp(&volume(b)));
    match worst {
        None => Ok(()),
        Some(cell) => {
            Err(MeshError::NotPositive { worst: victim(points, tets, cell), volume: volume(cell), count: bad.len() })
        }
    }
}

/// Checks that `faces` (sorted) are exactly the boundary of the cells, outward, and that no face has three cells.
pub(super) fn check_boundary(tets: &[[u32; 4]], faces: &[Face]) -> Result<(), MeshError> {
    let rows = FaceRows::new(tets);
    let mut listed = faces.iter().peekable();
    let mut fault = None;
    rows.visit(
        |key, uses| (uses.len() != 2).then(|| (key, uses.len(), uses[0].1)),
        |(key, count, face)| {
            if fault.is_none() {
                fault = check_face(&rows, &mut listed, key, count, face).err();
            }
        },
    );
    match (fault, listed.next()) {
        (Some(fault), _) => Err(fault),
        (None, Some(face)) => Err(unmatched(&rows, face)),
        (None, None) => Ok(()),
    }
}

/// Checks the next face that is not between two cells against the next of the list.
fn check_face<'a>(
    rows: &FaceRows,
    listed: &mut std::iter::Peekable<impl Iterator<Item = &'a Face>>,
    key: [u32; 3],
    count: usize,
    face: u32,
) -> Result<(), MeshError> {
    if count > 2 {
        return Err(overcrowded(rows, key, count));
    }
    let Some(found) = listed.next_if(|f| sorted3(f.vertices) <= key) else {
        let problem = "is missing from the list of boundary faces";
        return Err(MeshError::Boundary { vertices: key, problem });
    };
    if sorted3(found.vertices) < key {
        return Err(unmatched(rows, found));
    }
    let outward = rows.face(face);
    if (0..3).any(|r| (0..3).all(|i| found.vertices[i] == outward[(i + r) % 3])) {
        return Ok(());
    }
    Err(MeshError::Boundary { vertices: found.vertices, problem: "is oriented inward" })
}

/// The error of a face with more than two cells.
fn overcrowded(rows: &FaceRows, vertices: [u32; 3], count: usize) -> MeshError {
    MeshError::OvercrowdedFace { vertices, count, cells: rows.cells_at(vertices) }
}

/// Why a listed face is none of the boundary.
fn unmatched(rows: &FaceRows, face: &Face) -> MeshError {
    let inside = rows.cells_at(sorted3(face.vertices)).len() == 2;
    let problem = if inside { "lies between two cells" } else { "belongs to no cell, or is listed twice" };
    MeshError::Boundary { vertices: face.vertices, problem }
}

/// Checks that creases and corners name vertices that exist.
pub(super) fn check_tagged_vertices(count: usize, creases: &[Crease], corners: &[u32]) -> Result<(), MeshError> {
    let tagged = creases.iter().flat_map(|c| c.vertices).chain(corners.iter().copied());
    match tagged.into_iter().find(|&v| v as usize >= count) {
        Some(v) => Err(MeshError::Inconsistent(format!("a crease or corner names vertex {v} of {count}"))),
        None => Ok(()),
    }
}

/// Names a cell for an error message.
#[must_use]
pub fn victim(points: &[DVec3], tets: &[[u32; 4]], cell: usize) -> Victim {
    let vertices = tets[cell];
    let centroid = vertices.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 4.0;
    Victim { cell, vertices, centroid }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate;
    use proptest::prelude::*;
    use std::collections::{BTreeMap, BTreeSet};

    /// The cells of a box that `keep` says, which may hang together or not.
    fn some_cells(keep: &[bool]) -> Vec<[u32; 4]> {
        let mesh = generate::box_tets([1.0; 3], [3; 3]).unwrap();
        mesh.tets().iter().zip(keep).filter(|(_, keep)| **keep).map(|(&tet, _)| tet).collect()
    }

    /// The cells at each face, and which of their faces it is.
    fn uses(tets: &[[u32; 4]]) -> BTreeMap<[u32; 3], Vec<(usize, usize)>> {
        let mut uses = BTreeMap::<_, Vec<_>>::new();
        for (t, &tet) in tets.iter().enumerate() {
            for (i, face) in tet_faces(tet).into_iter().enumerate() {
                uses.entry(sorted3(face)).or_default().push((t, i));
            }
        }
        uses
    }

    proptest! {
        #[test]
        fn faces_neighbours_parts_and_edges_are_those_of_a_plain_search(
            keep in prop::collection::vec(prop::bool::weighted(0.7), 162)
        ) {
            let tets = some_cells(&keep);
            let uses = uses(&tets);
            let single: Vec<(usize, usize)> = uses.values().filter(|u| u.len() == 1).map(|u| u[0]).collect();
            let faces: Vec<[u32; 3]> = single.iter().map(|&(t, i)| tet_faces(tets[t])[i]).collect();
            prop_assert_eq!(boundary_faces(&tets), faces.clone());
            prop_assert_eq!(boundary_cells(&tets), single.iter().map(|&(t, _)| t as u32).collect::<Vec<_>>());

            let mut neighbours = vec![[None; 4]; tets.len()];
            for pair in uses.values().filter(|u| u.len() == 2) {
                neighbours[pair[0].0][pair[0].1] = Some(pair[1].0 as u32);
                neighbours[pair[1].0][pair[1].1] = Some(pair[0].0 as u32);
            }
            prop_assert_eq!(&face_neighbours(&tets), &neighbours);

            // The smallest cell reached from each, until nothing changes.
            let mut first: Vec<usize> = (0..tets.len()).collect();
            let mut changed = true;
            while std::mem::take(&mut changed) {
                for t in 0..tets.len() {
                    let around = neighbours[t].iter().flatten().map(|&u| first[u as usize]);
                    let least = around.chain([first[t]]).min().unwrap();
                    changed |= least < first[t];
                    first[t] = least;
                }
            }
            let roots: Vec<usize> = first.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
            let part = first.iter().map(|f| roots.binary_search(f).unwrap() as u32).collect::<Vec<_>>();
            prop_assert_eq!(parts(&tets), (part, roots.len()));
            let connection = connect(&tets).unwrap();
            prop_assert_eq!((connection.faces, connection.parts), (faces, parts(&tets)));
            prop_assert!(connection.crowded.is_none());

            let all: BTreeSet<[u32; 2]> = tets.iter().flat_map(|&tet| tet_edges(tet)).collect();
            prop_assert_eq!(edges(&tets), all.into_iter().collect::<Vec<_>>());
        }

        #[test]
        fn a_repeated_cell_is_found(t in 0..162_usize, place in 0..=162_usize, turn in 0..4_usize) {
            let mut tets = some_cells(&[true; 162]);
            let mut again = tets[t];
            again.rotate_left(turn);
            tets.insert(place, again);
            let original = if place <= t { t + 1 } else { t };
            prop_assert_eq!(connect(&tets).err(), Some([original.min(place), original.max(place)]));
        }
    }
}
