//! Rows in narrow widths: what `compact`, `f16` and the single elements of `runs` hold in memory and write, section for section.
//!
//! A sparse matrix keeps the length of each row instead of its offset, in the narrowest integer that holds the longest row,
//! and one offset per block of rows so that threads and lookups can start anywhere; columns take the narrowest integer that
//! holds the last column. A full matrix keeps values alone.

mod pattern;
mod values;
mod whole;

pub(crate) use pattern::{Elements, Pattern};
pub(crate) use values::{ValueSections, Values};
pub(crate) use whole::Whole;

use crate::error::Result;
use crate::flops::{Count, Flops};
use crate::kernel::{self, BLOCK_ROWS, Column, Dictionary, Half, Integer, Plain, RowKernel, Stored};
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::sections::{Sink, Source};
use ndarray::{ArrayView2, ArrayViewMut2};

/// Where the values of a matrix's elements are written.
const ELEMENTS: ValueSections =
    ValueSections { header: "header/layout", codes: "weights/values", table: "weights/table" };

/// A matrix of narrow numbers.
pub(crate) struct Narrow {
    shape: Shape,
    /// Where the values are; `None` where there is one for every row and light.
    pattern: Option<Pattern>,
    values: Values,
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
pub(crate) use with_values;

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
pub(crate) use with_columns;

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

    /// Every element of `matrix`, exactly, in the fewest bytes: sparse or full.
    pub(crate) fn exact(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Narrow> {
        let (shape, cells) = (matrix.shape(), matrix.rows() * matrix.lights());
        let (pattern, values) = Pattern::of(matrix, progress)?;
        let sparse = Narrow::sparse(shape, pattern, Values::narrowest(values));
        // A full matrix takes a byte an element or more.
        if cells < sparse.bytes() {
            let full = Narrow::full(shape, Values::narrowest(all_values(matrix)));
            if full.bytes() < sparse.bytes() {
                return Ok(full);
            }
        }
        Ok(sparse)
    }

    /// Bytes of all sections but the header.
    pub(crate) fn bytes(&self) -> usize {
        self.pattern.as_ref().map_or(0, Pattern::bytes) + self.values.bytes()
    }

    /// Columns of the stored elements of one row of a sparse matrix; none of a full one.
    pub(crate) fn row_columns(&self, row: usize) -> impl Iterator<Item = usize> + '_ {
        self.pattern.iter().flat_map(move |p| p.range(row).map(|i| p.columns.at(i)))
    }

    /// Whether there is a value for every row and light.
    pub(crate) fn is_full(&self) -> bool {
        self.pattern.is_none()
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
        self.values.write(sink, ELEMENTS);
    }

    pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<Narrow> {
        let header: Vec<i32> = source.take_exact("header/layout", 4)?;
        let pattern = match [header[2], header[3]] {
            [0, 0] => None,
            widths => Some(Pattern::read(shape, source, widths)?),
        };
        let count = pattern.as_ref().map_or(shape.rows() * shape.lights, |p| p.columns.len());
        let values = Values::read(source, ELEMENTS, header[0], header[1], count)?;
        Ok(Narrow { shape, pattern, values })
    }
}

/// Every element, row-major.
fn all_values(matrix: &TransferMatrix) -> Vec<f32> {
    match matrix.as_dense() {
        Some(values) => values.to_vec(),
        None => {
            let mut values = vec![0f32; matrix.rows() * matrix.lights()];
            let rows = values.chunks_mut(matrix.lights().max(1)).enumerate();
            rows.for_each(|(row, out)| matrix.gather(row, out));
            values
        }
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
