//! Which edges subdivision has to keep.

use super::surface::{SurfaceFace, surface_edges, surface_faces};
use super::{Crease, Face, TetMesh, topology};
use glam::DVec3;

/// The mesh with its creases found: every edge where the boundary, or inside an interface between two regions, turns by
/// more than `angle` degrees (strictly), every edge of the boundary with other than two boundary faces, every edge in
/// `tagged`, and every edge between different patches or regions: where patches, interfaces, or an interface and the
/// boundary meet. All but the last kind are features. Vertices where surfaces touch become corners.
#[must_use]
pub fn with_creases(mesh: TetMesh, angle: f64, tagged: &[[u32; 2]]) -> TetMesh {
    let faces = surface_faces(&mesh);
    let edges = surface_edges(&faces);
    let mut creases: Vec<Crease> = edges
        .iter()
        .filter_map(|&(vertices, ref at)| {
            let feature = is_sharp(mesh.points(), &faces, at, angle);
            let border = at.len() != 2 || faces[at[0]].patch != faces[at[1]].patch;
            (feature || border).then_some(Crease { vertices, feature })
        })
        .collect();
    creases.extend(tagged.iter().map(|&e| Crease { vertices: topology::sorted2(e), feature: true }));
    // One entry an edge; a feature wins.
    creases.sort_unstable_by_key(|c| (c.vertices, !c.feature));
    creases.dedup_by_key(|c| c.vertices);
    let mut corners = [mesh.corners(), &touching(&faces, &edges)].concat();
    corners.sort_unstable();
    corners.dedup();
    mesh.replace_features(creases, corners)
}

/// True if the boundary turns by more than `angle` at the edge of these faces, or is no surface there; or inside, where
/// one interface has the edge, if that turns.
fn is_sharp(points: &[DVec3], faces: &[SurfaceFace], at: &[usize], angle: f64) -> bool {
    let (boundary, inside): (Vec<usize>, Vec<usize>) = at.iter().partition(|&&f| faces[f].outer.is_none());
    let turns = |f: usize, g: usize| turn(points, faces[f].vertices, faces[g].vertices) > angle;
    match (&boundary[..], &inside[..]) {
        (&[f, g], _) | (&[], &[f, g]) => turns(f, g),
        (&[], _) => false,
        _ => true,
    }
}

/// The vertices whose surface faces do not hang together through edges: surfaces touch there, and no rule for one
/// surface may move them.
fn touching(faces: &[SurfaceFace], edges: &[([u32; 2], Vec<usize>)]) -> Vec<u32> {
    // Corner k of face f has number 3 f + k; those at one vertex that hang together have one root.
    let mut parents: Vec<usize> = (0..3 * faces.len()).collect();
    let corner =
        |f: usize, v: u32| 3 * f + usize::from(faces[f].vertices[1] == v) + 2 * usize::from(faces[f].vertices[2] == v);
    for (ends, around) in edges {
        for &v in ends {
            for pair in around.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|f| root(&mut parents, corner(f, v)));
                parents[a.max(b)] = a.min(b);
            }
        }
    }
    let mut roots: Vec<u32> =
        (0..parents.len()).filter(|&c| parents[c] == c).map(|c| faces[c / 3].vertices[c % 3]).collect();
    roots.sort_unstable();
    roots.chunk_by(|a, b| a == b).filter(|same| same.len() > 1).map(|same| same[0]).collect()
}

/// The edges with more than two boundary faces, and the vertices whose boundary faces do not hang together through edges; ascending.
#[must_use]
pub fn pinches(faces: &[Face]) -> (Vec<[u32; 2]>, Vec<u32>) {
    let surface = |f: &Face| SurfaceFace { vertices: f.vertices, inner: 0, outer: None, patch: None };
    let surface: Vec<SurfaceFace> = faces.iter().map(surface).collect();
    let edges = surface_edges(&surface);
    let pinched = edges.iter().filter(|(_, around)| around.len() > 2).map(|(edge, _)| *edge).collect();
    (pinched, touching(&surface, &edges))
}

/// The root of a corner; halves the way to it for the next time.
fn root(parents: &mut [usize], mut corner: usize) -> usize {
    while parents[corner] != corner {
        parents[corner] = parents[parents[corner]];
        corner = parents[corner];
    }
    corner
}

/// The edges of the boundary, sorted by vertices, with the indices of the faces at each.
#[must_use]
pub fn boundary_edges(faces: &[Face]) -> Vec<([u32; 2], Vec<usize>)> {
    topology::triangle_edges(faces.iter().map(|f| f.vertices))
}

/// Angle in degrees between the outward normals of two faces, given by their indices in `mesh.faces()`.
#[must_use]
pub fn angle_between(mesh: &TetMesh, f: usize, g: usize) -> f64 {
    turn(mesh.points(), mesh.faces()[f].vertices, mesh.faces()[g].vertices)
}

/// Angle in degrees between the normals of two triangles.
fn turn(points: &[DVec3], f: [u32; 3], g: [u32; 3]) -> f64 {
    let [m, n] = [f, g].map(|vertices| face_normal(points, vertices));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;

    /// Two bricks, the second moved, with the vertices at the same place made one.
    fn two_bricks(offset: DVec3) -> TetMesh {
        let brick = box_tets([1.0; 3], [2; 3]).unwrap();
        let mut points = brick.points().to_vec();
        let number = |p: DVec3, points: &mut Vec<DVec3>| {
            points.iter().position(|q| q.distance(p) < 1e-12).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            }) as u32
        };
        let moved: Vec<u32> = brick.points().iter().map(|p| number(*p + offset, &mut points)).collect();
        let other = brick.tets().iter().map(|t| t.map(|v| moved[v as usize]));
        let tets = brick.tets().iter().copied().chain(other).collect();
        TetMesh::from_cells(points, tets, "solid").unwrap()
    }

    #[test]
    fn where_surfaces_touch_in_a_vertex_there_is_a_corner() {
        let mesh = with_creases(two_bricks(DVec3::ONE), 180.0, &[]);
        let [corner] = *mesh.corners() else { panic!("{:?}", mesh.corners()) };
        assert_eq!(mesh.points()[corner as usize], DVec3::ONE);
        assert!(mesh.creases().is_empty());
    }

    /// Along an edge of four faces there is a crease, and the surface hangs together.
    #[test]
    fn where_surfaces_touch_in_an_edge_there_is_a_crease() {
        let mesh = with_creases(two_bricks(DVec3::new(1.0, 1.0, 0.0)), 180.0, &[]);
        assert_eq!((feature_count_and_length(&mesh), mesh.corners()), ((2, 1.0), &[][..]));
        assert!(with_creases(two_bricks(DVec3::X), 180.0, &[]).corners().is_empty());
    }
}
