//! Meshes made of the bricks of a lattice, each cut into six tetrahedra around its main diagonal (the Kuhn or Freudenthal
//! triangulation), and put in their places by a map.

use super::{MAX_CELLS, Takes, brick, tagged_mesh};
use crate::mesh::{MeshError, TetMesh, quality};
use glam::DVec3;

/// Coordinates of a point of the lattice.
pub(super) type At = [usize; 3];

/// A lattice and what is made of it.
pub(super) struct Lattice<'a> {
    /// What it is called in messages.
    pub name: &'static str,
    /// Bricks along each axis.
    pub cells: At,
    /// Along the axes where this is true, the last points are the first again.
    pub closed: [bool; 3],
    /// Where the diagonals of the bricks turn round: on each side of this coordinate they point away from it. Zero where
    /// all point one way. Round bodies need this, since a brick with two sides on the surface must be cut between them.
    pub mirror: At,
    /// Whether the brick with this lowest corner exists.
    pub keep: &'a dyn Fn(At) -> bool,
    /// Where a point of the lattice lies.
    pub place: &'a dyn Fn(At) -> DVec3,
    /// Names of groups; a boundary face belongs to the first that takes all its points.
    pub groups: &'a [(&'a str, &'a dyn Fn(At) -> bool)],
}

impl Lattice<'_> {
    /// The mesh, of the region "solid".
    ///
    /// # Errors
    /// [`MeshError::Generator`]: no bricks or too many, or bricks without volume.
    pub fn mesh(&self) -> Result<TetMesh, MeshError> {
        let refuse = |problem: String| Err(MeshError::Generator(format!("{}: {problem}", self.name)));
        let tets = self.cells.iter().try_fold(6_usize, |product, n| product.checked_mul(*n));
        match tets {
            Some(0) => return refuse(format!("{:?} cells: it needs at least one along each axis", self.cells)),
            Some(tets) if tets <= MAX_CELLS => {}
            _ => return refuse(format!("{:?} cells are more than {MAX_CELLS} tetrahedra", self.cells)),
        }
        let (points, lattice, tets) = self.used(self.tets());
        let at = |v: u32| lattice[v as usize];
        let takes: Vec<_> = self.groups.iter().map(|(_, takes)| move |v: u32| takes(at(v))).collect();
        let groups = self.groups.iter().zip(&takes).map(|((name, _), takes)| (*name, takes as Takes<'_>));
        tagged_mesh(self.name, points, tets, &groups.collect::<Vec<_>>())
    }

    /// Points along each axis.
    fn sizes(&self) -> At {
        std::array::from_fn(|a| if self.closed[a] { self.cells[a] } else { self.cells[a] + 1 })
    }

    fn number(&self, at: At) -> u32 {
        let sizes = self.sizes();
        let [i, j, k]: At = std::array::from_fn(|a| at[a] % sizes[a]);
        (i + sizes[0] * (j + sizes[1] * k)) as u32
    }

    fn at(&self, number: u32) -> At {
        let (sizes, number) = (self.sizes(), number as usize);
        [number % sizes[0], number / sizes[0] % sizes[1], number / sizes[0] / sizes[1]]
    }

    /// The tetrahedra of all bricks, in numbers of lattice points, not yet oriented.
    fn tets(&self) -> Vec<[u32; 4]> {
        let [nx, ny, nz] = self.cells;
        let bricks = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let corner = |low: At, c: u32| {
            let at = std::array::from_fn(|a| {
                let turned = low[a] < self.mirror[a];
                low[a] + usize::from((c >> a & 1 == 1) != turned)
            });
            self.number(at)
        };
        // The corners of a brick are numbered by bits; those of its tetrahedra follow from the strides 1, 2, 4.
        let cut = |low: At| brick(0, [1, 2, 4]).map(|tet| tet.map(|c| corner(low, c)));
        bricks.filter(|low| (self.keep)(*low)).flat_map(cut).collect()
    }

    /// The points that are used with their lattice coordinates, and the tetrahedra in their numbers, positive.
    fn used(&self, tets: Vec<[u32; 4]>) -> (Vec<DVec3>, Vec<At>, Vec<[u32; 4]>) {
        let count = self.sizes().iter().product();
        let mut numbers = vec![u32::MAX; count];
        tets.iter().flatten().for_each(|&v| numbers[v as usize] = 0);
        let lattice: Vec<At> = (0..count).filter(|&v| numbers[v] == 0).map(|v| self.at(v as u32)).collect();
        (0..).zip(&lattice).for_each(|(new, &at)| numbers[self.number(at) as usize] = new);
        let points: Vec<DVec3> = lattice.iter().map(|&at| (self.place)(at)).collect();
        let positive = |tet: [u32; 4]| {
            let [a, b, c, d] = tet.map(|v| numbers[v as usize]);
            let volume = quality::volume([a, b, c, d].map(|v| points[v as usize]));
            if volume < 0.0 { [a, b, d, c] } else { [a, b, c, d] }
        };
        let tets = tets.into_iter().map(positive).collect();
        (points, lattice, tets)
    }
}
