//! Meshes: positions, cells, tagged boundary faces, creases and corners; topology, quality, readers and generators.
//!
//! A mesh is a value. Its fields are private, [`TetMesh::new`] checks them, and refinement returns a new mesh.

pub mod contact;
mod error;
mod face_rows;
pub mod features;
pub mod generate;
pub mod hex;
pub mod locate;
pub mod midside;
pub mod quality;
pub mod read;
pub(crate) mod rows;
pub mod surface;
pub mod tet_oct;
pub mod topology;
pub mod weights;

pub use error::{MeshError, Place, Victim};

use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// Identifies a name in [`TetMesh::groups`] (named sets of boundary faces).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GroupId(pub u32);

/// Identifies a class of boundary faces that belong to exactly the same groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchId(pub u32);

/// Identifies a region (a named set of cells), an index into [`TetMesh::region_names`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RegionId(pub u16);

/// A boundary triangle: its vertices counter-clockwise seen from outside, and the patch it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// Vertex indices; `(b - a) x (c - a)` points out of the solid.
    pub vertices: [u32; 3],
    /// The set of groups the face belongs to, see [`TetMesh::patch_groups`].
    pub patch: PatchId,
}

/// An edge that subdivision keeps as an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crease {
    /// Vertex indices, the smaller first.
    pub vertices: [u32; 2],
    /// True for an edge above the feature angle or tagged by the user; false for an edge that is kept only because
    /// groups, supports, loads or regions meet there.
    pub feature: bool,
}

/// The fields of a [`TetMesh`] before they are checked.
#[derive(Debug, Clone, Default)]
pub struct TetMeshParts {
    /// Vertex positions.
    pub points: Vec<DVec3>,
    /// Four vertices a cell, positively oriented: `(b - a) x (c - a) . (d - a) > 0`.
    pub tets: Vec<[u32; 4]>,
    /// Region of each cell.
    pub regions: Vec<RegionId>,
    /// How many refinements made each cell.
    pub levels: Vec<u8>,
    /// All boundary faces, each exactly once; any order (they are sorted by [`TetMesh::new`]).
    pub faces: Vec<Face>,
    /// Creases; any order.
    pub creases: Vec<Crease>,
    /// Vertices that subdivision never moves; any order.
    pub corners: Vec<u32>,
    /// Names of the regions.
    pub region_names: Vec<String>,
    /// Names of the groups of boundary faces.
    pub groups: Vec<String>,
    /// The sorted groups of each patch.
    pub patches: Vec<Vec<GroupId>>,
}

/// A conforming tetrahedral mesh with tags.
#[derive(Debug, Clone)]
pub struct TetMesh {
    parts: TetMeshParts,
    /// The connected part of each cell and their number, from when they are first asked for.
    connected: OnceLock<Arc<(Vec<u32>, usize)>>,
}

impl TetMesh {
    /// Checks the parts and makes a mesh of them.
    ///
    /// # Errors
    /// Names the victim: an index out of range, a coordinate that is not finite, a repeated vertex, a cell whose volume
    /// is not positive, a face shared by more than two cells, a boundary face that is missing, foreign, or inward.
    pub fn new(parts: TetMeshParts) -> Result<Self, MeshError> {
        let mut parts = parts;
        sort(&mut parts);
        check(&parts)?;
        topology::check_boundary(&parts.tets, &parts.faces)?;
        Ok(Self { parts, connected: OnceLock::new() })
    }

    /// As [`TetMesh::new`], of parts whose boundary faces are those that `connection`, of the same cells, has found.
    fn connected(mut parts: TetMeshParts, connection: topology::Connection) -> Result<Self, MeshError> {
        sort(&mut parts);
        check(&parts)?;
        connection.crowded.map_or(Ok(()), Err)?;
        Ok(Self { parts, connected: OnceLock::from(Arc::new(connection.parts)) })
    }

    /// A mesh of one region `name` whose boundary faces are found and carry no group.
    ///
    /// # Errors
    /// As [`TetMesh::new`].
    pub fn from_cells(points: Vec<DVec3>, tets: Vec<[u32; 4]>, name: &str) -> Result<Self, MeshError> {
        topology::check_cells(&points, &tets)?;
        let faces = topology::boundary_faces(&tets);
        Self::new(TetMeshParts {
            regions: vec![RegionId(0); tets.len()],
            levels: vec![0; tets.len()],
            faces: faces.into_iter().map(|vertices| Face { vertices, patch: PatchId(0) }).collect(),
            region_names: vec![name.to_owned()],
            patches: vec![Vec::new()],
            points,
            tets,
            ..TetMeshParts::default()
        })
    }

    /// Gives the parts back, to build another mesh of them.
    #[must_use]
    pub fn into_parts(self) -> TetMeshParts {
        self.parts
    }

    /// Vertex positions.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.parts.points
    }

    /// Vertices of each cell, positively oriented.
    #[must_use]
    pub fn tets(&self) -> &[[u32; 4]] {
        &self.parts.tets
    }

    /// Region of each cell.
    #[must_use]
    pub fn regions(&self) -> &[RegionId] {
        &self.parts.regions
    }

    /// How many refinements made each cell.
    #[must_use]
    pub fn levels(&self) -> &[u8] {
        &self.parts.levels
    }

    /// Boundary faces, sorted by their sorted vertices.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
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

    /// The group of that name.
    #[must_use]
    pub fn group(&self, name: &str) -> Option<GroupId> {
        let index = self.parts.groups.iter().position(|g| g == name)?;
        u32::try_from(index).ok().map(GroupId)
    }

    /// Boundary faces of a group, in the order of [`TetMesh::faces`].
    pub fn group_faces(&self, group: GroupId) -> impl Iterator<Item = &Face> {
        let member: Vec<bool> = self.parts.patches.iter().map(|groups| groups.contains(&group)).collect();
        self.parts.faces.iter().filter(move |f| member[f.patch.0 as usize])
    }

    /// The mesh with one more group of boundary faces; `selected[i]` says whether `faces()[i]` belongs to it. Patches
    /// are split so that each still stands for one set of groups.
    ///
    /// # Errors
    /// [`MeshError::Inconsistent`] if the selection has not one entry a face.
    pub fn with_group(self, name: &str, selected: &[bool]) -> Result<(Self, GroupId), MeshError> {
        let mut parts = self.parts;
        if selected.len() != parts.faces.len() {
            let (got, want) = (selected.len(), parts.faces.len());
            return Err(MeshError::Inconsistent(format!(
                "group {name:?} selects among {got} faces, the mesh has {want}"
            )));
        }
        let group = GroupId(parts.groups.len() as u32);
        parts.groups.push(name.to_owned());
        split_patches(&mut parts.patches, parts.faces.iter_mut().map(|f| &mut f.patch), selected, group);
        Ok((Self { parts, connected: self.connected }, group))
    }

    /// The mesh with other creases (sorted, all naming vertices of this mesh).
    fn replace_features(self, creases: Vec<Crease>, corners: Vec<u32>) -> Self {
        Self { parts: TetMeshParts { creases, corners, ..self.parts }, connected: self.connected }
    }

    /// The connected part of each cell (cells are connected through faces), numbered by first cell, and the number of
    /// parts.
    #[must_use]
    pub fn connected_parts(&self) -> (&[u32], usize) {
        let (part, count) = &**self.connected.get_or_init(|| Arc::new(topology::parts(&self.parts.tets)));
        (part, *count)
    }

    /// Volume of cell `t`.
    #[must_use]
    pub fn cell_volume(&self, t: usize) -> f64 {
        quality::volume(self.cell_points(t))
    }

    /// The four positions of cell `t`.
    #[must_use]
    pub fn cell_points(&self, t: usize) -> [DVec3; 4] {
        self.parts.tets[t].map(|v| self.parts.points[v as usize])
    }

    /// Total volume.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.parts.tets.len()).map(|t| self.cell_volume(t)).sum()
    }

    /// Smallest and largest coordinates.
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
}

/// What meshes of all kinds of cells have: vertices, named regions of cells and named groups of boundary faces.
pub trait Tagged: Clone {
    /// Vertex positions.
    fn points(&self) -> &[DVec3];
    /// Number of boundary faces.
    fn face_count(&self) -> usize;
    /// Vertices of a boundary face.
    fn face_corners(&self, face: usize) -> &[u32];
    /// Outward normal of a boundary face, of the length of its area.
    fn face_area(&self, face: usize) -> DVec3;
    /// The sorted groups of a boundary face.
    fn face_groups(&self, face: usize) -> &[GroupId];
    /// The mesh with one more group of boundary faces, of which `selected` has one entry a face.
    ///
    /// # Errors
    /// [`MeshError::Inconsistent`] if it has not.
    fn and_group(self, name: &str, selected: &[bool]) -> Result<(Self, GroupId), MeshError>;

    /// The group of that name.
    fn group_named(&self, name: &str) -> Option<GroupId> {
        let index = self.groups().iter().position(|g| g == name)?;
        u32::try_from(index).ok().map(GroupId)
    }

    /// Boundary faces of a group, ascending.
    fn faces_of(&self, group: GroupId) -> impl Iterator<Item = usize> {
        (0..self.face_count()).filter(move |&f| self.face_groups(f).contains(&group))
    }

    /// Smallest and largest coordinates of the vertices.
    fn limits(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.points().iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }

    /// Names of the regions, indexed by [`RegionId`].
    fn region_names(&self) -> &[String];
    /// Region of each cell.
    fn regions(&self) -> &[RegionId];
    /// Names of the groups of boundary faces, indexed by [`GroupId`].
    fn groups(&self) -> &[String];
}

impl Tagged for TetMesh {
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
        self.with_group(name, selected)
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

/// Gives the selected faces, whose patches these are, a further group: patches are split so that each still stands for one
/// set of groups.
fn split_patches<'a>(
    patches: &mut Vec<Vec<GroupId>>,
    faces: impl Iterator<Item = &'a mut PatchId>,
    selected: &[bool],
    group: GroupId,
) {
    // The patch that a selected face of each old patch moves to, made when the first such face is met.
    let mut inside: Vec<Option<PatchId>> = vec![None; patches.len()];
    for (patch, _) in faces.zip(selected).filter(|(_, selected)| **selected) {
        let old = patch.0 as usize;
        *patch = *inside[old].get_or_insert_with(|| {
            let mut groups = patches[old].clone();
            groups.push(group);
            patches.push(groups);
            PatchId(patches.len() as u32 - 1)
        });
    }
}

/// Brings the lists whose order means nothing into one.
fn sort(parts: &mut TetMeshParts) {
    parts.faces.par_sort_unstable_by_key(|f| topology::sorted3(f.vertices));
    parts.creases.sort_unstable();
    parts.creases.dedup_by_key(|c| c.vertices);
    parts.corners.sort_unstable();
    parts.corners.dedup();
}

/// The checks of [`TetMesh::new`] but that of the boundary, on sorted parts.
fn check(parts: &TetMeshParts) -> Result<(), MeshError> {
    let lengths = [("regions", parts.regions.len()), ("levels", parts.levels.len())];
    for (what, len) in lengths {
        if len != parts.tets.len() {
            return Err(MeshError::Inconsistent(format!("{what}: {len} entries for {} cells", parts.tets.len())));
        }
    }
    if let Some(r) = parts.regions.iter().find(|r| r.0 as usize >= parts.region_names.len()) {
        return Err(MeshError::Inconsistent(format!("region {} has no name", r.0)));
    }
    if let Some(f) = parts.faces.iter().find(|f| f.patch.0 as usize >= parts.patches.len()) {
        return Err(MeshError::Inconsistent(format!("patch {} of face {:?} does not exist", f.patch.0, f.vertices)));
    }
    topology::check_cells(&parts.points, &parts.tets)?;
    topology::check_volumes(&parts.points, &parts.tets)?;
    topology::check_tagged_vertices(parts.points.len(), &parts.creases, &parts.corners)
}
