//! Evaluating in parallel, changing in a fixed order: results do not depend on the number of threads.

use super::super::solid::{Solid, rest_of};
use super::fan::Fan;
use super::freedom::Freedom;
use crate::mesh::topology;
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

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

/// The inner faces of the wanted cells, each with its vertices in order, sorted, with the cells at it.
pub(super) fn faces_where(solid: &Solid, wanted: impl Fn(u32) -> bool + Sync) -> Vec<([u32; 3], [u32; 2])> {
    let at = |&v: &u32| {
        let mut faces: SmallVec<[([u32; 2], u32); 64]> = SmallVec::new();
        for &t in solid.cells_at(v) {
            let [p, q, r] = rest_of(solid.tet(t), v);
            let pairs = [[p, q], [q, r], [r, p]].map(topology::sorted2);
            faces.extend(pairs.into_iter().filter(|pair| pair[0] > v).map(|pair| (pair, t)));
        }
        faces.sort_unstable();
        let twice = faces.windows(2).filter(|two| two[0].0 == two[1].0 && (wanted(two[0].1) || wanted(two[1].1)));
        twice.map(|two| ([v, two[0].0[0], two[0].0[1]], [two[0].1, two[1].1])).collect::<Vec<_>>()
    };
    let vertices = vertices_where(solid, &wanted);
    vertices.par_iter().with_min_len(64).map(at).collect::<Vec<_>>().concat()
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
