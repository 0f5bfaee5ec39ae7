//! The elementary stages of refinement steps as VTK files, to be watched in ParaView.

use super::OutputError;
use super::atomic::ensure_writable_dir;
use super::options::{Compression, Units};
use super::pvd::write_pvd;
use super::vtk::{Fields, Values, write_vtu};
use crate::fem::Space;
use crate::mesh::TetMesh;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The file that lists the frames.
const COLLECTION: &str = "frames.pvd";

/// Writes one file a frame, and `frames.pvd` with all of them.
#[derive(Debug)]
pub struct FrameWriter {
    folder: PathBuf,
    files: Vec<(f64, String)>,
    /// Cells of the last frame, each with its vertices sorted, sorted.
    cells: Vec<[u32; 4]>,
    points: Vec<DVec3>,
}

impl FrameWriter {
    /// A writer for a folder, which is made if it is missing. Where it holds `frames.pvd` of an earlier run, that run's
    /// frames are removed; other files stay.
    ///
    /// # Errors
    /// [`OutputError::Write`] if no files can be made or removed there.
    pub fn new(folder: &Path) -> Result<Self, OutputError> {
        without_frames(folder)?;
        Ok(Self { folder: folder.to_owned(), files: Vec::new(), cells: Vec::new(), points: Vec::new() })
    }

    /// Writes the next frame as `frame_NNN_<name>.vtu`. Beside what [`write_vtu`] makes of a mesh it has the cell data `new`
    /// (no cell of the frame before has these vertices) and the point data `moved` (the vertex was there, at another place).
    /// Vertices must keep their numbers from frame to frame.
    ///
    /// # Errors
    /// [`OutputError::Write`] names the file.
    pub fn write(&mut self, name: &str, mesh: &TetMesh) -> Result<(), OutputError> {
        let keys: Vec<[u32; 4]> = mesh.tets().iter().map(|tet| sorted(*tet)).collect();
        let first = self.files.is_empty();
        let new: Vec<bool> = keys.iter().map(|key| !first && self.cells.binary_search(key).is_err()).collect();
        let moved: Vec<bool> =
            mesh.points().iter().enumerate().map(|(v, p)| self.points.get(v).is_some_and(|old| old != p)).collect();
        let fields = Fields {
            time: self.files.len() as f64,
            units: Units::default(),
            points: vec![("moved", Values::Flags(&moved))],
            cells: vec![("new", Values::Flags(&new))],
        };
        let words: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let file = format!("frame_{:03}_{words}.vtu", self.files.len());
        write_vtu(&self.folder.join(&file), &Space::linear(mesh), &fields, Compression::default())?;
        self.files.push((fields.time, file));
        self.cells = keys;
        self.cells.sort_unstable();
        self.points = mesh.points().to_vec();
        write_pvd(&self.folder.join(COLLECTION), &self.files)
    }
}

/// Makes a folder for frames, if it is missing. Where it holds `frames.pvd` of an earlier run, that run's frames are removed.
///
/// # Errors
/// [`OutputError::Write`] if no files can be made or removed there.
pub fn without_frames(folder: &Path) -> Result<(), OutputError> {
    ensure_writable_dir(folder)?;
    if folder.join(COLLECTION).is_file() {
        remove_frames(folder).map_err(|source| OutputError::write(folder, source))?;
    }
    Ok(())
}

/// Removes the files that are called as frames are.
fn remove_frames(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.starts_with("frame_") && name.ends_with(".vtu") {
            std::fs::remove_file(&path)?;
        }
    }
    Ok(())
}

fn sorted(mut tet: [u32; 4]) -> [u32; 4] {
    tet.sort_unstable();
    tet
}
