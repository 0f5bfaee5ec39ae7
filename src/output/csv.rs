//! Tables of numbers as comma-separated values.

use super::OutputError;
use super::atomic::write_atomic;
use std::path::Path;

/// Writes a line of names and a line for each row, in full precision. A number that is not finite is left empty.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn write_csv(path: &Path, names: &[&str], rows: &[Vec<f64>]) -> Result<(), OutputError> {
    write_atomic(path, |w| {
        writeln!(w, "{}", names.join(","))?;
        for row in rows {
            let numbers = row.iter().map(|x| if x.is_finite() { x.to_string() } else { String::new() });
            writeln!(w, "{}", numbers.collect::<Vec<_>>().join(","))?;
        }
        Ok(())
    })
}
