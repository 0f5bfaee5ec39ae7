//! Connectivity: faces, edges, neighbours. Nothing here but the volume check looks at positions.

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

/// All edges of the cells, sorted, each once.
#[must_use]
pub fn edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let mut all: Vec<[u32; 2]> = tets.iter().flat_map(|&t| tet_edges(t)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// A face of a cell: its sorted vertices, the cell, and which of its four faces it is.
type FaceUse = ([u32; 3], u32, u8);

/// Every face of every cell, sorted so that the uses of one face stand together.
fn face_uses(tets: &[[u32; 4]]) -> Vec<FaceUse> {
    let mut uses: Vec<FaceUse> = Vec::with_capacity(4 * tets.len());
    for (t, &tet) in tets.iter().enumerate() {
        for (i, f) in tet_faces(tet).into_iter().enumerate() {
            uses.push((sorted3(f), t as u32, i as u8));
        }
    }
    // No two uses are equal, so the order does not depend on the number of threads.
    uses.par_sort_unstable();
    uses
}

/// Boundary faces of the cells, outward, sorted by their sorted vertices.
#[must_use]
pub fn boundary_faces(tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let uses = face_uses(tets);
    uses.chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() == 1)
        .map(|same| tet_faces(tets[same[0].1 as usize])[same[0].2 as usize])
        .collect()
}

/// The cell of each boundary face, in the order of [`boundary_faces`] and of [`super::TetMesh::faces`].
#[must_use]
pub fn boundary_cells(tets: &[[u32; 4]]) -> Vec<u32> {
    face_uses(tets).chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].1).collect()
}

/// For each cell the neighbour across the face opposite to each vertex; `None` at the boundary.
#[must_use]
pub fn face_neighbours(tets: &[[u32; 4]]) -> Vec<[Option<u32>; 4]> {
    let mut neighbours = vec![[None; 4]; tets.len()];
    for same in face_uses(tets).chunk_by(|a, b| a.0 == b.0) {
        if let [(_, t, i), (_, u, j)] = *same {
            neighbours[t as usize][i as usize] = Some(u);
            neighbours[u as usize][j as usize] = Some(t);
        }
    }
    neighbours
}

/// Lists of cells by vertex, in one array (compressed rows).
#[derive(Debug, Clone)]
pub struct VertexCells {
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl VertexCells {
    /// Collects the cells at each of `vertex_count` vertices, in ascending order.
    #[must_use]
    pub fn new(vertex_count: usize, tets: &[[u32; 4]]) -> Self {
        let mut starts = vec![0_u32; vertex_count + 1];
        for &v in tets.iter().flatten() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut cells = vec![0_u32; 4 * tets.len()];
        for (t, tet) in tets.iter().enumerate() {
            for &v in tet {
                cells[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        Self { starts, cells }
    }

    /// Cells at vertex `v`, ascending.
    #[must_use]
    pub fn at(&self, v: u32) -> &[u32] {
        &self.cells[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}

/// The connected part of each cell (cells are connected through faces), numbered by first cell, and the number of parts.
#[must_use]
pub fn parts(tets: &[[u32; 4]]) -> (Vec<u32>, usize) {
    let neighbours = face_neighbours(tets);
    let mut part = vec![u32::MAX; tets.len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for start in 0..tets.len() {
        if part[start] != u32::MAX {
            continue;
        }
        part[start] = count;
        stack.push(start);
        while let Some(t) = stack.pop() {
            for u in neighbours[t].into_iter().flatten() {
                if part[u as usize] == u32::MAX {
                    part[u as usize] = count;
                    stack.push(u as usize);
                }
            }
        }
        count += 1;
    }
    (part, count as usize)
}

/// Checks positions and indices: finite, in range, no repeated vertex.
pub(super) fn check_cells(points: &[DVec3], tets: &[[u32; 4]]) -> Result<(), MeshError> {
    if tets.is_empty() {
        return Err(MeshError::NoCells);
    }
    if let Some(vertex) = points.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { vertex, position: points[vertex] });
    }
    for (cell, &vertices) in tets.iter().enumerate() {
        if let Some(&vertex) = vertices.iter().find(|&&v| v as usize >= points.len()) {
            return Err(MeshError::VertexOutOfRange { cell, vertices, vertex, count: points.len() });
        }
        if tet_edges(vertices).iter().any(|[a, b]| a == b) {
            return Err(MeshError::RepeatedVertex(victim(points, tets, cell)));
        }
    }
    Ok(())
}

/// Checks that every cell has a positive volume ([`quality::is_positive`]); names the worst.
pub(super) fn check_volumes(points: &[DVec3], tets: &[[u32; 4]]) -> Result<(), MeshError> {
    let corners = |cell: usize| tets[cell].map(|v| points[v as usize]);
    let volume = |cell: usize| quality::volume(corners(cell));
    let bad: Vec<usize> = (0..tets.len()).filter(|&t| !quality::is_positive(corners(t))).collect();
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
    let uses = face_uses(tets);
    let mut listed = faces.iter().peekable();
    for same in uses.chunk_by(|a, b| a.0 == b.0) {
        let key = same[0].0;
        if same.len() > 2 {
            let cells = same.iter().map(|u| u.1 as usize).collect();
            return Err(MeshError::OvercrowdedFace { vertices: key, count: same.len(), cells });
        }
        let Some(face) = listed.next_if(|f| sorted3(f.vertices) <= key) else {
            if same.len() == 1 {
                return Err(MeshError::Boundary {
                    vertices: key,
                    problem: "is missing from the list of boundary faces",
                });
            }
            continue;
        };
        let problem = |problem| Err(MeshError::Boundary { vertices: face.vertices, problem });
        if sorted3(face.vertices) < key {
            return problem("belongs to no cell, or is listed twice");
        }
        if same.len() == 2 {
            return problem("lies between two cells");
        }
        let outward = tet_faces(tets[same[0].1 as usize])[same[0].2 as usize];
        if !(0..3).any(|r| (0..3).all(|i| face.vertices[i] == outward[(i + r) % 3])) {
            return problem("is oriented inward");
        }
    }
    match listed.next() {
        Some(face) => {
            Err(MeshError::Boundary { vertices: face.vertices, problem: "belongs to no cell, or is listed twice" })
        }
        None => Ok(()),
    }
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
