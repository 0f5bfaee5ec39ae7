//! ParaView collections (`.pvd`): the list of the files of a run with the time of each.

use super::OutputError;
use super::atomic::write_atomic;
use std::path::Path;

/// Writes a collection. `files` holds the time of each file and its path relative to the collection. To be called again
/// after each step, so that a run can be watched and an interrupted one still opens.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn write_pvd(path: &Path, files: &[(f64, String)]) -> Result<(), OutputError> {
    write_atomic(path, |w| {
        writeln!(w, "<?xml version=\"1.0\"?>")?;
        writeln!(w, "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>")?;
        for (time, file) in files {
            let file = escape(file);
            writeln!(w, "    <DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{file}\"/>")?;
        }
        writeln!(w, "  </Collection>\n</VTKFile>")
    })
}

/// The text as the value of an XML attribute.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Writes a script for ParaView's `pvpython` that shows `results.pvd` of its own folder: deformed by the point field
/// `displacement`, coloured by the cell field `von_mises`, at the last step.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn write_view(path: &Path) -> Result<(), OutputError> {
    write_atomic(path, |w| w.write_all(include_bytes!("view.py")))
}
