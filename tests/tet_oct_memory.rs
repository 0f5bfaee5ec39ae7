//! How much memory a step of smooth subdivision takes. A binary of its own: it measures the whole process.
#![allow(clippy::unwrap_used)]

use peak_alloc::PeakAlloc;
use subsolid::mesh::tet_oct::TetOctMesh;
use subsolid::mesh::{features, generate};
use subsolid::subdiv::tet_oct::refine;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

#[test]
fn a_step_takes_at_most_100_bytes_a_cell_beside_the_mesh_it_makes() {
    let start = features::with_creases(generate::box_tets([1.0; 3], [8; 3]).unwrap(), 40.0, &[]);
    let coarse = refine(&refine(&TetOctMesh::from(&start)));
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let fine = refine(&coarse);
    let (peak, kept) = (ALLOCATOR.peak_usage() - before, ALLOCATOR.current_usage() - before);
    let [peak, kept] = [peak, kept].map(|bytes| bytes as f64 / fine.cell_count() as f64);
    println!("{} cells: {kept:.1} bytes a cell kept, {peak:.1} at most", fine.cell_count());
    assert!(peak - kept < 100.0, "{kept} bytes a cell kept, {peak} at most");
}
