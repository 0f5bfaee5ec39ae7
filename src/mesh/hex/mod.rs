//! Hexahedral meshes: positions, cells, tagged boundary faces, creases and corners.
//!
//! Corner `c` of a cell lies at `(c & 1, c >> 1 & 1, c >> 2)` of its unit cube. (VTK, Gmsh and Abaqus swap the third and the
//! fourth corner of each layer; [`from_vtk_order`] and [`to_vtk_order`] translate.)

pub mod curved;
mod error;
pub mod features;
pub mod generate;
pub mod read;
mod topology;

pub use error::HexError;
pub(crate) use error::check_cells;
pub use topology::{HexTopology, NONE};

use super::{Crease, GroupId, MeshError, PatchId, RegionId, Tagged};
use glam::{DMat3, DVec3};

/// Corners of the faces of a cell, counter-clockwise seen from outside: face `2 a + s` lies at coordinate `s` of axis `a`.
pub const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Corners of the edges of a cell, the lower first: four along each axis.
pub const EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

/// A cell whose corners are in VTK's order, in ours.
#[must_use]
pub fn from_vtk_order([a, b, c, d, e, f, g, h]: [u32; 8]) -> [u32; 8] {
    [a, b, d, c, e, f, h, g]
}

/// A cell in VTK's order of corners.
#[must_use]
pub fn to_vtk_order(cell: [u32; 8]) -> [u32; 8] {
    // Its own inverse.
    from_vtk_order(cell)
}

/// A boundary quadrilateral: its vertices counter-clockwise seen from outside, and the patch it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadFace {
    /// Vertex indices.
    pub vertices: [u32; 4],
    /// The set of groups the face belongs to, see [`HexMesh::patch_groups`].
    pub patch: PatchId,
}

/// The fields of a [`HexMesh`] before they are checked.
#[derive(Debug, Clone, Default)]
pub struct HexMeshParts {
    /// Vertex positions.
    pub points: Vec<DVec3>,
    /// Eight vertices a cell, positively oriented.
    pub cells: Vec<[u32; 8]>,
    /// Region of each cell.
    pub regions: Vec<RegionId>,
    /// All boundary faces, each exactly once; any order (they are brought into that of [`HexTopology`]).
    pub faces: Vec<QuadFace>,
    /// Creases of the boundary; any order.
    pub creases: Vec<Crease>,
    /// Vertices that subdivision never moves; any order.
    pub corners: Vec<u32>,
    /// The middles of edges, faces and cells, in the order of [`HexTopology`], if cells are curved; else empty.
    pub middles: Vec<DVec3>,
    /// Names of the regions.
    pub region_names: Vec<String>,
    /// Names of the groups of boundary faces.
    pub groups: Vec<String>,
    /// The sorted groups of each patch.
    pub patches: Vec<Vec<GroupId>>,
}

/// A conforming hexahedral mesh with tags.
#[derive(Debug, Clone)]
pub struct HexMesh {
    parts: HexMeshParts,
    topology: HexTopology,
}

impl HexMesh {
    /// Checks the parts and makes a mesh of them.
    ///
    /// # Errors
    /// Names the victim: an index out of range, a coordinate that is not finite, a repeated vertex, a twisted cell, a face
    /// shared by more than two cells, a boundary face that is missing or foreign.
    pub fn new(parts: HexMeshParts) -> Result<Self, HexError> {
        error::check_lists(&parts)?;
        check_cells(&parts.points, &parts.cells)?;
        Self::refined(parts)
    }

    /// As [`HexMesh::new`], of a control mesh that subdivision has made: its cells may be twisted where the limit is not.
    ///
    /// # Errors
    /// As [`HexMesh::new`], but for twisted cells.
    pub(crate) fn refined(mut parts: HexMeshParts) -> Result<Self, HexError> {
        error::check_lists(&parts)?;
        let topology = HexTopology::new(parts.points.len(), &parts.cells)?;
        topology.order_boundary(&mut parts.faces)?;
        parts.creases.sort_unstable_by_key(|c| (c.vertices, !c.feature));
        parts.creases.dedup_by_key(|c| c.vertices);
        parts.corners.sort_unstable();
        parts.corners.dedup();
        error::check_tags(&parts, &topology)?;
        Ok(Self { parts, topology })
    }

    /// A mesh of one region "solid"; a boundary face belongs to the groups whose predicate takes all its vertices.
    ///
    /// # Errors
    /// As [`HexMesh::new`].
    pub fn tagged(
        points: Vec<DVec3>,
        cells: Vec<[u32; 8]>,
        groups: &[(&str, &dyn Fn(u32) -> bool)],
    ) -> Result<Self, HexError> {
        let topology = HexTopology::new(points.len(), &cells)?;
        let mut patches: Vec<Vec<GroupId>> = Vec::new();
        let mut faces = Vec::new();
        for vertices in topology.boundary().map(|(_, vertices)| vertices) {
            let taken = |(_, (_, takes)): &(u32, &(&str, &dyn Fn(u32) -> bool))| vertices.iter().all(|&v| takes(v));
            let own: Vec<GroupId> = (0..).zip(groups).filter(taken).map(|(g, _)| GroupId(g)).collect();
            let patch = patches.iter().position(|p| *p == own).unwrap_or_else(|| {
                patches.push(own);
                patches.len() - 1
            });
            faces.push(QuadFace { vertices, patch: PatchId(patch as u32) });
        }
        Self::new(HexMeshParts {
            regions: vec![RegionId(0); cells.len()],
            region_names: vec!["solid".to_owned()],
            groups: groups.iter().map(|(name, _)| (*name).to_owned()).collect(),
            patches,
            faces,
            points,
            cells,
            ..HexMeshParts::default()
        })
    }

    /// Gives the parts back, to build another mesh of them.
    #[must_use]
    pub fn into_parts(self) -> HexMeshParts {
        self.parts
    }

    /// Vertex positions.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.parts.points
    }

    /// Vertices of each cell.
    #[must_use]
    pub fn cells(&self) -> &[[u32; 8]] {
        &self.parts.cells
    }

    /// Region of each cell.
    #[must_use]
    pub fn regions(&self) -> &[RegionId] {
        &self.parts.regions
    }

    /// Boundary faces, in the order of [`HexTopology::boundary`].
    #[must_use]
    pub fn faces(&self) -> &[QuadFace] {
        &self.parts.faces
    }

    /// Creases, sorted by vertices.
    #[must_use]
    pub fn creases(&self) -> &[Crease] {
        &self.parts.creases
    }

    /// Vertices that subdivision never moves, sorted.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.parts.corners
    }

    /// The middles of edges, faces and cells, in the order of [`HexTopology`], if cells are curved; else empty.
    #[must_use]
    pub fn middles(&self) -> &[DVec3] {
        &self.parts.middles
    }

    /// The mesh with these middles: as many as edges, faces and cells.
    pub(crate) fn with_middles(mut self, middles: Vec<DVec3>) -> Self {
        self.parts.middles = middles;
        self
    }

    /// Names of the regions, indexed by [`RegionId`].
    #[must_use]
    pub fn region_names(&self) -> &[String] {
        &self.parts.region_names
    }

    /// Names of the groups of boundary faces, indexed by [`GroupId`].
    #[must_use]
    pub fn groups(&self) -> &[String] {
        &self.parts.groups
    }

    /// The sorted groups of each patch, indexed by [`PatchId`].
    #[must_use]
    pub fn patch_groups(&self) -> &[Vec<GroupId>] {
        &self.parts.patches
    }

    /// Edges, faces and what meets where.
    #[must_use]
    pub fn topology(&self) -> &HexTopology {
        &self.topology
    }

    /// The group of that name.
    #[must_use]
    pub fn group(&self, name: &str) -> Option<GroupId> {
        let index = self.parts.groups.iter().position(|g| g == name)?;
        u32::try_from(index).ok().map(GroupId)
    }

    /// Indices in [`HexMesh::faces`] of the faces of a group, ascending.
    pub fn group_faces(&self, group: GroupId) -> impl Iterator<Item = usize> + '_ {
        let member: Vec<bool> = self.parts.patches.iter().map(|groups| groups.contains(&group)).collect();
        (0..self.parts.faces.len()).filter(move |&f| member[self.parts.faces[f].patch.0 as usize])
    }

    /// The mesh with one more group of boundary faces; `selected[i]` says whether `faces()[i]` belongs to it.
    #[must_use]
    pub fn with_group(mut self, name: &str, selected: &[bool]) -> (Self, GroupId) {
        let group = GroupId(self.parts.groups.len() as u32);
        self.parts.groups.push(name.to_owned());
        let (patches, faces) = (&mut self.parts.patches, &mut self.parts.faces);
        super::split_patches(patches, faces.iter_mut().map(|f| &mut f.patch), selected, group);
        (self, group)
    }

    /// The connected part of each cell (cells are connected through faces), numbered by first cell, and the number of
    /// parts.
    #[must_use]
    pub fn connected_parts(&self) -> (Vec<u32>, usize) {
        let (topology, count) = (&self.topology, self.parts.cells.len());
        let (mut part, mut parts) = (vec![NONE; count], 0);
        for first in 0..count {
            if part[first] != NONE {
                continue;
            }
            part[first] = parts;
            let mut open = vec![first];
            while let Some(t) = open.pop() {
                for u in topology.cell_faces()[t].into_iter().flat_map(|f| topology.face_cells()[f as usize]) {
                    if u != NONE && part[u as usize] == NONE {
                        part[u as usize] = parts;
                        open.push(u as usize);
                    }
                }
            }
            parts += 1;
        }
        (part, parts as usize)
    }

    /// The eight positions of cell `t`.
    #[must_use]
    pub fn cell_points(&self, t: usize) -> [DVec3; 8] {
        self.parts.cells[t].map(|v| self.parts.points[v as usize])
    }

    /// Smallest and largest coordinates of the vertices.
    #[must_use]
    pub fn bounding_box(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.parts.points.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }

    /// Length of the diagonal of the bounding box, the scale of geometric tolerances.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounding_box();
        (hi - lo).length()
    }

    /// Volume of the trilinear cells.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.parts.cells.len()).map(|t| cell_volume(&self.cell_points(t))).sum()
    }
}

impl Tagged for HexMesh {
    fn points(&self) -> &[DVec3] {
        self.points()
    }

    fn face_count(&self) -> usize {
        self.faces().len()
    }

    fn face_corners(&self, face: usize) -> &[u32] {
        &self.faces()[face].vertices
    }

    fn face_area(&self, face: usize) -> DVec3 {
        0.5 * features::face_normal(self.points(), self.faces()[face].vertices)
    }

    fn face_groups(&self, face: usize) -> &[GroupId] {
        &self.patch_groups()[self.faces()[face].patch.0 as usize]
    }

    fn and_group(self, name: &str, selected: &[bool]) -> Result<(Self, GroupId), MeshError> {
        if selected.len() == self.faces().len() {
            return Ok(self.with_group(name, selected));
        }
        let (got, want) = (selected.len(), self.faces().len());
        Err(MeshError::Inconsistent(format!("group {name:?} selects among {got} faces, the mesh has {want}")))
    }

    fn region_names(&self) -> &[String] {
        self.region_names()
    }

    fn regions(&self) -> &[RegionId] {
        self.regions()
    }

    fn groups(&self) -> &[String] {
        self.groups()
    }
}

/// The derivatives of the trilinear map of a cell at a point of the unit cube, in the columns.
#[must_use]
pub fn jacobian(points: &[DVec3; 8], at: DVec3) -> DMat3 {
    let side = |axis: usize, c: usize| if c >> axis & 1 == 1 { at[axis] } else { 1.0 - at[axis] };
    let sign = |axis: usize, c: usize| if c >> axis & 1 == 1 { 1.0 } else { -1.0 };
    let derivative = |axis: usize| {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        (0..8).map(|c| sign(axis, c) * side(u, c) * side(v, c) * points[c]).sum()
    };
    DMat3::from_cols(derivative(0), derivative(1), derivative(2))
}

/// Smallest angle in degrees between two faces of a cell, at its corners.
#[must_use]
pub fn min_dihedral(points: &[DVec3; 8]) -> f64 {
    let mut least = 180.0_f64;
    for corner in 0..8_usize {
        let at = DVec3::from_array([0, 1, 2].map(|axis| (corner >> axis & 1) as f64));
        let frame = jacobian(points, at);
        for axis in 0..3 {
            let edge = frame.col(axis);
            // Into the two faces at the edge.
            let into = |a: usize| if corner >> a & 1 == 1 { -frame.col(a) } else { frame.col(a) };
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|a| into(a).reject_from(edge));
            least = least.min(u.angle_between(v).to_degrees());
        }
    }
    least
}

/// Volume of a trilinear cell: its Jacobian determinant has degree two in each coordinate, so two Gauss points are exact.
#[must_use]
pub fn cell_volume(points: &[DVec3; 8]) -> f64 {
    let x = 0.5 - 0.5 / 3.0_f64.sqrt();
    let at = |c: usize| DVec3::from_array([0, 1, 2].map(|axis| if c >> axis & 1 == 1 { 1.0 - x } else { x }));
    (0..8).map(|c| jacobian(points, at(c)).determinant() / 8.0).sum()
}
