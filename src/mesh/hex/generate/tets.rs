//! Tetrahedra split into hexahedra.

use super::super::{HexMeshParts, QuadFace};
use super::{HexError, HexMesh};
use crate::mesh::topology::{edges, sorted2, sorted3};
use crate::mesh::{Crease, Face, TetMesh};

/// The other vertices of a tetrahedron seen from each, so that the four are positive.
const FROM: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]];

/// Each tetrahedron split into four hexahedra, one at each of its vertices, by the middles of its edges, its faces and itself;
/// cell `t` gives the cells `4 t` to `4 t + 3`. Regions, groups, creases and corners stay.
///
/// # Errors
/// [`HexError::Generator`] if there would be too many vertices.
pub fn from_tets(mesh: &TetMesh) -> Result<HexMesh, HexError> {
    let tets = mesh.tets();
    let edges = edges(tets);
    let mut faces: Vec<[u32; 3]> =
        tets.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]].map(sorted3)).collect();
    faces.sort_unstable();
    faces.dedup();
    let counts = [mesh.points().len(), edges.len(), faces.len(), tets.len()];
    let total: usize = counts.iter().sum();
    if u32::try_from(total).is_err() {
        return Err(HexError::Generator(format!("{} tetrahedra split into hexahedra: too many vertices", tets.len())));
    }
    let first = [counts[0], counts[0] + counts[1], total - counts[3]].map(|n| n as u32);
    let middle = |e: [u32; 2]| first[0] + edges.partition_point(|x| *x < sorted2(e)) as u32;
    let centre = |f: [u32; 3]| first[1] + faces.partition_point(|x| *x < sorted3(f)) as u32;
    let at = |v: u32| mesh.points()[v as usize];
    let mut points = mesh.points().to_vec();
    points.extend(edges.iter().map(|&[a, b]| at(a).midpoint(at(b))));
    points.extend(faces.iter().map(|&[a, b, c]| (at(a) + at(b) + at(c)) / 3.0));
    points.extend(tets.iter().map(|&[a, b, c, d]| (at(a) + at(b) + at(c) + at(d)) / 4.0));
    let cell = |t: usize, k: usize| {
        let [a, b, c, d] = FROM[k].map(|i| tets[t][i]);
        let sides = [centre([a, b, c]), centre([a, b, d]), centre([a, c, d])];
        [a, middle([a, b]), middle([a, c]), sides[0], middle([a, d]), sides[1], sides[2], first[2] + t as u32]
    };
    let quads = |face: &Face| {
        let ([a, b, c], patch) = (face.vertices, face.patch);
        let quad = |[a, b, c]: [u32; 3]| [a, middle([a, b]), centre([a, b, c]), middle([c, a])];
        [[a, b, c], [b, c, a], [c, a, b]].map(|corners| QuadFace { vertices: quad(corners), patch })
    };
    let halves = |crease: &Crease| {
        let middle = middle(crease.vertices);
        crease.vertices.map(|v| Crease { vertices: [v, middle], feature: crease.feature })
    };
    HexMesh::new(HexMeshParts {
        cells: (0..tets.len()).flat_map(|t| (0..4).map(move |k| (t, k))).map(|(t, k)| cell(t, k)).collect(),
        regions: mesh.regions().iter().flat_map(|r| [*r; 4]).collect(),
        faces: mesh.faces().iter().flat_map(quads).collect(),
        creases: mesh.creases().iter().flat_map(halves).collect(),
        corners: mesh.corners().to_vec(),
        middles: Vec::new(),
        region_names: mesh.region_names().to_vec(),
        groups: mesh.groups().to_vec(),
        patches: mesh.patch_groups().to_vec(),
        points,
    })
}
