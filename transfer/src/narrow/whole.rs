//! Unsigned integers, all of the narrowest width that holds their maximum.

use crate::error::Result;
use crate::kernel::Column;
use crate::sections::{Sink, Source, broken};

/// Columns, row lengths or table indices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Whole {
    U8(Vec<u8>),
    U16(Vec<u16>),
    U32(Vec<u32>),
}

/// Evaluates an expression for whichever width there is.
macro_rules! each_width {
    ($whole:expr, $numbers:ident => $body:expr) => {
        match $whole {
            Whole::U8($numbers) => $body,
            Whole::U16($numbers) => $body,
            Whole::U32($numbers) => $body,
        }
    };
}

impl Whole {
    /// None yet, of the width that holds `max`.
    pub(crate) fn up_to(max: usize) -> Whole {
        match max {
            0..=0xff => Whole::U8(Vec::new()),
            0x100..=0xffff => Whole::U16(Vec::new()),
            _ => Whole::U32(Vec::new()),
        }
    }

    /// The same numbers in the width that holds `max`, which is at least their maximum.
    pub(crate) fn narrowed(&self, max: usize) -> Whole {
        match max {
            0..=0xff => Whole::U8((0..self.len()).map(|i| self.at(i) as u8).collect()),
            0x100..=0xffff => Whole::U16((0..self.len()).map(|i| self.at(i) as u16).collect()),
            _ => Whole::U32((0..self.len()).map(|i| self.at(i) as u32).collect()),
        }
    }

    /// Appends a number, which the width holds.
    pub(crate) fn push(&mut self, number: usize) {
        match self {
            Whole::U8(numbers) => numbers.push(number as u8),
            Whole::U16(numbers) => numbers.push(number as u16),
            Whole::U32(numbers) => numbers.push(number as u32),
        }
    }

    pub(crate) fn shrink_to_fit(&mut self) {
        each_width!(self, numbers => numbers.shrink_to_fit());
    }

    pub(crate) fn len(&self) -> usize {
        each_width!(self, numbers => numbers.len())
    }

    pub(crate) fn at(&self, i: usize) -> usize {
        each_width!(self, numbers => numbers[i].at())
    }

    pub(crate) fn max(&self) -> usize {
        each_width!(self, numbers => numbers.iter().max().map_or(0, |n| n.at()))
    }

    /// Bytes of one number.
    pub(crate) fn width(&self) -> i32 {
        match self {
            Whole::U8(_) => 1,
            Whole::U16(_) => 2,
            Whole::U32(_) => 4,
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.len() * self.width() as usize
    }

    pub(crate) fn write(&self, sink: &mut Sink, name: &str) {
        each_width!(self, numbers => sink.put(name, numbers));
    }

    /// The numbers of a section, however many, of a width that the section `header` tells.
    pub(crate) fn read(source: &mut Source, name: &str, header: &str, width: i32) -> Result<Whole> {
        Ok(match width {
            1 => Whole::U8(source.take(name)?),
            2 => Whole::U16(source.take(name)?),
            4 => Whole::U32(source.take(name)?),
            _ => return Err(broken(header, format!("1, 2 or 4 bytes for {name}"), width.to_string())),
        })
    }
}
