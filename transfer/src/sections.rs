//! Named sections of plain numbers: what an encoded matrix consists of, and the only source of its size.

use crate::error::{Error, Result};
use bytemuck::{Pod, Zeroable};

// Sections are the little-endian bytes of their numbers, copied as they lie in memory.
#[cfg(target_endian = "big")]
compile_error!(
    "prt-transfer reads and writes little-endian sections by copying memory; big-endian machines need byte swaps"
);

/// A name and the bytes behind it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Unique within a file; `kind/name`, where kind is basis, weights, index or header.
    pub name: String,
    /// Little-endian numbers, as relighting holds them in memory.
    pub bytes: Vec<u8>,
}

/// Collects sections from [`crate::Encoded::write`].
#[derive(Default)]
pub struct Sink {
    sections: Vec<Section>,
}

/// Hands sections to [`crate::Restore::read`], each once.
pub struct Source {
    sections: Vec<Section>,
}

impl Sink {
    /// Nothing yet.
    pub fn new() -> Sink {
        Sink::default()
    }
    /// Adds a section of numbers. Writing a name twice is a mistake in the codec, and reading the file back says so.
    pub fn put<T: Pod>(&mut self, name: &str, numbers: &[T]) {
        self.sections.push(Section { name: name.into(), bytes: bytemuck::cast_slice(numbers).to_vec() });
    }
    /// Bytes by section, in the order in which they were written.
    pub fn sizes(&self) -> impl Iterator<Item = (&str, usize)> {
        self.sections.iter().map(|s| (s.name.as_str(), s.bytes.len()))
    }
    /// Bytes of all sections: what relighting holds in memory.
    pub fn resident_bytes(&self) -> usize {
        self.sections.iter().map(|s| s.bytes.len()).sum()
    }
    /// The sections themselves.
    pub fn into_sections(self) -> Vec<Section> {
        self.sections
    }
}

impl Source {
    /// Sections to be read; two of one name are refused.
    pub fn new(sections: Vec<Section>) -> Result<Source> {
        for (i, section) in sections.iter().enumerate() {
            if sections[..i].iter().any(|s| s.name == section.name) {
                return Err(broken(&section.name, "a unique name", "a second section of this name"));
            }
        }
        Ok(Source { sections })
    }
    /// Whether a section of this name is left: for sections that a codec writes only where it needs them.
    pub fn has(&self, name: &str) -> bool {
        self.sections.iter().any(|s| s.name == name)
    }
    /// The numbers of a section, however many.
    pub fn take<T: Pod + Zeroable>(&mut self, name: &str) -> Result<Vec<T>> {
        let at =
            self.sections.iter().position(|s| s.name == name).ok_or_else(|| broken(name, "this section", "none"))?;
        let bytes = self.sections.swap_remove(at).bytes;
        let size = size_of::<T>();
        if !bytes.len().is_multiple_of(size) {
            return Err(broken(name, format!("a multiple of {size} bytes"), format!("{} bytes", bytes.len())));
        }
        // Copied rather than cast, since a Vec<u8> need not be aligned for T.
        let mut numbers = vec![T::zeroed(); bytes.len() / size];
        bytemuck::cast_slice_mut::<T, u8>(&mut numbers).copy_from_slice(&bytes);
        Ok(numbers)
    }
    /// The numbers of a section, which must be `count`.
    pub fn take_exact<T: Pod + Zeroable>(&mut self, name: &str, count: usize) -> Result<Vec<T>> {
        let numbers = self.take(name)?;
        if numbers.len() == count {
            Ok(numbers)
        } else {
            Err(broken(name, format!("{count} numbers"), format!("{} numbers", numbers.len())))
        }
    }
    /// Finite `f32`s of a section, which must be `count`.
    pub fn take_finite(&mut self, name: &str, count: usize) -> Result<Vec<f32>> {
        let numbers: Vec<f32> = self.take_exact(name, count)?;
        match numbers.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(broken(name, "finite numbers", format!("{} at position {at}", numbers[at]))),
            None => Ok(numbers),
        }
    }
    /// Every section has been read: one left over is a damaged or foreign file.
    pub fn finish(self) -> Result<()> {
        match self.sections.first() {
            Some(section) => Err(broken(&section.name, "no further section", format!("{} bytes", section.bytes.len()))),
            None => Ok(()),
        }
    }
}

/// A section whose content breaks its codec's layout.
pub fn broken(section: &str, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Format {
        format: "prt",
        place: format!("section '{section}'"),
        expected: expected.into(),
        found: found.into(),
    }
}
