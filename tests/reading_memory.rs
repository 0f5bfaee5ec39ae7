//! How much memory reading takes. A binary of its own: it measures the whole process.
#![allow(clippy::unwrap_used)]

#[path = "meshes/binary_msh.rs"]
mod binary_msh;

use binary_msh::binary_msh;
use peak_alloc::PeakAlloc;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;
use subsolid::mesh::read::read;
use subsolid::mesh::{TetMesh, generate};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One test at a time.
static TURN: Mutex<()> = Mutex::new(());

/// Bytes of the lists of a mesh.
fn bytes_of(mesh: &TetMesh) -> usize {
    24 * mesh.points().len() + (16 + 2 + 1) * mesh.tets().len() + 16 * mesh.faces().len()
}

#[test]
fn a_large_binary_file_takes_at_most_three_times_the_mesh_in_memory() {
    let _turn = TURN.lock();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.msh");
    let cells = {
        let mesh = generate::box_tets([1.0; 3], [62; 3]).unwrap();
        std::fs::write(&path, binary_msh(&mesh, false)).unwrap();
        mesh.tets().len()
    };
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let start = Instant::now();
    let mesh = read(&path).unwrap().mesh;
    let (seconds, peak) = (start.elapsed().as_secs_f64(), ALLOCATOR.peak_usage() - before);
    let ratio = peak as f64 / bytes_of(&mesh) as f64;
    println!("{cells} cells: {seconds:.2} s, {:.0} MB at most, {ratio:.2} times the mesh", peak as f64 / 1e6);
    assert_eq!(mesh.tets().len(), cells);
    assert!(ratio <= 3.0, "{ratio} times the mesh");
}

/// Numbers all over the files, made huge: whatever counts they are, no memory is taken for them.
#[test]
fn huge_counts_take_no_memory() {
    let _turn = TURN.lock();
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let folder = tempfile::tempdir().unwrap();
    for name in ["gmsh22_binary.msh", "partitioned_binary.msh", "vtk51_binary.vtk", "vtk_raw_lz4.vtu"] {
        let bytes = std::fs::read(meshes.join(name)).unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).unwrap();
        let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
        let put = |i: usize, bytes: &[u8]| {
            (&file).seek(SeekFrom::Start(i as u64)).unwrap();
            (&file).write_all(bytes).unwrap();
        };
        for i in (0..bytes.len() - 4).step_by(3) {
            put(i, &[0xff, 0xff, 0xff, 0x7f]);
            let before = ALLOCATOR.current_usage();
            ALLOCATOR.reset_peak_usage();
            let _ = read(&path);
            let peak = ALLOCATOR.peak_usage() - before;
            assert!(peak < 20_000_000, "{name}: {peak} bytes taken with byte {i} changed");
            put(i, &bytes[i..i + 4]);
        }
    }
}
