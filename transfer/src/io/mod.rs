//! Files: transfer matrices, compressed matrices, meshes, images and pictures.
//!
//! | module | formats |
//! | --- | --- |
//! | [`matrix`] | a transfer matrix, the format chosen by the file's extension: [`npz`], [`npy`], [`mtx`] |
//! | [`prt`] | a compressed matrix |
//! | [`mesh`] | `.ply`, `.obj` |
//! | [`image`] | `.exr`, `.hdr`, `.png` (written only) |
//! | [`atomic`] | how all of them are written: beside the old file, then renamed |
//!
//! Bytes are untrusted. A reader never panics, names the place where a file breaks its format, and allocates no more
//! than a small multiple of the bytes that really are there. Compressed formats may expand by what their compression
//! can earn: deflate by 1032, `.prt` sections and images by 1000.

pub mod atomic;
pub mod image;
pub mod matrix;
pub mod mesh;
pub mod mtx;
pub mod npy;
pub mod npz;
pub mod prt;

mod element;
mod numpy;
mod obj;
mod openexr;
mod ply;
mod radiance;
mod triplets;

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufReader, ErrorKind};
use std::path::Path;

/// A part of a file that is being read: the format, by its extension, and where in the file.
#[derive(Clone, Copy)]
struct Place<'a> {
    format: &'static str,
    name: &'a str,
}

impl Place<'_> {
    /// [`Error::Format`] at this place.
    fn broken(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        broken(self.format, self.name, expected, found)
    }
    /// What a failed read means for the reader of a format.
    fn unreadable(&self, expected: impl Into<String>, source: &std::io::Error) -> Error {
        match source.kind() {
            ErrorKind::UnexpectedEof => self.broken(expected, "the end of the data"),
            _ => self.broken(expected, source.to_string()),
        }
    }
}

fn broken(
    format: &'static str,
    place: impl Into<String>,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> Error {
    Error::Format { format, place: place.into(), expected: expected.into(), found: found.into() }
}

fn open(path: &Path) -> Result<BufReader<File>> {
    let refused = |cause| Error::Io { action: "read", path: path.into(), cause };
    Ok(BufReader::with_capacity(1 << 16, File::open(path).map_err(refused)?))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|cause| Error::Io { action: "read", path: path.into(), cause })
}

/// The extension in lower case; empty where there is none.
fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// [`Error::Unknown`] for an extension that no reader or writer here is known by.
fn unknown_extension(path: &Path, what: &'static str, known: &str) -> Error {
    Error::Unknown { what, name: extension(path), known: known.into() }.in_file(path)
}
