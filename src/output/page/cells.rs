//! The cells that a cut through the body shows: all, or if these are too many, fewer that fill the same space.

use super::shown::Shown;
use glam::DVec3;
use rayon::prelude::*;

/// Most tetrahedra that a page has of a step.
pub(super) const MOST_CELLS: usize = 50_000;

/// Most lattice points, summed over cells, that a page has of the hexahedra of a step.
const MOST_PLACES: usize = 400_000;

/// The first width of boxes that is tried, over that which would give six cells a box in a body that is a box.
const START: f64 = 0.9;

/// The least factor from one width to the next.
const LEAST_GROWTH: f64 = 1.03;

/// Cells to draw.
pub(super) struct Drawn {
    /// Points of the cells, `points` each.
    pub nodes: Vec<u32>,
    pub points: usize,
    /// The elements that they are, if not all.
    pub elements: Option<Vec<u32>>,
    /// The distance within which points became one, if not all cells are there.
    pub merged: Option<f64>,
}

/// The cells that a page has of a step.
pub(super) fn drawn(shown: &Shown<'_>) -> Drawn {
    let count = shown.cell_count();
    if shown.is_tetrahedral() {
        if count <= MOST_CELLS {
            return Drawn { nodes: shown.cells.to_vec(), points: 4, elements: None, merged: None };
        }
        return merged(shown);
    }
    if shown.cells.len() <= MOST_PLACES {
        return Drawn { nodes: shown.cells.to_vec(), points: shown.cell_points, elements: None, merged: None };
    }
    if count > MOST_CELLS {
        return Drawn { nodes: Vec::new(), points: 8, elements: Some(Vec::new()), merged: None };
    }
    let order = shown.order();
    let corner = |c: usize| order * ((c & 1) + (order + 1) * ((c >> 1 & 1) + (order + 1) * (c >> 2)));
    let nodes = shown.cells.chunks_exact(shown.cell_points).flat_map(|own| (0..8).map(move |c| own[corner(c)]));
    Drawn { nodes: nodes.collect(), points: 8, elements: None, merged: None }
}

/// Fewer tetrahedra: points that lie in one box of a grid become the first of them, and cells keep four points or go. The
/// first are the vertices that the mesh had before it was refined.
fn merged(shown: &Shown<'_>) -> Drawn {
    let (lo, hi) = limits(&shown.points);
    let mut width = START * ((hi - lo).element_product() * 6.0 / MOST_CELLS as f64).cbrt();
    loop {
        let (nodes, elements) = merge(shown, lo, hi, width);
        if elements.len() <= MOST_CELLS {
            return Drawn { nodes, points: 4, elements: Some(elements), merged: Some(width) };
        }
        width *= (elements.len() as f64 / MOST_CELLS as f64).cbrt().max(LEAST_GROWTH);
    }
}

/// One of the cells that are left where boxes have this width.
fn merge(shown: &Shown<'_>, lo: DVec3, hi: DVec3, width: f64) -> (Vec<u32>, Vec<u32>) {
    let boxes = ((hi - lo) / width).floor() + DVec3::ONE;
    let mut first = vec![u32::MAX; boxes.element_product() as usize];
    let vertices = shown.cells.iter().max().map_or(0, |v| *v as usize + 1);
    let of = |p: &DVec3| {
        let at = ((*p - lo) / width).floor();
        (at.x + boxes.x * (at.y + boxes.y * at.z)) as usize
    };
    let owner: Vec<u32> = (0..)
        .zip(&shown.points[..vertices])
        .map(|(v, p)| {
            let place = &mut first[of(p)];
            *place = (*place).min(v);
            *place
        })
        .collect();
    let of_cell = |(t, cell): (usize, &[u32; 4])| {
        let mut own = cell.map(|v| owner[v as usize]);
        own.sort_unstable();
        (own[0] != own[1] && own[1] != own[2] && own[2] != own[3]).then_some((own, t as u32))
    };
    let mut left: Vec<([u32; 4], u32)> =
        shown.cells.as_chunks::<4>().0.par_iter().enumerate().filter_map(of_cell).collect();
    left.par_sort_unstable();
    left.dedup_by_key(|(own, _)| *own);
    left.par_sort_unstable_by_key(|(_, t)| *t);
    let of_cell = |t: u32| shown.cells[4 * t as usize..][..4].iter().map(|v| owner[*v as usize]);
    (left.iter().flat_map(|(_, t)| of_cell(*t)).collect(), left.iter().map(|(_, t)| *t).collect())
}

fn limits(points: &[DVec3]) -> (DVec3, DVec3) {
    points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Space;
    use crate::mesh::generate::box_tets;

    #[test]
    fn merged_cells_fill_the_body_and_are_elements_of_it() {
        let mesh = box_tets([1.0; 3], [24; 3]).unwrap();
        let space = Space::linear(&mesh);
        let shown = Shown::tetrahedra(&space);
        assert!(shown.cell_count() > MOST_CELLS);
        let drawn = drawn(&shown);
        let elements = drawn.elements.unwrap();
        assert!((MOST_CELLS / 8..=MOST_CELLS).contains(&elements.len()), "{}", elements.len());
        assert_eq!(drawn.nodes.len(), 4 * elements.len());
        let volume = |own: &[u32; 4]| crate::mesh::quality::volume(own.map(|v| mesh.points()[v as usize])).abs();
        let filled: f64 = drawn.nodes.as_chunks::<4>().0.iter().map(volume).sum();
        assert!((0.7..1.3).contains(&filled), "{filled}");
    }
}
