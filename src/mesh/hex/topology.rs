//! Edges and faces of a hexahedral mesh, and what meets where.

use super::super::rows::Rows;
use super::{EDGES, FACES, HexError, QuadFace};
use crate::mesh::topology::sorted2;

/// No cell: the other side of a boundary face.
pub const NONE: u32 = u32::MAX;

/// Edges and faces of a mesh. Edges are sorted by their vertices, faces by their sorted vertices.
#[derive(Debug, Clone)]
pub struct HexTopology {
    edges: Vec<[u32; 2]>,
    faces: Vec<[u32; 4]>,
    cell_edges: Vec<[u32; 12]>,
    cell_faces: Vec<[u32; 6]>,
    face_cells: Vec<[u32; 2]>,
    face_edges: Vec<[u32; 4]>,
    edge_cells: Rows,
    edge_faces: Rows,
    vertex_cells: Rows,
    vertex_edges: Rows,
    boundary: Vec<u32>,
}

impl HexTopology {
    /// Finds edges and faces of cells over `vertices` vertices.
    ///
    /// # Errors
    /// [`HexError::VertexOutOfRange`], [`HexError::RepeatedVertex`], [`HexError::CrowdedFace`], [`HexError::InwardFace`].
    pub(crate) fn new(vertices: usize, cells: &[[u32; 8]]) -> Result<Self, HexError> {
        super::error::check_vertices(vertices, cells)?;
        let (edges, cell_edges) = numbered(cells, |cell, e| sorted2(EDGES[e].map(|c| cell[c])));
        let (keys, cell_faces) = numbered(cells, |cell, f| sorted4(FACES[f].map(|c| cell[c])));
        let mut faces = vec![[NONE; 4]; keys.len()];
        let mut face_cells = vec![[NONE; 2]; keys.len()];
        for (t, own) in cell_faces.iter().enumerate() {
            for (k, &f) in own.iter().enumerate() {
                let vertices = FACES[k].map(|c| cells[t][c]);
                match &mut face_cells[f as usize] {
                    [first @ NONE, _] => {
                        *first = t as u32;
                        faces[f as usize] = vertices;
                    }
                    [first, second @ NONE] => {
                        let first = *first;
                        *second = t as u32;
                        if !is_reversed(faces[f as usize], vertices) {
                            return Err(HexError::InwardFace { cells: [first as usize, t], vertices });
                        }
                    }
                    [first, second] => {
                        let cells = [*first as usize, *second as usize, t];
                        return Err(HexError::CrowdedFace { cells, vertices });
                    }
                }
            }
        }
        let number = |a: u32, b: u32| edges.partition_point(|e| *e < sorted2([a, b])) as u32;
        let face_edges: Vec<[u32; 4]> =
            faces.iter().map(|f| std::array::from_fn(|i| number(f[i], f[(i + 1) % 4]))).collect();
        let boundary = (0..faces.len() as u32).filter(|&f| face_cells[f as usize][1] == NONE).collect();
        Ok(Self {
            edge_cells: users(edges.len(), &cell_edges),
            edge_faces: users(edges.len(), &face_edges),
            vertex_cells: users(vertices, cells),
            vertex_edges: users(vertices, &edges),
            edges,
            faces,
            cell_edges,
            cell_faces,
            face_cells,
            face_edges,
            boundary,
        })
    }

    /// Vertices of each edge, the smaller first.
    #[must_use]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Vertices of each face, counter-clockwise seen from outside its first cell.
    #[must_use]
    pub fn faces(&self) -> &[[u32; 4]] {
        &self.faces
    }

    /// Edges of each cell, in the order of [`EDGES`].
    #[must_use]
    pub fn cell_edges(&self) -> &[[u32; 12]] {
        &self.cell_edges
    }

    /// Faces of each cell, in the order of [`FACES`].
    #[must_use]
    pub fn cell_faces(&self) -> &[[u32; 6]] {
        &self.cell_faces
    }

    /// The one or two cells of each face; the second is [`NONE`] on the boundary.
    #[must_use]
    pub fn face_cells(&self) -> &[[u32; 2]] {
        &self.face_cells
    }

    /// Edges of each face: from its first vertex to the second, and so on.
    #[must_use]
    pub fn face_edges(&self) -> &[[u32; 4]] {
        &self.face_edges
    }

    /// Cells at an edge, ascending.
    #[must_use]
    pub fn edge_cells(&self, edge: u32) -> &[u32] {
        self.edge_cells.row(edge as usize)
    }

    /// Faces at an edge, ascending.
    #[must_use]
    pub fn edge_faces(&self, edge: u32) -> &[u32] {
        self.edge_faces.row(edge as usize)
    }

    /// Cells at a vertex, ascending.
    #[must_use]
    pub fn vertex_cells(&self, vertex: u32) -> &[u32] {
        self.vertex_cells.row(vertex as usize)
    }

    /// Edges at a vertex, ascending.
    #[must_use]
    pub fn vertex_edges(&self, vertex: u32) -> &[u32] {
        self.vertex_edges.row(vertex as usize)
    }

    /// The faces of the boundary with their vertices, outward; ascending.
    pub fn boundary(&self) -> impl Iterator<Item = (u32, [u32; 4])> + '_ {
        self.boundary.iter().map(|&f| (f, self.faces[f as usize]))
    }

    /// Whether a face lies on the boundary.
    #[must_use]
    pub fn is_boundary(&self, face: u32) -> bool {
        self.face_cells[face as usize][1] == NONE
    }

    /// The place of a face among those of the boundary.
    #[must_use]
    pub fn boundary_index(&self, face: u32) -> Option<usize> {
        self.boundary.binary_search(&face).ok()
    }

    /// The face that is number `index` on the boundary.
    #[must_use]
    pub fn boundary_number(&self, index: usize) -> u32 {
        self.boundary[index]
    }

    /// The edge between two vertices.
    #[must_use]
    pub fn edge(&self, ends: [u32; 2]) -> Option<u32> {
        self.edges.binary_search(&sorted2(ends)).ok().map(|e| e as u32)
    }

    /// Faces of the boundary at an edge.
    pub fn boundary_faces_at(&self, edge: u32) -> impl Iterator<Item = u32> + '_ {
        self.edge_faces(edge).iter().copied().filter(|&f| self.is_boundary(f))
    }

    /// Brings given boundary faces into the order of [`HexTopology::boundary`], with the vertices as they stand there.
    pub(super) fn order_boundary(&self, faces: &mut [QuadFace]) -> Result<(), HexError> {
        faces.sort_by_key(|f| sorted4(f.vertices));
        let mut want = self.boundary();
        for face in faces.iter_mut() {
            let (key, found) = (sorted4(face.vertices), want.next());
            match found {
                Some((_, vertices)) if sorted4(vertices) == key => face.vertices = vertices,
                Some((_, vertices)) if sorted4(vertices) < key => return Err(HexError::MissingFace { vertices }),
                _ => return Err(HexError::ForeignFace { vertices: face.vertices }),
            }
        }
        want.next().map_or(Ok(()), |(_, vertices)| Err(HexError::MissingFace { vertices }))
    }
}

/// Which items have each of `count` things, ascending.
fn users<const N: usize>(count: usize, items: &[[u32; N]]) -> Rows {
    Rows::new(count, items.len(), |i| items[i].map(|thing| (thing, i as u32)))
}

/// The distinct keys of all cells, sorted, and the number of each cell's own.
fn numbered<K: Ord + Copy, const N: usize>(
    cells: &[[u32; 8]],
    key: impl Fn(&[u32; 8], usize) -> K,
) -> (Vec<K>, Vec<[u32; N]>) {
    let mut all: Vec<(K, u32, u8)> = Vec::with_capacity(N * cells.len());
    for (t, cell) in cells.iter().enumerate() {
        all.extend((0..N).map(|i| (key(cell, i), t as u32, i as u8)));
    }
    all.sort_unstable();
    let (mut keys, mut numbers) = (Vec::new(), vec![[0; N]; cells.len()]);
    for (key, t, i) in all {
        if keys.last() != Some(&key) {
            keys.push(key);
        }
        numbers[t as usize][i as usize] = keys.len() as u32 - 1;
    }
    (keys, numbers)
}

fn sorted4(mut vertices: [u32; 4]) -> [u32; 4] {
    vertices.sort_unstable();
    vertices
}

/// Whether `b` runs round the same quadrilateral as `a` the other way.
fn is_reversed(a: [u32; 4], b: [u32; 4]) -> bool {
    (0..4).any(|shift| (0..4).all(|i| b[(4 + shift - i) % 4] == a[i]))
}
