//! Growing a selection.

use crate::mesh::{TetMesh, topology};

/// The selection with `rings` rings of cells around it; a ring is every cell that shares a face with a selected one.
///
/// `selected` has one entry a cell.
#[must_use]
pub fn grow(mesh: &TetMesh, selected: Vec<bool>, rings: usize) -> Vec<bool> {
    if rings == 0 || selected.iter().all(|s| *s) {
        return selected;
    }
    let neighbours = topology::face_neighbours(mesh.tets());
    let mut selected = selected;
    for _ in 0..rings {
        let beside = |around: &[Option<u32>; 4]| around.iter().flatten().any(|&t| selected[t as usize]);
        let grown: Vec<bool> = neighbours.iter().zip(&selected).map(|(around, &s)| s || beside(around)).collect();
        if grown == selected {
            break;
        }
        selected = grown;
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::box_tets;

    /// Numbers of cells selected around a start after 0, 1, ... rings.
    fn counts(mesh: &TetMesh, start: usize, rings: usize) -> Vec<usize> {
        let only = |start| (0..mesh.tets().len()).map(|t| t == start).collect::<Vec<bool>>();
        (0..=rings).map(|n| grow(mesh, only(start), n).into_iter().filter(|s| *s).count()).collect()
    }

    /// The six cells of a brick form a ring around its diagonal: each has two neighbours.
    #[test]
    fn rings_go_round_a_brick() {
        let mesh = box_tets([1.0; 3], [1; 3]).unwrap();
        for start in 0..6 {
            assert_eq!(counts(&mesh, start, 4), [1, 3, 5, 6, 6]);
        }
    }

    #[test]
    fn an_inner_cell_has_four_neighbours() {
        let mesh = box_tets([1.0; 3], [3; 3]).unwrap();
        let middle = 6 * 13;
        assert_eq!(counts(&mesh, middle, 1), [1, 5]);
        assert_eq!(counts(&mesh, middle, 100)[100], 6 * 27);
    }

    #[test]
    fn nothing_grows_to_nothing() {
        let mesh = box_tets([1.0; 3], [2; 3]).unwrap();
        assert!(!grow(&mesh, vec![false; 48], 3).contains(&true));
    }

    #[test]
    fn two_rings_are_one_ring_twice() {
        let mesh = box_tets([1.0, 2.0, 3.0], [2, 3, 4]).unwrap();
        let start: Vec<bool> = (0..mesh.tets().len()).map(|t| t % 37 == 5).collect();
        let twice = grow(&mesh, grow(&mesh, start.clone(), 1), 1);
        assert_eq!(grow(&mesh, start, 2), twice);
    }
}
