//! Hostile input: what every reader of the program is given that nobody meant to write, and what it promises all the same.
//!
//! A [`Reader`] takes bytes and either refuses them, with an error that names what is wrong, or accepts them; what it accepts satisfies the
//! invariants of its kind. Mutations make hostile bytes of the seeds. What lies behind a checksum and zstd is reached as
//! [`Parts`]: a compressed matrix taken apart. `tests/hostile.rs` tries many mutations of every reader, `fuzz/` searches with coverage.

mod invariants;
mod mutation;
mod parts;
mod seeds;

pub use invariants::Check;
pub use mutation::{mutate, mutate_parts, reseal};
pub use parts::Parts;

use prt_cpca::d3dx;
use prt_harness::registry::registry;
use prt_harness::{lobe_file, results};
use prt_transfer::io::image::{read_exr, read_hdr};
use prt_transfer::io::matrix::Description;
use prt_transfer::io::mesh::{read_charted_obj, read_charted_ply, read_obj, read_ply};
use prt_transfer::io::{mtx, npy, npz, prt};
use prt_transfer::{Error, Registry};
use std::io::Cursor;
use std::sync::LazyLock;

/// Every method, known to all readers of compressed matrices.
pub static REGISTRY: LazyLock<Registry> = LazyLock::new(registry);

/// What came of hostile bytes: a check of what was read, or what the user is told.
pub type Outcome = Result<Check, String>;

/// Something that reads bytes of strangers.
pub struct Reader {
    /// Its format, or the codec of its sections; the name of its target in `fuzz/`.
    pub name: &'static str,
    /// Files that it reads.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads, or refuses.
    pub read: fn(&[u8]) -> Outcome,
    /// The most bytes of memory that reading may hold at once, of a file of these bytes.
    pub limit: fn(&[u8]) -> usize,
    /// What its bytes are.
    pub kind: Kind,
    /// How many mutations are worth their time, as a part of those that most readers get in a test.
    pub share: f64,
}

/// What bytes are, and how they must be changed to get anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A file of a format without checksums that matter.
    File,
    /// A `.prt` file, whose header has a checksum: see [`reseal`].
    Sealed,
    /// [`Parts`].
    Parts,
}

const KIB: usize = 1 << 10;
const MIB: usize = 1 << 20;

/// A text or an array of numbers: each byte can be a number, a few bytes of memory each, twice while a vector grows.
fn plain(bytes: &[u8]) -> usize {
    256 * KIB + 32 * bytes.len()
}

/// As [`plain`]; 2^24 samples of one cluster cost nothing in the file and 4 bytes each in memory.
fn samples(bytes: &[u8]) -> usize {
    64 * MIB + plain(bytes)
}

/// Triplets: 2^20 empty rows cost nothing in the file; offsets of them are held twice.
fn triplets(bytes: &[u8]) -> usize {
    20 * MIB + 64 * bytes.len()
}

/// As [`triplets`], deflated, which earns 1032 times as much.
fn deflated(bytes: &[u8]) -> usize {
    20 * MIB + 16 * 1032 * bytes.len()
}

/// 64 MiB and 1000 times the file, in pixels that are held up to three times: as stored, as an image, as blocks.
fn pixels(bytes: &[u8]) -> usize {
    3 * (64 * MIB + 1000 * bytes.len())
}

/// Of the bytes that the sections claim, once the header is known to deserve them.
fn container(bytes: &[u8]) -> usize {
    4 * MIB + 16 * prt::inspect(bytes).map_or(0, |contents| contents.sizes.raw as usize) + derived(bytes)
}

/// Sections as arrays, as a copy of them and as what relighting holds besides.
fn sections(bytes: &[u8]) -> usize {
    256 * KIB + 16 * bytes.len()
}

/// As [`sections`], and tables of the 65,536 symbols of a block.
fn symbols(bytes: &[u8]) -> usize {
    2 * MIB + sections(bytes)
}

/// As [`sections`], and what a light transform derives from its label and basis, up to 2^24 moments and a few numbers for each light.
fn derived(bytes: &[u8]) -> usize {
    512 * MIB + sections(bytes)
}

/// What a light transform derives from its label and basis alone takes seconds on larger bases, which is legal and bounded: see
/// `MAX_EVALUATIONS` of `sh` and of `srbf`.
const DEAR: usize = 1 << 11;

fn refused(error: Error) -> String {
    error.to_string()
}

/// Sections of the codecs of these names.
fn read_parts(bytes: &[u8], codecs: &[&str]) -> Outcome {
    let parts = Parts::from_bytes(bytes).map_err(refused)?;
    if !codecs.contains(&parts.header.label.codec.name.as_str()) {
        return Err("another reader's".into());
    }
    if parts.header.label.transform.name != "identity" && parts.header.basis.lights() > DEAR {
        return Err("too dear to try".into());
    }
    let compressed = REGISTRY.restore(&parts.header, parts.sections.clone()).map_err(refused)?;
    Ok(invariants::compressed(compressed))
}

macro_rules! sections_of {
    ($name:literal, $stages:expr, [$($codec:literal),+], $limit:ident, $share:literal) => {
        Reader {
            name: $name,
            seeds: || seeds::parts($stages),
            read: |bytes| read_parts(bytes, &[$($codec),+]),
            limit: $limit,
            kind: Kind::Parts,
            share: $share,
        }
    };
}

/// Every reader: files of others first, then compressed matrices by codec, then light transforms.
pub const READERS: &[Reader] = &[
    Reader {
        name: "npz",
        seeds: seeds::npz,
        read: |bytes| {
            let read = npz::read_from(Cursor::new(bytes), &Description::default()).map_err(refused)?;
            Ok(invariants::matrix(read.matrix))
        },
        limit: deflated,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "npy",
        seeds: seeds::npy,
        read: |bytes| match npy::read_from(Cursor::new(bytes), &Description::default()) {
            Ok(matrix) => Ok(invariants::matrix(matrix)),
            // A vector is a light and no matrix.
            Err(_) => Ok(invariants::lights(npy::read_lights_from(Cursor::new(bytes)).map_err(refused)?)),
        },
        limit: plain,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "mtx",
        seeds: seeds::mtx,
        read: |bytes| Ok(invariants::matrix(mtx::read_from(bytes, &Description::default()).map_err(refused)?)),
        limit: triplets,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "ply",
        seeds: seeds::ply,
        read: |bytes| match read_charted_ply(bytes) {
            Ok(charted) => Ok(invariants::charted(charted)),
            Err(_) => Ok(invariants::mesh(read_ply(bytes).map_err(refused)?)),
        },
        limit: plain,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "obj",
        seeds: seeds::obj,
        read: |bytes| match read_charted_obj(bytes) {
            Ok(charted) => Ok(invariants::charted(charted)),
            Err(_) => Ok(invariants::mesh(read_obj(bytes).map_err(refused)?)),
        },
        limit: plain,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "hdr",
        seeds: seeds::hdr,
        read: |bytes| Ok(invariants::image(read_hdr(bytes).map_err(refused)?)),
        limit: pixels,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "exr",
        seeds: seeds::exr,
        read: |bytes| Ok(invariants::image(read_exr(bytes).map_err(refused)?)),
        limit: pixels,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "pca",
        seeds: seeds::pca,
        read: |bytes| Ok(invariants::model(d3dx::from_d3dx(bytes).map_err(refused)?)),
        limit: samples,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "lobes",
        seeds: seeds::lobes,
        read: |bytes| Ok(invariants::lobes(lobe_file::from_bytes(bytes).map_err(refused)?)),
        limit: plain,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "results",
        seeds: seeds::results,
        read: |bytes| Ok(invariants::results(results::from_csv(bytes).map_err(|e| format!("{e:#}"))?)),
        limit: plain,
        kind: Kind::File,
        share: 1.0,
    },
    Reader {
        name: "prt",
        seeds: seeds::container,
        read: |bytes| {
            let compressed = prt::from_bytes(bytes, &REGISTRY).map_err(refused)?;
            Ok(invariants::container(compressed))
        },
        limit: container,
        kind: Kind::Sealed,
        share: 1.0,
    },
    sections_of!("dense", &["dense"], ["dense"], sections, 1.0),
    sections_of!("csr", &["csr"], ["csr"], sections, 1.0),
    sections_of!("compact", &["compact"], ["compact"], sections, 1.0),
    sections_of!("f16", &["f16"], ["f16"], sections, 1.0),
    sections_of!("runs", &["runs"], ["runs"], sections, 1.0),
    sections_of!("visibility", &["visibility"], ["visibility"], sections, 1.0),
    sections_of!("truncate", &["truncate"], ["truncate"], sections, 1.0),
    sections_of!("bicluster", &["bicluster"], ["bicluster"], symbols, 1.0),
    sections_of!("cpca", &["vq", "pca", "cpca"], ["vq", "pca", "cpca"], sections, 1.0),
    sections_of!("tensor", &["tucker", "cta"], ["tucker", "cta"], sections, 1.0),
    sections_of!("slf", &["slf"], ["slf"], sections, 1.0),
    sections_of!("haar", &["haar"], ["csr", "truncate"], sections, 1.0),
    sections_of!("sh", &["sh"], ["csr"], derived, 0.5),
    sections_of!("srbf", &["srbf"], ["csr"], derived, 0.1),
];

/// The reader of this name.
///
/// # Panics
/// Where there is none.
pub fn reader(name: &str) -> &'static Reader {
    READERS.iter().find(|reader| reader.name == name).unwrap_or_else(|| panic!("no reader {name}"))
}
