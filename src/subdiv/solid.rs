//! The mesh while it is being changed: cells with their incidence lists, the surface, the creases.
//!
//! Only vertex-to-cell lists are kept; everything else (rings of edges, cells at a face) is found from them. Slots of
//! removed cells are used again. Vertices keep their numbers; those that lost their cells are dropped at the very end
//! (`compact`), if at all.

use super::Stencil;
use crate::mesh::surface::interfaces;
use crate::mesh::{Crease, Face, MeshError, PatchId, RegionId, TetMesh, TetMeshParts, quality, topology};
mod compact;
mod frames;
mod journal;
mod ring;

use frames::Stages;
use glam::DVec3;
use journal::{Change, Journal};
pub(super) use ring::{Ring, rest_of};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

/// Marks a free slot.
const DEAD: u32 = u32::MAX;

/// The patch number of faces between two regions, which belong to the surface but not to the boundary.
const INTERFACE: PatchId = PatchId(u32::MAX);

/// What a cell hands on to the cells that take its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellTag {
    pub region: RegionId,
    pub level: u8,
}

/// A mesh being changed.
pub(super) struct Solid {
    points: Vec<DVec3>,
    /// How each added vertex was made.
    transfer: Vec<Stencil>,
    tets: Vec<[u32; 4]>,
    tags: Vec<CellTag>,
    sines: Vec<f64>,
    stamps: Vec<u32>,
    clock: u32,
    free: Vec<u32>,
    cells_at: Vec<Vec<u32>>,
    faces: Vec<Face>,
    free_faces: Vec<u32>,
    faces_at: Vec<Vec<u32>>,
    creases: FxHashMap<[u32; 2], bool>,
    /// Vertices on a crease, and corners.
    pinned: Vec<bool>,
    journal: Journal,
    stages: Stages,
    rest: TetMeshParts,
}

impl Solid {
    /// Opens a mesh for changes.
    pub(super) fn new(mesh: &TetMesh) -> Self {
        let count = mesh.points().len();
        let mut solid = Self {
            points: mesh.points().to_vec(),
            transfer: Vec::new(),
            tets: Vec::with_capacity(8 * mesh.tets().len()),
            tags: Vec::with_capacity(8 * mesh.tets().len()),
            sines: Vec::with_capacity(8 * mesh.tets().len()),
            stamps: Vec::with_capacity(8 * mesh.tets().len()),
            clock: 0,
            free: Vec::new(),
            cells_at: vec![Vec::new(); count],
            faces: Vec::new(),
            free_faces: Vec::new(),
            faces_at: vec![Vec::new(); count],
            creases: mesh.creases().iter().map(|c| (c.vertices, c.feature)).collect(),
            pinned: vec![false; count],
            journal: Journal::default(),
            stages: Stages::default(),
            rest: TetMeshParts { points: Vec::new(), tets: Vec::new(), ..mesh.clone().into_parts() },
        };
        for (t, &tet) in mesh.tets().iter().enumerate() {
            solid.add_cell(tet, CellTag { region: mesh.regions()[t], level: mesh.levels()[t] });
        }
        for &face in mesh.faces() {
            solid.add_face(face);
        }
        for face in interfaces(mesh) {
            solid.add_face(Face { vertices: face.vertices, patch: INTERFACE });
        }
        for v in mesh.creases().iter().flat_map(|c| c.vertices).chain(mesh.corners().iter().copied()) {
            solid.pinned[v as usize] = true;
        }
        solid
    }

    /// Takes the stencils of the vertices added so far.
    pub(super) fn take_transfer(&mut self) -> Vec<Stencil> {
        std::mem::take(&mut self.transfer)
    }

    /// Closes the mesh.
    ///
    /// # Errors
    /// [`MeshError`] if the changes left an invalid mesh.
    pub(super) fn finish(mut self) -> Result<TetMesh, MeshError> {
        let (points, rest) = (std::mem::take(&mut self.points), std::mem::take(&mut self.rest));
        TetMesh::new(self.parts(points, rest))
    }

    /// The mesh as it is, with these points and what never changes.
    fn parts(&self, points: Vec<DVec3>, rest: TetMeshParts) -> TetMeshParts {
        let live: Vec<usize> = (0..self.tets.len()).filter(|&t| self.tets[t][0] != DEAD).collect();
        let boundary = |f: &&Face| f.vertices[0] != DEAD && f.patch != INTERFACE;
        TetMeshParts {
            tets: live.iter().map(|&t| self.tets[t]).collect(),
            regions: live.iter().map(|&t| self.tags[t].region).collect(),
            levels: live.iter().map(|&t| self.tags[t].level).collect(),
            faces: self.faces.iter().filter(boundary).copied().collect(),
            creases: self.creases.iter().map(|(&vertices, &feature)| Crease { vertices, feature }).collect(),
            points,
            ..rest
        }
    }

    // ---- reading ----

    pub(super) fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    pub(super) fn tet(&self, t: u32) -> [u32; 4] {
        self.tets[t as usize]
    }

    pub(super) fn tag(&self, t: u32) -> CellTag {
        self.tags[t as usize]
    }

    /// Minimum sine of the dihedral angles of cell `t`.
    pub(super) fn sine(&self, t: u32) -> f64 {
        self.sines[t as usize]
    }

    /// Smallest minimum sine of the given cells.
    pub(super) fn worst_sine(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&t| self.sine(t)).fold(f64::INFINITY, f64::min)
    }

    /// Smallest minimum sine of all cells.
    pub(super) fn worst_sine_of_all(&self) -> f64 {
        self.live_cells().map(|t| self.sine(t)).fold(f64::INFINITY, f64::min)
    }

    /// Cells in slot order.
    pub(super) fn live_cells(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tets.len() as u32).filter(|&t| self.tets[t as usize][0] != DEAD)
    }

    /// Cells made or reshaped at or after `time`, in slot order.
    pub(super) fn cells_since(&self, time: u32) -> impl Iterator<Item = u32> + '_ {
        self.live_cells().filter(move |&t| self.stamps[t as usize] >= time)
    }

    /// True if the cell was made, reshaped or removed at or after `time`.
    pub(super) fn is_changed(&self, t: u32, time: u32) -> bool {
        self.stamps[t as usize] >= time
    }

    /// Starts a new period of the clock that stamps changed cells, and returns it.
    pub(super) fn tick(&mut self) -> u32 {
        self.clock += 1;
        self.clock
    }

    /// Cells at vertex `v`.
    pub(super) fn cells_at(&self, v: u32) -> &[u32] {
        &self.cells_at[v as usize]
    }

    /// True if no surface (boundary or interface) passes through `v`, and it is on no crease.
    pub(super) fn is_interior(&self, v: u32) -> bool {
        self.faces_at[v as usize].is_empty() && !self.pinned[v as usize]
    }

    /// Number of vertices.
    pub(super) fn point_count(&self) -> usize {
        self.points.len()
    }

    /// Largest absolute value of a coordinate.
    pub(super) fn largest_coordinate(&self) -> f64 {
        self.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max)
    }

    /// Boundary and interface faces at vertex `v`.
    pub(super) fn faces_at(&self, v: u32) -> impl Iterator<Item = &Face> {
        self.faces_at[v as usize].iter().map(|&f| &self.faces[f as usize])
    }

    /// The creases, each with whether it is a feature, in no order.
    pub(super) fn crease_edges(&self) -> impl Iterator<Item = ([u32; 2], bool)> {
        self.creases.iter().map(|(&edge, &feature)| (edge, feature))
    }

    /// True if the vertex is on a crease or a corner.
    pub(super) fn is_pinned(&self, v: u32) -> bool {
        self.pinned[v as usize]
    }

    /// True if the vertex is tagged as a corner.
    pub(super) fn is_corner(&self, v: u32) -> bool {
        self.rest.corners.binary_search(&v).is_ok()
    }

    /// True if the edge is tagged as a crease.
    pub(super) fn is_crease(&self, edge: [u32; 2]) -> bool {
        self.creases.contains_key(&topology::sorted2(edge))
    }

    /// True if a boundary or interface face has this edge.
    pub(super) fn is_surface_edge(&self, [a, b]: [u32; 2]) -> bool {
        let faces = &self.faces_at[a as usize];
        faces.iter().any(|&f| self.faces[f as usize].vertices.contains(&b))
    }

    /// Boundary and interface faces at the edge.
    pub(super) fn faces_at_edge(&self, [a, b]: [u32; 2]) -> Vec<Face> {
        let faces = self.faces_at[a as usize].iter().map(|&f| self.faces[f as usize]);
        faces.filter(|f| f.vertices.contains(&b)).collect()
    }

    /// True if the two vertices are joined by an edge.
    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.cells_at(a).iter().any(|&t| has_vertex(self.tet(t), b))
    }

    /// The cells (one or two) that hold the three vertices.
    pub(super) fn cells_at_face(&self, face: [u32; 3]) -> SmallVec<[u32; 2]> {
        let has = |t: &&u32| face.iter().all(|&v| has_vertex(self.tet(**t), v));
        self.cells_at(face[0]).iter().filter(has).copied().collect()
    }

    /// Positions of cell `t`.
    pub(super) fn cell_points(&self, t: u32) -> [DVec3; 4] {
        self.tet(t).map(|v| self.point(v))
    }

    // ---- changing ----

    /// Adds the vertex that a stencil says.
    pub(super) fn add_vertex(&mut self, stencil: Stencil) -> u32 {
        self.points.push(stencil.combine(|v| self.point(v)));
        self.transfer.push(stencil);
        self.cells_at.push(Vec::new());
        self.faces_at.push(Vec::new());
        self.pinned.push(false);
        self.points.len() as u32 - 1
    }

    /// Adds a cell.
    pub(super) fn add_cell(&mut self, tet: [u32; 4], tag: CellTag) -> u32 {
        self.add_cell_of(tet, self.sine_of(tet), tag)
    }

    /// Minimum sine of the cell with these corners.
    pub(super) fn sine_of(&self, tet: [u32; 4]) -> f64 {
        quality::min_sine(tet.map(|v| self.point(v)))
    }

    /// Adds a cell whose minimum sine is known ([`Solid::sine_of`]).
    pub(super) fn add_cell_of(&mut self, tet: [u32; 4], sine: f64, tag: CellTag) -> u32 {
        let slot = match self.free.pop() {
            Some(slot) => {
                let i = slot as usize;
                (self.tets[i], self.tags[i], self.sines[i], self.stamps[i]) = (tet, tag, sine, self.clock);
                slot
            }
            None => {
                self.tets.push(tet);
                self.tags.push(tag);
                self.sines.push(sine);
                self.stamps.push(self.clock);
                self.tets.len() as u32 - 1
            }
        };
        for v in tet {
            self.cells_at[v as usize].push(slot);
        }
        self.journal.note(Change::CellAdded(slot));
        slot
    }

    /// Removes a cell and returns its vertices and tag.
    pub(super) fn remove_cell(&mut self, t: u32) -> ([u32; 4], CellTag) {
        let tet = self.tet(t);
        for v in tet {
            remove_value(&mut self.cells_at[v as usize], t);
        }
        self.journal.note(Change::CellRemoved(tet, self.tag(t), self.stamps[t as usize]));
        self.tets[t as usize] = [DEAD; 4];
        self.stamps[t as usize] = self.clock;
        self.free.push(t);
        (tet, self.tag(t))
    }

    /// Replaces a cell by its children, one level deeper or at its own level.
    pub(super) fn split_cell(&mut self, t: u32, children: impl IntoIterator<Item = [u32; 4]>, deeper: bool) {
        let (_, mut tag) = self.remove_cell(t);
        tag.level = tag.level.saturating_add(u8::from(deeper));
        for child in children {
            self.add_cell(child, tag);
        }
    }

    /// Raises the level of a cell by one.
    pub(super) fn deepen(&mut self, t: u32) {
        let level = &mut self.tags[t as usize].level;
        *level = level.saturating_add(1);
    }

    /// Adds a surface face.
    pub(super) fn add_face(&mut self, face: Face) {
        let slot = if let Some(slot) = self.free_faces.pop() {
            self.faces[slot as usize] = face;
            slot
        } else {
            self.faces.push(face);
            self.faces.len() as u32 - 1
        };
        for v in face.vertices {
            self.faces_at[v as usize].push(slot);
        }
        self.journal.note(Change::FaceAdded(face.vertices));
    }

    /// Removes the surface face with these vertices (in any order); `None` if there is none.
    pub(super) fn remove_face(&mut self, vertices: [u32; 3]) -> Option<Face> {
        let [a, b, c] = vertices;
        let has = |&&f: &&u32| {
            let v = self.faces[f as usize].vertices;
            v.contains(&b) && v.contains(&c)
        };
        let slot = *self.faces_at[a as usize].iter().find(has)?;
        let face = self.faces[slot as usize];
        for v in face.vertices {
            remove_value(&mut self.faces_at[v as usize], slot);
        }
        self.faces[slot as usize].vertices = [DEAD; 3];
        self.free_faces.push(slot);
        self.journal.note(Change::FaceRemoved(face));
        Some(face)
    }

    /// Divides edge (a, b) by new vertices `inner` (in order from a to b): every cell and surface face of its ring is
    /// cut, a crease becomes creases. The cells' levels stay.
    pub(super) fn divide_edge(&mut self, a: u32, b: u32, inner: &[u32]) {
        let chain: Vec<u32> = [a].iter().chain(inner).chain(&[b]).copied().collect();
        let ring: Vec<u32> = self.cells_at(a).iter().copied().filter(|&t| self.tet(t).contains(&b)).collect();
        for t in ring {
            let tet = self.tet(t);
            let pieces: Vec<[u32; 4]> = chain.windows(2).map(|w| replace(tet, [a, b], [w[0], w[1]])).collect();
            self.split_cell(t, pieces, false);
        }
        for face in self.faces_at_edge([a, b]) {
            self.remove_face(face.vertices);
            for w in chain.windows(2) {
                self.add_face(Face { vertices: replace(face.vertices, [a, b], [w[0], w[1]]), ..face });
            }
        }
        if let Some(feature) = self.creases.remove(&topology::sorted2([a, b])) {
            for w in chain.windows(2) {
                self.creases.insert(topology::sorted2([w[0], w[1]]), feature);
            }
            for &v in inner {
                self.pinned[v as usize] = true;
            }
        }
    }

    /// Makes the creases at the surface vertex `v` end in `b`; that between the two goes.
    pub(super) fn pull_creases(&mut self, v: u32, b: u32) {
        let mut around: SmallVec<[u32; 16]> = self.faces_at(v).flat_map(|f| f.vertices).filter(|&w| w != v).collect();
        around.sort_unstable();
        around.dedup();
        for w in around {
            if let Some(feature) = self.creases.remove(&topology::sorted2([v, w]))
                && w != b
            {
                self.creases.insert(topology::sorted2([b, w]), feature);
            }
        }
    }

    /// Minimum sines of the cells at `v`, in the order of [`Solid::cells_at`], if it were at `p`.
    pub(super) fn sines_with(&self, v: u32, p: DVec3) -> SmallVec<[f64; 32]> {
        let corner = |w| if w == v { p } else { self.point(w) };
        self.cells_at(v).iter().map(|&t| quality::min_sine(self.tet(t).map(corner))).collect()
    }

    /// Moves vertex `v` to where its cells have these minimum sines ([`Solid::sines_with`]).
    pub(super) fn move_point_to(&mut self, v: u32, p: DVec3, sines: &[f64]) {
        self.note_move(v);
        self.points[v as usize] = p;
        for (&t, &sine) in self.cells_at[v as usize].iter().zip(sines) {
            self.sines[t as usize] = sine;
            self.stamps[t as usize] = self.clock;
        }
    }

    /// Moves vertex `v`.
    pub(super) fn move_point(&mut self, v: u32, p: DVec3) {
        self.note_move(v);
        self.points[v as usize] = p;
        for i in 0..self.cells_at[v as usize].len() {
            let t = self.cells_at[v as usize][i];
            self.sines[t as usize] = quality::min_sine(self.cell_points(t));
            self.stamps[t as usize] = self.clock;
        }
    }

    /// Smallest minimum sine of the cells at `v` if it were at `p`; stops early below `enough`. Of cells that are not
    /// positive it says zero.
    pub(super) fn worst_sine_with(&self, v: u32, p: DVec3, enough: f64) -> f64 {
        let mut worst = f64::INFINITY;
        for &t in self.cells_at(v) {
            let corners = self.tet(t).map(|w| if w == v { p } else { self.point(w) });
            worst = worst.min(quality::positive_min_sine(corners));
            if worst < enough {
                break;
            }
        }
        worst
    }
}

/// The simplex with vertices `from` replaced by `to`.
fn replace<const N: usize>(simplex: [u32; N], from: [u32; 2], to: [u32; 2]) -> [u32; N] {
    simplex.map(|v| {
        if v == from[0] {
            to[0]
        } else if v == from[1] {
            to[1]
        } else {
            v
        }
    })
}

/// True if `v` is a corner of `tet`, without a branch a corner.
fn has_vertex(tet: [u32; 4], v: u32) -> bool {
    (tet[0] == v) | (tet[1] == v) | (tet[2] == v) | (tet[3] == v)
}

/// Removes one value from an unordered list.
fn remove_value(list: &mut Vec<u32>, value: u32) {
    if let Some(i) = list.iter().position(|&x| x == value) {
        list.swap_remove(i);
    }
}
