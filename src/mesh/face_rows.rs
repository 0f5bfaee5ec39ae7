//! Which cells meet at each face: the base of all connectivity.

use super::quality;
use super::rows::Rows;
use super::topology::{sorted3, tet_faces, vertex_count};
use rayon::prelude::*;

/// The faces of all cells in rows by their smallest vertex (compressed rows), 4 bytes a face of a cell.
pub(super) struct FaceRows<'a> {
    tets: &'a [[u32; 4]],
    /// Face `i` of cell `t` as `4 t + i`, ascending in each row; enough for 2^30 cells.
    rows: Rows,
}

/// A face of a cell: its two larger vertices in ascending order (the smaller one in the upper half), and `4 t + i`.
pub(super) type FaceUse = (u64, u32);

/// How many rows a thread takes at a time, and how many are visited before their results are taken.
const ROWS: usize = 1 << 10;
const BATCH: usize = 16 * ROWS;

impl<'a> FaceRows<'a> {
    pub(super) fn new(tets: &'a [[u32; 4]]) -> Self {
        let smallest = |t: usize| tet_faces(tets[t]).map(|[a, b, c]| a.min(b).min(c));
        let rows = Rows::new(vertex_count(tets), tets.len(), |t| smallest(t).into_iter().zip(4 * t as u32..));
        Self { tets, rows }
    }

    /// The outward face that a use stands for.
    pub(super) fn face(&self, face: u32) -> [u32; 3] {
        let tet = self.tets[face as usize / 4];
        quality::FACES[face as usize % 4].map(|i| tet[i])
    }

    /// Shows every face to `visit`: its sorted vertices, and its uses `4 t + i` in ascending order. Gives the results in
    /// the order of the sorted vertices to `take`, whatever the number of threads.
    pub(super) fn visit<T: Send>(&self, visit: impl Fn([u32; 3], &[FaceUse]) -> Option<T> + Sync, take: impl FnMut(T)) {
        let rows = self.rows.len();
        let mut take = take;
        for batch in (0..rows).step_by(BATCH) {
            let end = rows.min(batch + BATCH);
            let chunks: Vec<usize> = (batch..end).step_by(ROWS).collect();
            let found: Vec<Vec<T>> =
                chunks.into_par_iter().map(|first| self.visit_rows(first..end.min(first + ROWS), &visit)).collect();
            found.into_iter().flatten().for_each(&mut take);
        }
    }

    fn visit_rows<T>(
        &self,
        rows: std::ops::Range<usize>,
        visit: &impl Fn([u32; 3], &[FaceUse]) -> Option<T>,
    ) -> Vec<T> {
        let mut found = Vec::new();
        let mut row: Vec<FaceUse> = Vec::new();
        for v in rows {
            row.clear();
            row.extend(self.rows.row(v).iter().map(|&face| {
                let [_, b, c] = sorted3(self.face(face));
                (u64::from(b) << 32 | u64::from(c), face)
            }));
            row.sort_unstable();
            let faces = row.chunk_by(|x, y| x.0 == y.0);
            found.extend(faces.filter_map(|same| visit([v as u32, (same[0].0 >> 32) as u32, same[0].0 as u32], same)));
        }
        found
    }

    /// The cells at a face.
    pub(super) fn cells_at(&self, key: [u32; 3]) -> Vec<usize> {
        let uses = 0..4 * self.tets.len() as u32;
        uses.filter(|&face| sorted3(self.face(face)) == key).map(|face| face as usize / 4).collect()
    }
}
