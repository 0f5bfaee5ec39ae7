//! Meshes of tetrahedra and octahedra: the control meshes of smooth tetrahedral subdivision (Schaefer, Hakenberg and Warren
//! 2004).
//!
//! An octahedron is kept as its three pairs of opposite vertices `[a, a', b, b', c, c']`, oriented so that
//! `(a - a') x (b - b') . (c - c') > 0`. Its eight faces take one vertex of each pair.

mod edges;
mod tets;

pub use edges::{CellEdges, EdgeUse};
pub use tets::{OctSplit, Tetrahedra};

use super::{Crease, Face, GroupId, RegionId, TetMesh, quality, surface};
use glam::DVec3;
use rayon::prelude::*;

/// The vertices at both ends of the twelve edges of an octahedron, as places in its list.
pub const OCT_EDGES: [[usize; 2]; 12] =
    [[0, 2], [0, 3], [1, 2], [1, 3], [0, 4], [0, 5], [1, 4], [1, 5], [2, 4], [2, 5], [3, 4], [3, 5]];

/// Its eight faces, counter-clockwise seen from outside; face `i` is opposite to face `7 - i`.
pub const OCT_FACES: [[usize; 3]; 8] =
    [[0, 2, 4], [0, 5, 2], [0, 4, 3], [0, 3, 5], [1, 4, 2], [1, 2, 5], [1, 3, 4], [1, 5, 3]];

/// The fields of a [`TetOctMesh`].
#[derive(Debug, Clone, Default)]
pub struct TetOctParts {
    /// Vertex positions.
    pub points: Vec<DVec3>,
    /// Four vertices a tetrahedron, positively oriented.
    pub tets: Vec<[u32; 4]>,
    /// Three pairs of opposite vertices an octahedron, positively oriented.
    pub octs: Vec<[u32; 6]>,
    /// Region of each tetrahedron.
    pub tet_regions: Vec<RegionId>,
    /// Region of each octahedron.
    pub oct_regions: Vec<RegionId>,
    /// How many steps made the mesh.
    pub level: u8,
    /// All boundary faces, outward.
    pub faces: Vec<Face>,
    /// The crease surfaces inside: the faces between cells of different regions, each once.
    pub interfaces: Vec<[u32; 3]>,
    /// Creases.
    pub creases: Vec<Crease>,
    /// Vertices that subdivision never moves.
    pub corners: Vec<u32>,
    /// Names of the regions.
    pub region_names: Vec<String>,
    /// Names of the groups of boundary faces.
    pub groups: Vec<String>,
    /// The sorted groups of each patch.
    pub patches: Vec<Vec<GroupId>>,
}

/// A conforming mesh of tetrahedra and octahedra with tags. Its cells are numbered tetrahedra first.
#[derive(Debug, Clone)]
pub struct TetOctMesh(TetOctParts);

impl From<&TetMesh> for TetOctMesh {
    fn from(mesh: &TetMesh) -> Self {
        let interfaces = surface::interfaces(mesh).into_iter().map(|f| f.vertices).collect();
        let parts = mesh.clone().into_parts();
        Self(TetOctParts {
            points: parts.points,
            tets: parts.tets,
            tet_regions: parts.regions,
            level: parts.levels.iter().copied().max().unwrap_or(0),
            faces: parts.faces,
            interfaces,
            creases: parts.creases,
            corners: parts.corners,
            region_names: parts.region_names,
            groups: parts.groups,
            patches: parts.patches,
            ..TetOctParts::default()
        })
    }
}

impl TetOctMesh {
    /// A mesh of parts that subdivision has made of those of another: nothing is checked. Its cells may be inverted where a
    /// control mesh is too twisted to be smoothed; [`TetOctMesh::tetrahedra`] looks.
    pub(crate) fn refined(parts: TetOctParts) -> Self {
        Self(parts)
    }

    /// The parts.
    #[must_use]
    pub fn parts(&self) -> &TetOctParts {
        &self.0
    }

    /// Gives the parts back.
    #[must_use]
    pub fn into_parts(self) -> TetOctParts {
        self.0
    }

    /// Vertex positions.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.0.points
    }

    /// Vertices of each tetrahedron.
    #[must_use]
    pub fn tets(&self) -> &[[u32; 4]] {
        &self.0.tets
    }

    /// Vertices of each octahedron, in opposite pairs.
    #[must_use]
    pub fn octs(&self) -> &[[u32; 6]] {
        &self.0.octs
    }

    /// Number of cells.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.0.tets.len() + self.0.octs.len()
    }

    /// The mesh with its vertices at other places.
    #[must_use]
    pub fn with_points(&self, points: Vec<DVec3>) -> Self {
        debug_assert_eq!(points.len(), self.0.points.len());
        Self(TetOctParts { points, ..self.0.clone() })
    }

    /// Total volume: that of the tetrahedra, and of octahedra as cones of their faces over their centroids.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let at = |v: u32| self.0.points[v as usize];
        let tets: f64 = self.0.tets.iter().map(|t| quality::volume(t.map(at))).sum();
        tets + self.0.octs.iter().map(|o| oct_volume(o.map(at))).sum::<f64>()
    }

    /// The smallest of the volumes of the tetrahedra and of the eight cones of the octahedra, over the mean of their absolute
    /// values: positive exactly where no cell is inverted.
    #[must_use]
    pub fn worst_volume(&self) -> f64 {
        let at = |v: u32| self.0.points[v as usize];
        let tets = self.0.tets.par_iter().map(|t| quality::volume(t.map(at)));
        let cones = self.0.octs.par_iter().flat_map_iter(|o| oct_cones(o.map(at)));
        let volumes: Vec<f64> = tets.chain(cones).collect();
        let mean = volumes.iter().map(|v| v.abs()).sum::<f64>() / volumes.len().max(1) as f64;
        volumes.into_iter().fold(f64::INFINITY, f64::min) / mean
    }
}

/// Volumes of the cones of the faces over the centroid of an octahedron.
#[must_use]
pub fn oct_cones(p: [DVec3; 6]) -> [f64; 8] {
    let centroid = p.iter().sum::<DVec3>() / 6.0;
    OCT_FACES.map(|[i, j, k]| quality::volume([centroid, p[i], p[j], p[k]]))
}

/// Volume of an octahedron, whose faces are flat.
#[must_use]
pub fn oct_volume(p: [DVec3; 6]) -> f64 {
    oct_cones(p).iter().sum()
}
