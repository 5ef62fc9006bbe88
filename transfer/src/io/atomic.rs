//! Files appear whole or not at all: written beside the old file, flushed to the disk, then renamed over it.
//!
//! A full disk, an error or a killed process leaves the old file as it was. What is not a regular file (a device, a pipe)
//! cannot be replaced and is written in place; a symbolic link stays, and the file it points at is replaced.
//!
//! Whoever writes holds a lock on the file beside. One without a lock belongs to a process that was killed, and the next file that is
//! written into the folder takes it away.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What names of files beside begin with …
const PREFIX: &str = ".prt-";
/// … and end with.
const SUFFIX: &str = ".part";

/// A file that takes its place only at [`AtomicFile::commit`]; dropped before that, it leaves nothing.
pub struct AtomicFile {
    path: PathBuf,
    writer: BufWriter<Target>,
}

enum Target {
    Beside(NamedTempFile),
    InPlace(File),
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            // Not by way of the wrapper, whose errors name the file beside.
            Target::Beside(file) => file.as_file_mut().write(bytes),
            Target::InPlace(file) => file.write(bytes),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        match self {
            Target::Beside(file) => file.as_file_mut().flush(),
            Target::InPlace(file) => file.flush(),
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`. Fails where the folder does not exist or refuses.
    pub fn create(path: impl AsRef<Path>) -> Result<AtomicFile> {
        let path = path.as_ref();
        if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty() && !f.exists()) {
            let cause = io::Error::new(io::ErrorKind::NotFound, format!("folder {} does not exist", folder.display()));
            return Err(Error::Io { action: "create", path: path.into(), cause });
        }
        let target = open(path).map_err(|cause| Error::Io { action: "create", path: path.into(), cause })?;
        Ok(AtomicFile { path: path.into(), writer: BufWriter::with_capacity(1 << 16, target) })
    }
    /// Writes, keeping the path in the error.
    pub fn put(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.writer.write_all(bytes);
        written.map_err(|source| self.failed(source))
    }
    /// Brings everything to the disk, then replaces the file at the path.
    pub fn commit(self) -> Result<()> {
        let AtomicFile { path, writer } = self;
        let finish = || match writer.into_inner().map_err(io::IntoInnerError::into_error)? {
            Target::InPlace(_) => Ok(()),
            Target::Beside(file) => {
                file.as_file().sync_all()?;
                file.persist(resolve(&path)).map(drop).map_err(|e| e.error)
            }
        };
        finish().map_err(|cause| Error::Io { action: "write", path: path.clone(), cause })
    }

    fn failed(&self, cause: io::Error) -> Error {
        Error::Io { action: "write", path: self.path.clone(), cause }
    }
}

/// Writes a whole file with `fill`; where that fails, nothing is left and an older file stays.
pub fn write(path: impl AsRef<Path>, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    fill(&mut file).map_err(|source| file.failed(source))?;
    file.commit()
}

/// A new file that others can tell from an abandoned one. Where the file system has no locks, nobody takes it for abandoned.
fn locked(mut create: impl FnMut() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    loop {
        let file = create()?;
        // Between creating and locking, another process may have thought that nobody writes it.
        if matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock)) || !file.path().exists() {
            continue;
        }
        return Ok(file);
    }
}

/// Removes what killed processes left in a folder. Whatever cannot be read, locked or removed stays.
fn remove_abandoned(folder: &Path) {
    let parts = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes())
    });
    for part in parts.filter(|part| part.file_type().is_ok_and(|kind| kind.is_file())) {
        // The lock is held until the file is gone, so that nobody takes it up again meanwhile.
        if let Ok(file) = File::open(part.path())
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(part.path());
        }
    }
}

/// The file itself where the path is a symbolic link, which a rename would replace.
fn resolve(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.into())
}

fn open(path: &Path) -> io::Result<Target> {
    let old = path.metadata().ok();
    if old.as_ref().is_some_and(|m| !m.is_file() && !m.is_dir()) {
        return Ok(Target::InPlace(OpenOptions::new().write(true).open(path)?));
    }
    if old.as_ref().is_some_and(std::fs::Metadata::is_dir) {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    let path = resolve(path);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    remove_abandoned(folder);
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    // A temporary file is private; a result has the permissions of any new file (less the umask), or those of the old one.
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = locked(|| builder.tempfile_in(folder))?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(Target::Beside(file))
}
