//! Evaluating in parallel, changing in a fixed order: results do not depend on the number of threads.

use super::super::solid::Solid;
use super::freedom::Freedom;
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

/// The vertices of the cells, sorted.
pub(super) fn vertices_of(solid: &Solid, cells: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut vertices: Vec<u32> = cells.flat_map(|t| solid.tet(t)).collect();
    vertices.par_sort_unstable();
    vertices.dedup();
    vertices
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
        let new = |work: &mut W, v: u32| {
            let p = propose(work, mesh, v, freedoms[v as usize])?;
            Some((v, p, mesh.sines_with(v, p)))
        };
        let moves = class.into_par_iter().with_min_len(64).map_init(&space, new);
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
