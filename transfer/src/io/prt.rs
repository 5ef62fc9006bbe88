//! The container of a compressed matrix, `.prt`; `docs/format.md` describes it byte by byte.
//!
//! A header says what the matrix is and lists the sections; the sections follow, each compressed by zstd at one level
//! that is the same for every method, or raw where that is smaller. Each carries a checksum. The same matrix gives the
//! same bytes on any number of threads.

mod wire;

use super::{atomic, broken, bytes_of};
use crate::error::{Error, Result};
use crate::method::{Compressed, Header, Registry};
use crate::progress::Progress;
use crate::sections::Section;
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// Version of the container; a reader reads every version up to its own, and a writer writes the first that can say
/// everything: 1, or 2 where it is known what the responses stand for.
pub const VERSION: u32 = 2;
/// Sections that one file may have.
pub const MAX_SECTIONS: usize = 256;
/// Bytes of a section's name.
pub const MAX_NAME: usize = 64;

/// Level of zstd in every file. On the `csr` sections of a synthetic visibility matrix (39 MB) level 15 makes 0.92
/// times the bytes and takes some 7 times as long, level 9 1.14 times the bytes in a third of the time.
const ZSTD_LEVEL: i32 = 12;
/// Bytes that are compressed between two reports: a tenth of a second.
const REPORTED: usize = 1 << 20;
/// A section may be this many times its stored bytes …
const EXPANSION: u64 = 1000;
/// … and this much more.
const ALLOWANCE: u64 = 1 << 16;

/// How a section is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As it is.
    Raw,
    /// One zstd frame, possibly with a skippable frame behind it.
    Zstd,
}

/// A section as the header lists it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SectionInfo {
    /// `kind/name`, where kind is basis, weights, index or header.
    pub name: String,
    /// How it is stored.
    pub encoding: Encoding,
    /// Bytes before compression.
    pub raw: u64,
    /// Bytes in the file.
    pub stored: u64,
    /// CRC-32 (IEEE) of the raw bytes.
    pub crc: u32,
}

/// The bytes that a compressed matrix takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// The file's header, magic and checksum included.
    pub header: u64,
    /// The sections before compression. Most codecs hold them in memory as they are.
    pub raw: u64,
    /// At rest: the file.
    pub file: u64,
}

/// What a file says before its sections are decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Method, shape, basis, layout.
    pub header: Header,
    /// The sections in their order.
    pub sections: Vec<SectionInfo>,
    /// Bytes by kind.
    pub sizes: Sizes,
}

/// The file of a compressed matrix.
pub fn to_bytes(compressed: &Compressed, progress: &dyn Progress) -> Result<Vec<u8>> {
    pack(&compressed.header(), compressed.sections().into_sections(), progress)
}

/// Writes a compressed matrix and says how large it became.
pub fn write(path: impl AsRef<Path>, compressed: &Compressed, progress: &dyn Progress) -> Result<Sizes> {
    let path = path.as_ref();
    let parts = Parts::new(&compressed.header(), compressed.sections().into_sections(), progress);
    let parts = parts.map_err(|e| e.in_file(path))?;
    atomic::write(path, |file| parts.all().try_for_each(|part| file.write_all(part)))?;
    Ok(parts.sizes)
}

/// Reads a compressed matrix whose transform and codec `registry` knows.
pub fn read(path: impl AsRef<Path>, registry: &Registry) -> Result<Compressed> {
    let path = path.as_ref();
    from_bytes(&bytes_of(path)?, registry).map_err(|e| e.in_file(path))
}

/// As [`read`], from memory.
pub fn from_bytes(bytes: &[u8], registry: &Registry) -> Result<Compressed> {
    let (header, sections) = unpack(bytes)?;
    registry.restore(&header, sections)
}

/// Header, sections and sizes of a file, nothing decoded. The header's checksum and all lengths have been checked, the
/// sections' checksums not.
pub fn inspect(bytes: &[u8]) -> Result<Contents> {
    let (header, sections, length) = wire::read_header(bytes)?;
    let stored = sections.iter().try_fold(length as u64, |sum, s| sum.checked_add(s.stored));
    if stored != Some(bytes.len() as u64) {
        let sum = stored.map_or("more than 2^64".into(), |sum| sum.to_string());
        return Err(broken("prt", "end of the file", format!("{sum} bytes"), format!("{} bytes", bytes.len())));
    }
    for section in &sections {
        let limit = match section.encoding {
            Encoding::Raw => section.stored,
            Encoding::Zstd => section.stored.saturating_mul(EXPANSION).saturating_add(ALLOWANCE),
        };
        if section.raw > limit || (section.encoding == Encoding::Raw && section.raw != section.stored) {
            let place = format!("section '{}'", section.name);
            let expected = format!("at most {limit} bytes of {} stored {:?} bytes", section.stored, section.encoding);
            return Err(broken("prt", place, expected, section.raw.to_string()));
        }
    }
    let raw = sections.iter().map(|s| s.raw).sum::<u64>();
    let sizes = Sizes { header: length as u64, raw, file: bytes.len() as u64 };
    Ok(Contents { header, sections, sizes })
}

/// Header and raw sections of a file, checksums checked: everything but the codec's own reading.
pub fn unpack(bytes: &[u8]) -> Result<(Header, Vec<Section>)> {
    let Contents { header, sections, sizes } = inspect(bytes)?;
    let mut rest = &bytes[sizes.header as usize..];
    let stored: Vec<(SectionInfo, &[u8])> = sections
        .into_iter()
        .map(|section| {
            let (payload, after) = rest.split_at(section.stored as usize);
            rest = after;
            (section, payload)
        })
        .collect();
    let sections = stored.into_par_iter().map(|(section, payload)| decode(section, payload)).collect::<Result<_>>()?;
    Ok((header, sections))
}

/// A file of any header and sections; [`to_bytes`] is its use.
pub fn pack(header: &Header, sections: Vec<Section>, progress: &dyn Progress) -> Result<Vec<u8>> {
    let parts = Parts::new(header, sections, progress)?;
    let mut bytes = Vec::with_capacity(parts.sizes.file as usize);
    parts.all().for_each(|part| bytes.extend_from_slice(part));
    Ok(bytes)
}

/// What a file consists of, in its order: large files are never in memory twice.
struct Parts {
    header: Vec<u8>,
    payloads: Vec<Vec<u8>>,
    sizes: Sizes,
}

impl Parts {
    /// Sections are given up one by one as they are compressed.
    fn new(header: &Header, sections: Vec<Section>, progress: &dyn Progress) -> Result<Parts> {
        progress.start("zstd", sections.iter().map(|section| section.bytes.len() as u64).sum());
        let encoded = sections.into_par_iter().map(|section| encode(section, progress));
        let (infos, payloads): (Vec<SectionInfo>, Vec<Vec<u8>>) =
            encoded.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        let header = wire::header(header, &infos)?;
        let sum = |bytes: fn(&SectionInfo) -> u64| infos.iter().map(bytes).sum::<u64>();
        let length = header.len() as u64;
        let sizes = Sizes { header: length, raw: sum(|info| info.raw), file: length + sum(|info| info.stored) };
        Ok(Parts { header, payloads, sizes })
    }

    fn all(&self) -> impl Iterator<Item = &Vec<u8>> {
        std::iter::once(&self.header).chain(&self.payloads)
    }
}

fn encode(section: Section, progress: &dyn Progress) -> Result<(SectionInfo, Vec<u8>)> {
    let Section { name, bytes: raw } = section;
    let failed = |e: std::io::Error| broken("prt", format!("section '{name}'"), "zstd to work", e.to_string());
    // With its length, so that the frame says it and is searched as one whole.
    let mut frame = zstd::stream::Encoder::new(Vec::new(), ZSTD_LEVEL).map_err(failed)?;
    frame.set_pledged_src_size(Some(raw.len() as u64)).map_err(failed)?;
    for part in raw.chunks(REPORTED) {
        frame.write_all(part).map_err(failed)?;
        progress.advance(part.len() as u64)?;
    }
    let mut payload = frame.finish().map_err(failed)?;
    pad(&mut payload, raw.len());
    let encoding = if payload.len() < raw.len() { Encoding::Zstd } else { Encoding::Raw };
    let (length, crc) = (raw.len() as u64, crc32fast::hash(&raw));
    if encoding == Encoding::Raw {
        payload = raw;
    }
    Ok((SectionInfo { name, encoding, raw: length, stored: payload.len() as u64, crc }, payload))
}

/// Makes a frame long enough for what it expands to, by a skippable frame of zeros, which every zstd decoder passes
/// over.
fn pad(frame: &mut Vec<u8>, raw: usize) {
    let least = (raw as u64).saturating_sub(ALLOWANCE).div_ceil(EXPANSION) as usize;
    if frame.len() < least {
        let zeros = least.saturating_sub(frame.len() + 8);
        frame.extend(0x184D_2A50u32.to_le_bytes());
        frame.extend((zeros as u32).to_le_bytes());
        frame.resize(frame.len() + zeros, 0);
    }
}

fn decode(section: SectionInfo, payload: &[u8]) -> Result<Section> {
    let place = format!("section '{}'", section.name);
    let bytes = match section.encoding {
        Encoding::Raw => payload.to_vec(),
        Encoding::Zstd => zstd::bulk::decompress(payload, section.raw as usize)
            .map_err(|e| broken("prt", &*place, format!("zstd frames of {} bytes", section.raw), e.to_string()))?,
    };
    if bytes.len() as u64 != section.raw {
        return Err(broken("prt", &*place, format!("{} bytes", section.raw), format!("{} bytes", bytes.len())));
    }
    let crc = crc32fast::hash(&bytes);
    if crc != section.crc {
        return Err(broken("prt", &*place, format!("checksum {:08x}", section.crc), format!("{crc:08x}")));
    }
    Ok(Section { name: section.name, bytes })
}

/// A quantity that the header's fields cannot hold.
fn too_large(what: &str, limit: usize, found: usize) -> Error {
    Error::TooLarge { what: what.into(), limit: limit as u64, found: found as u64 }
}
