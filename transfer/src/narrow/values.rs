//! Values in the narrowest exact form, or as scaled halves.

use super::with_values;
use crate::error::Result;
use crate::kernel::{Column, Dictionary, Half, Integer, Plain, Stored};
use crate::sections::{Sink, Source, broken};
use bytemuck::Pod;
use half::f16;
use rayon::prelude::*;
use std::collections::HashSet;

/// Stored values. A scale is a power of two, so that multiplying by it is exact.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    Plain(Vec<f32>),
    Half { halves: Vec<f16>, scale: f32 },
    U8 { codes: Vec<u8>, scale: f32 },
    I8 { codes: Vec<i8>, scale: f32 },
    U16 { codes: Vec<u16>, scale: f32 },
    I16 { codes: Vec<i16>, scale: f32 },
    Table8 { codes: Vec<u8>, table: Vec<f32> },
    Table16 { codes: Vec<u16>, table: Vec<f32> },
}

/// Names of the sections that stored values appear in.
#[derive(Clone, Copy)]
pub(crate) struct ValueSections {
    /// Where the form and its exponent are written, for messages.
    pub(crate) header: &'static str,
    /// One number for each value.
    pub(crate) codes: &'static str,
    /// What codes of a table stand for.
    pub(crate) table: &'static str,
}

/// Entries that 16-bit codes can name.
const MAX_TABLE: usize = 1 << 16;

impl Values {
    /// The fewest bytes that give every finite value back bit for bit, up to the sign of zero.
    pub(crate) fn narrowest(values: Vec<f32>) -> Values {
        let grid = Grid::of(&values);
        if let Some(bytes) = grid.bytes(&values) {
            return bytes;
        }
        // 1, 2 and 4 bytes for each value, and 4 for each entry of a table.
        let (n, table) = (values.len(), distinct(&values));
        let table_bytes = table.as_ref().map(|t| n * if t.len() <= 256 { 1 } else { 2 } + 4 * t.len());
        let table_below = |bytes: usize| table.as_ref().filter(|_| table_bytes.is_some_and(|b| b < bytes));
        if let Some(table) = table_below(2 * n) {
            return Values::looked_up(&values, table);
        }
        if let Some(words) = grid.words(&values) {
            return words;
        }
        let halves = Values::halves(&values);
        if with_values!(&halves, h => exact(h, &values)) {
            return halves;
        }
        match table_below(4 * n) {
            Some(table) => Values::looked_up(&values, table),
            None => Values::Plain(values),
        }
    }

    /// Half precision, scaled by a power of two so that the largest magnitude lies in [2^14, 2^15): nothing overflows, and
    /// whatever is above 2^-28 of the largest keeps a relative precision of 2^-11.
    pub(crate) fn halves(values: &[f32]) -> Values {
        let largest = values.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
        // Below 2^-126 the scale would not be a normal number; there halves are finer than f32 anyway.
        let exponent = if largest == 0.0 { 0 } else { (magnitude(largest) - 14).max(-126) };
        let (scale, inverse) = (power_of_two(exponent), 2f64.powi(-exponent));
        let halve = |&v: &f32| {
            let half = f16::from_f64(f64::from(v) * inverse);
            // Only beside f32::MAX can rounding up leave f32's range.
            if (half.to_f32() * scale).is_finite() { half } else { f16::from_bits(half.to_bits() - 1) }
        };
        Values::Half { halves: values.par_iter().map(halve).collect(), scale }
    }

    fn looked_up(values: &[f32], table: &[f32]) -> Values {
        let code = |v: &f32| table.partition_point(|t| t < v);
        if table.len() <= 256 {
            Values::Table8 { codes: values.par_iter().map(|v| code(v) as u8).collect(), table: table.to_vec() }
        } else {
            Values::Table16 { codes: values.par_iter().map(|v| code(v) as u16).collect(), table: table.to_vec() }
        }
    }

    pub(crate) fn len(&self) -> usize {
        with_values!(self, v => v.len())
    }

    /// Value `i`, which must be below the length.
    pub(crate) fn at(&self, i: usize) -> f32 {
        assert!(i < self.len(), "value {i} of {}", self.len());
        // SAFETY: just checked.
        with_values!(self, v => unsafe { v.at(i) })
    }

    /// Writes the values from `first` on into `out`.
    pub(crate) fn decode_into(&self, first: usize, out: &mut [f32]) {
        with_values!(self, v => {
            let v = v.from(first);
            assert!(out.len() <= v.len(), "{} values of {}", out.len(), v.len());
            // SAFETY: just checked.
            out.iter_mut().enumerate().for_each(|(i, y)| *y = unsafe { v.at(i) });
        });
    }

    /// Bytes of its sections.
    pub(crate) fn bytes(&self) -> usize {
        let (codes, table) = match self {
            Values::Plain(values) => (size_of_val(&values[..]), 0),
            Values::Half { halves, .. } => (size_of_val(&halves[..]), 0),
            Values::U8 { codes, .. } => (codes.len(), 0),
            Values::I8 { codes, .. } => (codes.len(), 0),
            Values::U16 { codes, .. } => (size_of_val(&codes[..]), 0),
            Values::I16 { codes, .. } => (size_of_val(&codes[..]), 0),
            Values::Table8 { codes, table } => (codes.len(), table.len()),
            Values::Table16 { codes, table } => (size_of_val(&codes[..]), table.len()),
        };
        codes + table * size_of::<f32>()
    }

    /// The form's number in a header, and the exponent of its scale.
    pub(crate) fn kind(&self) -> (i32, i32) {
        match self {
            Values::Plain(_) => (0, 0),
            Values::Half { scale, .. } => (1, magnitude(*scale)),
            Values::U8 { scale, .. } => (2, magnitude(*scale)),
            Values::I8 { scale, .. } => (3, magnitude(*scale)),
            Values::U16 { scale, .. } => (4, magnitude(*scale)),
            Values::I16 { scale, .. } => (5, magnitude(*scale)),
            Values::Table8 { .. } => (6, 0),
            Values::Table16 { .. } => (7, 0),
        }
    }

    pub(crate) fn write(&self, sink: &mut Sink, to: ValueSections) {
        match self {
            Values::Plain(values) => sink.put(to.codes, values),
            Values::Half { halves, .. } => sink.put(to.codes, halves),
            Values::U8 { codes, .. } => sink.put(to.codes, codes),
            Values::I8 { codes, .. } => sink.put(to.codes, codes),
            Values::U16 { codes, .. } => sink.put(to.codes, codes),
            Values::I16 { codes, .. } => sink.put(to.codes, codes),
            Values::Table8 { codes, table } => {
                sink.put(to.codes, codes);
                sink.put(to.table, table);
            }
            Values::Table16 { codes, table } => {
                sink.put(to.codes, codes);
                sink.put(to.table, table);
            }
        }
    }

    /// The `count` values of a form that the header names.
    pub(crate) fn read(
        source: &mut Source,
        from: ValueSections,
        kind: i32,
        exponent: i32,
        count: usize,
    ) -> Result<Values> {
        let header = |expected: &str, found: i32| broken(from.header, expected, found.to_string());
        let scaled = matches!(kind, 1..=5);
        if !(-149..=127).contains(&exponent) || (!scaled && exponent != 0) {
            return Err(header("an exponent from -149 to 127, 0 without a scale", exponent));
        }
        let scale = power_of_two(exponent);
        let values = match kind {
            0 => Values::Plain(source.take_exact(from.codes, count)?),
            1 => Values::Half { halves: source.take_exact(from.codes, count)?, scale },
            2 => Values::U8 { codes: source.take_exact(from.codes, count)?, scale },
            3 => Values::I8 { codes: source.take_exact(from.codes, count)?, scale },
            4 => Values::U16 { codes: source.take_exact(from.codes, count)?, scale },
            5 => Values::I16 { codes: source.take_exact(from.codes, count)?, scale },
            6 => {
                let (codes, table) = read_table::<u8>(source, from, count)?;
                Values::Table8 { codes, table }
            }
            7 => {
                let (codes, table) = read_table::<u16>(source, from, count)?;
                Values::Table16 { codes, table }
            }
            _ => return Err(header("a form of values from 0 to 7", kind)),
        };
        match (0..count).into_par_iter().position_first(|i| !values.at(i).is_finite()) {
            Some(i) => Err(broken(from.codes, "finite numbers", format!("{} at position {i}", values.at(i)))),
            None => Ok(values),
        }
    }
}

fn read_table<T: Pod + Column>(source: &mut Source, from: ValueSections, count: usize) -> Result<(Vec<T>, Vec<f32>)> {
    let codes: Vec<T> = source.take_exact(from.codes, count)?;
    let table: Vec<f32> = source.take(from.table)?;
    match codes.iter().position(|c| c.at() >= table.len()) {
        Some(i) => {
            let found = format!("{} at position {i}", codes[i].at());
            Err(broken(from.codes, format!("codes below {}, the entries of {}", table.len(), from.table), found))
        }
        None if table.iter().any(|v| !v.is_finite()) => Err(broken(from.table, "finite numbers", "another")),
        None => Ok((codes, table)),
    }
}

/// The coarsest grid of a power of two that every value lies on, and the range of the multiples.
struct Grid {
    exponent: i32,
    lowest: f64,
    highest: f64,
}

impl Grid {
    fn of(values: &[f32]) -> Grid {
        let all = |a: (i32, f32, f32), b: (i32, f32, f32)| (a.0.min(b.0), a.1.min(b.1), a.2.max(b.2));
        let none = || (i32::MAX, 0f32, 0f32);
        let (exponent, lowest, highest) =
            values.par_iter().filter(|v| **v != 0.0).map(|&v| (last_bit(v), v, v)).reduce(none, all);
        let exponent = if exponent == i32::MAX { 0 } else { exponent };
        let step = 2f64.powi(exponent);
        Grid { exponent, lowest: f64::from(lowest) / step, highest: f64::from(highest) / step }
    }

    fn within(&self, lowest: i32, highest: i32) -> bool {
        self.lowest >= f64::from(lowest) && self.highest <= f64::from(highest)
    }

    fn codes<T: Send>(&self, values: &[f32], to: impl Fn(f64) -> T + Sync) -> (Vec<T>, f32) {
        let inverse = 2f64.powi(-self.exponent);
        (values.par_iter().map(|&v| to(f64::from(v) * inverse)).collect(), power_of_two(self.exponent))
    }

    /// One byte a value, where that is exact.
    fn bytes(&self, values: &[f32]) -> Option<Values> {
        if self.within(0, 0xff) {
            let (codes, scale) = self.codes(values, |k| k as u8);
            Some(Values::U8 { codes, scale })
        } else if self.within(-0x80, 0x7f) {
            let (codes, scale) = self.codes(values, |k| k as i8);
            Some(Values::I8 { codes, scale })
        } else {
            None
        }
    }

    /// Two bytes a value, where that is exact.
    fn words(&self, values: &[f32]) -> Option<Values> {
        if self.within(0, 0xffff) {
            let (codes, scale) = self.codes(values, |k| k as u16);
            Some(Values::U16 { codes, scale })
        } else if self.within(-0x8000, 0x7fff) {
            let (codes, scale) = self.codes(values, |k| k as i16);
            Some(Values::I16 { codes, scale })
        } else {
            None
        }
    }
}

/// Whether stored values are these values.
fn exact<V: Stored>(stored: V, values: &[f32]) -> bool {
    // SAFETY: i < values.len(), for each of which one is stored.
    stored.len() == values.len() && values.par_iter().enumerate().all(|(i, v)| unsafe { stored.at(i) } == *v)
}

/// The distinct values, ascending, where 16-bit codes can name them. Both zeros are one.
fn distinct(values: &[f32]) -> Option<Vec<f32>> {
    let mut seen = HashSet::new();
    for &v in values {
        if seen.insert((v + 0.0).to_bits()) && seen.len() > MAX_TABLE {
            return None;
        }
    }
    let mut table: Vec<f32> = seen.into_iter().map(f32::from_bits).collect();
    table.sort_unstable_by(f32::total_cmp);
    Some(table)
}

/// The exponent of the highest bit of a positive number: floor(log2).
fn magnitude(value: f32) -> i32 {
    // f64 holds every f32 as a normal number.
    ((f64::from(value).to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// The exponent of the lowest bit that is set in a number other than 0.
fn last_bit(value: f32) -> i32 {
    let bits = f64::from(value).to_bits();
    let (exponent, fraction) = (((bits >> 52) & 0x7ff) as i32 - 1023, bits & ((1 << 52) - 1));
    exponent - 52 + (fraction | 1 << 52).trailing_zeros() as i32
}

/// 2^exponent for exponents from -149 to 127, exactly.
fn power_of_two(exponent: i32) -> f32 {
    2f64.powi(exponent) as f32
}
