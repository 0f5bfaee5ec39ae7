//! Files that appear whole or not at all.

use super::OutputError;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// What the names of files begin with that are being written; a run that is killed may leave one.
pub const TEMPORARY: &str = ".subsolid-";

/// Writes a file through a temporary one beside it that takes its name when everything is on the disk. Whatever happens,
/// `path` holds the old bytes or the new ones, and no other file stays behind.
///
/// # Errors
/// [`OutputError::Write`] names `path`; its old content, if any, is untouched.
pub fn write_atomic(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), OutputError> {
    replace(path, write).map_err(|source| OutputError::write(path, source))
}

/// Makes the folder (and those above it) if it is missing, and checks that files can be made in it. To be called before
/// the first long computation.
///
/// # Errors
/// [`OutputError::Write`] names the folder.
pub fn ensure_writable_dir(path: &Path) -> Result<(), OutputError> {
    if path.is_file() {
        return Err(OutputError::write(path, io::Error::other("it is a file, not a folder")));
    }
    std::fs::create_dir_all(path)
        .and_then(|()| temporary(path))
        .map(|_| ())
        .map_err(|source| OutputError::write(path, source))
}

/// Checks that the folder of a file to be written is there; `-`, standard output, needs none. To be called before the first
/// long computation.
///
/// # Errors
/// [`OutputError::NoFolder`].
pub fn ensure_parent(path: &Path) -> Result<(), OutputError> {
    let folder = folder_of(path);
    if path == Path::new("-") || folder.is_dir() {
        return Ok(());
    }
    Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() })
}

/// Checks that a file can be written: that its folder is there and files can be made in it, and that it is none of those that are
/// read. `-`, standard output, needs nothing. To be called before the first long computation.
///
/// # Errors
/// [`OutputError::NoFolder`], [`OutputError::Write`], [`OutputError::Overwrites`].
pub fn ensure_target<'a>(path: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), OutputError> {
    ensure_parent(path)?;
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() {
        return Err(OutputError::write(path, io::Error::other("it is a folder, not a file")));
    }
    let real = path.canonicalize().ok();
    if real.is_some() && inputs.into_iter().any(|input| input.canonicalize().ok() == real) {
        return Err(OutputError::Overwrites { path: path.to_owned() });
    }
    temporary(folder_of(path)).map(drop).map_err(|source| OutputError::write(path, source))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Renaming is atomic within one file system only, so the temporary file lives in the same folder.
    let mut buffered = BufWriter::new(temporary(folder_of(path))?);
    write(&mut buffered)?;
    let file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    // Temporary files are private by default; results get the permissions of any other new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn class_53_a_full_disk_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.txt");
        write_atomic(&path, |w| w.write_all(b"old")).unwrap();
        let failure = write_atomic(&path, |w| {
            w.write_all(&[b'x'; 100_000])?;
            Err(io::Error::other("disk full"))
        });
        let OutputError::Write { path: named, source } = failure.unwrap_err() else { panic!("another kind of error") };
        assert!(named.ends_with("result.txt") && source.to_string() == "disk full");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["result.txt"]);
        write_atomic(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn a_file_in_place_of_a_folder_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let OutputError::Write { path, source } = ensure_writable_dir(&file).unwrap_err() else { panic!() };
        assert_eq!((path, source.to_string().as_str()), (file.clone(), "it is a file, not a folder"));
        let OutputError::Write { source, .. } = ensure_writable_dir(&file.join("below")).unwrap_err() else { panic!() };
        assert!(!source.to_string().contains("subsolid-"), "{source}");
        let missing = write_atomic(&folder.path().join("none/file"), |_| Ok(())).unwrap_err();
        let OutputError::Write { source, .. } = missing else { panic!() };
        assert!(!source.to_string().contains("subsolid-"), "{source}");
        let deep = folder.path().join("a/b");
        ensure_writable_dir(&deep).unwrap();
        assert_eq!(names(&deep), [""; 0]);
        for there in [Path::new("-"), Path::new("file"), &deep.join("file")] {
            ensure_parent(there).unwrap();
        }
        let OutputError::NoFolder { folder, .. } = ensure_parent(&deep.join("c/file")).unwrap_err() else { panic!() };
        assert_eq!(folder, deep.join("c"));
    }
}
