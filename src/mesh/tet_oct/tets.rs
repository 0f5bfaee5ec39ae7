//! Octahedra cut into tetrahedra, for analysis, for pictures and to locate points.

use super::{OCT_FACES, TetOctMesh};
use crate::mesh::{MeshError, TetMesh, TetMeshParts};
use glam::DVec3;

/// How octahedra are cut into tetrahedra. The eight outer triangles stay whole, so both make conforming meshes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum OctSplit {
    /// Four around the shortest diagonal; no new vertices.
    #[default]
    Diagonal,
    /// Eight around the centroid, which becomes a vertex.
    Centroid,
}

/// A mesh cut into tetrahedra.
#[derive(Debug, Clone)]
pub struct Tetrahedra {
    /// Vertices keep their numbers; the centroids of octahedra come after them.
    pub mesh: TetMesh,
    /// The octahedron that each cell is a part of; the first cells are those that were tetrahedra.
    pub octs: Vec<Option<u32>>,
}

impl TetOctMesh {
    /// Cuts the octahedra into tetrahedra.
    ///
    /// # Errors
    /// [`MeshError::NotPositive`] if a cell is inverted, so that this is no mesh of a solid.
    pub fn tetrahedra(&self, split: OctSplit) -> Result<Tetrahedra, MeshError> {
        let own = self.parts();
        let Cut { points, tets, octs } = self.cut(split);
        let of_oct = |o: u32| own.oct_regions[o as usize];
        let regions = octs.iter().enumerate().map(|(t, oct)| oct.map_or_else(|| own.tet_regions[t], of_oct)).collect();
        let mesh = TetMesh::new(TetMeshParts {
            levels: vec![own.level; tets.len()],
            points,
            tets,
            regions,
            faces: own.faces.clone(),
            creases: own.creases.clone(),
            corners: own.corners.clone(),
            region_names: own.region_names.clone(),
            groups: own.groups.clone(),
            patches: own.patches.clone(),
        })?;
        Ok(Tetrahedra { mesh, octs })
    }

    /// Cuts the octahedra of a mesh without tags around their shortest diagonals; the boundary is found.
    ///
    /// # Errors
    /// As [`TetOctMesh::tetrahedra`].
    pub fn untagged(&self) -> Result<Tetrahedra, MeshError> {
        let Cut { points, tets, octs } = self.cut(OctSplit::Diagonal);
        Ok(Tetrahedra { mesh: TetMesh::from_cells(points, tets, "solid")?, octs })
    }

    fn cut(&self, split: OctSplit) -> Cut {
        let mut points = self.points().to_vec();
        let mut tets = self.tets().to_vec();
        let mut octs = vec![None; tets.len()];
        for (o, oct) in (0..).zip(self.octs()) {
            match split {
                OctSplit::Diagonal => tets.extend(around_diagonal(oct, &points)),
                OctSplit::Centroid => {
                    let middle = points.len() as u32;
                    points.push(oct.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 6.0);
                    tets.extend(OCT_FACES.map(|[i, j, k]| [middle, oct[i], oct[j], oct[k]]));
                }
            }
            octs.resize(tets.len(), Some(o));
        }
        Cut { points, tets, octs }
    }
}

/// The lists of [`Tetrahedra`].
struct Cut {
    points: Vec<DVec3>,
    tets: Vec<[u32; 4]>,
    octs: Vec<Option<u32>>,
}

/// Four tetrahedra around the shortest diagonal, the first of equal ones.
pub(super) fn around_diagonal(oct: &[u32; 6], points: &[DVec3]) -> [[u32; 4]; 4] {
    let squared = |p: usize| points[oct[2 * p] as usize].distance_squared(points[oct[2 * p + 1] as usize]);
    let mut best = 0;
    for p in 1..3 {
        if squared(p) < squared(best) {
            best = p;
        }
    }
    let [q, r] = [(best + 1) % 3, (best + 2) % 3];
    let ring = [2 * q, 2 * r, 2 * q + 1, 2 * r + 1].map(|i| oct[i]);
    [0, 1, 2, 3].map(|i| [oct[2 * best + 1], oct[2 * best], ring[i], ring[(i + 1) % 4]])
}
