//! Layers of hexahedra over a mesh of quadrilaterals.

use super::{HexError, HexMesh};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::hash::Hash;

/// Whether a group takes the point of a layer's vertex; layers count from 0.
pub(super) type Takes<'a, K> = &'a dyn Fn(K, usize) -> bool;

/// A mesh of quadrilaterals, and what is put over it. Its vertices are keys: equal ones are one vertex.
pub(super) struct Layers<'a, K> {
    /// What it is called in messages.
    pub name: &'static str,
    /// Vertices counter-clockwise, seen from the last layer.
    pub quads: Vec<[K; 4]>,
    /// Number of layers.
    pub count: usize,
    /// Where a vertex lies before the first layer, after it, and so on.
    pub place: &'a dyn Fn(K, usize) -> DVec3,
    /// Names of groups; a boundary face belongs to those that take all its points.
    pub groups: &'a [(&'a str, Takes<'a, K>)],
}

impl<K: Copy + Eq + Hash> Layers<'_, K> {
    /// The mesh, of the region "solid".
    ///
    /// # Errors
    /// [`HexError::Generator`] if cells have no volume.
    pub fn mesh(&self) -> Result<HexMesh, HexError> {
        let (mut numbers, mut keys) = (FxHashMap::default(), Vec::new());
        let mut number = |key: K| {
            *numbers.entry(key).or_insert_with(|| {
                keys.push(key);
                keys.len() as u32 - 1
            })
        };
        let quads: Vec<[u32; 4]> = self.quads.iter().map(|quad| quad.map(&mut number)).collect();
        let level = keys.len() as u32;
        let points = (0..=self.count).flat_map(|k| keys.iter().map(move |&key| (self.place)(key, k))).collect();
        let cell = |[a, b, c, d]: [u32; 4], k: usize| {
            let first = k as u32 * level;
            [a, b, d, c, a + level, b + level, d + level, c + level].map(|v| v + first)
        };
        let cells = (0..self.count).flat_map(|k| quads.iter().map(move |&quad| cell(quad, k))).collect();
        let at = |v: u32| (keys[(v % level) as usize], (v / level) as usize);
        let takes: Vec<_> = self.groups.iter().map(|(_, takes)| move |v: u32| takes(at(v).0, at(v).1)).collect();
        let groups: Vec<(&str, &dyn Fn(u32) -> bool)> =
            self.groups.iter().zip(&takes).map(|((name, _), takes)| (*name, takes as &dyn Fn(u32) -> bool)).collect();
        HexMesh::tagged(points, cells, &groups).map_err(|error| match error {
            HexError::Twisted { .. } => HexError::Generator(format!(
                "{}: its cells have no volume beyond rounding: make its measures more alike, or ask for other numbers of \
                 cells",
                self.name
            )),
            other => other,
        })
    }
}

/// The quadrilaterals of a grid, with the places of their corners.
pub(super) fn grid([nx, ny]: [usize; 2]) -> impl Iterator<Item = [[usize; 2]; 4]> {
    let quad = |i: usize, j: usize| [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
    (0..ny).flat_map(move |j| (0..nx).map(move |i| quad(i, j)))
}
