//! The order of a level's nodes: chunks along a space-filling curve, coloured, so that Gauss-Seidel sweeps run in
//! parallel within a colour and give the same bytes on any number of threads.

use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Marks a node that is not on the level.
pub(super) const NONE: u32 = u32::MAX;

/// Bits of a coordinate on the curve.
const BITS: u32 = 16;

/// The nodes of a level in chunks of equal size (the last may be smaller) and the chunks by colour. No two chunks of a
/// colour are neighbours.
pub(super) struct Order {
    /// Nodes a chunk, a power of two.
    pub chunk: usize,
    /// The natural number of each node.
    pub natural: Vec<u32>,
    /// The place of each natural number, [`NONE`] for those that are not on the level.
    pub place: Vec<u32>,
    /// Chunks of each colour.
    pub colours: Vec<Range<usize>>,
    /// Places in the order of the curve.
    pub curve: Vec<u32>,
}

impl Order {
    /// Orders the nodes that are `active`; `neighbours` calls back with the neighbours of a node, inactive ones included.
    pub fn new<N: Fn(u32, &mut dyn FnMut(u32)) + Sync>(
        points: &[DVec3],
        active: &[bool],
        chunk: usize,
        neighbours: N,
    ) -> Self {
        let along = along_the_curve(points, active);
        let mut chunk_of = vec![NONE; points.len()];
        for (k, &i) in along.iter().enumerate() {
            chunk_of[i as usize] = (k / chunk) as u32;
        }
        let near: Vec<Vec<u32>> =
            along.par_chunks(chunk).map(|nodes| adjacent(nodes, &chunk_of, &neighbours)).collect();
        let colour = colour(&near, !along.len().is_multiple_of(chunk));
        let mut by_colour: Vec<usize> = (0..near.len()).collect();
        by_colour.sort_by_key(|&c| colour[c]);
        let chunk_nodes = |c: usize| &along[c * chunk..along.len().min((c + 1) * chunk)];
        let natural: Vec<u32> = by_colour.iter().flat_map(|&c| chunk_nodes(c)).copied().collect();
        let mut place = vec![NONE; points.len()];
        for (k, &i) in natural.iter().enumerate() {
            place[i as usize] = k as u32;
        }
        let mut colours = Vec::new();
        let mut first = 0;
        for same in by_colour.chunk_by(|&a, &b| colour[a] == colour[b]) {
            colours.push(first..first + same.len());
            first += same.len();
        }
        let curve = along.iter().map(|&i| place[i as usize]).collect();
        Self { chunk, natural, place, colours, curve }
    }

    /// Nodes on the level.
    pub fn len(&self) -> usize {
        self.natural.len()
    }

    /// Chunks.
    pub fn chunks(&self) -> usize {
        self.len().div_ceil(self.chunk)
    }

    /// Nodes of a chunk.
    pub fn nodes(&self, chunk: usize) -> Range<usize> {
        chunk * self.chunk..self.len().min((chunk + 1) * self.chunk)
    }
}

/// The chunk of a node, and its place there: quotient and remainder, without a division, of which there are millions.
#[inline(always)]
pub(super) fn split(i: usize, chunk: usize) -> (usize, usize) {
    (i >> chunk.trailing_zeros(), i & (chunk - 1))
}

/// The active nodes in the order of Hilbert's curve through their bounding box.
fn along_the_curve(points: &[DVec3], active: &[bool]) -> Vec<u32> {
    let nodes: Vec<u32> = (0..points.len() as u32).filter(|&i| active[i as usize]).collect();
    let extent = |pick: fn(DVec3, DVec3) -> DVec3| nodes.iter().map(|&i| points[i as usize]).reduce(pick);
    let (Some(low), Some(high)) = (extent(DVec3::min), extent(DVec3::max)) else { return nodes };
    let size = (high - low).max_element();
    let scale = if size > 0.0 { f64::from((1_u32 << BITS) - 1) / size } else { 0.0 };
    let key = |&i: &u32| (hilbert(((points[i as usize] - low) * scale).to_array().map(|x| x as u32)), i);
    let mut keys: Vec<(u64, u32)> = nodes.par_iter().map(key).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

/// The place of a cell of a cube of 2^[`BITS`] cells a side on Hilbert's curve (Skilling 2004, "Programming the Hilbert
/// curve").
fn hilbert(mut x: [u32; 3]) -> u64 {
    let mut bit = 1 << (BITS - 1);
    while bit > 1 {
        let below = bit - 1;
        for i in 0..3 {
            if x[i] & bit != 0 {
                x[0] ^= below;
            } else {
                let swap = (x[0] ^ x[i]) & below;
                x[0] ^= swap;
                x[i] ^= swap;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flip = 0;
    let mut bit = 1 << (BITS - 1);
    while bit > 1 {
        if x[2] & bit != 0 {
            flip ^= bit - 1;
        }
        bit >>= 1;
    }
    let x = x.map(|x| x ^ flip);
    (0..BITS).rev().fold(0, |key, b| x.iter().fold(key, |key, x| key << 1 | u64::from(x >> b & 1)))
}

/// Other chunks next to that of `nodes`, ascending.
fn adjacent<N: Fn(u32, &mut dyn FnMut(u32))>(nodes: &[u32], chunk_of: &[u32], neighbours: &N) -> Vec<u32> {
    let own = chunk_of[nodes[0] as usize];
    let mut near = Vec::new();
    let mut last = own;
    for &i in nodes {
        neighbours(i, &mut |j| {
            let c = chunk_of[j as usize];
            if c != own && c != NONE && c != last {
                last = c;
                near.push(c);
            }
        });
        if near.len() > 4096 {
            near.sort_unstable();
            near.dedup();
        }
    }
    near.sort_unstable();
    near.dedup();
    near
}

/// Gives each chunk the first colour that no neighbour before it has. A short last chunk gets a colour of its own, the last,
/// so that all chunks before it are full.
fn colour(near: &[Vec<u32>], last_is_short: bool) -> Vec<u32> {
    let mut colour = vec![NONE; near.len()];
    for c in 0..near.len() {
        let taken = |colour: &[u32], k: u32| near[c].iter().any(|&n| colour[n as usize] == k);
        colour[c] = (0..).find(|&k| !taken(&colour, k)).unwrap_or(NONE);
    }
    if let (true, Some(last)) = (last_is_short, colour.len().checked_sub(1)) {
        colour[last] = colour.iter().max().map_or(0, |most| most + 1);
    }
    colour
}
