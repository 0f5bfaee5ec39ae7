//! Removal of vertices that have lost their cells.

use super::{DEAD, Solid};
use crate::mesh::topology;

impl Solid {
    /// Drops the vertices from `first` on that have no cell, and numbers the others anew, in their order. Returns the old
    /// number of each. The last change before the mesh is closed.
    pub(in crate::subdiv) fn drop_unused(&mut self, first: u32) -> Vec<u32> {
        let used = |v: &u32| *v < first || !self.cells_at(*v).is_empty();
        let kept: Vec<u32> = (0..self.points.len() as u32).filter(used).collect();
        let mut numbers = vec![DEAD; self.points.len()];
        kept.iter().zip(0..).for_each(|(&v, number)| numbers[v as usize] = number);
        let new = |v: u32| if v == DEAD { DEAD } else { numbers[v as usize] };
        self.points = kept.iter().map(|&v| self.points[v as usize]).collect();
        self.tets.iter_mut().for_each(|tet| *tet = tet.map(new));
        self.faces.iter_mut().for_each(|face| face.vertices = face.vertices.map(new));
        let creases = self.creases.iter().map(|(edge, &feature)| (topology::sorted2(edge.map(new)), feature));
        self.creases = creases.collect();
        self.rest.corners.iter_mut().for_each(|v| *v = new(*v));
        kept
    }
}
