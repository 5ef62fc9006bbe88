//! Numbers as they are stored: single precision, or 16 bits and a scale for each vector of them.

use crate::error::Result;
use crate::kernel::dense;
use crate::matrix::Shape;
use crate::sections::broken;
use crate::sections::{Sink, Source};
use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::{ArrayView2, ArrayViewMut2};
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
            Numbers::I16 { codes: each.map(|(&v, vector)| code(v, scales[vector])).collect(), scales }
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
        let codes = values.iter().zip(vector_of).map(|(&v, vector)| code(v, scales[vector])).collect();
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

/// The exponent of the highest bit of a positive number: ⌊log2⌋.
fn magnitude(value: f64) -> i32 {
    // f64 holds every f32 and its parts as normal numbers.
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

fn scale_of_halves(largest: f32) -> f32 {
    // Below 2^-126 halves are finer than f32.
    let exponent = if largest == 0.0 { 0 } else { (magnitude(largest.into()) - 14).max(-126) };
    2f64.powi(exponent) as f32
}

fn halve(value: f32, scale: f32) -> f16 {
    let half = f16::from_f32((f64::from(value) / f64::from(scale)) as f32);
    // Only beside f32::MAX can rounding up leave f32's range.
    if (half.to_f32() * scale).is_finite() { half } else { f16::from_bits(half.to_bits() - 1) }
}

fn scale_of_codes(largest: f32) -> f32 {
    if largest == 0.0 {
        return 0.0;
    }
    let scale = f64::from(largest) / f64::from(i16::MAX);
    // Nine bits times the fifteen of a code are the 24 of an f32; nothing is below 2^-149.
    let last_bit = 2f64.powi((magnitude(scale) - 8).max(-149));
    ((scale / last_bit).ceil() * last_bit) as f32
}

/// At most `step`, in nine bits; 0 where it is none.
fn scale_of_step(step: f64) -> f32 {
    if !(step > 0.0 && step < f64::from(f32::MAX * UNIT)) {
        return 0.0;
    }
    let last_bit = 2f64.powi((magnitude(step) - 8).max(-149));
    ((step / last_bit).floor() * last_bit) as f32
}

fn code(value: f32, scale: f32) -> i16 {
    if scale == 0.0 {
        return 0;
    }
    let code = (f64::from(value) / f64::from(scale)).round() as i16;
    // As in `halve`.
    if (f32::from(code) * scale).is_finite() { code } else { code - code.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SECTIONS: Sections = Sections { numbers: "weights/numbers", scales: "weights/scales" };

    /// Finite numbers of every size, many of them near each other, some at the ends of `f32`.
    fn vector() -> impl Strategy<Value = Vec<f32>> {
        let any = (any::<bool>(), -149f64..=127.99).prop_map(|(n, e)| if n { -1.0 } else { 1.0 } * e.exp2() as f32);
        let end = prop::sample::select(vec![0.0, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, f32::from_bits(1), -0.0]);
        let near =
            (-149f64..=127.0).prop_flat_map(|e| prop::collection::vec(-e.exp2() as f32..=e.exp2() as f32, 0..40));
        prop_oneof![prop::collection::vec(prop_oneof![any, end], 0..40), near]
    }

    fn stored(values: &[f32], width: Width) -> Numbers {
        Numbers::store(values, width, 1, std::iter::repeat(0))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn errors_keep_their_bounds_and_what_is_decoded_is_finite_and_read_again(values in vector()) {
            let largest = values.iter().fold(0f32, |m, v| m.max(v.abs()));
            for width in [Width::F32, Width::F16, Width::I16] {
                let numbers = stored(&values, width);
                let scale = f64::from(numbers.scale(0));
                for (&v, d) in values.iter().zip(numbers.decode(std::iter::repeat(0))) {
                    prop_assert!(d.is_finite());
                    // Beside f32::MAX numbers are rounded towards 0: a whole step.
                    let whole = if largest > 0.99 * f32::MAX { 2.0 } else { 1.0 };
                    let bound = match width {
                        Width::F32 => 0.0,
                        Width::F16 => {
                            let of_largest = f64::from(largest) * 2f64.powi(-39);
                            (f64::from(v.abs()) * 2f64.powi(-11)).max(of_largest) * whole
                        }
                        Width::I16 => scale / 2.0 * whole,
                    };
                    let error = (f64::from(v) - f64::from(d)).abs();
                    prop_assert!(error <= bound * (1.0 + 1e-9), "{width:?}: {v:e} {d:e} of {largest:e}");
                }
                if width == Width::I16 {
                    prop_assert!(scale <= f64::from(largest) / 32767.0 * (1.0 + 2f64.powi(-8)) + 2f64.powi(-149));
                }
                let mut sink = Sink::new();
                numbers.write(&mut sink, SECTIONS);
                let mut source = Source::new(sink.into_sections()).unwrap();
                let count = [values.len(), 1];
                let read = Numbers::read(&mut source, SECTIONS, width, count, std::iter::repeat(0));
                prop_assert_eq!(read.unwrap(), numbers);
            }
        }

        #[test]
        fn coarse_numbers_keep_their_steps_and_come_back_from_sorted_sections(
            values in prop::collection::vec(-1e3f32..=1e3, 0..60), exponents in prop::collection::vec(-20i32..10, 3),
        ) {
            let steps: Vec<f64> = exponents.iter().map(|e| 1.1 * f64::from(*e).exp2()).collect();
            let vector_of = (0..values.len()).map(|i| i * i % 3);
            let numbers = Numbers::store_coarse(&values, &steps, vector_of.clone());
            for ((value, decoded), vector) in values.iter().zip(numbers.decode(vector_of.clone())).zip(vector_of.clone()) {
                // A step is never coarser than asked for, unless 16 bits do not reach so far.
                let finest = 1e3 / 32767.0 * (1.0 + 2f64.powi(-8));
                let error = (f64::from(*value) - f64::from(decoded)).abs();
                prop_assert!(error <= steps[vector].max(finest) / 2.0 * (1.0 + 1e-6), "{value} {decoded} {vector}");
            }
            for numbers in [numbers, Numbers::store(&values, Width::F16, 3, vector_of.clone())] {
                let mut sink = Sink::new();
                numbers.write_sorted(&mut sink, SECTIONS, vector_of.clone());
                let mut source = Source::new(sink.into_sections()).unwrap();
                let (width, count) = (numbers.width(), [values.len(), 3]);
                let read = Numbers::read_sorted(&mut source, SECTIONS, width, count, vector_of.clone());
                prop_assert_eq!(read.unwrap(), numbers);
            }
        }
    }

    #[test]
    fn numbers_of_zero_and_of_one_size_come_back_exactly() {
        for values in [vec![0.0; 5], vec![3.0, -3.0, 3.0], vec![f32::from_bits(1), f32::from_bits(7)]] {
            for width in [Width::F16, Width::I16] {
                let decoded = stored(&values, width).decode(std::iter::repeat(0));
                let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-4 * a.abs();
                assert!(decoded.iter().zip(&values).all(close), "{width:?}: {decoded:?} for {values:?}");
                assert!(values[0] != 0.0 || decoded == values);
            }
        }
    }

    #[test]
    fn products_that_overflow_are_refused() {
        let read = |codes: &[i16], scale: f32| {
            let mut sink = Sink::new();
            sink.put(SECTIONS.numbers, codes);
            sink.put(SECTIONS.scales, &[scale]);
            let mut source = Source::new(sink.into_sections()).unwrap();
            Numbers::read(&mut source, SECTIONS, Width::I16, [codes.len(), 1], std::iter::repeat_n(0, codes.len()))
        };
        assert!(read(&[1, -32768], 1e34).is_ok());
        let refused = [read(&[1, 32767], 1.1e34), read(&[0], -1.0), read(&[0], f32::NAN), read(&[0], 3e34)];
        assert!(refused.iter().all(Result::is_err));
    }
}
