//! The header of a `.prt` file, little-endian, as `docs/format.md` lists it.

use super::super::broken;
use super::{Encoding, MAX_NAME, MAX_SECTIONS, SectionInfo, VERSION, too_large};
use crate::error::{Error, Result};
use crate::matrix::{Layout, Shape};
use crate::method::Header;
use crate::responses::ResponseBasis;

/// As PNG's: catches transfers that strip the eighth bit or change line ends.
const MAGIC: [u8; 8] = *b"\x89PRT\r\n\x1a\n";
/// Magic, version, length.
const PREFIX: usize = 16;
/// Bytes of the checksum that ends the header.
const CHECKSUM: usize = 4;

pub(super) fn header(header: &Header, sections: &[SectionInfo]) -> Result<Vec<u8>> {
    let mut bytes = MAGIC.to_vec();
    let version = if header.responses.is_plain() { 1 } else { VERSION };
    bytes.extend(version.to_le_bytes());
    bytes.extend([0; 4]);
    text(&mut bytes, "bytes of the label", &header.label.to_string())?;
    text(&mut bytes, "bytes of the codec's tag", &header.tag)?;
    let Shape { samples, responses, lights } = header.shape;
    [samples, responses, lights].iter().for_each(|&n| bytes.extend((n as u64).to_le_bytes()));
    text(&mut bytes, "bytes of the light basis", &header.basis.to_string())?;
    if version > 1 {
        text(&mut bytes, "bytes of the response basis", &header.responses.to_string())?;
    }
    bytes.push(match header.layout {
        Layout::Sparse => 0,
        Layout::Rows => 1,
        Layout::Samples => 2,
    });
    if sections.len() > MAX_SECTIONS {
        return Err(too_large("sections of a .prt file", MAX_SECTIONS, sections.len()));
    }
    bytes.extend((sections.len() as u16).to_le_bytes());
    for section in sections {
        if section.name.len() > MAX_NAME {
            return Err(too_large("bytes of a section's name", MAX_NAME, section.name.len()));
        }
        bytes.push(section.name.len() as u8);
        bytes.extend(section.name.as_bytes());
        bytes.push(match section.encoding {
            Encoding::Raw => 0,
            Encoding::Zstd => 1,
        });
        bytes.extend(section.raw.to_le_bytes());
        bytes.extend(section.stored.to_le_bytes());
        bytes.extend(section.crc.to_le_bytes());
    }
    // At most 4 x 65,535 + 256 x 86 bytes and a few.
    let length = (bytes.len() - PREFIX + CHECKSUM) as u32;
    bytes[PREFIX - 4..PREFIX].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32fast::hash(&bytes);
    bytes.extend(checksum.to_le_bytes());
    Ok(bytes)
}

fn text(bytes: &mut Vec<u8>, what: &str, text: &str) -> Result<()> {
    let length = u16::try_from(text.len()).map_err(|_| too_large(what, u16::MAX.into(), text.len()))?;
    bytes.extend(length.to_le_bytes());
    bytes.extend(text.as_bytes());
    Ok(())
}

/// Header, section table and the length of both in bytes.
pub(super) fn read_header(bytes: &[u8]) -> Result<(Header, Vec<SectionInfo>, usize)> {
    let mut fields = Fields { bytes, at: 0 };
    let magic = fields.take::<8>("the magic number")?;
    if magic != MAGIC {
        return Err(broken("prt", "byte 0", "\\x89PRT\\r\\n\\x1a\\n", magic.escape_ascii().to_string()));
    }
    let version = fields.u32("the version")?;
    if !(1..=VERSION).contains(&version) {
        return Err(broken("prt", "byte 8", format!("a version up to {VERSION}"), format!("version {version}")));
    }
    let length = fields.u32("the header's length")? as usize;
    let end = length.checked_add(PREFIX).filter(|&end| length >= CHECKSUM && end <= bytes.len());
    let Some(end) = end else {
        let left = bytes.len() - PREFIX;
        return Err(broken("prt", "byte 12", format!("a header of 4 to {left} bytes"), length.to_string()));
    };
    let (covered, checksum) = bytes[..end].split_at(end - CHECKSUM);
    let crc = crc32fast::hash(covered);
    if crc.to_le_bytes() != checksum {
        return Err(broken("prt", format!("byte {}", end - CHECKSUM), format!("header checksum {crc:08x}"), "another"));
    }
    fields.bytes = covered;
    let label = fields.text("the label")?.parse()?;
    let tag = fields.text("the codec's tag")?.into();
    let shape = fields.shape()?;
    let basis = fields.text("the light basis")?.parse()?;
    let responses = match version {
        1 => ResponseBasis::Plain { responses: shape.responses },
        _ => fields.text("the response basis")?.parse()?,
    };
    let header = Header { label, tag, shape, basis, responses, layout: fields.layout()? };
    let sections = fields.sections()?;
    if fields.at != covered.len() {
        return Err(fields.broken("the end of the header", format!("{} more bytes", covered.len() - fields.at)));
    }
    Ok((header, sections, end))
}

struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn broken(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        broken("prt", format!("byte {}", self.at), expected, found)
    }
    fn slice(&mut self, length: usize, what: &str) -> Result<&'a [u8]> {
        match self.bytes[self.at..].get(..length) {
            Some(slice) => {
                self.at += length;
                Ok(slice)
            }
            None => Err(self.broken(format!("{length} bytes of {what}"), (self.bytes.len() - self.at).to_string())),
        }
    }
    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let mut taken = [0; N];
        taken.copy_from_slice(self.slice(N, what)?);
        Ok(taken)
    }
    fn u32(&mut self, what: &str) -> Result<u32> {
        Ok(u32::from_le_bytes(self.take(what)?))
    }
    fn u64(&mut self, what: &str) -> Result<u64> {
        Ok(u64::from_le_bytes(self.take(what)?))
    }
    fn string(&mut self, length: usize, what: &str) -> Result<&'a str> {
        let at = self.at;
        let text = self.slice(length, what)?;
        std::str::from_utf8(text)
            .map_err(|e| broken("prt", format!("byte {at}"), format!("{what} in UTF-8"), e.to_string()))
    }
    fn text(&mut self, what: &str) -> Result<&'a str> {
        let length = u16::from_le_bytes(self.take(what)?);
        self.string(length.into(), what)
    }
    fn shape(&mut self) -> Result<Shape> {
        let mut size = |what: &str| {
            let size = self.u64(what)?;
            usize::try_from(size).map_err(|_| self.broken(format!("{what} that memory can address"), size.to_string()))
        };
        Shape::new(size("samples")?, size("responses")?, size("lights")?)
    }
    fn layout(&mut self) -> Result<Layout> {
        match self.take::<1>("the layout")? {
            [0] => Ok(Layout::Sparse),
            [1] => Ok(Layout::Rows),
            [2] => Ok(Layout::Samples),
            [other] => Err(self.broken("layout 0, 1 or 2", other.to_string())),
        }
    }
    fn sections(&mut self) -> Result<Vec<SectionInfo>> {
        let count = usize::from(u16::from_le_bytes(self.take("the number of sections")?));
        if count > MAX_SECTIONS {
            return Err(self.broken(format!("at most {MAX_SECTIONS} sections"), count.to_string()));
        }
        (0..count).map(|_| self.section()).collect()
    }
    fn section(&mut self) -> Result<SectionInfo> {
        let [length] = self.take("the length of a section's name")?;
        if usize::from(length) > MAX_NAME {
            return Err(self.broken(format!("a name of at most {MAX_NAME} bytes"), length.to_string()));
        }
        let name = self.string(length.into(), "a section's name")?.into();
        let encoding = match self.take("a section's encoding")? {
            [0] => Encoding::Raw,
            [1] => Encoding::Zstd,
            [other] => return Err(self.broken("encoding 0 (raw) or 1 (zstd)", other.to_string())),
        };
        let (raw, stored) = (self.u64("a section's length")?, self.u64("a section's stored length")?);
        Ok(SectionInfo { name, encoding, raw, stored, crc: self.u32("a section's checksum")? })
    }
}
