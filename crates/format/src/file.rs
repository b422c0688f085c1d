//! Files on disk: read whole, written whole or not at all.

use std::path::Path;

use meshfront_hierarchies::Hierarchy;
#[cfg(feature = "write")]
use meshfront_hierarchies::Stored;

#[cfg(feature = "write")]
use crate::error::WriteError;
use crate::{Info, ReadError, decode, inspect};

/// Reads a file and checks everything: bytes, columns, and that they are a hierarchy.
///
/// # Errors
/// [`ReadError`], which names the file, the place and what to do.
pub fn read(path: impl AsRef<Path>) -> Result<Hierarchy, ReadError> {
    let (bytes, file) = load(path.as_ref())?;
    let columns = decode(&bytes, &file)?;
    drop(bytes);
    Hierarchy::new(columns).map_err(|source| ReadError::Hierarchy { file, source })
}

/// What a file holds: [`inspect`] of all its bytes.
///
/// # Errors
/// [`ReadError`], which names the file, the place and what to do.
pub fn inspect_file(path: impl AsRef<Path>) -> Result<Info, ReadError> {
    let (bytes, file) = load(path.as_ref())?;
    inspect(&bytes, &file)
}

fn load(path: &Path) -> Result<(Vec<u8>, String), ReadError> {
    let bytes = std::fs::read(path).map_err(|source| ReadError::Io { path: path.to_owned(), source })?;
    Ok((bytes, path.display().to_string()))
}

/// How to write.
#[cfg(feature = "write")]
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions {
    /// Replace a file that exists.
    pub overwrite: bool,
}

/// What was written.
#[cfg(feature = "write")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Length of the file.
    pub bytes: u64,
}

/// Writes what is stored of a hierarchy. The file appears under its name when all of it is on disk; until then an old file of
/// that name stays as it was.
///
/// Everything is packed in memory first, then written to a hidden file in the same folder, synchronised and renamed.
/// That file is removed on any error. Only a process killed in the milliseconds between leaves it behind.
///
/// # Errors
/// [`WriteError`]: the file exists and is not to be replaced (asked before any work), the columns cannot be stored,
/// or the system refuses.
#[cfg(feature = "write")]
pub fn write(path: impl AsRef<Path>, stored: &Stored, options: &WriteOptions) -> Result<Written, WriteError> {
    use std::io::Write;
    let path = path.as_ref();
    let exists = || WriteError::Exists { path: path.to_owned() };
    let io = |source| WriteError::Io { path: path.to_owned(), source };
    if !options.overwrite && path.symlink_metadata().is_ok() {
        return Err(exists());
    }
    let bytes = crate::encode(stored)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".front-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets, the umask taken off; the default is the owner alone.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut hidden = builder.tempfile_in(folder).map_err(io)?;
    hidden.write_all(&bytes).map_err(io)?;
    hidden.as_file().sync_all().map_err(io)?;
    if options.overwrite {
        hidden.persist(path).map_err(|e| io(e.error))?;
    } else {
        hidden.persist_noclobber(path).map_err(|e| match e.error.kind() {
            std::io::ErrorKind::AlreadyExists => exists(),
            _ => io(e.error),
        })?;
    }
    // The name itself lasts only when the folder is on disk as well.
    #[cfg(unix)]
    std::fs::File::open(folder).and_then(|f| f.sync_all()).map_err(io)?;
    Ok(Written { bytes: bytes.len() as u64 })
}
