//! The ring of a cell: the cells that share a vertex with it, seen from its own frame.

use crate::mesh::hex::{FACES, HexTopology, NONE};
use crate::subdiv::catmull_clark::Control;
use rustc_hash::FxHashMap;

/// The connectivity and the tags of a ring, in numbers of its own: all that the functions on its first cell depend on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Shape {
    /// The cells; the first is the one in the middle, whose corners are the vertices 0 to 7. The others are seen in frames
    /// carried over from it through faces.
    pub cells: Vec<[u16; 8]>,
    /// Where each cell lies, in steps from the first along the axes; a grid's coordinates if the ring is one.
    offsets: Vec<[i8; 3]>,
    /// Creases at the corners of the first cell, sorted.
    creases: Vec<[u16; 2]>,
    /// Corners of the first cell that are tagged, one bit each.
    corners: u8,
}

/// A ring in a mesh.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    /// The mesh's number of each vertex of the ring.
    pub vertices: Vec<u32>,
    pub shape: Shape,
}

/// The control points of a cell in a grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Grid {
    /// Whether there is a neighbour below and above, for each axis.
    pub lower: [bool; 3],
    pub upper: [bool; 3],
    /// The ring's vertices at the places of a 4 x 4 x 4 array, x fastest; those that do not exist are `u16::MAX`.
    pub places: [u16; 64],
}

/// Corners of each face as bits.
const FACE_BITS: [u8; 6] = {
    let mut bits = [0; 6];
    let mut f = 0;
    while f < 6 {
        let [a, b, c, d] = FACES[f];
        bits[f] = 1 << a | 1 << b | 1 << c | 1 << d;
        f += 1;
    }
    bits
};

impl Ring {
    /// The ring of cell `t`.
    pub fn of(control: &Control<'_>, t: u32) -> Self {
        let topology = control.topology;
        let own = control.cells[t as usize];
        let mut wanted: Vec<u32> = own.iter().flat_map(|&v| topology.vertex_cells(v)).copied().collect();
        wanted.sort_unstable();
        wanted.dedup();
        let mut walk = Walk { control, reached: vec![(t, own, [0; 3])], wanted };
        let mut next = 0;
        while next < walk.reached.len() {
            walk.visit(next);
            next += 1;
        }
        Self::numbered(control, &walk.reached)
    }

    fn numbered(control: &Control<'_>, reached: &[(u32, [u32; 8], [i8; 3])]) -> Self {
        let mut numbers: FxHashMap<u32, u16> = FxHashMap::default();
        let mut vertices = Vec::new();
        let mut number = |v: u32| {
            *numbers.entry(v).or_insert_with(|| {
                vertices.push(v);
                vertices.len() as u16 - 1
            })
        };
        let cells = reached.iter().map(|(_, frame, _)| frame.map(&mut number)).collect();
        let mut shape =
            Shape { cells, offsets: reached.iter().map(|r| r.2).collect(), creases: Vec::new(), corners: 0 };
        for (i, &v) in vertices[..8].iter().enumerate() {
            shape.corners |= u8::from(control.corner[v as usize]) << i;
            let creases = control.topology.vertex_edges(v).iter().filter(|e| control.creased[**e as usize]);
            shape.creases.extend(creases.map(|&e| {
                let mut ends = control.topology.edges()[e as usize].map(|v| numbers[&v]);
                ends.sort_unstable();
                ends
            }));
        }
        shape.creases.sort_unstable();
        shape.creases.dedup();
        Self { vertices, shape }
    }
}

/// A walk over the cells of a ring through their faces.
struct Walk<'a, 'c> {
    control: &'a Control<'c>,
    /// Cells, their corners in the frame of the walk, and where they lie.
    reached: Vec<(u32, [u32; 8], [i8; 3])>,
    /// Cells not reached yet, and the first; sorted.
    wanted: Vec<u32>,
}

impl Walk<'_, '_> {
    /// Goes to the neighbours of the cell that was reached as number `i`.
    fn visit(&mut self, i: usize) {
        let (t, frame, offset) = self.reached[i];
        let own = self.control.cells[t as usize];
        // Frames have the vertices of their cells.
        let index = |cell: &[u32; 8], v: u32| cell.iter().position(|w| *w == v).unwrap_or(0);
        for (k, face) in FACES.iter().enumerate() {
            let (axis, side) = (k / 2, k % 2);
            let bits = face.iter().fold(0, |bits, &c| bits | 1_u8 << index(&own, frame[c]));
            let Some(local) = FACE_BITS.iter().position(|b| *b == bits) else { continue };
            let [a, b] =
                self.control.topology.face_cells()[self.control.topology.cell_faces()[t as usize][local] as usize];
            let other = if a == t { b } else { a };
            if other == NONE || self.wanted.binary_search(&other).is_err() || self.reached.iter().any(|r| r.0 == other)
            {
                continue;
            }
            let cell = self.control.cells[other as usize];
            let shared = face.iter().fold(0, |bits, &c| bits | 1_u8 << index(&cell, frame[c]));
            let across = FACE_BITS.iter().position(|b| *b == shared).unwrap_or(0) / 2;
            let mut carried = [0; 8];
            for &c in face {
                carried[c ^ 1 << axis] = frame[c];
                carried[c] = cell[index(&cell, frame[c]) ^ 1 << across];
            }
            let mut at = offset;
            at[axis] += 2 * side as i8 - 1;
            self.reached.push((other, carried, at));
        }
    }
}

impl Shape {
    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.cells.iter().flatten().max().map_or(0, |v| usize::from(*v) + 1)
    }

    /// The cells with vertices as in a mesh.
    pub fn mesh_cells(&self) -> Vec<[u32; 8]> {
        self.cells.iter().map(|c| c.map(u32::from)).collect()
    }

    /// The tags, for the masks of what touches the first cell.
    pub fn control<'a>(&self, cells: &'a [[u32; 8]], topology: &'a HexTopology) -> Control<'a> {
        let mut creased = vec![false; topology.edges().len()];
        for ends in &self.creases {
            if let Some(e) = topology.edge(ends.map(u32::from)) {
                creased[e as usize] = true;
            }
        }
        let corner = (0..self.vertices()).map(|v| v < 8 && self.corners >> v & 1 == 1).collect();
        Control { cells, topology, creased, corner }
    }

    /// The array of control points, if the functions are a tensor product of splines.
    pub fn regular(&self) -> Option<Grid> {
        let has = |offset: [i8; 3]| self.offsets.contains(&offset);
        let step = |axis: usize, by: i8| std::array::from_fn(|a| if a == axis { by } else { 0 });
        let lower = [0, 1, 2].map(|axis| has(step(axis, -1)));
        let upper = [0, 1, 2].map(|axis| has(step(axis, 1)));
        let count: usize = (0..3).map(|a| 1 + usize::from(lower[a]) + usize::from(upper[a])).product();
        if self.cells.len() != count {
            return None;
        }
        let mut places = [u16::MAX; 64];
        for (cell, offset) in self.cells.iter().zip(&self.offsets) {
            for (c, &v) in cell.iter().enumerate() {
                let at = [0, 1, 2].map(|a| i16::from(offset[a]) + (c >> a & 1) as i16 + 1);
                if at.iter().any(|x| !(0..4).contains(x)) {
                    return None;
                }
                let place = &mut places[(at[0] + 4 * at[1] + 16 * at[2]) as usize];
                if *place != u16::MAX && *place != v {
                    return None;
                }
                *place = v;
            }
        }
        let grid = Grid { lower, upper, places };
        (self.corners_fit(&grid) && grid.creases() == self.creases).then_some(grid)
    }

    /// Whether only corners of the grid are tagged as such.
    fn corners_fit(&self, grid: &Grid) -> bool {
        (0..8).all(|c| self.corners >> c & 1 == 0 || (0..3).all(|axis| grid.ends(c, axis)))
    }
}

impl Grid {
    /// Whether the grid ends at corner `c` of the cell in the middle, along an axis.
    fn ends(&self, c: usize, axis: usize) -> bool {
        !(if c >> axis & 1 == 0 { self.lower[axis] } else { self.upper[axis] })
    }

    /// The creases that a box has at the corners of the cell in the middle, sorted: where the grid ends along two axes.
    fn creases(&self) -> Vec<[u16; 2]> {
        let mut creases = Vec::new();
        for c in 0..8 {
            let at = [0, 1, 2].map(|axis| 1 + (c >> axis & 1));
            for axis in (0..3).filter(|axis| (0..3).all(|other| other == *axis || self.ends(c, other))) {
                for next in [at[axis] - 1, at[axis] + 1] {
                    let mut to = at;
                    to[axis] = next;
                    let mut ends = [at, to].map(|[x, y, z]| self.places[x + 4 * y + 16 * z]);
                    ends.sort_unstable();
                    if ends[1] != u16::MAX {
                        creases.push(ends);
                    }
                }
            }
        }
        creases.sort_unstable();
        creases.dedup();
        creases
    }
}
