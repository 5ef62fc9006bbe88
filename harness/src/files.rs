//! The one place where the program touches files of matrices, lights, compressed matrices and pictures.

use crate::room;
use ndarray::{Array2, ArrayView2};
use prt_transfer::image::{Image, Picture};
use prt_transfer::io::{atomic, image, matrix, npy, prt};
use prt_transfer::matrix::Layout;
use prt_transfer::{Compressed, Error, Extent, LightBasis, Progress, Registry, Result, Shape, TransferMatrix};
use std::path::Path;

pub use prt_transfer::io::matrix::Description;

/// Refuses an output file whose extension promises another format than the one that is written.
pub fn expect_extension(path: &Path, extension: &'static str) -> Result<()> {
    expect_one_of(path, &[extension]).map(drop)
}

/// The format that an output file's extension promises, out of those that can be written.
pub fn expect_one_of(path: &Path, extensions: &[&'static str]) -> Result<&'static str> {
    let found = path.extension().unwrap_or_default();
    extensions.iter().copied().find(|known| found.eq_ignore_ascii_case(known)).ok_or_else(|| Error::Unsupported {
        what: format!("output file {}", path.display()),
        expected: format!("the extension .{}", extensions.join(" or .")),
        found: format!("'{}'", found.display()),
    })
}

/// Reads a transfer matrix; the extension says which format.
///
/// # Errors
/// A file that cannot be read; a matrix that does not fit into memory, of which nothing is read.
pub fn read_matrix(path: &Path, description: &Description) -> anyhow::Result<TransferMatrix> {
    if let Some((extent, _)) = outline(path, description)? {
        room::check(&path.display().to_string(), extent.bytes(), room::SMALLER_MATRIX)?;
    }
    Ok(matrix::read(path, description)?)
}

/// What [`read_matrix`] would read, told without reading its elements; `None` of a text.
pub fn outline(path: &Path, description: &Description) -> Result<Option<(Extent, LightBasis)>> {
    matrix::outline(path, description)
}

/// Writes a transfer matrix; the extension says which format.
pub fn write_matrix(path: &Path, matrix: &TransferMatrix) -> Result<()> {
    matrix::write(path, matrix)
}

/// Writes a compressed matrix.
pub fn write_prt(path: &Path, compressed: &Compressed, progress: &dyn Progress) -> Result<prt::Sizes> {
    prt::write(path, compressed, progress)
}

/// Reads a compressed matrix.
pub fn read_prt(path: &Path, registry: &Registry) -> Result<Compressed> {
    prt::read(path, registry)
}

/// The file of a compressed matrix, in memory.
pub fn prt_bytes(compressed: &Compressed, progress: &dyn Progress) -> Result<Vec<u8>> {
    prt::to_bytes(compressed, progress)
}

/// As [`read_prt`], from memory.
pub fn prt_from_bytes(bytes: &[u8], registry: &Registry) -> Result<Compressed> {
    prt::from_bytes(bytes, registry)
}

/// Reads a light of one or several channels: lights x channels.
pub fn read_lights(path: &Path) -> Result<Array2<f32>> {
    npy::read_lights(path)
}

/// Reads linear radiance: finite values, .exr or .hdr.
pub fn read_radiance(path: &Path) -> Result<Image> {
    let image = image::read(path)?;
    image.check().map_err(|e| e.in_file(path))?;
    Ok(image)
}

/// Writes linear radiance as 32-bit OpenEXR.
pub fn write_radiance(path: &Path, radiance: &Image) -> Result<()> {
    image::write_exr(path, radiance, image::Precision::Single)
}

/// Writes a picture as PNG.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    image::write_png(path, picture)
}

/// Writes an array of finite numbers. A light or a matrix of the largest numbers gives others, which are refused here.
pub fn write_array(path: &Path, array: ArrayView2<f32>) -> Result<()> {
    if let Some(((row, col), &value)) = array.indexed_iter().find(|(_, v)| !v.is_finite()) {
        return Err(Error::NotFinite { row, col, value: value.into() }.in_file(path));
    }
    npy::write_array(path, array)
}

/// Reads all of a file whose format someone else knows.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|cause| Error::Io { action: "read", path: path.into(), cause })
}

/// Writes a file beside the old one and renames it, so that an interrupted run leaves the old file.
pub fn write_beside(path: &Path, bytes: &[u8]) -> Result<()> {
    atomic::write(path, |file| file.write_all(bytes))
}

/// A dense matrix written row by row, samples x responses x lights where there are several responses.
pub fn dense_writer(path: &Path, shape: Shape) -> Result<npy::RowWriter> {
    let layout = if shape.responses > 1 { Layout::Samples } else { Layout::Rows };
    npy::RowWriter::create(path, shape, layout)
}
