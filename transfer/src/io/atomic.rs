//! Files appear whole or not at all: written beside the old file, flushed to the disk, then renamed over it.
//!
//! A full disk, an error or a killed process leaves the old file as it was. What is not a regular file (a device, a pipe)
//! cannot be replaced and is written in place; a symbolic link stays, and the file it points at is replaced.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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
            Target::Beside(file) => file.write(bytes),
            Target::InPlace(file) => file.write(bytes),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        match self {
            Target::Beside(file) => file.flush(),
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
    let mut builder = tempfile::Builder::new();
    builder.prefix(".prt-").suffix(".part");
    // A temporary file is private; a result has the permissions of any new file (less the umask), or those of the old one.
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder)?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(Target::Beside(file))
}
