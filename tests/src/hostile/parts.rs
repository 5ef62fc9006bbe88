//! A compressed matrix taken apart: what lies behind the checksums and the compression of a `.prt` file.
//!
//! As bytes these are eight lines of text (label, tag, samples, responses, lights, light basis, response basis, layout), then section after section a
//! line with its name, a u32 with its length and its bytes. A length beyond the end means all that is left, so that mutations seldom break it.

use prt_transfer::io::prt::MAX_NAME;
use prt_transfer::matrix::Layout;
use prt_transfer::method::Header;
use prt_transfer::sections::Section;
use prt_transfer::{Compressed, Error, Result, Shape};

/// Header and sections, as [`prt_transfer::Registry::restore`] takes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// What the file says first.
    pub header: Header,
    /// What follows, unpacked.
    pub sections: Vec<Section>,
}

const LAYOUTS: [(&str, Layout); 3] = [("sparse", Layout::Sparse), ("rows", Layout::Rows), ("samples", Layout::Samples)];

impl Parts {
    /// Of a compressed matrix.
    pub fn of(compressed: &Compressed) -> Parts {
        Parts { header: compressed.header(), sections: compressed.sections().into_sections() }
    }

    /// The lines of the header.
    pub fn lines(&self) -> [String; 8] {
        let Header { label, tag, shape, basis, responses, layout } = &self.header;
        let layout = LAYOUTS.iter().find(|(_, known)| known == layout).map_or("", |(name, _)| name);
        let sizes = [shape.samples, shape.responses, shape.lights].map(|size| size.to_string());
        let [samples, per_sample, lights] = sizes;
        let (label, basis, responses) = (label.to_string(), basis.to_string(), responses.to_string());
        [label, tag.clone(), samples, per_sample, lights, basis, responses, layout.into()]
    }

    /// Lines and sections one after the other.
    pub fn to_bytes(&self) -> Vec<u8> {
        Parts::join(&self.lines(), &self.sections)
    }

    /// As [`Parts::to_bytes`] with other lines, which need not mean anything.
    pub fn join(lines: &[String; 8], sections: &[Section]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for line in lines {
            bytes.extend(line.as_bytes());
            bytes.push(b'\n');
        }
        for section in sections {
            bytes.extend(section.name.as_bytes());
            bytes.push(b'\n');
            bytes.extend((section.bytes.len() as u32).to_le_bytes());
            bytes.extend(&section.bytes);
        }
        bytes
    }

    /// The way back.
    ///
    /// # Errors
    /// Lines that a header cannot have.
    pub fn from_bytes(bytes: &[u8]) -> Result<Parts> {
        let mut rest = bytes;
        let mut lines = [""; 8];
        for text in &mut lines {
            *text = line(&mut rest).ok_or_else(|| refused("a line of the header"))?;
        }
        let [label, tag, samples, responses, lights, basis, response_basis, layout] = lines;
        let size = |text: &str| text.parse::<usize>().map_err(|_| refused("a size"));
        let layout = LAYOUTS.iter().find(|(name, _)| *name == layout).ok_or_else(|| refused("a layout"))?.1;
        let header = Header {
            label: label.parse()?,
            tag: tag.into(),
            shape: Shape::new(size(samples)?, size(responses)?, size(lights)?)?,
            basis: basis.parse()?,
            responses: response_basis.parse()?,
            layout,
        };
        let mut sections = Vec::new();
        while !rest.is_empty() {
            let name = line(&mut rest).filter(|name| name.len() <= MAX_NAME);
            let name = name.ok_or_else(|| refused("the name of a section"))?.into();
            let (length, after) = rest.split_first_chunk::<4>().ok_or_else(|| refused("the length of a section"))?;
            let (bytes, after) = after.split_at(after.len().min(u32::from_le_bytes(*length) as usize));
            sections.push(Section { name, bytes: bytes.into() });
            rest = after;
        }
        Ok(Parts { header, sections })
    }
}

/// Takes a line of text.
fn line<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let end = rest.iter().position(|&b| b == b'\n')?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    str::from_utf8(line).ok()
}

fn refused(expected: &str) -> Error {
    Error::Format { format: "parts", place: "text".into(), expected: expected.into(), found: "something else".into() }
}
