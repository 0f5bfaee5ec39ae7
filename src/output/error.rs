//! What can go wrong while writing results.

use std::io;
use std::path::{Path, PathBuf};

/// Why a result could not be written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputError {
    /// The operating system refused.
    #[error("cannot write {path}", path = path.display())]
    #[diagnostic(help(
        "check that the folder exists, may be written to and has free space, or name another by the option it came from \
         (--output, --frames or --json); an older file of that name was left as it was"
    ))]
    Write {
        /// The file or folder asked for.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A file is to be written into a folder that is not there.
    #[error("cannot write {path}: there is no folder {folder}", path = path.display(), folder = folder.display())]
    #[diagnostic(help("make the folder first; nothing was computed or written"))]
    NoFolder {
        /// The file asked for.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// A file that no earlier run wrote has the name of a result.
    #[error("{path} is in the way: a result has this name, and no earlier run wrote this file", path = path.display())]
    #[diagnostic(help("choose another folder by --output, or move the file away; nothing was removed or written"))]
    InTheWay {
        /// The file.
        path: PathBuf,
    },
    /// The mesh to compute on is a result of an earlier run that this run would remove.
    #[error("{path} is the mesh of this run, and a result of an earlier one that would be removed", path = path.display())]
    #[diagnostic(help("choose another folder by --output; nothing was removed or written"))]
    Input {
        /// The file.
        path: PathBuf,
    },
    /// A file to be written is one that is read.
    #[error("{path} is read by this command, and would be written over", path = path.display())]
    #[diagnostic(help("name another file to write; nothing was computed or written"))]
    Overwrites {
        /// The file.
        path: PathBuf,
    },
    /// Results are not such that a page can show them.
    #[error("cannot show {path}: {why}", path = path.display())]
    #[diagnostic(help(
        "name a folder that `subsolid run` or `subsolid compare` has written, or run the scenario again"
    ))]
    NotShown {
        /// The file or folder.
        path: PathBuf,
        /// What is missing or unknown.
        why: String,
    },
    /// A field does not fit the mesh; a programming error of the caller.
    #[error("cannot write {path}: {field:?} has {got} values, the mesh asks for {want}", path = path.display())]
    Length {
        /// The file asked for.
        path: PathBuf,
        /// Name of the field.
        field: String,
        /// Values given.
        got: usize,
        /// Points or cells of the mesh.
        want: usize,
    },
    /// A field holds NaN or an infinity.
    #[error("cannot write {path}: value {index} of {field:?} is not finite", path = path.display())]
    #[diagnostic(help(
        "the numbers left the range of double precision: check the units of the mesh, the material and the loads"
    ))]
    NotFinite {
        /// The file asked for.
        path: PathBuf,
        /// Name of the field.
        field: String,
        /// Index of the point or cell.
        index: usize,
    },
}

impl OutputError {
    /// The error of the operating system at `path`. Of the names that it may tell, only `path` means something to the
    /// user: a temporary file beside it does not.
    pub fn write(path: &Path, source: io::Error) -> Self {
        let source = match source.raw_os_error() {
            Some(code) => io::Error::from_raw_os_error(code),
            None if source.get_ref().is_some() => match source.kind() {
                io::ErrorKind::Other => source,
                kind => io::Error::from(kind),
            },
            None => source,
        };
        Self::Write { path: path.to_owned(), source }
    }
}
