//! Which edges and vertices of the boundary subdivision has to keep, and which meshes it can smooth.

use super::{HexError, HexMesh};
use crate::mesh::{Crease, GroupId};
use glam::DVec3;

/// Normal of a quadrilateral, by its diagonals; its length is twice the area of a flat one.
#[must_use]
pub fn face_normal(points: &[DVec3], vertices: [u32; 4]) -> DVec3 {
    let [a, b, c, d] = vertices.map(|v| points[v as usize]);
    (c - a).cross(d - b)
}

impl HexMesh {
    /// The mesh with its creases found: the edges of a single cell, those where the boundary turns by more than `angle`
    /// degrees, and those where one of the groups `bounded` ends. All but the last kind are features. Creases and corners
    /// that the mesh has are kept.
    #[must_use]
    pub fn with_creases(self, angle: f64, bounded: &[GroupId]) -> Self {
        let topology = &self.topology;
        let member = |f: usize, g: &GroupId| self.parts.patches[self.parts.faces[f].patch.0 as usize].contains(g);
        let mut found = Vec::new();
        for (e, &vertices) in (0..).zip(topology.edges()) {
            let at: Vec<usize> = topology.boundary_faces_at(e).filter_map(|f| topology.boundary_index(f)).collect();
            let [f, g] = at[..] else { continue };
            let [m, n] = [f, g].map(|f| face_normal(&self.parts.points, self.parts.faces[f].vertices));
            let turn = m.cross(n).length().atan2(m.dot(n)).to_degrees();
            let feature = topology.edge_cells(e).len() == 1 || turn > angle;
            if feature || bounded.iter().any(|group| member(f, group) != member(g, group)) {
                found.push(Crease { vertices, feature });
            }
        }
        self.and_creases(found)
    }

    /// The mesh with more creases, edges of the boundary.
    #[must_use]
    pub fn and_creases(mut self, more: Vec<Crease>) -> Self {
        let creases = &mut self.parts.creases;
        creases.extend(more);
        creases.sort_unstable_by_key(|c| (c.vertices, !c.feature));
        creases.dedup_by_key(|c| c.vertices);
        self
    }

    /// Checks that the limit of subdivision is a solid: three cells or more at each interior edge, a surface without
    /// self-contact as boundary, and creases along edges of a single cell.
    ///
    /// # Errors
    /// [`HexError::LowValence`], [`HexError::NotManifold`], [`HexError::SmoothSingleCell`].
    pub fn check_smoothable(&self) -> Result<(), HexError> {
        let topology = &self.topology;
        for (e, &edge) in (0..).zip(topology.edges()) {
            let (cells, faces) = (topology.edge_cells(e).len(), topology.boundary_faces_at(e).count());
            let at = edge.map(|v| self.parts.points[v as usize]);
            let at = at[0].midpoint(at[1]);
            match (faces, cells) {
                (0, ..3) => return Err(HexError::LowValence { edge, cells, at }),
                (0 | 2, _) => {}
                _ => return Err(HexError::NotManifold { what: "edge", vertices: edge.to_vec(), at }),
            }
            let crease = self.parts.creases.binary_search_by_key(&edge, |c| c.vertices);
            if faces == 2 && cells == 1 && crease.is_err() {
                return Err(HexError::SmoothSingleCell { edge, at });
            }
        }
        let touching = (0..self.parts.points.len() as u32).find(|&v| !self.is_one_fan(v));
        touching.map_or(Ok(()), |v| {
            let at = self.parts.points[v as usize];
            Err(HexError::NotManifold { what: "vertex", vertices: vec![v], at })
        })
    }

    /// Whether the cells at a vertex hang together through faces, and the boundary faces there through edges.
    fn is_one_fan(&self, v: u32) -> bool {
        let topology = &self.topology;
        let cells = topology.vertex_cells(v);
        let faces_of = |t: u32| topology.cell_faces()[t as usize].into_iter();
        let cells_hang = hangs(cells, |t, u| {
            faces_of(t)
                .any(|f| topology.face_cells()[f as usize].contains(&u) && topology.faces()[f as usize].contains(&v))
        });
        let mut faces: Vec<u32> = cells.iter().flat_map(|&t| faces_of(t)).collect();
        faces.retain(|&f| topology.is_boundary(f) && topology.faces()[f as usize].contains(&v));
        let edges_of = |f: u32| topology.face_edges()[f as usize];
        let faces_hang = hangs(&faces, |f, g| {
            edges_of(f).iter().any(|&e| edges_of(g).contains(&e) && topology.edges()[e as usize].contains(&v))
        });
        cells_hang && faces_hang
    }
}

/// Whether items are connected by a relation.
fn hangs(items: &[u32], related: impl Fn(u32, u32) -> bool) -> bool {
    let Some((&first, _)) = items.split_first() else { return true };
    let (mut reached, mut next) = (vec![first], 0);
    while next < reached.len() {
        let from = reached[next];
        next += 1;
        for &item in items {
            if !reached.contains(&item) && related(from, item) {
                reached.push(item);
            }
        }
    }
    reached.len() == items.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::hex::{FACES, HexMeshParts, QuadFace};
    use crate::mesh::{PatchId, RegionId};

    /// Two cells that share two faces cannot both have corners that are not twisted; refinement may still meet them.
    #[test]
    fn two_cells_at_an_interior_edge_are_refused_by_name() {
        let cells = vec![[0, 1, 2, 3, 4, 5, 6, 7], [1, 8, 3, 2, 5, 9, 7, 6]];
        let points = [
            [0, 0, 0],
            [2, 0, 0],
            [0, 2, 0],
            [1, 1, 0],
            [0, 0, 1],
            [2, 0, 1],
            [0, 2, 1],
            [1, 1, 1],
            [4, 4, 0],
            [4, 4, 1],
        ];
        let own = |t: usize| FACES.map(|f| f.map(|c| cells[t][c]));
        let inner = |f: &[u32; 4]| f.contains(&3) && f.contains(&7);
        let faces = [own(0), own(1)].concat().into_iter().filter(|f| !inner(f));
        let mesh = HexMesh::refined(HexMeshParts {
            points: points.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect(),
            faces: faces.map(|vertices| QuadFace { vertices, patch: PatchId(0) }).collect(),
            regions: vec![RegionId(0); 2],
            region_names: vec!["solid".to_owned()],
            patches: vec![Vec::new()],
            cells,
            ..HexMeshParts::default()
        });
        let refused = mesh.unwrap().with_creases(30.0, &[]).check_smoothable();
        assert!(matches!(refused, Err(HexError::LowValence { edge: [3, 7], cells: 2, .. })), "{refused:?}");
    }
}
