//! Points embedded in the limit of a control mesh: they move with its control points (Schaefer, Hakenberg and Warren 2004,
//! section 3).
//!
//! The control mesh is refined, and each point is located in a cell of it, octahedra cut in four. Its weights over the control points
//! are its barycentric coordinates B there, times the rows of the composite matrix S at the cell's corners. Both are kept
//! as they are: to move points, S moves the corners that are used, of which there are few, then B the points.

use super::{WeightRows, composite};
use crate::mesh::locate::Locator;
use crate::mesh::tet_oct::{OctSplit, TetOctMesh};
use crate::mesh::{MeshError, quality};
use glam::DVec3;
use rayon::prelude::*;

/// How far a point may lie outside the refined mesh, as a fraction of the diagonal of its bounding box: rounding.
const OUTSIDE: f64 = 1e-9;

/// How many points a thread moves at a time.
const PIECE: usize = 1 << 12;

/// Why points cannot be embedded, or not be moved.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EmbedError {
    /// The control mesh has inverted cells after refinement.
    #[error("smooth subdivision inverts cells of this mesh")]
    #[diagnostic(help("make the mesh less twisted, or keep more of its edges as creases, by a smaller feature angle"))]
    Folded(#[source] MeshError),
    /// Points lie outside.
    #[error(
        "{count} of {total} embedded points lie outside the refined control mesh, the farthest by {distance:.3e}: point {point} at ({}, {}, {})",
        at.x, at.y, at.z
    )]
    #[diagnostic(help(
        "smoothing draws the boundary inwards: make the control mesh larger, or keep its edges sharp (features.angle)"
    ))]
    Outside {
        /// How many.
        count: usize,
        /// Of so many.
        total: usize,
        /// The farthest.
        point: usize,
        /// Where it is.
        at: DVec3,
        /// How far outside.
        distance: f64,
    },
}

/// Points with their weights over the control points.
#[derive(Debug, Clone)]
pub struct Embedding {
    /// The smooth basis functions at the corners of the cells that hold points.
    rows: WeightRows,
    /// The corners of each point's cell, as rows.
    corners: Vec<[u32; 4]>,
    /// Its barycentric coordinates there.
    weights: Vec<[f64; 4]>,
    /// The basis functions at all vertices of the refined mesh, and its cells.
    all: WeightRows,
    cells: Vec<[u32; 4]>,
}

impl Embedding {
    /// Embeds points in a control mesh refined `steps` times.
    ///
    /// # Errors
    /// [`EmbedError`], if the refined mesh has inverted cells or a point lies outside it.
    pub fn new(control: &TetOctMesh, steps: usize, points: &[DVec3]) -> Result<Self, EmbedError> {
        let (fine, all) = composite(control, steps);
        let mesh = fine.tetrahedra(OctSplit::Diagonal).map_err(EmbedError::Folded)?.mesh;
        let locator = Locator::new(&mesh);
        let located: Vec<_> = points.par_iter().with_min_len(256).map(|p| locator.nearest(*p)).collect();
        let allowed = OUTSIDE * mesh.diagonal();
        let far = |i: &usize| located[*i].distance > allowed;
        let count = (0..points.len()).filter(far).count();
        let farthest = (0..points.len()).max_by(|&i, &j| located[i].distance.total_cmp(&located[j].distance));
        if let Some(point) = farthest.filter(far) {
            let (total, at, distance) = (points.len(), points[point], located[point].distance);
            return Err(EmbedError::Outside { count, total, point, at, distance });
        }
        let cell = |i: usize| mesh.tets()[located[i].cell];
        let mut used: Vec<u32> = (0..points.len()).flat_map(cell).collect();
        used.par_sort_unstable();
        used.dedup();
        let mut places = vec![0; mesh.points().len()];
        used.iter().zip(0..).for_each(|(&v, place)| places[v as usize] = place);
        Ok(Self {
            rows: all.select(&used),
            corners: (0..points.len()).map(|i| cell(i).map(|v| places[v as usize])).collect(),
            weights: located.iter().map(|l| l.weights).collect(),
            all,
            cells: mesh.tets().to_vec(),
        })
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Number of weights that are kept.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.rows.entries() + 4 * self.corners.len()
    }

    /// Where the points are when the control points are there.
    #[must_use]
    pub fn places(&self, control: &[DVec3]) -> Vec<DVec3> {
        let at = self.rows.apply(control);
        let place = |(corners, weights): (&[u32; 4], &[f64; 4])| -> DVec3 {
            corners.iter().zip(weights).map(|(&v, w)| *w * at[v as usize]).sum()
        };
        self.corners.par_iter().zip(&self.weights).with_min_len(PIECE).map(place).collect()
    }

    /// The weights of a point over the control points, ascending: none negative, their sum is 1.
    #[must_use]
    pub fn weights(&self, point: usize) -> Vec<(u32, f64)> {
        let (corners, weights) = (self.corners[point], self.weights[point]);
        let rows = WeightRows::collect(1, self.rows.width(), |_, row| {
            for (corner, weight) in corners.into_iter().zip(weights) {
                row.extend(self.rows.row(corner as usize).map(|(v, w)| (v, weight * w)));
            }
        });
        rows.row(0).collect()
    }

    /// How many cells of the refined mesh are inverted when the control points are there, and how many there are: where one is,
    /// the deformation is not one-to-one.
    #[must_use]
    pub fn inverted(&self, control: &[DVec3]) -> (usize, usize) {
        let at = self.all.apply(control);
        let inverted = |t: &&[u32; 4]| !quality::is_positive(t.map(|v| at[v as usize]));
        (self.cells.par_iter().with_min_len(PIECE).filter(inverted).count(), self.cells.len())
    }
}
