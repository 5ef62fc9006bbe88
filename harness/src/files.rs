//! The one place where the program touches files of matrices, lights and compressed matrices.

use ndarray::{Array2, ArrayView2};
use prt_transfer::io::{atomic, matrix, npy, prt};
use prt_transfer::{Compressed, Registry, Result, TransferMatrix};
use std::path::Path;

pub use prt_transfer::io::matrix::Description;

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
