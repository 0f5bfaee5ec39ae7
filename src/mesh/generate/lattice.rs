//! Meshes made of the bricks of a lattice, each cut into six tetrahedra around its main diagonal (the Kuhn or Freudenthal
//! triangulation), and put in their places by a map.

use super::{Curved, MAX_CELLS, Takes, brick, tagged_mesh};
use crate::mesh::midside::Midside;
use crate::mesh::{MeshError, TetMesh, quality, topology};
use glam::DVec3;

/// Distance from the middle over the edge's length from which an edge counts as curved: above rounding.
const CURVED: f64 = 1e-12;

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
    /// Where a point of the lattice lies; the middle of an edge has coordinates that are halves.
    pub place: &'a dyn Fn([f64; 3]) -> DVec3,
    /// Names of groups; a boundary face belongs to the first that takes all its points.
    pub groups: &'a [(&'a str, &'a dyn Fn(At) -> bool)],
}

impl Lattice<'_> {
    /// The mesh, of the region "solid".
    ///
    /// # Errors
    /// [`MeshError::Generator`]: no bricks or too many, or bricks without volume.
    pub fn mesh(&self) -> Result<TetMesh, MeshError> {
        Ok(self.made()?.0)
    }

    /// The mesh, and its edges that the map bends.
    ///
    /// # Errors
    /// As [`Self::mesh`].
    pub fn curved(&self) -> Result<Curved, MeshError> {
        let (mesh, lattice) = self.made()?;
        let node = |edge: [u32; 2]| {
            let [p, q] = edge.map(|v| mesh.points()[v as usize]);
            let position = (self.place)(self.middle(edge.map(|v| lattice[v as usize])));
            (position.distance(p.midpoint(q)) > CURVED * p.distance(q)).then_some(Midside { edge, position })
        };
        let midsides = topology::edges(mesh.tets()).into_iter().filter_map(node).collect();
        Ok(Curved { mesh, midsides })
    }

    /// The middle between two neighbours in the lattice, of which one may lie behind the seam of a closed axis.
    fn middle(&self, [a, b]: [At; 2]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let seam = self.closed[axis] && a[axis].abs_diff(b[axis]) > 1;
            let turn = if seam { self.cells[axis] } else { 0 };
            0.5 * (a[axis] + b[axis] + turn) as f64
        })
    }

    /// The mesh, and the place in the lattice of each vertex.
    fn made(&self) -> Result<(TetMesh, Vec<At>), MeshError> {
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
        let mesh = tagged_mesh(self.name, points, tets, &groups.collect::<Vec<_>>())?;
        Ok((mesh, lattice))
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
        let points: Vec<DVec3> = lattice.iter().map(|&at| (self.place)(at.map(|i| i as f64))).collect();
        let positive = |tet: [u32; 4]| {
            let [a, b, c, d] = tet.map(|v| numbers[v as usize]);
            let volume = quality::volume([a, b, c, d].map(|v| points[v as usize]));
            if volume < 0.0 { [a, b, d, c] } else { [a, b, c, d] }
        };
        let tets = tets.into_iter().map(positive).collect();
        (points, lattice, tets)
    }
}
