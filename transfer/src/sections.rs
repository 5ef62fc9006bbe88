//! Named sections of plain numbers: what an encoded matrix consists of, and the only source of its size.

use crate::error::{Error, Result};
use bytemuck::Zeroable;

/// What a section can hold, for codecs that are generic over the width of their numbers.
pub use bytemuck::Pod;

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
    /// Adds what `write` writes, each name with `prefix-` before its last part: `index/columns` becomes `index/rest-columns`.
    pub fn nest(&mut self, prefix: &str, write: impl FnOnce(&mut Sink)) {
        let mut sink = Sink::new();
        write(&mut sink);
        let renamed = |section: Section| match section.name.split_once('/') {
            Some((kind, name)) => Section { name: format!("{kind}/{prefix}-{name}"), ..section },
            None => Section { name: format!("{prefix}-{}", section.name), ..section },
        };
        self.sections.extend(sink.sections.into_iter().map(renamed));
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
    /// The sections that [`Sink::nest`] wrote with this prefix, under their own names; `None` without any.
    pub fn nested(&mut self, prefix: &str) -> Option<Source> {
        let own_name = |name: &str| {
            let (kind, name) = name.split_once('/').map_or(("", name), |(kind, name)| (kind, name));
            let name = name.strip_prefix(prefix)?.strip_prefix('-')?;
            Some(if kind.is_empty() { name.into() } else { format!("{kind}/{name}") })
        };
        let nested = self.sections.extract_if(.., |s| own_name(&s.name).is_some());
        let renamed = nested.map(|s| Section { name: own_name(&s.name).unwrap_or_default(), ..s });
        let sections: Vec<Section> = renamed.collect();
        // Names were unique before, and the same prefix has been taken from all.
        (!sections.is_empty()).then_some(Source { sections })
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
