//! Numbers of any NumPy type, read as what a matrix needs.

use super::Place;
use crate::error::{Error, Result};
use half::f16;
use std::io::Read;

/// A NumPy element type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementType {
    pub(super) kind: Kind,
    /// Bytes of one element.
    pub(super) size: usize,
    pub(super) big_endian: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Signed,
    Unsigned,
    Float,
    /// Byte strings, padded with 0.
    Bytes,
    /// UCS-4 strings, padded with 0.
    Text,
}

impl ElementType {
    /// `<f4`, `|u1`, `>i8`, … as NumPy's `descr` writes them.
    pub(super) fn parse(descr: &str, place: Place) -> Result<ElementType> {
        let refuse = || {
            let known = "an element type of bool, integers or f16, f32, f64 (b1, i1-i8, u1-u8, f2, f4, f8)";
            place.broken(known, format!("'{descr}'"))
        };
        let mut letters = descr.chars();
        let (order, kind) = (letters.next().ok_or_else(refuse)?, letters.next().ok_or_else(refuse)?);
        let count: usize = letters.as_str().parse().map_err(|_| refuse())?;
        let (kind, size, legal) = match kind {
            'b' => (Kind::Bool, count, count == 1),
            'i' => (Kind::Signed, count, matches!(count, 1 | 2 | 4 | 8)),
            'u' => (Kind::Unsigned, count, matches!(count, 1 | 2 | 4 | 8)),
            'f' => (Kind::Float, count, matches!(count, 2 | 4 | 8)),
            'S' => (Kind::Bytes, count, count <= 64),
            'U' => (Kind::Text, count.saturating_mul(4), count <= 64),
            _ => return Err(refuse()),
        };
        let big_endian = match order {
            '<' | '=' => false,
            '>' => true,
            '|' if size <= 1 || kind == Kind::Bytes => false,
            _ => return Err(refuse()),
        };
        if legal { Ok(ElementType { kind, size, big_endian }) } else { Err(refuse()) }
    }
}

/// A stream of elements, `count` of them, with the bytes that are known to lie behind it.
pub(super) struct Elements<'a, R> {
    pub(super) reader: R,
    pub(super) element: ElementType,
    pub(super) count: usize,
    /// Bytes that the source has earned: no more is reserved before it is read.
    pub(super) earned: u64,
    pub(super) place: Place<'a>,
}

/// Values, and the first one whose magnitude `f32` cannot hold.
pub(super) struct Values {
    pub(super) values: Vec<f32>,
    pub(super) overflow: Option<(usize, f64)>,
}

impl<R: Read> Elements<'_, R> {
    /// Values rounded to `f32`.
    pub(super) fn values(self) -> Result<Values> {
        use Kind::{Bool, Float, Signed, Unsigned};
        let mut overflow = None;
        let values = match (self.element.kind, self.element.size) {
            (Bool, 1) => self.each(|_, [b]| Ok(f32::from(b != 0))),
            (Signed, 1) => self.each(|_, b| Ok(f32::from(i8::from_le_bytes(b)))),
            (Signed, 2) => self.each(|_, b| Ok(f32::from(i16::from_le_bytes(b)))),
            (Signed, 4) => self.each(|_, b| Ok(i32::from_le_bytes(b) as f32)),
            (Signed, 8) => self.each(|_, b| Ok(i64::from_le_bytes(b) as f32)),
            (Unsigned, 1) => self.each(|_, [b]| Ok(f32::from(b))),
            (Unsigned, 2) => self.each(|_, b| Ok(f32::from(u16::from_le_bytes(b)))),
            (Unsigned, 4) => self.each(|_, b| Ok(u32::from_le_bytes(b) as f32)),
            (Unsigned, 8) => self.each(|_, b| Ok(u64::from_le_bytes(b) as f32)),
            (Float, 2) => self.each(|_, b| Ok(f16::from_le_bytes(b).to_f32())),
            (Float, 4) => self.each(|_, b| Ok(f32::from_le_bytes(b))),
            (Float, 8) => self.each(|at, b| {
                let wide = f64::from_le_bytes(b);
                let value = wide as f32;
                if value.is_infinite() && wide.is_finite() && overflow.is_none() {
                    overflow = Some((at, wide));
                }
                Ok(value)
            }),
            _ => Err(self.place.broken("numbers", "text")),
        }?;
        Ok(Values { values, overflow })
    }

    /// Indices and sizes, each of which must fit `T`.
    pub(super) fn indices<T: TryFrom<u64>>(self) -> Result<Vec<T>> {
        use Kind::{Signed, Unsigned};
        let place = self.place;
        let fit = move |at: usize, value: i128| {
            let narrow = u64::try_from(value).ok().and_then(|v| T::try_from(v).ok());
            narrow.ok_or_else(|| {
                let limit = format!("an index from 0 that fits {} bits at position {at}", 8 * size_of::<T>());
                place.broken(limit, value.to_string())
            })
        };
        match (self.element.kind, self.element.size) {
            (Signed, 1) => self.each(|at, b| fit(at, i8::from_le_bytes(b).into())),
            (Signed, 2) => self.each(|at, b| fit(at, i16::from_le_bytes(b).into())),
            (Signed, 4) => self.each(|at, b| fit(at, i32::from_le_bytes(b).into())),
            (Signed, 8) => self.each(|at, b| fit(at, i64::from_le_bytes(b).into())),
            (Unsigned, 1) => self.each(|at, [b]| fit(at, b.into())),
            (Unsigned, 2) => self.each(|at, b| fit(at, u16::from_le_bytes(b).into())),
            (Unsigned, 4) => self.each(|at, b| fit(at, u32::from_le_bytes(b).into())),
            (Unsigned, 8) => self.each(|at, b| fit(at, u64::from_le_bytes(b).into())),
            _ => Err(place.broken("integer indices", "another type")),
        }
    }

    /// The one string of an array without axes.
    pub(super) fn text(mut self) -> Result<String> {
        let mut bytes = vec![0; self.element.size];
        if self.count != 1 {
            return Err(self.place.broken("one string", format!("{} elements", self.count)));
        }
        self.reader.read_exact(&mut bytes).map_err(|e| self.place.unreadable("a string", &e))?;
        let letters: Vec<u32> = match self.element.kind {
            Kind::Bytes => bytes.iter().map(|&b| b.into()).collect(),
            Kind::Text => bytes
                .chunks_exact(4)
                .map(|c| {
                    let word = [c[0], c[1], c[2], c[3]];
                    if self.element.big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
                })
                .collect(),
            _ => return Err(self.place.broken("a string", "numbers")),
        };
        let text = letters.into_iter().map(|c| char::from_u32(c).unwrap_or(char::REPLACEMENT_CHARACTER));
        Ok(text.collect::<String>().trim_end_matches('\0').into())
    }

    fn each<const N: usize, T>(mut self, mut decode: impl FnMut(usize, [u8; N]) -> Result<T>) -> Result<Vec<T>> {
        let mut elements = Vec::with_capacity(self.count.min((self.earned / N as u64) as usize));
        let mut chunk = vec![0; 8192 * N];
        while elements.len() < self.count {
            let chunk = &mut chunk[..N * (self.count - elements.len()).min(8192)];
            self.reader.read_exact(chunk).map_err(|e| {
                let missing = format!("{} elements, read {}", self.count, elements.len());
                self.place.unreadable(missing, &e)
            })?;
            for bytes in chunk.as_chunks_mut::<N>().0 {
                if self.element.big_endian {
                    bytes.reverse();
                }
                elements.push(decode(elements.len(), *bytes)?);
            }
        }
        Ok(elements)
    }
}

/// [`Error::Format`] for a value too large for `f32`.
pub(super) fn overflow(format: &'static str, row: usize, col: usize, value: f64) -> Error {
    super::broken(
        format,
        format!("row {row}, column {col}"),
        format!("a magnitude of at most {:e}, which single precision holds", f32::MAX),
        format!("{value:e}"),
    )
}
