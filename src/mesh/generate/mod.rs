//! Meshes made from a few numbers.

mod lattice;
mod prism;
mod shapes;

pub use prism::prism;
pub use shapes::{cylinder, fichera, l_prism, le10, plate_with_hole, sphere_shell, tube};

use super::midside::{self, Midside};
use super::{Face, GroupId, MeshError, PatchId, RegionId, TetMesh, TetMeshParts, topology};
use glam::DVec3;

/// Most cells a generator makes.
const MAX_CELLS: usize = 50_000_000;

/// A body with curved sides: its mesh, and the nodes that its curved edges have in the middle, sorted by edge.
#[derive(Debug, Clone)]
pub struct Curved {
    /// The mesh, whose vertices lie on the body's surface.
    pub mesh: TetMesh,
    /// The nodes on edges that are not straight.
    pub midsides: Vec<Midside>,
}

impl Curved {
    /// The body, if its curved cells are not folded.
    ///
    /// # Errors
    /// [`MeshError::Generator`] says how many are.
    pub fn unfolded(self) -> Result<Self, MeshError> {
        match midside::folded(&self.mesh, &self.midsides).len() {
            0 => Ok(self),
            n => Err(MeshError::Generator(format!(
                "{n} of its curved cells are folded: ask for more cells along the curved sides, or mesh.midside = \"straight\""
            ))),
        }
    }
}

/// The order in which the six tetrahedra of a brick walk along the axes from its lowest to its highest corner. The first
/// three walks are even permutations, whose tetrahedra are positive; the others are odd.
const WALKS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];

/// A box with one corner at the origin, made of `cells[0] x cells[1] x cells[2]` bricks of six tetrahedra each, all
/// around the brick's main diagonal (the Kuhn or Freudenthal triangulation), so that neighbouring bricks match.
///
/// One region "solid" and the groups "x-min", "x-max", "y-min", "y-max", "z-min", "z-max".
///
/// # Errors
/// [`MeshError::Generator`] if a size is not positive and finite, a number of cells is zero, or there would be more than
/// 50 million tetrahedra.
pub fn box_tets(size: [f64; 3], cells: [usize; 3]) -> Result<TetMesh, MeshError> {
    check_box(size, cells)?;
    let grid = Grid { cells };
    let tets = grid.tets();
    let groups = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"].map(str::to_owned).to_vec();
    let faces = topology::boundary_faces(&tets)
        .into_iter()
        .map(|vertices| Face { vertices, patch: PatchId(grid.side(vertices)) })
        .collect();
    TetMesh::new(TetMeshParts {
        points: grid.points(size),
        regions: vec![RegionId(0); tets.len()],
        levels: vec![0; tets.len()],
        tets,
        faces,
        region_names: vec!["solid".to_owned()],
        patches: (0..6).map(|g| vec![GroupId(g)]).collect(),
        groups,
        ..TetMeshParts::default()
    })
    .map_err(|error| match error {
        MeshError::NotPositive { .. } => MeshError::Generator(too_flat(size, cells)),
        other => other,
    })
}

/// Whether a group takes a vertex.
type Takes<'a> = &'a dyn Fn(u32) -> bool;

/// A mesh of the region "solid"; a boundary face belongs to the first group that takes all its vertices.
fn tagged_mesh(
    name: &str,
    points: Vec<DVec3>,
    tets: Vec<[u32; 4]>,
    groups: &[(&str, Takes<'_>)],
) -> Result<TetMesh, MeshError> {
    let patch = |vertices: [u32; 3]| {
        let takes = |(_, takes): &(&str, Takes<'_>)| vertices.iter().all(|&v| takes(v));
        groups.iter().position(takes).unwrap_or(groups.len())
    };
    let face = |vertices| Face { vertices, patch: PatchId(patch(vertices) as u32) };
    let parts = TetMeshParts {
        faces: topology::boundary_faces(&tets).into_iter().map(face).collect(),
        regions: vec![RegionId(0); tets.len()],
        levels: vec![0; tets.len()],
        region_names: vec!["solid".to_owned()],
        groups: groups.iter().map(|(name, _)| (*name).to_owned()).collect(),
        // The last one is that of faces without a group.
        patches: (0..groups.len() as u32).map(|g| vec![GroupId(g)]).chain([Vec::new()]).collect(),
        points,
        tets,
        ..TetMeshParts::default()
    };
    match TetMesh::new(parts) {
        Err(MeshError::NotPositive { .. }) => Err(MeshError::Generator(format!(
            "{name}: its tetrahedra have no volume beyond rounding: make its measures more alike, or ask for other \
             numbers of cells"
        ))),
        mesh => mesh,
    }
}

/// Says that bricks are so long and thin that the volumes of their tetrahedra are rounding.
fn too_flat(size: [f64; 3], cells: [usize; 3]) -> String {
    let [x, y, z] = [0, 1, 2].map(|i| size[i] / cells[i] as f64);
    format!(
        "the bricks of the box measure {x:e} x {y:e} x {z:e}: their tetrahedra have no volume beyond rounding; change its \
         size or cells so that their sides are more alike"
    )
}

fn check_box(size: [f64; 3], cells: [usize; 3]) -> Result<(), MeshError> {
    let refuse = |message: String| Err(MeshError::Generator(message));
    for (axis, (s, n)) in ["x", "y", "z"].into_iter().zip(size.into_iter().zip(cells)) {
        if !(s > 0.0 && s.is_finite()) {
            return refuse(format!("the size of the box in {axis} is {s}, it must be a positive number"));
        }
        if n == 0 {
            return refuse(format!("the box has no cells in {axis}, it needs at least one"));
        }
    }
    let tets = cells.iter().try_fold(6_usize, |product, n| product.checked_mul(*n));
    match tets {
        Some(tets) if tets <= MAX_CELLS => Ok(()),
        _ => refuse(format!("a box of {cells:?} bricks has more than {MAX_CELLS} tetrahedra; ask for fewer cells")),
    }
}

/// A grid of bricks; vertex (i, j, k) has the number i + (nx + 1) (j + (ny + 1) k).
struct Grid {
    cells: [usize; 3],
}

impl Grid {
    fn strides(&self) -> [u32; 3] {
        let [nx, ny, _] = self.cells;
        [1, nx as u32 + 1, (nx as u32 + 1) * (ny as u32 + 1)]
    }

    fn points(&self, size: [f64; 3]) -> Vec<DVec3> {
        let [nx, ny, nz] = self.cells;
        let at = |axis: usize, i: usize| size[axis] * (i as f64 / self.cells[axis] as f64);
        let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
        for k in 0..=nz {
            for j in 0..=ny {
                points.extend((0..=nx).map(|i| DVec3::new(at(0, i), at(1, j), at(2, k))));
            }
        }
        points
    }

    fn tets(&self) -> Vec<[u32; 4]> {
        let [nx, ny, nz] = self.cells;
        let strides = self.strides();
        let mut tets = Vec::with_capacity(6 * nx * ny * nz);
        for k in 0..nz as u32 {
            for j in 0..ny as u32 {
                for i in 0..nx as u32 {
                    tets.extend(brick(i * strides[0] + j * strides[1] + k * strides[2], strides));
                }
            }
        }
        tets
    }

    /// The side of the box that a boundary face lies on: twice the axis, one more at the upper end.
    fn side(&self, face: [u32; 3]) -> u32 {
        let strides = self.strides();
        let coordinate = |v: u32, axis: usize| match axis {
            0 => v % strides[1],
            1 => v % strides[2] / strides[1],
            _ => v / strides[2],
        };
        let sides = (0..3_u32).flat_map(|axis| [(axis, 0), (axis, self.cells[axis as usize] as u32)]);
        let all_at = |axis: u32, level: u32| face.iter().all(|&v| coordinate(v, axis as usize) == level);
        let side = sides.zip(0..).find(|&((axis, level), _)| all_at(axis, level)).map(|(_, side)| side);
        side.unwrap_or_else(|| unreachable!("face {face:?} is not on the boundary"))
    }
}

/// The six tetrahedra of the brick whose lowest corner is `low`.
fn brick(low: u32, strides: [u32; 3]) -> [[u32; 4]; 6] {
    let high = low + strides.iter().sum::<u32>();
    std::array::from_fn(|w| {
        let [first, second, _] = WALKS[w].map(|axis| strides[axis]);
        let (a, b) = (low + first, low + first + second);
        if w < 3 { [low, a, b, high] } else { [low, b, a, high] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::features::face_normal;
    use proptest::prelude::*;

    #[test]
    fn a_unit_cube_has_the_known_counts() {
        let mesh = box_tets([1.0; 3], [2, 3, 4]).unwrap();
        assert_eq!(mesh.tets().len(), 6 * 24);
        assert_eq!(mesh.points().len(), 3 * 4 * 5);
        assert_eq!(mesh.faces().len(), 4 * (2 * 3 + 3 * 4 + 2 * 4));
        assert_eq!(mesh.region_names(), ["solid"]);
    }

    #[test]
    fn impossible_boxes_are_refused() {
        for size in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, f64::NAN], [f64::INFINITY, 1.0, 1.0]] {
            assert!(matches!(box_tets(size, [1; 3]), Err(MeshError::Generator(_))), "{size:?}");
        }
        for cells in [[0, 1, 1], [1, 1, 0], [1000, 1000, 9], [usize::MAX; 3]] {
            assert!(matches!(box_tets([1.0; 3], cells), Err(MeshError::Generator(_))), "{cells:?}");
        }
    }

    #[test]
    fn bricks_without_volume_get_a_remedy_that_fits_a_box() {
        let Err(MeshError::Generator(message)) = box_tets([1.0, 1.0, 1e-14], [1; 3]) else { panic!("accepted") };
        assert!(message.contains("1e-14") && message.contains("cells"), "{message}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// The cells fill the box, and each side's faces lie in its plane, look outward and have its area.
        #[test]
        fn volume_and_sides_are_those_of_the_box(
            size in prop::array::uniform3(0.1_f64..10.0), cells in prop::array::uniform3(1_usize..5)
        ) {
            let mesh = box_tets(size, cells).unwrap();
            let [x, y, z] = size;
            prop_assert!((mesh.volume() - x * y * z).abs() < 1e-12 * x * y * z);
            for (g, area) in [y * z, y * z, x * z, x * z, x * y, x * y].into_iter().enumerate() {
                let (axis, upper) = (g / 2, g % 2 == 1);
                let mut sum = DVec3::ZERO;
                for face in mesh.group_faces(GroupId(g as u32)) {
                    let level = if upper { size[axis] } else { 0.0 };
                    prop_assert!(face.vertices.iter().all(|&v| mesh.points()[v as usize][axis] == level));
                    sum += 0.5 * face_normal(mesh.points(), face.vertices);
                }
                let want = DVec3::AXES[axis] * if upper { area } else { -area };
                prop_assert!((sum - want).length() < 1e-12 * area.max(1.0));
            }
        }
    }
}
