//! NumPy arrays, `.npy`: dense transfer matrices, lights, relit output.
//!
//! Read: format versions 1 to 3, C and Fortran order, either byte order, bool, integers, f16, f32, f64; values are
//! taken as they are and rounded to `f32`. Written: little-endian `f32` in C order.

use super::atomic::{self, AtomicFile};
use super::element::{Values, overflow};
use super::matrix::Description;
use super::numpy::{ArrayHeader, header};
use super::triplets::{lights, rows_of};
use super::{Place, open};
use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::footprint::Extent;
use crate::matrix::{Layout, Shape, TransferMatrix};
use crate::responses::ResponseBasis;
use ndarray::{Array2, ArrayView2};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

const PLACE: Place = Place { format: "npy", name: "array" };

/// Reads a dense matrix: 2-D rows x lights, or 3-D samples x responses x lights.
pub fn read(path: impl AsRef<Path>, description: &Description) -> Result<TransferMatrix> {
    let path = path.as_ref();
    read_from(open(path)?, description).map_err(|e| e.in_file(path))
}

/// As [`read`], from any source.
pub fn read_from(source: impl Read + Seek, description: &Description) -> Result<TransferMatrix> {
    let Array { shape, values } = read_array(source)?;
    let (carried, rows, columns) = rows_and_columns(&shape)?;
    let (by_samples, lights) = (carried.responses.is_some(), lights(columns as u64)?);
    let rows = rows_of(rows as u64, lights)?;
    let (responses, basis) = description.and(carried, lights)?;
    let matrix = TransferMatrix::from_dense(values, rows, responses.responses(), basis)?.with_responses(responses)?;
    Ok(if by_samples { matrix.by_samples() } else { matrix })
}

/// What [`read`] would read, from the header alone; how many elements are 0 it does not say, so that all count.
pub fn outline(path: impl AsRef<Path>, description: &Description) -> Result<(Extent, LightBasis)> {
    let path = path.as_ref();
    let header = ArrayHeader::read(&mut open(path)?, PLACE);
    header.and_then(|header| outline_of(&header.shape, description)).map_err(|e| e.in_file(path))
}

fn outline_of(shape: &[usize], description: &Description) -> Result<(Extent, LightBasis)> {
    let (carried, rows, columns) = rows_and_columns(shape)?;
    let lights = lights(columns as u64)?;
    let (responses, basis) = description.and(carried, lights)?;
    let responses = responses.responses();
    let shape = Shape::new(rows_of(rows as u64, lights)?.div_ceil(responses), responses, lights)?;
    Ok((Extent { shape, non_zeros: rows as u64 * lights as u64, sparse: false }, basis))
}

/// What the axes say of the responses, rows, and columns.
fn rows_and_columns(shape: &[usize]) -> Result<(Description, usize, usize)> {
    match *shape {
        [rows, columns] => Ok((Description::default(), rows, columns)),
        [samples, responses, columns] => {
            let rows = Shape::new(samples, responses, lights(columns as u64)?)?.rows();
            let carried = Description { responses: Some(ResponseBasis::Plain { responses }), basis: None };
            Ok((carried, rows, columns))
        }
        _ => Err(PLACE.broken("2 axes (rows, lights) or 3 (samples, responses, lights)", axes(shape))),
    }
}

/// Reads a light, lights x channels, all finite. A 1-D array is one channel.
pub fn read_lights(path: impl AsRef<Path>) -> Result<Array2<f32>> {
    let path = path.as_ref();
    read_lights_from(open(path)?).map_err(|e| e.in_file(path))
}

/// As [`read_lights`], from any source.
pub fn read_lights_from(source: impl Read + Seek) -> Result<Array2<f32>> {
    let Array { shape, values } = read_array(source)?;
    let (rows, columns) = match shape[..] {
        [rows] => (rows, 1),
        [rows, columns] => (rows, columns),
        _ => return Err(PLACE.broken("1 axis (lights) or 2 (lights, channels)", axes(&shape))),
    };
    if let Some(at) = values.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite { row: at / columns, col: at % columns, value: values[at].into() });
    }
    Array2::from_shape_vec((rows, columns), values).map_err(|e| PLACE.broken("an array of its shape", e.to_string()))
}

/// Writes a plain array, such as relit output: rows x channels.
pub fn write_array(path: impl AsRef<Path>, array: ArrayView2<f32>) -> Result<()> {
    atomic::write(path, |file| {
        file.write_all(&header("<f4", array.shape()))?;
        array.outer_iter().try_for_each(|row| match row.as_slice() {
            Some(values) => file.write_all(bytemuck::cast_slice(values)),
            None => file.write_all(bytemuck::cast_slice(&row.to_vec())),
        })
    })
}

/// Writes a matrix densely: 3-D where it came so, otherwise 2-D. Responses and basis are not kept.
pub fn write(path: impl AsRef<Path>, matrix: &TransferMatrix) -> Result<()> {
    let mut file = RowWriter::create(path, matrix.shape(), matrix.layout())?;
    let mut buffer = vec![0f32; matrix.lights()];
    for row in 0..matrix.rows() {
        matrix.gather(row, &mut buffer);
        file.push(&buffer)?;
    }
    file.finish()
}

/// Writes a dense matrix row by row, so that a large one never has to be in memory.
pub struct RowWriter {
    file: AtomicFile,
    lights: usize,
    rows: usize,
    written: usize,
}

impl RowWriter {
    /// Begins a file of `shape`: 3-D (samples x responses x lights) for [`Layout::Samples`], otherwise 2-D (rows x
    /// lights).
    pub fn create(path: impl AsRef<Path>, shape: Shape, layout: Layout) -> Result<RowWriter> {
        let axes = match layout {
            Layout::Samples => vec![shape.samples, shape.responses, shape.lights],
            Layout::Rows | Layout::Sparse => vec![shape.rows(), shape.lights],
        };
        let mut file = AtomicFile::create(path)?;
        file.put(&header("<f4", &axes))?;
        Ok(RowWriter { file, lights: shape.lights, rows: shape.rows(), written: 0 })
    }
    /// The next row, all lights of it.
    pub fn push(&mut self, row: &[f32]) -> Result<()> {
        Error::expect_size("values of a row", self.lights, row.len())?;
        self.written += 1;
        self.file.put(bytemuck::cast_slice(row))
    }
    /// The next rows, as many as `rows` holds.
    pub fn push_rows(&mut self, rows: &[f32]) -> Result<()> {
        let count = rows.len() / self.lights.max(1);
        Error::expect_size("values of whole rows", count * self.lights, rows.len())?;
        self.written += count;
        self.file.put(bytemuck::cast_slice(rows))
    }
    /// Puts the file in its place; every row must have been written.
    pub fn finish(self) -> Result<()> {
        Error::expect_size("rows written", self.rows, self.written)?;
        self.file.commit()
    }
}

/// Row-major values.
struct Array {
    shape: Vec<usize>,
    values: Vec<f32>,
}

fn read_array(mut source: impl Read + Seek) -> Result<Array> {
    let header = ArrayHeader::read(&mut source, PLACE)?;
    let left = remaining(&mut source).map_err(|e| PLACE.unreadable("a file of known length", &e))?;
    let needed = header.count(PLACE)? as u64 * header.element.size as u64;
    if needed > left {
        return Err(PLACE.broken(format!("{needed} bytes for shape {:?}", header.shape), format!("{left} bytes")));
    }
    let Values { values, overflow: too_large } = header.elements(source, left, PLACE)?.values()?;
    if let Some((at, value)) = too_large {
        let (row, col) = row_and_column(&header, at);
        return Err(overflow("npy", row, col, value));
    }
    let values = if header.fortran { c_order(&values, &header.shape) } else { values };
    Ok(Array { shape: header.shape, values })
}

fn remaining(source: &mut impl Seek) -> std::io::Result<u64> {
    let here = source.stream_position()?;
    let end = source.seek(SeekFrom::End(0))?;
    source.seek(SeekFrom::Start(here))?;
    Ok(end.saturating_sub(here))
}

/// Row and column of the element stored at `at`; the last axis counts columns.
fn row_and_column(header: &ArrayHeader, at: usize) -> (usize, usize) {
    let columns = header.shape.last().copied().unwrap_or(1).max(1);
    if !header.fortran {
        return (at / columns, at % columns);
    }
    let (mut rest, mut row, leading) = (at, 0, &header.shape[..header.shape.len().saturating_sub(1)]);
    let mut stride = leading.iter().product::<usize>();
    for &axis in leading {
        stride /= axis;
        row += rest % axis * stride;
        rest /= axis;
    }
    (row, rest)
}

/// The elements of a first-axis-fastest array with the last axis fastest.
fn c_order(values: &[f32], shape: &[usize]) -> Vec<f32> {
    // Reversed axes read the same memory in C order; ndarray then walks it transposed.
    let reversed: Vec<usize> = shape.iter().rev().copied().collect();
    match ndarray::ArrayView::from_shape(reversed, values) {
        Ok(view) => view.reversed_axes().iter().copied().collect(),
        Err(_) => values.to_vec(),
    }
}

fn axes(shape: &[usize]) -> String {
    format!("{} axes {shape:?}", shape.len())
}
