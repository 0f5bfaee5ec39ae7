//! From the arrays of a grid to lists of nodes and elements.

use super::super::raw::{MidsideOrder, Raw};
use super::super::runs::Runs;
use super::super::{error_at, finite};
use crate::mesh::hex::to_vtk_order;
use crate::mesh::{MeshError, Place};
use glam::DVec3;
use std::path::Path;

/// Cell data that say which region or group a cell belongs to, the first found is taken; capitals do not matter.
const TAGS: [&str; 13] = [
    "region",
    "gmsh:physical",
    "medit:ref",
    "cellentityids",
    "regionid",
    "region_id",
    "materialids",
    "materialid",
    "material",
    "physical",
    "elementblockids",
    "cell_tags",
    "gmsh:geometrical",
];

/// Whether cell data of that name are wanted.
pub(super) fn is_tag(name: &str) -> bool {
    rank(name).is_some()
}

fn rank(name: &str) -> Option<usize> {
    // VTK writes signs other than letters as %3A and the like.
    let name = name.replace("%3a", ":").replace("%3A", ":").replace("%20", "_").to_ascii_lowercase();
    TAGS.iter().position(|known| *known == name)
}

/// The arrays of a grid, or of one piece of it.
#[derive(Debug, Default)]
pub(super) struct Grid {
    pub(super) points: Vec<f64>,
    /// The points of all cells, one cell after the other.
    pub(super) connectivity: Vec<f64>,
    /// Where the points of each cell end.
    pub(super) ends: Vec<f64>,
    pub(super) types: Vec<f64>,
    /// Cell data that may be tags.
    pub(super) tags: Vec<(String, Vec<f64>)>,
    /// Place of each point and of each cell; shorter lists stand for the place of the arrays.
    pub(super) point_places: Runs,
    pub(super) cell_places: Runs,
    /// Where the arrays begin.
    pub(super) place: u64,
}

const DAMAGED: &str = "the file is damaged, or not written whole: write it again";

/// What a cell type is here, and its number of points.
enum Kind {
    Tet,
    Triangle,
    Hex,
    /// A hexahedron with corners in our order.
    Voxel,
    Quad,
    Skipped,
    Refused(&'static str),
}

fn kind(code: f64, points: usize) -> Kind {
    match (code as u8, points) {
        (10, 4) | (24 | 71, 10) | (71, 4) => Kind::Tet,
        (5, 3) | (22 | 69, 6) | (69, 3) => Kind::Triangle,
        (12, 8) | (25, 20) | (29, 27) | (72, 8) => Kind::Hex,
        (11, 8) => Kind::Voxel,
        (9, 4) | (23, 8) | (28, 9) | (70, 4) => Kind::Quad,
        (1..=4 | 6..=9 | 21 | 23 | 28 | 30 | 34..=36 | 68 | 70, _) => Kind::Skipped,
        (10 | 24 | 71 | 78, _) => Kind::Refused("a tetrahedron with another number of points than 4 or 10"),
        (5 | 22 | 69, _) => Kind::Refused("a triangle with another number of points than 3 or 6"),
        (11 | 12 | 25 | 29 | 33 | 72 | 79, _) => {
            Kind::Refused("a hexahedron with another number of points than 8, 20 or 27")
        }
        (13 | 26 | 31 | 32 | 73 | 80, _) => Kind::Refused("a wedge, which is not supported yet"),
        (14 | 27 | 37 | 74, _) => Kind::Refused("a pyramid, which is not supported yet"),
        _ => Kind::Refused("of a type that is not read"),
    }
}

/// A number as an index.
fn index(x: f64) -> Option<u32> {
    (x >= 0.0 && x < f64::from(u32::MAX) && x.fract() == 0.0).then_some(x as u32)
}

impl Grid {
    fn place_of(&self, places: &Runs, i: usize) -> u64 {
        if i < places.len() { places.get(i) as u64 } else { self.place }
    }

    /// Adds the nodes and cells to the lists of the file, numbered from 0 as in ParaView. Gives the number of cells passed
    /// over.
    pub(super) fn list(&self, path: &Path, raw: &mut Raw) -> Result<usize, MeshError> {
        let binary = raw.binary;
        let at = |place: u64| if binary { Place::Byte(place as usize) } else { Place::Line(place as usize) };
        let first_point = raw.nodes.positions.len() as u32;
        for (i, p) in self.points.chunks_exact(3).enumerate() {
            let (id, place) = (first_point + i as u32, self.place_of(&self.point_places, i));
            for (x, name) in p.iter().zip(["x", "y", "z"]) {
                finite(*x, name, id).map_err(|(message, help)| error_at(path, at(place), message, help))?;
            }
            raw.nodes.push(id, DVec3::new(p[0], p[1], p[2]), place);
        }
        if self.ends.len() != self.types.len() {
            let message = format!("{} cells, but {} cell types", self.ends.len(), self.types.len());
            return Err(error_at(path, at(self.place), message, DAMAGED));
        }
        let tags = self.tags.iter().filter(|(_, values)| values.len() == self.types.len());
        let tags = tags.min_by_key(|(name, _)| rank(name)).map(|(_, values)| values);
        let first_cell = raw.element_count() as u32;
        let (mut begin, mut skipped) = (0, 0);
        for (i, &code) in self.types.iter().enumerate() {
            let (id, place) = (first_cell + i as u32, self.place_of(&self.cell_places, i));
            let fail = |(message, help): (String, &str)| error_at(path, at(place), message, help);
            let points = self.points_of(i, begin).map_err(fail)?;
            begin += points.len();
            // Tags are whole numbers; what is not cannot be one.
            let cell = Cell { id, place, tag: tags.map_or(0, |values| values[i] as i32) };
            skipped += cell.list(code, points, first_point, raw).map_err(fail)?;
        }
        Ok(skipped)
    }

    /// The points of cell `i`, which begin at `begin`.
    fn points_of(&self, i: usize, begin: usize) -> Result<&[f64], (String, &'static str)> {
        let end = self.ends[i];
        index(end).and_then(|end| self.connectivity.get(begin..end as usize)).ok_or_else(|| {
            let message = format!("the points of cell {i} end at {end}, after {begin} of {}", self.connectivity.len());
            (message, DAMAGED)
        })
    }
}

/// What is known of a cell beside its points.
struct Cell {
    id: u32,
    place: u64,
    tag: i32,
}

impl Cell {
    /// Adds the cell to the lists; gives 1 if it is passed over.
    fn list(
        &self,
        code: f64,
        points: &[f64],
        first_point: u32,
        raw: &mut Raw,
    ) -> Result<usize, (String, &'static str)> {
        let Self { id, place, tag } = *self;
        let node = |k: usize| {
            let node = index(points[k]).and_then(|n| n.checked_add(first_point));
            node.ok_or_else(|| (format!("cell {id} uses point {}", points[k]), DAMAGED))
        };
        match kind(code, points.len()) {
            Kind::Tet => {
                raw.tets.push(id, [node(0)?, node(1)?, node(2)?, node(3)?], tag, place);
                if points.len() == 10 {
                    let mids = [node(4)?, node(5)?, node(6)?, node(7)?, node(8)?, node(9)?];
                    raw.midsides(id, MidsideOrder::Vtk, mids, raw.tets.nodes.len() - 1, place);
                }
            }
            Kind::Triangle => raw.triangle(id, [node(0)?, node(1)?, node(2)?], [tag, 0], place),
            Kind::Hex | Kind::Voxel => {
                let mut nodes = [0; 8];
                for (k, own) in nodes.iter_mut().enumerate() {
                    *own = node(k)?;
                }
                if matches!(kind(code, points.len()), Kind::Voxel) {
                    nodes = to_vtk_order(nodes);
                }
                raw.hex(id, nodes, tag, place);
                if points.len() > 8 {
                    let mut mids = [0; 12];
                    for (k, own) in mids.iter_mut().enumerate() {
                        *own = node(8 + k)?;
                    }
                    raw.hex_midsides(id, MidsideOrder::Vtk, mids, place);
                }
            }
            Kind::Quad => raw.quad(id, [node(0)?, node(1)?, node(2)?, node(3)?], [tag, 0], place),
            Kind::Skipped => return Ok(1),
            Kind::Refused(what) => {
                let message =
                    format!("cell {id} (VTK type {code}) is {what}; only tetrahedra and hexahedra are computed");
                return Err((message, "mesh the volume with tetrahedra alone, or with hexahedra alone"));
            }
        }
        Ok(0)
    }
}
