//! The edges of a mesh of tetrahedra and octahedra.

use super::super::rows::Rows;
use super::super::topology::sorted2;
use super::{OCT_EDGES, TetOctMesh};
use crate::mesh::quality::EDGES;
use rayon::prelude::*;

/// Which edges there are, and which cells have them.
#[derive(Debug)]
pub struct CellEdges {
    /// All edges, each sorted, sorted by their smaller vertices and then by the larger.
    edges: Vec<[u32; 2]>,
    /// Where the edges of each smaller vertex begin.
    starts: Vec<u32>,
    /// The edges of each tetrahedron, in the order of [`EDGES`].
    of_tets: Vec<[u32; 6]>,
    /// The edges of each octahedron, in the order of [`OCT_EDGES`].
    of_octs: Vec<[u32; 12]>,
    /// The uses of each edge: `6 t + i` of tetrahedron `t`; after these `12 o + i` of octahedron `o`.
    uses: Rows,
}

/// A cell with an edge: its number among its kind, and which of its edges it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeUse {
    /// A tetrahedron, an edge of [`EDGES`].
    Tet(usize, usize),
    /// An octahedron, an edge of [`OCT_EDGES`].
    Oct(usize, usize),
}

/// How many vertices or cells a thread takes at a time.
const PIECE: usize = 1 << 11;

impl CellEdges {
    /// Finds the edges of a mesh.
    #[must_use]
    pub fn new(mesh: &TetOctMesh) -> Self {
        let (tets, octs) = (mesh.tets(), mesh.octs());
        let (starts, edges) = collect(mesh);
        let mut found = Self { edges, starts, of_tets: Vec::new(), of_octs: Vec::new(), uses: Rows::new(0, 0, |_| []) };
        let id = |a: u32, b: u32| found.find([a, b]).unwrap_or(u32::MAX);
        let of_tets: Vec<_> = tets.par_iter().with_min_len(PIECE).map(|t| EDGES.map(|[i, j]| id(t[i], t[j]))).collect();
        let of_octs: Vec<_> =
            octs.par_iter().with_min_len(PIECE).map(|o| OCT_EDGES.map(|[i, j]| id(o[i], o[j]))).collect();
        let after = 6 * tets.len() as u32;
        found.uses = Rows::new(found.edges.len(), tets.len() + octs.len(), |cell| {
            let (own, first): (&[u32], u32) = match cell.checked_sub(tets.len()) {
                None => (&of_tets[cell], 6 * cell as u32),
                Some(oct) => (&of_octs[oct], after + 12 * oct as u32),
            };
            own.iter().copied().zip(first..)
        });
        Self { of_tets, of_octs, ..found }
    }

    /// All edges, sorted.
    #[must_use]
    pub fn all(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// The number of the edge between two vertices.
    #[must_use]
    pub fn find(&self, ends: [u32; 2]) -> Option<u32> {
        let [a, b] = sorted2(ends);
        let first = *self.starts.get(a as usize)? as usize;
        let row = &self.edges[first..*self.starts.get(a as usize + 1)? as usize];
        row.iter().position(|edge| edge[1] == b).map(|place| (first + place) as u32)
    }

    /// The edges of a tetrahedron, in the order of [`EDGES`].
    #[must_use]
    pub fn of_tet(&self, tet: usize) -> [u32; 6] {
        self.of_tets[tet]
    }

    /// The edges of an octahedron, in the order of [`OCT_EDGES`].
    #[must_use]
    pub fn of_oct(&self, oct: usize) -> [u32; 12] {
        self.of_octs[oct]
    }

    /// The cells with an edge, ascending.
    pub fn uses(&self, edge: usize) -> impl Iterator<Item = EdgeUse> + '_ {
        let after = 6 * self.of_tets.len();
        self.uses.row(edge).iter().map(move |&entry| match (entry as usize).checked_sub(after) {
            None => EdgeUse::Tet(entry as usize / 6, entry as usize % 6),
            Some(rest) => EdgeUse::Oct(rest / 12, rest % 12),
        })
    }
}

/// All edges, sorted, and where those of each smaller vertex begin.
fn collect(mesh: &TetOctMesh) -> (Vec<u32>, Vec<[u32; 2]>) {
    let (tets, octs) = (mesh.tets(), mesh.octs());
    let rows = Rows::new(mesh.points().len(), tets.len() + octs.len(), |cell| {
        let edge = move |i: usize| match cell.checked_sub(tets.len()) {
            None => EDGES[i].map(|j| tets[cell][j]),
            Some(oct) => OCT_EDGES[i].map(|j| octs[oct][j]),
        };
        let count = if cell < tets.len() { 6 } else { 12 };
        (0..count).map(move |i| sorted2(edge(i))).map(|[a, b]| (a, b))
    });
    let of_piece = |first: usize| {
        let (mut edges, mut counts, mut row) = (Vec::new(), Vec::with_capacity(PIECE), Vec::new());
        for a in first..rows.len().min(first + PIECE) {
            row.clear();
            row.extend_from_slice(rows.row(a));
            row.sort_unstable();
            row.dedup();
            counts.push(row.len() as u32);
            edges.extend(row.iter().map(|&b| [a as u32, b]));
        }
        (edges, counts)
    };
    let firsts: Vec<usize> = (0..rows.len()).step_by(PIECE).collect();
    let pieces: Vec<(Vec<[u32; 2]>, Vec<u32>)> = firsts.into_par_iter().map(of_piece).collect();
    let mut starts = Vec::with_capacity(rows.len() + 1);
    starts.push(0);
    let mut end = 0;
    for count in pieces.iter().flat_map(|p| &p.1) {
        end += count;
        starts.push(end);
    }
    let mut edges = Vec::with_capacity(end as usize);
    pieces.iter().for_each(|p| edges.extend_from_slice(&p.0));
    (starts, edges)
}
