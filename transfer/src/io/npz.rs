//! Sparse matrices as `scipy.sparse.save_npz` writes them, `.npz`.
//!
//! Read: `csr`, `csc` and `coo` (canonical or not: columns are sorted and duplicates summed, as scipy does), any
//! numeric data type taken at its value, 32- or 64-bit indices, entries stored or deflated. Written: `csr` with `f32`
//! data, which `scipy.sparse.load_npz` reads, and one more entry `prt.npy`, an array of bytes whose JSON says what the
//! rows and columns are: `{"responses": 64, "response_basis": "local:8", "basis": "cubemap:32", "signal": "…"}`.

use super::atomic;
use super::element::{Elements, Values, overflow};
use super::matrix::Description;
use super::numpy::{ArrayHeader, header};
use super::triplets::{SparseParts, Triplets, lights, rows_of};
use super::{Place, broken, open};
use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::footprint::Extent;
use crate::matrix::{Shape, TransferMatrix};
use crate::responses::ResponseBasis;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::{Cursor, Read, Seek, Write};
use std::path::Path;
use zip::write::{FileOptions, PreparedZipFile, ZipFileBuilder};
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// On a synthetic visibility matrix of 4.8 M elements level 3 makes 0.6 times the bytes of level 1 and 1.07 times those
/// of level 6.
const DEFLATE_LEVEL: i64 = 3;
/// Most bytes of `prt.npy`.
const LONGEST_NOTE: u64 = 1 << 16;

/// A matrix and what its file says of the signal it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The matrix.
    pub matrix: TransferMatrix,
    /// Free text of whoever wrote it; empty where there is none.
    pub signal: String,
}

/// The entry `prt.npy`.
#[derive(Default, Serialize, Deserialize)]
struct Note {
    responses: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    response_basis: Option<String>,
    basis: Option<String>,
    #[serde(default)]
    signal: String,
}

/// Reads a sparse matrix.
pub fn read(path: impl AsRef<Path>, description: &Description) -> Result<Signal> {
    let path = path.as_ref();
    read_from(open(path)?, description).map_err(|e| e.in_file(path))
}

/// As [`read`], from any source.
pub fn read_from(source: impl Read + Seek, description: &Description) -> Result<Signal> {
    let mut archive = Archive::new(source)?;
    let note = archive.note()?;
    let parts = match archive.format()?.as_str() {
        "csr" => archive.csr()?,
        "csc" => archive.csc()?,
        "coo" => archive.coo()?,
        other => {
            return Err(broken("npz", "entry 'format.npy'", "csr, csc or coo (convert with .tocsr())", other));
        }
    };
    let carried = note.description()?;
    Ok(Signal { matrix: parts.matrix(description, carried)?, signal: note.signal })
}

/// What [`read`] would read, from the beginnings of the entries alone.
pub fn outline(path: impl AsRef<Path>, description: &Description) -> Result<(Extent, LightBasis)> {
    let path = path.as_ref();
    outline_of(open(path)?, description).map_err(|e| e.in_file(path))
}

fn outline_of(source: impl Read + Seek, description: &Description) -> Result<(Extent, LightBasis)> {
    let mut archive = Archive::new(source)?;
    let carried = archive.note()?.description()?;
    let (rows, columns) = archive.shape()?;
    let lights = lights(columns)?;
    let (responses, basis) = description.and(carried, lights)?;
    let non_zeros = archive.length("data.npy")?;
    let samples = rows_of(rows, lights)?.div_ceil(responses.responses());
    Ok((Extent { shape: Shape::new(samples, responses.responses(), lights)?, non_zeros, sparse: true }, basis))
}

impl Note {
    fn description(&self) -> Result<Description> {
        let basis = self.basis.as_ref().map(|text| text.parse()).transpose()?;
        let responses = match (&self.response_basis, self.responses) {
            (Some(text), number) => {
                let basis: ResponseBasis = text.parse()?;
                let (what, known) = (format!("responses of {basis}"), basis.responses());
                Error::expect_size(what, known, number.unwrap_or(known))?;
                Some(basis)
            }
            (None, number) => number.map(|responses| ResponseBasis::Plain { responses }),
        };
        Ok(Description { responses, basis })
    }
}

struct Archive<R>(ZipArchive<R>);

impl<R: Read + Seek> Archive<R> {
    fn new(source: R) -> Result<Archive<R>> {
        let archive = ZipArchive::new(source);
        archive.map(Archive).map_err(|e| broken("npz", "archive", "a zip archive", e.to_string()))
    }
    /// Elements of an array, which is not read.
    fn length(&mut self, name: &str) -> Result<u64> {
        let label = format!("entry '{name}'");
        let place = Place { format: "npz", name: &label };
        let entry = self.0.index_for_name(name).map(|index| self.0.by_index(index));
        let mut file = match entry {
            Some(Ok(file)) => file,
            Some(Err(e)) => return Err(place.broken("a stored or deflated entry", e.to_string())),
            None => return Err(place.broken("a matrix saved by scipy.sparse.save_npz", "none")),
        };
        Ok(ArrayHeader::read(&mut file, place)?.count(place)? as u64)
    }
    /// Reads one array with `take`, then makes sure that nothing follows it and that its checksum holds.
    fn entry<T>(
        &mut self,
        name: &str,
        take: impl FnOnce(&ArrayHeader, Elements<'_, &mut dyn Read>) -> Result<T>,
    ) -> Result<T> {
        let label = format!("entry '{name}'");
        let place = Place { format: "npz", name: &label };
        let names = || self.0.file_names().flatten().collect::<Vec<_>>().join(", ");
        let Some(index) = self.0.index_for_name(name) else {
            return Err(place.broken("a matrix saved by scipy.sparse.save_npz", format!("only [{}]", names())));
        };
        let mut file = self.0.by_index(index).map_err(|e| place.broken("a stored or deflated entry", e.to_string()))?;
        let earned = file.size().min(file.compressed_size().saturating_mul(16));
        let header = ArrayHeader::read(&mut file, place)?;
        let elements = header.elements(&mut file as &mut dyn Read, earned, place)?;
        let taken = take(&header, elements)?;
        match file.read(&mut [0; 1]) {
            Ok(0) => Ok(taken),
            Ok(_) => Err(place.broken(format!("nothing after shape {:?}", header.shape), "more bytes")),
            Err(e) => Err(place.unreadable("an intact entry", &e)),
        }
    }

    fn format(&mut self) -> Result<String> {
        self.entry("format.npy", |_, elements| elements.text())
    }
    fn shape(&mut self) -> Result<(u64, u64)> {
        let shape: Vec<u64> = self.entry("shape.npy", |header, elements| match header.shape[..] {
            [2] => elements.indices(),
            _ => Err(elements.place.broken("2 sizes", format!("shape {:?}", header.shape))),
        })?;
        Ok((shape[0], shape[1]))
    }
    fn indices<T: TryFrom<u64>>(&mut self, name: &str) -> Result<Vec<T>> {
        self.entry(name, |header, elements| match header.shape.len() {
            1 => elements.indices(),
            axes => Err(elements.place.broken("1 axis", format!("{axes} axes"))),
        })
    }
    fn data(&mut self, count: usize) -> Result<Values> {
        self.entry("data.npy", |header, elements| match header.shape[..] {
            [found] if found == count => elements.values(),
            _ => Err(elements.place.broken(format!("{count} values"), format!("shape {:?}", header.shape))),
        })
    }

    fn csr(&mut self) -> Result<SparseParts> {
        let (rows, columns) = self.shape()?;
        let (offsets, indices, values) = self.compressed("rows", rows)?;
        if let Some((at, value)) = values.overflow {
            return Err(overflow("npz", line_of(&offsets, at), indices[at] as usize, value));
        }
        Ok(SparseParts { offsets, columns: indices, values: values.values, lights: lights(columns)? })
    }

    fn csc(&mut self) -> Result<SparseParts> {
        let shape = self.shape()?;
        let (offsets, indices, values) = self.compressed("columns", shape.1)?;
        if let Some((at, value)) = values.overflow {
            return Err(overflow("npz", indices[at] as usize, line_of(&offsets, at), value));
        }
        let mut columns = Vec::with_capacity(indices.len());
        for (column, window) in offsets.windows(2).enumerate() {
            columns.extend(std::iter::repeat_n(column as u32, window[1] - window[0]));
        }
        Triplets { rows: indices, columns, values: values.values }.compress(shape)
    }

    fn coo(&mut self) -> Result<SparseParts> {
        let shape = self.shape()?;
        let (rows, columns) = if self.0.index_for_name("coords.npy").is_some() {
            let mut rows: Vec<u32> = self.entry("coords.npy", |header, elements| match header.shape[..] {
                [2, _] if !header.fortran => elements.indices(),
                _ => Err(elements.place.broken("2 x elements in C order", format!("shape {:?}", header.shape))),
            })?;
            let columns = rows.split_off(rows.len() / 2);
            (rows, columns)
        } else {
            (self.indices("row.npy")?, self.indices("col.npy")?)
        };
        Error::expect_size("entry 'col.npy' beside 'row.npy'", rows.len(), columns.len())?;
        let values = self.data(rows.len())?;
        if let Some((at, value)) = values.overflow {
            return Err(overflow("npz", rows[at] as usize, columns[at] as usize, value));
        }
        Triplets { rows, columns, values: values.values }.compress(shape)
    }

    /// Offsets of `lines` compressed rows or columns, indices and values; offsets ascend from 0 to the number of
    /// values.
    fn compressed(&mut self, what: &str, lines: u64) -> Result<(Vec<usize>, Vec<u32>, Values)> {
        let offsets: Vec<usize> = self.indices("indptr.npy")?;
        let place = Place { format: "npz", name: "entry 'indptr.npy'" };
        if offsets.len() as u64 != lines.saturating_add(1) {
            let expected = format!("{} offsets for {lines} {what}", lines.saturating_add(1));
            return Err(place.broken(expected, offsets.len().to_string()));
        }
        let indices: Vec<u32> = self.indices("indices.npy")?;
        if offsets[0] != 0 || !offsets.is_sorted() || offsets[offsets.len() - 1] != indices.len() {
            let ends = format!("{} to {}", offsets[0], offsets[offsets.len() - 1]);
            return Err(place.broken(format!("offsets ascending from 0 to {} indices", indices.len()), ends));
        }
        let values = self.data(indices.len())?;
        Ok((offsets, indices, values))
    }

    fn note(&mut self) -> Result<Note> {
        if self.0.index_for_name("prt.npy").is_none() {
            return Ok(Note::default());
        }
        self.entry("prt.npy", |header, elements| {
            let place = elements.place;
            if elements.count as u64 > LONGEST_NOTE || header.shape.len() != 1 {
                let found = format!("shape {:?}", header.shape);
                return Err(place.broken(format!("1 axis of at most {LONGEST_NOTE} bytes"), found));
            }
            let text: Vec<u8> = elements.indices()?;
            serde_json::from_slice(&text).map_err(|e| place.broken("JSON with responses and basis", e.to_string()))
        })
    }
}

/// The compressed row or column that holds the element at `at`.
fn line_of(offsets: &[usize], at: usize) -> usize {
    offsets.partition_point(|&offset| offset <= at) - 1
}

/// Writes `csr` with responses, basis and a free text about the signal (at most some 60,000 bytes).
pub fn write(path: impl AsRef<Path>, matrix: &TransferMatrix, signal: &str) -> Result<()> {
    let path = path.as_ref();
    let archive = to_bytes(matrix, signal).map_err(|e| e.in_file(path))?;
    atomic::write(path, |file| file.write_all(&archive))
}

/// The file that [`write()`] makes; the same bytes on any number of threads.
pub fn to_bytes(matrix: &TransferMatrix, signal: &str) -> Result<Vec<u8>> {
    let note = Note {
        responses: Some(matrix.shape().responses),
        response_basis: Some(matrix.responses()).filter(|r| !r.is_plain()).map(ToString::to_string),
        basis: Some(matrix.basis().to_string()),
        signal: signal.into(),
    };
    let note = serde_json::to_vec(&note).map_err(|e| broken("npz", "entry 'prt.npy'", "JSON", e.to_string()))?;
    if note.len() as u64 > LONGEST_NOTE {
        let what = "bytes of the signal's description".into();
        return Err(Error::TooLarge { what, limit: LONGEST_NOTE, found: note.len() as u64 });
    }
    match matrix.as_csr() {
        Some((offsets, columns, values)) => pack(matrix, offsets, columns, values, &note),
        None => {
            let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
            for row in 0..matrix.rows() {
                for (column, value) in matrix.row(row).non_zeros() {
                    columns.push(column as u32);
                    values.push(value);
                }
                offsets.push(columns.len());
            }
            pack(matrix, &offsets, &columns, &values, &note)
        }
    }
}

/// One array of the archive: name, NumPy type, axes, bytes.
struct Entry<'a>(&'static str, &'static str, &'a [usize], &'a [u8]);

fn pack(matrix: &TransferMatrix, offsets: &[usize], columns: &[u32], values: &[f32], note: &[u8]) -> Result<Vec<u8>> {
    let shape = [matrix.rows() as i64, matrix.lights() as i64];
    // scipy keeps 32-bit indices wherever they suffice. Columns are below 2^25, so that u32 and i32 have the same
    // bytes.
    let narrow: Option<Vec<i32>> = offsets.iter().map(|&o| i32::try_from(o).ok()).collect();
    let wide: Vec<i64> = if narrow.is_none() { offsets.iter().map(|&o| o as i64).collect() } else { Vec::new() };
    let (index, offset_bytes) = match &narrow {
        Some(narrow) => ("<i4", bytemuck::cast_slice(narrow)),
        None => ("<i8", bytemuck::cast_slice(&wide)),
    };
    let entries = [
        Entry("indices.npy", "<i4", &[columns.len()], bytemuck::cast_slice(columns)),
        Entry("indptr.npy", index, &[offsets.len()], offset_bytes),
        Entry("format.npy", "|S3", &[], b"csr"),
        Entry("shape.npy", "<i8", &[2], bytemuck::cast_slice(&shape)),
        Entry("data.npy", "<f4", &[values.len()], bytemuck::cast_slice(values)),
        Entry("prt.npy", "|u1", &[note.len()], note),
    ];
    let failed = |e: zip::result::ZipError| broken("npz", "archive", "a zip archive", e.to_string());
    let deflated: Vec<PreparedZipFile> = entries.par_iter().map(deflate).collect::<Result<_, _>>().map_err(failed)?;
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for entry in deflated {
        archive.add_prepared_file(entry).map_err(failed)?;
    }
    Ok(archive.finish().map_err(failed)?.into_inner())
}

fn deflate(Entry(name, descr, shape, bytes): &Entry) -> zip::result::ZipResult<PreparedZipFile> {
    let options = FileOptions::<()>::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(DEFLATE_LEVEL));
    let mut file = ZipFileBuilder::new(*name, options)?;
    file.write_all(&header(descr, shape))?;
    file.write_all(bytes)?;
    file.finish()
}
