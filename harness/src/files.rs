//! The one place where the program touches files of matrices, lights and compressed matrices.

use ndarray::{Array2, ArrayView2};
use prt_transfer::io::{atomic, matrix, npy, prt};
use prt_transfer::{Compressed, Error, Registry, Result, TransferMatrix};
use std::path::Path;

pub use prt_transfer::io::matrix::Description;

/// Refuses an output file whose extension promises another format than the one that is written.
pub fn expect_extension(path: &Path, extension: &'static str) -> Result<()> {
    let found = path.extension().unwrap_or_default();
    if found.eq_ignore_ascii_case(extension) {
        return Ok(());
    }
    let (what, expected) = (format!("output file {}", path.display()), format!("the extension .{extension}"));
    Err(Error::Unsupported { what, expected, found: format!("'{}'", found.display()) })
}

/// Reads a transfer matrix; the extension says which format.
pub fn read_matrix(path: &Path, description: &Description) -> Result<TransferMatrix> {
    matrix::read(path, description)
}

/// Writes a transfer matrix; the extension says which format.
pub fn write_matrix(path: &Path, matrix: &TransferMatrix) -> Result<()> {
    matrix::write(path, matrix)
}

/// Writes a compressed matrix.
pub fn write_prt(path: &Path, compressed: &Compressed) -> Result<prt::Sizes> {
    prt::write(path, compressed)
}

/// Reads a compressed matrix.
pub fn read_prt(path: &Path, registry: &Registry) -> Result<Compressed> {
    prt::read(path, registry)
}

/// Reads a light of one or several channels: lights x channels.
pub fn read_lights(path: &Path) -> Result<Array2<f32>> {
    npy::read_lights(path)
}

/// Writes an array of numbers.
pub fn write_array(path: &Path, array: ArrayView2<f32>) -> Result<()> {
    npy::write_array(path, array)
}

/// Writes a file beside the old one and renames it, so that an interrupted run leaves the old file.
pub fn write_beside(path: &Path, bytes: &[u8]) -> Result<()> {
    atomic::write(path, |file| file.write_all(bytes))
}
