//! Evaluating in parallel, changing in a fixed order: results do not depend on the number of threads.

use super::super::solid::Solid;
use super::fan::Fan;
use super::freedom::Freedom;
use crate::mesh::topology;
use glam::DVec3;
use rayon::prelude::*;

/// Those items, in order, that `worth` (with work space of its own on each thread) says yes to.
pub(super) fn select<T: Copy + Send + Sync, W: Default>(
    items: Vec<T>,
    worth: impl Fn(&mut W, &T) -> bool + Sync,
) -> Vec<T> {
    let verdicts = items.par_iter().with_min_len(256).map_init(W::default, |work, item| worth(work, item));
    let verdicts: Vec<bool> = verdicts.collect();
    items.into_iter().zip(verdicts).filter_map(|(item, yes)| yes.then_some(item)).collect()
}

/// Goes through the items in order, block by block: `propose` sees each item of a block in parallel (with work space of
/// its own on each thread), then `commit` gets the block with its proposals. What a commit changes is for it to keep track
/// of, so that it can do as if each proposal had been made just before.
pub(super) fn in_blocks<T: Copy + Send + Sync, W: Default, P: Send>(
    solid: &mut Solid,
    items: &[T],
    size: usize,
    propose: impl Fn(&mut W, &Solid, T) -> P + Sync,
    mut commit: impl FnMut(&mut Solid, Vec<(T, P)>),
) {
    for block in items.chunks(size) {
        let mesh = &*solid;
        let proposals = block.par_iter().with_min_len(32).map_init(W::default, |work, &t| (t, propose(work, mesh, t)));
        let proposals = proposals.collect();
        commit(solid, proposals);
    }
}

/// The vertices of the cells, sorted.
pub(super) fn vertices_of(solid: &Solid, cells: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut vertices: Vec<u32> = cells.flat_map(|t| solid.tet(t)).collect();
    vertices.par_sort_unstable();
    vertices.dedup();
    vertices
}

/// The vertices of the wanted cells, sorted.
pub(super) fn vertices_where(solid: &Solid, wanted: impl Fn(u32) -> bool + Sync) -> Vec<u32> {
    let mut marks = vec![false; solid.point_count()];
    for t in solid.live_cells().filter(|&t| wanted(t)) {
        for v in solid.tet(t) {
            marks[v as usize] = true;
        }
    }
    (0..solid.point_count() as u32).filter(|&v| marks[v as usize]).collect()
}

/// The faces of the wanted cells, each with its vertices in order, sorted.
pub(super) fn faces_where(solid: &Solid, wanted: impl Fn(u32) -> bool + Sync) -> Vec<[u32; 3]> {
    by_vertex(solid, |v, found| {
        let start = found.len();
        for &t in solid.cells_at(v).iter().filter(|t| wanted(**t)) {
            let faces = topology::tet_faces(solid.tet(t)).map(topology::sorted3);
            found.extend(faces.into_iter().filter(|f| f[0] == v));
        }
        found[start..].sort_unstable();
        let mut last = None;
        let mut end = start;
        for i in start..found.len() {
            if last != Some(found[i]) {
                last = Some(found[i]);
                found[end] = found[i];
                end += 1;
            }
        }
        found.truncate(end);
    })
}

/// What `each` finds at the vertices, in their order.
fn by_vertex<T: Clone + Send + Sync>(solid: &Solid, each: impl Fn(u32, &mut Vec<T>) + Sync) -> Vec<T> {
    const CHUNK: u32 = 256;
    let count = solid.point_count() as u32;
    let chunk = |i: u32| {
        let mut found = Vec::new();
        for v in CHUNK * i..(CHUNK * (i + 1)).min(count) {
            each(v, &mut found);
        }
        found
    };
    let chunks: Vec<Vec<T>> = (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
    chunks.concat()
}

/// Moves vertices to where `propose` (with work space of its own on each thread) says; those without common cells at the
/// same time. Returns how many moved.
pub(super) fn sweep<W>(
    solid: &mut Solid,
    freedoms: &[Freedom],
    vertices: Vec<u32>,
    space: impl Fn() -> W + Sync,
    propose: impl Fn(&mut W, &Solid, u32, Freedom) -> Option<DVec3> + Sync,
) -> usize {
    let movable = vertices.into_iter().filter(|&v| freedoms[v as usize] != Freedom::Fixed).collect();
    let mut moved = 0;
    for class in independent_classes(solid, movable) {
        let mesh = &*solid;
        let new = |(work, fan): &mut (W, Fan), v: u32| {
            let p = propose(work, mesh, v, freedoms[v as usize])?;
            fan.gather(mesh, v);
            Some((v, p, fan.sines(p)))
        };
        let moves = class.into_par_iter().with_min_len(64).map_init(|| (space(), Fan::default()), new);
        for (v, p, sines) in moves.collect::<Vec<_>>().into_iter().flatten() {
            solid.move_point_to(v, p, &sines);
            moved += 1;
        }
    }
    moved
}

/// Classes of vertices of which no two share a cell: a greedy colouring in the given order. At most 64 classes; what is
/// left over waits for the next sweep.
fn independent_classes(solid: &Solid, vertices: Vec<u32>) -> Vec<Vec<u32>> {
    const NONE: u8 = u8::MAX;
    let mut colours = vec![NONE; solid.point_count()];
    let mut classes: Vec<Vec<u32>> = Vec::new();
    for v in vertices {
        let mut used = 0_u64;
        for &t in solid.cells_at(v) {
            for w in solid.tet(t) {
                let colour = colours[w as usize];
                used |= if colour == NONE { 0 } else { 1 << colour };
            }
        }
        let colour = (!used).trailing_zeros() as usize;
        if colour == 64 {
            continue;
        }
        colours[v as usize] = colour as u8;
        if colour == classes.len() {
            classes.push(Vec::new());
        }
        classes[colour].push(v);
    }
    classes
}
