//! What a file lists, before anything is checked across its entries.

use super::runs::Runs;
use crate::mesh::Place;
use crate::mesh::hex::from_vtk_order;
use glam::DVec3;
use std::collections::BTreeMap;

/// Nodes as the file gives them.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub(super) ids: Runs,
    pub(super) places: Runs,
    pub(super) positions: Vec<DVec3>,
}

impl Nodes {
    pub(super) fn push(&mut self, id: u32, position: DVec3, place: u64) {
        self.ids.push(i64::from(id));
        self.places.push(place as i64);
        self.positions.push(position);
    }
}

/// Elements of `N` nodes as the file gives them.
#[derive(Debug)]
pub(super) struct Elements<const N: usize> {
    pub(super) ids: Runs,
    pub(super) places: Runs,
    /// Ids of the nodes, not indices.
    pub(super) nodes: Vec<[u32; N]>,
    /// Tag of the region or of the group of each, 0 if it has none.
    pub(super) tags: Runs,
}

impl<const N: usize> Default for Elements<N> {
    fn default() -> Self {
        Self { ids: Runs::default(), places: Runs::default(), nodes: Vec::new(), tags: Runs::default() }
    }
}

impl<const N: usize> Elements<N> {
    pub(super) fn push(&mut self, id: u32, nodes: [u32; N], tag: i32, place: u64) {
        self.ids.push(i64::from(id));
        self.places.push(place as i64);
        self.nodes.push(nodes);
        self.tags.push(i64::from(tag));
    }
}

/// The edges in the order in which a format lists their mid-side nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MidsideOrder {
    /// 01, 12, 02, 03, 13, 23: VTK, Abaqus, GiD, MEDIT.
    Vtk,
    /// 01, 12, 02, 03, 23, 13.
    Gmsh,
}

/// Places among the twelve edges of a cell, in the order of [`EDGES`](crate::mesh::hex::EDGES), from the order in which a
/// format lists their mid-side nodes. VTK and Abaqus go round below, round above, and up.
const HEX_VTK: [usize; 12] = [0, 2, 4, 6, 3, 1, 7, 5, 8, 9, 11, 10];
const HEX_GMSH: [usize; 12] = [0, 5, 8, 11, 1, 3, 9, 10, 2, 4, 7, 6];

/// The lists of a file.
#[derive(Debug, Default)]
pub(super) struct Raw {
    /// Whether places are bytes; else they are lines.
    pub(super) binary: bool,
    pub(super) nodes: Nodes,
    /// Tetrahedra with the tags of their regions.
    pub(super) tets: Elements<4>,
    /// Triangles with the tags of their groups; one that belongs to several is listed once for each.
    pub(super) triangles: Elements<3>,
    /// Tag of the surface that each triangle was made on, 0 if unknown. It names the groups if no triangle has a tag.
    pub(super) surfaces: Runs,
    /// The mid-side nodes of second-order tetrahedra, in the order of [`EDGES`](crate::mesh::quality::EDGES); the tag is the
    /// place of the tetrahedron in `tets`.
    pub(super) midsides: Elements<6>,
    /// Hexahedra with the tags of their regions; corners in the order of [`hex`](crate::mesh::hex).
    pub(super) hexes: Elements<8>,
    /// Quadrilaterals with the tags of their groups, as triangles.
    pub(super) quads: Elements<4>,
    /// Tag of the surface that each quadrilateral was made on, 0 if unknown.
    pub(super) quad_surfaces: Runs,
    /// The mid-side nodes of second-order hexahedra, in the order of [`EDGES`](crate::mesh::hex::EDGES); the tag is the place
    /// of the hexahedron in `hexes`.
    pub(super) hex_midsides: Elements<12>,
    pub(super) region_names: BTreeMap<i32, String>,
    pub(super) group_names: BTreeMap<i32, String>,
    /// Sets of nodes, each a group of the faces all whose corners it holds, unless a group has that name already.
    pub(super) node_groups: Vec<(String, Vec<u32>)>,
    pub(super) notes: Vec<String>,
}

impl Raw {
    /// Adds the mid-side nodes of the tetrahedron that stands, or will stand, at place `cell`.
    pub(super) fn midsides(&mut self, id: u32, order: MidsideOrder, nodes: [u32; 6], cell: usize, place: u64) {
        let order = match order {
            MidsideOrder::Vtk => [0, 2, 3, 1, 4, 5],
            MidsideOrder::Gmsh => [0, 2, 3, 1, 5, 4],
        };
        self.midsides.push(id, order.map(|k| nodes[k]), cell as i32, place);
    }

    /// Adds a triangle with the tags of its group and of its surface.
    pub(super) fn triangle(&mut self, id: u32, nodes: [u32; 3], [group, surface]: [i32; 2], place: u64) {
        self.triangles.push(id, nodes, group, place);
        self.surfaces.push(i64::from(surface));
    }

    /// Adds a hexahedron with corners in VTK's order, the same in all formats.
    pub(super) fn hex(&mut self, id: u32, nodes: [u32; 8], tag: i32, place: u64) {
        self.hexes.push(id, from_vtk_order(nodes), tag, place);
    }

    /// Adds the mid-side nodes of the last hexahedron.
    pub(super) fn hex_midsides(&mut self, id: u32, order: MidsideOrder, nodes: [u32; 12], place: u64) {
        let order = match order {
            MidsideOrder::Vtk => HEX_VTK,
            MidsideOrder::Gmsh => HEX_GMSH,
        };
        let cell = self.hexes.nodes.len().saturating_sub(1) as i32;
        self.hex_midsides.push(id, order.map(|k| nodes[k]), cell, place);
    }

    /// Adds a quadrilateral with the tags of its group and of its surface.
    pub(super) fn quad(&mut self, id: u32, nodes: [u32; 4], [group, surface]: [i32; 2], place: u64) {
        self.quads.push(id, nodes, group, place);
        self.quad_surfaces.push(i64::from(surface));
    }

    /// Number of elements listed so far.
    pub(super) fn element_count(&self) -> usize {
        self.tets.nodes.len() + self.triangles.nodes.len() + self.hexes.nodes.len() + self.quads.nodes.len()
    }

    /// The place of an entry.
    pub(super) fn place(&self, places: &Runs, index: usize) -> Place {
        let at = places.get(index) as usize;
        if self.binary { Place::Byte(at) } else { Place::Line(at) }
    }
}
