//! Numbers as they are stored: single precision, or 16 bits and a scale for each vector of them.

mod scale;

use crate::error::Result;
use crate::kernel::dense;
use crate::matrix::Shape;
use crate::sections::broken;
use crate::sections::{Sink, Source};
use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::{ArrayView2, ArrayViewMut2};
pub use scale::code;
use scale::{halve, scale_of_codes, scale_of_halves, scale_of_step};
use std::ops::Range;

crate::choices! {
    /// How numbers are stored.
    pub enum Width {
        /// Single precision.
        F32 = "f32",
        /// Half precision with a scale of its own for each vector of numbers.
        F16 = "f16",
        /// 16-bit integers with a scale of their own for each vector of numbers.
        I16 = "i16",
    }
}

impl Width {
    /// Of one number.
    pub fn bytes(self) -> usize {
        match self {
            Width::F32 => 4,
            Width::F16 | Width::I16 => 2,
        }
    }

    /// The width that a section `name` gives as a number.
    ///
    /// # Errors
    /// A number of none.
    pub fn of_code(code: u32, name: &str) -> Result<Width> {
        [Width::F32, Width::F16, Width::I16]
            .into_iter()
            .find(|&width| width as u32 == code)
            .ok_or_else(|| broken(name, "widths 0 (f32), 1 (f16) or 2 (i16)", code.to_string()))
    }
}

/// What 16-bit numbers are multiplied by before a sum, and their scales divided by: terms stay below 2, so that no
/// light overflows that does not with the decoded numbers, and neither does a scale.
pub const UNIT: f32 = 1.0 / 16_384.0;

/// Numbers in vectors, each with a scale: a number is what is stored times the scale of its vector, in `f32` and
/// exactly.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// Themselves.
    F32(Vec<f32>),
    /// A scale is a power of two that brings the largest magnitude to [2^14, 2^15): |error| ≤ 2^-11 of the number down
    /// to 2^-28 of that power, 2^-39 of the largest below.
    F16 {
        /// What is stored.
        halves: Vec<f16>,
        /// Of each vector.
        scales: Vec<f32>,
    },
    /// A scale has nine significant bits, so that its multiples are exact, and is at most 1 + 2^-8 times the 32767th
    /// part of the largest magnitude: |error| ≤ scale / 2. It is 0 where all numbers are.
    I16 {
        /// What is stored.
        codes: Vec<i16>,
        /// Of each vector.
        scales: Vec<f32>,
    },
}

/// Names of the sections of numbers.
#[derive(Clone, Copy)]
pub struct Sections {
    /// Of what is stored.
    pub numbers: &'static str,
    /// Of the scales.
    pub scales: &'static str,
}

impl Numbers {
    /// Stores finite `values`; `vector_of` says for each of them which of `vectors` it belongs to.
    pub fn store(
        values: &[f32],
        width: Width,
        vectors: usize,
        vector_of: impl Iterator<Item = usize> + Clone,
    ) -> Numbers {
        if width == Width::F32 {
            return Numbers::F32(values.to_vec());
        }
        let mut largest = vec![0f32; vectors];
        values.iter().zip(vector_of.clone()).for_each(|(v, vector)| largest[vector] = largest[vector].max(v.abs()));
        let each = values.iter().zip(vector_of);
        if width == Width::F16 {
            let scales: Vec<f32> = largest.into_iter().map(scale_of_halves).collect();
            Numbers::F16 { halves: each.map(|(&v, vector)| halve(v, scales[vector])).collect(), scales }
        } else {
            let scales: Vec<f32> = largest.into_iter().map(scale_of_codes).collect();
            Numbers::I16 { codes: each.map(|(&v, vector)| code(v.into(), scales[vector].into())).collect(), scales }
        }
    }

    /// As [`Numbers::store`] in [`Width::I16`], with steps that are at most those given for each vector, and less only by their rounding to
    /// nine bits; a step that would take more than 16 bits is as fine as they allow.
    pub fn store_coarse(values: &[f32], steps: &[f64], vector_of: impl Iterator<Item = usize> + Clone) -> Numbers {
        let mut scales = vec![0f32; steps.len()];
        values.iter().zip(vector_of.clone()).for_each(|(v, vector)| scales[vector] = scales[vector].max(v.abs()));
        for (scale, step) in scales.iter_mut().zip(steps) {
            *scale = scale_of_codes(*scale).max(scale_of_step(*step));
        }
        let codes = values.iter().zip(vector_of).map(|(&v, vector)| code(v.into(), scales[vector].into())).collect();
        Numbers::I16 { codes, scales }
    }

    /// How they are stored.
    pub fn width(&self) -> Width {
        match self {
            Numbers::F32(_) => Width::F32,
            Numbers::F16 { .. } => Width::F16,
            Numbers::I16 { .. } => Width::I16,
        }
    }

    /// How many numbers.
    pub fn len(&self) -> usize {
        match self {
            Numbers::F32(values) => values.len(),
            Numbers::F16 { halves, .. } => halves.len(),
            Numbers::I16 { codes, .. } => codes.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What is stored at `at`.
    #[inline(always)]
    pub fn stored(&self, at: usize) -> f32 {
        match self {
            Numbers::F32(values) => values[at],
            Numbers::F16 { halves, .. } => halves[at].to_f32(),
            Numbers::I16 { codes, .. } => codes[at].into(),
        }
    }

    /// The scales of all vectors; `None` where numbers are stored as they are.
    pub fn scales(&self) -> Option<&[f32]> {
        match self {
            Numbers::F32(_) => None,
            Numbers::F16 { scales, .. } | Numbers::I16 { scales, .. } => Some(scales),
        }
    }

    /// The scale of a vector.
    pub fn scale(&self, vector: usize) -> f32 {
        self.scales().map_or(1.0, |scales| scales[vector])
    }

    /// What is stored in a range and `spare` finite numbers more, unpacked into `buffer` unless it is `f32` already.
    pub fn unpack<'a>(&'a self, range: Range<usize>, spare: usize, buffer: &'a mut Vec<f32>) -> &'a [f32] {
        let (count, longer) = (range.len() + spare, range.start..range.end + spare);
        match self {
            Numbers::F32(values) if longer.end <= values.len() => return &values[longer],
            Numbers::F32(values) => {
                buffer.clear();
                buffer.extend(&values[range]);
            }
            Numbers::F16 { halves, .. } => {
                buffer.resize(range.len(), 0.0);
                halves[range].convert_to_f32_slice(buffer);
            }
            Numbers::I16 { codes, .. } => {
                buffer.clear();
                buffer.extend(codes[range].iter().map(|&code| f32::from(code)));
            }
        }
        buffer.resize(count, 0.0);
        buffer
    }

    /// All numbers as they are decoded.
    pub fn decode(&self, vector_of: impl Iterator<Item = usize>) -> Vec<f32> {
        match self {
            Numbers::F32(values) => values.clone(),
            _ => {
                vector_of.take(self.len()).enumerate().map(|(i, vector)| self.stored(i) * self.scale(vector)).collect()
            }
        }
    }

    /// Writes what is stored, and the scales where there are any.
    pub fn write(&self, sink: &mut Sink, to: Sections) {
        match self {
            Numbers::F32(values) => sink.put(to.numbers, values),
            Numbers::F16 { halves, .. } => sink.put(to.numbers, halves),
            Numbers::I16 { codes, .. } => sink.put(to.numbers, codes),
        }
        if let Some(scales) = self.scales() {
            sink.put(to.scales, scales);
        }
    }

    /// As [`Numbers::write`] in the order in which a file of integers shrinks most: vectors of ascending scales one after the other, which
    /// brings numbers of like magnitudes together, first the lower bytes of all, then the upper ones.
    pub fn write_sorted(&self, sink: &mut Sink, to: Sections, vector_of: impl Iterator<Item = usize> + Clone) {
        let Numbers::I16 { codes, scales } = self else { return self.write(sink, to) };
        let places = by_scale(scales, vector_of.take(codes.len()));
        let mut bytes = vec![0u8; 2 * codes.len()];
        let (low, high) = bytes.split_at_mut(codes.len());
        for (code, &place) in codes.iter().zip(&places) {
            [low[place], high[place]] = code.to_le_bytes();
        }
        sink.put(to.numbers, &bytes);
        sink.put(to.scales, scales);
    }

    /// Reads what [`Numbers::write_sorted`] wrote; see [`Numbers::read`].
    pub fn read_sorted(
        source: &mut Source,
        from: Sections,
        width: Width,
        [count, vectors]: [usize; 2],
        vector_of: impl Iterator<Item = usize> + Clone,
    ) -> Result<Numbers> {
        if width != Width::I16 {
            return Numbers::read(source, from, width, [count, vectors], vector_of);
        }
        let bytes: Vec<u8> = source.take_exact(from.numbers, count.saturating_mul(2))?;
        let scales = source.take_finite(from.scales, vectors)?;
        let (low, high) = bytes.split_at(count);
        let places = by_scale(&scales, vector_of.clone().take(count));
        let codes = places.iter().map(|&place| i16::from_le_bytes([low[place], high[place]])).collect();
        Numbers::I16 { codes, scales }.checked(from, vector_of)
    }

    /// Reads `count` numbers of `vectors`, checked to decode to finite ones.
    pub fn read(
        source: &mut Source,
        from: Sections,
        width: Width,
        [count, vectors]: [usize; 2],
        vector_of: impl Iterator<Item = usize>,
    ) -> Result<Numbers> {
        let numbers = match width {
            Width::F32 => return Ok(Numbers::F32(source.take_finite(from.numbers, count)?)),
            Width::F16 => Numbers::F16 {
                halves: source.take_exact(from.numbers, count)?,
                scales: source.take_finite(from.scales, vectors)?,
            },
            Width::I16 => Numbers::I16 {
                codes: source.take_exact(from.numbers, count)?,
                scales: source.take_finite(from.scales, vectors)?,
            },
        };
        numbers.checked(from, vector_of)
    }

    /// Refuses scales and numbers that do not decode to finite ones.
    fn checked(self, from: Sections, vector_of: impl Iterator<Item = usize>) -> Result<Numbers> {
        let scales = self.scales().unwrap_or_default();
        // Divided by the unit a scale must still be finite.
        if let Some(at) = scales.iter().position(|scale| !(0.0..=f32::MAX * UNIT).contains(scale)) {
            let expected = format!("from 0 to {:e}", f32::MAX * UNIT);
            return Err(broken(from.scales, expected, format!("{:e} at position {at}", scales[at])));
        }
        match vector_of.take(self.len()).enumerate().find(|&(i, v)| !(self.stored(i) * scales[v]).is_finite()) {
            Some((i, vector)) => {
                let found = format!("{} times {:e} at position {i}", self.stored(i), scales[vector]);
                Err(broken(from.numbers, "numbers that times their scale are finite", found))
            }
            None => Ok(self),
        }
    }

    /// `out` = the rows from number `first` on, of which `shape` tells how many and how long, times `lights`: of what is stored, so that the
    /// scales are left to the caller; 16-bit numbers times [`UNIT`].
    pub fn apply_stored(
        &self,
        first: usize,
        shape: Shape,
        lights: ArrayView2<f32>,
        out: ArrayViewMut2<f32>,
    ) -> Result<()> {
        let range = first..first + shape.rows() * shape.lights;
        match self {
            Numbers::F32(values) => dense::apply(&values[range], shape, lights, out),
            Numbers::F16 { halves, .. } => dense::apply_halves(&halves[range], UNIT, shape, lights, out),
            Numbers::I16 { codes, .. } => dense::apply_integers(&codes[range], UNIT, shape, lights, out),
        }
    }

    /// What [`Numbers::apply_stored`] multiplies by beside the scale of a vector.
    pub fn unit(&self) -> f32 {
        self.scales().map_or(1.0, |_| UNIT)
    }
}

/// Where numbers come to lie when vectors are sorted by their scales, each in its order.
fn by_scale(scales: &[f32], vector_of: impl Iterator<Item = usize> + Clone) -> Vec<usize> {
    let mut counts = vec![0usize; scales.len()];
    vector_of.clone().for_each(|vector| counts[vector] += 1);
    let mut sorted: Vec<usize> = (0..scales.len()).collect();
    sorted.sort_by(|a, b| scales[*a].total_cmp(&scales[*b]));
    let mut first = 0;
    for vector in sorted {
        first += std::mem::replace(&mut counts[vector], first);
    }
    let mut place = |vector: usize| {
        counts[vector] += 1;
        counts[vector] - 1
    };
    vector_of.map(&mut place).collect()
}

#[cfg(test)]
mod tests;
