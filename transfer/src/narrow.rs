//! Rows in narrow widths: what `compact` and `f16` hold in memory and write, section for section.
//!
//! A sparse matrix keeps the length of each row instead of its offset, in the narrowest integer that holds the longest row,
//! and one offset per block of rows so that threads and lookups can start anywhere; columns take the narrowest integer that
//! holds the last column. A full matrix keeps values alone.

mod values;
mod whole;

pub(crate) use values::Values;
use whole::Whole;

use crate::error::Result;
use crate::flops::{Count, Flops};
use crate::kernel::{self, BLOCK_ROWS, Column, Dictionary, Half, Integer, Plain, RowKernel, Stored};
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::sections::{Sink, Source, broken};
use ndarray::{ArrayView2, ArrayViewMut2};

/// A matrix of narrow numbers.
pub(crate) struct Narrow {
    shape: Shape,
    /// Where the values are; `None` where there is one for every row and light.
    pattern: Option<Pattern>,
    values: Values,
}

/// Places of the stored elements of a sparse matrix.
pub(crate) struct Pattern {
    lengths: Whole,
    /// The first element of every block of [`BLOCK_ROWS`] rows.
    starts: Vec<u64>,
    columns: Whole,
}

/// Evaluates an expression for the values as they are stored.
macro_rules! with_values {
    ($values:expr, $v:ident => $body:expr) => {
        match $values {
            Values::Plain(values) => with_values!(@ $v, Plain(values), $body),
            Values::Half { halves, scale } => with_values!(@ $v, Half { halves, scale: *scale }, $body),
            Values::U8 { codes, scale } => with_values!(@ $v, Integer { codes: &codes[..], scale: *scale }, $body),
            Values::I8 { codes, scale } => with_values!(@ $v, Integer { codes: &codes[..], scale: *scale }, $body),
            Values::U16 { codes, scale } => with_values!(@ $v, Integer { codes: &codes[..], scale: *scale }, $body),
            Values::I16 { codes, scale } => with_values!(@ $v, Integer { codes: &codes[..], scale: *scale }, $body),
            Values::Table8 { codes, table } => with_values!(@ $v, Dictionary { codes: &codes[..], table }, $body),
            Values::Table16 { codes, table } => with_values!(@ $v, Dictionary { codes: &codes[..], table }, $body),
        }
    };
    (@ $v:ident, $stored:expr, $body:expr) => {{
        let $v = $stored;
        $body
    }};
}
pub(super) use with_values;

/// Evaluates an expression for the columns as they are stored.
macro_rules! with_columns {
    ($columns:expr, $c:ident => $body:expr) => {
        match $columns {
            Whole::U8($c) => $body,
            Whole::U16($c) => $body,
            Whole::U32($c) => $body,
        }
    };
}

impl Pattern {
    /// Places of the non-zero elements of `matrix`, and their values in the same order.
    pub(crate) fn of(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<(Pattern, Vec<f32>)> {
        let (rows, lights) = (matrix.rows(), matrix.lights());
        progress.start("encode", rows as u64);
        let (mut lengths, mut columns) = (Whole::up_to(lights), Whole::up_to(lights.saturating_sub(1)));
        let (mut starts, mut values) = (Vec::with_capacity(rows.div_ceil(BLOCK_ROWS)), Vec::new());
        for row in 0..rows {
            if row % BLOCK_ROWS == 0 {
                starts.push(values.len() as u64);
            }
            let before = values.len();
            for (col, value) in matrix.row(row).non_zeros() {
                columns.push(col);
                values.push(value);
            }
            lengths.push(values.len() - before);
            progress.advance(1)?;
        }
        let longest = lengths.max();
        columns.shrink_to_fit();
        Ok((Pattern { lengths: lengths.narrowed(longest), starts, columns }, values))
    }

    /// Bytes of its sections.
    pub(crate) fn bytes(&self) -> usize {
        self.lengths.bytes() + self.columns.bytes() + size_of_val(&self.starts[..])
    }

    /// The elements of one row.
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        let block = row / BLOCK_ROWS;
        let before: usize = (block * BLOCK_ROWS..row).map(|r| self.lengths.at(r)).sum();
        let start = self.starts[block] as usize + before;
        start..start + self.lengths.at(row)
    }

    fn write(&self, sink: &mut Sink) {
        self.lengths.write(sink, "index/lengths");
        sink.put("index/starts", &self.starts);
        self.columns.write(sink, "index/columns");
    }

    fn read(shape: Shape, source: &mut Source, widths: [i32; 2]) -> Result<Pattern> {
        let rows = shape.rows();
        let lengths = Whole::read(source, "index/lengths", widths[0])?;
        if lengths.len() != rows {
            return Err(broken("index/lengths", format!("{rows} numbers"), format!("{} numbers", lengths.len())));
        }
        let starts: Vec<u64> = source.take_exact("index/starts", rows.div_ceil(BLOCK_ROWS))?;
        let columns = Whole::read(source, "index/columns", widths[1])?;
        let mut start = 0usize;
        for row in 0..rows {
            if row % BLOCK_ROWS == 0 && starts[row / BLOCK_ROWS] != start as u64 {
                let found = starts[row / BLOCK_ROWS].to_string();
                return Err(broken("index/starts", format!("{start}, the elements before row {row}"), found));
            }
            // No overflow: each length is below 2^32 and start at most the number of columns, or the loop has ended.
            let end = start + lengths.at(row);
            if end > columns.len() {
                let expected = format!("at least {end} columns, up to row {row}");
                return Err(broken("index/columns", expected, format!("{} columns", columns.len())));
            }
            if !with_columns!(&columns, c => ascending_below(&c[start..end], shape.lights)) {
                return Err(broken(
                    "index/columns",
                    format!("ascending columns below {} in row {row}", shape.lights),
                    format!("{:?}", (start..end.min(start + 8)).map(|i| columns.at(i)).collect::<Vec<_>>()),
                ));
            }
            start = end;
        }
        if start != columns.len() {
            return Err(broken("index/columns", format!("{start} columns"), format!("{} columns", columns.len())));
        }
        Ok(Pattern { lengths, starts, columns })
    }
}

fn ascending_below<I: Column>(columns: &[I], lights: usize) -> bool {
    columns.windows(2).all(|w| w[0].at() < w[1].at()) && columns.last().is_none_or(|c| c.at() < lights)
}

impl Narrow {
    /// Values at the places of a pattern, in its order.
    pub(crate) fn sparse(shape: Shape, pattern: Pattern, values: Values) -> Narrow {
        debug_assert_eq!(pattern.columns.len(), values.len());
        Narrow { shape, pattern: Some(pattern), values }
    }

    /// A value for every row and light, row-major.
    pub(crate) fn full(shape: Shape, values: Values) -> Narrow {
        debug_assert_eq!(shape.rows() * shape.lights, values.len());
        Narrow { shape, pattern: None, values }
    }

    /// Whether values are halves.
    pub(crate) fn is_half(&self) -> bool {
        matches!(self.values, Values::Half { .. })
    }

    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    pub(crate) fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        match &self.pattern {
            Some(_) => kernel::apply(self, self.shape, lights, out),
            None => with_values!(&self.values, v => kernel::dense::apply_stored(v, self.shape, lights, out)),
        }
    }

    pub(crate) fn row_into(&self, row: usize, out: &mut [f32]) {
        let Some(pattern) = &self.pattern else {
            return self.values.decode_into(row * self.shape.lights, out);
        };
        out.fill(0.0);
        pattern.range(row).for_each(|i| out[pattern.columns.at(i)] = self.values.at(i));
    }

    pub(crate) fn flops(&self, light: &[f32]) -> Flops {
        kernel::count(self, self.shape, light)
    }

    pub(crate) fn write(&self, sink: &mut Sink) {
        let (kind, exponent) = self.values.kind();
        let [lengths, columns] = self.pattern.as_ref().map_or([0; 2], |p| [p.lengths.width(), p.columns.width()]);
        sink.put("header/layout", &[kind, exponent, lengths, columns]);
        if let Some(pattern) = &self.pattern {
            pattern.write(sink);
        }
        self.values.write(sink);
    }

    pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<Narrow> {
        let header: Vec<i32> = source.take_exact("header/layout", 4)?;
        let pattern = match [header[2], header[3]] {
            [0, 0] => None,
            widths => Some(Pattern::read(shape, source, widths)?),
        };
        let count = pattern.as_ref().map_or(shape.rows() * shape.lights, |p| p.columns.len());
        let values = Values::read(source, header[0], header[1], count)?;
        Ok(Narrow { shape, pattern, values })
    }
}

impl RowKernel for Narrow {
    fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], count: &mut C) -> [f32; N] {
        let lights = self.shape.lights;
        let range = self.pattern.as_ref().map_or(row * lights..(row + 1) * lights, |p| p.range(row));
        count.multiply_add(range.len());
        count.factors(range.clone().map(|i| self.values.at(i)));
        let Some(pattern) = &self.pattern else {
            let mut y = [0.0; N];
            let terms = range.zip(x);
            terms.for_each(|(i, x)| y.iter_mut().zip(x).for_each(|(y, x)| *y += self.values.at(i) * x));
            return y;
        };
        with_columns!(&pattern.columns, c => with_values!(&self.values, v => {
            // SAFETY: `Pattern::of` and `Pattern::read` see to columns below lights = x.len(); there is a value for each.
            unsafe { kernel::dot(&c[range.clone()], v.from(range.start), x) }
        }))
    }

    fn block<const N: usize>(&self, first: usize, x: &[[f32; N]], out: &mut [[f32; N]]) {
        let Some(pattern) = &self.pattern else {
            return kernel::each_row(self, first, x, out);
        };
        let (mut ends, mut end) = ([0u32; BLOCK_ROWS], 0);
        let ends = &mut ends[..out.len()];
        with_columns!(&pattern.lengths, lengths => {
            for (e, length) in ends.iter_mut().zip(&lengths[first..]) {
                end += length.at() as u32;
                *e = end;
            }
        });
        let start = pattern.starts[first / BLOCK_ROWS] as usize;
        with_columns!(&pattern.columns, c => with_values!(&self.values, v => {
            // SAFETY: ends ascend to this block's last column; columns are checked as above.
            unsafe { kernel::rows_of(ends, &c[start..], v.from(start), x, out) }
        }));
    }
}
