//! Which edges of the boundary subdivision has to keep.

use super::{Crease, Face, TetMesh, topology};
use glam::DVec3;

/// The mesh with its creases found: every boundary edge whose outward normals differ by more than `angle` degrees
/// (strictly), every edge with other than two boundary faces, every edge in `tagged`, and every edge between different
/// patches or regions. All but the last kind are features.
#[must_use]
pub fn with_creases(mesh: TetMesh, angle: f64, tagged: &[[u32; 2]]) -> TetMesh {
    let cells = topology::boundary_cells(mesh.tets());
    let tag = |i: usize| (mesh.faces()[i].patch, mesh.regions()[cells[i] as usize]);
    let mut creases: Vec<Crease> = boundary_edges(mesh.faces())
        .into_iter()
        .filter_map(|(vertices, faces)| {
            let feature = !matches!(faces[..], [f, g] if angle_between(&mesh, f, g) <= angle);
            let border = faces.iter().any(|&f| tag(f) != tag(faces[0]));
            (feature || border).then_some(Crease { vertices, feature })
        })
        .collect();
    creases.extend(tagged.iter().map(|&e| Crease { vertices: topology::sorted2(e), feature: true }));
    // One entry an edge; a feature wins.
    creases.sort_unstable_by_key(|c| (c.vertices, !c.feature));
    creases.dedup_by_key(|c| c.vertices);
    mesh.replace_creases(creases)
}

/// The edges of the boundary, sorted by vertices, with the indices of the faces at each.
#[must_use]
pub fn boundary_edges(faces: &[Face]) -> Vec<([u32; 2], Vec<usize>)> {
    let mut uses: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * faces.len());
    for (i, f) in faces.iter().enumerate() {
        let [a, b, c] = f.vertices;
        uses.extend([[a, b], [b, c], [c, a]].map(|e| (topology::sorted2(e), i)));
    }
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|u| u.1).collect())).collect()
}

/// Angle in degrees between the outward normals of two faces, given by their indices in `mesh.faces()`.
#[must_use]
pub fn angle_between(mesh: &TetMesh, f: usize, g: usize) -> f64 {
    let [m, n] = [f, g].map(|i| face_normal(mesh.points(), mesh.faces()[i].vertices));
    m.cross(n).length().atan2(m.dot(n)).to_degrees()
}

/// Outward normal of a boundary face; its length is twice the area.
#[must_use]
pub fn face_normal(points: &[DVec3], vertices: [u32; 3]) -> DVec3 {
    let [a, b, c] = vertices.map(|v| points[v as usize]);
    (b - a).cross(c - a)
}

/// Number and total length of the feature edges.
#[must_use]
pub fn feature_count_and_length(mesh: &TetMesh) -> (usize, f64) {
    mesh.creases().iter().filter(|c| c.feature).fold((0, 0.0), |(n, length), c| {
        let [a, b] = c.vertices.map(|v| mesh.points()[v as usize]);
        (n + 1, length + (b - a).length())
    })
}
