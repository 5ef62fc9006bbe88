//! Which elements of a sparse matrix are stored.

use super::{Whole, with_columns};
use crate::error::Result;
use crate::kernel::{BLOCK_ROWS, Column};
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::sections::{Sink, Source, broken};

/// Places of the stored elements of a sparse matrix.
pub(crate) struct Pattern {
    pub(super) lengths: Whole,
    /// The first element of every block of [`BLOCK_ROWS`] rows.
    pub(super) starts: Vec<u64>,
    pub(super) columns: Whole,
}

impl Pattern {
    /// Places of the non-zero elements of `matrix`, and their values in the same order.
    pub(crate) fn of(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<(Pattern, Vec<f32>)> {
        progress.start("encode", matrix.rows() as u64);
        let mut elements = Elements::new(matrix.shape());
        for row in 0..matrix.rows() {
            matrix.row(row).non_zeros().for_each(|(col, value)| elements.push(col, value));
            elements.end_row();
            progress.advance(1)?;
        }
        Ok(elements.finish())
    }

    /// Bytes of its sections.
    pub(crate) fn bytes(&self) -> usize {
        self.lengths.bytes() + self.columns.bytes() + size_of_val(&self.starts[..])
    }

    /// The elements of one row.
    pub(super) fn range(&self, row: usize) -> std::ops::Range<usize> {
        let block = row / BLOCK_ROWS;
        let before: usize = (block * BLOCK_ROWS..row).map(|r| self.lengths.at(r)).sum();
        let start = self.starts[block] as usize + before;
        start..start + self.lengths.at(row)
    }

    pub(super) fn write(&self, sink: &mut Sink) {
        self.lengths.write(sink, "index/lengths");
        sink.put("index/starts", &self.starts);
        self.columns.write(sink, "index/columns");
    }

    pub(super) fn read(shape: Shape, source: &mut Source, widths: [i32; 2]) -> Result<Pattern> {
        let rows = shape.rows();
        let lengths = Whole::read(source, "index/lengths", "header/layout", widths[0])?;
        if lengths.len() != rows {
            return Err(broken("index/lengths", format!("{rows} numbers"), format!("{} numbers", lengths.len())));
        }
        let starts: Vec<u64> = source.take_exact("index/starts", rows.div_ceil(BLOCK_ROWS))?;
        let columns = Whole::read(source, "index/columns", "header/layout", widths[1])?;
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

/// Collects a pattern and its values, row by row.
pub(crate) struct Elements {
    pattern: Pattern,
    values: Vec<f32>,
    /// Elements before this row.
    before: usize,
}

impl Elements {
    /// Nothing yet, for the rows of a matrix of this shape.
    pub(crate) fn new(shape: Shape) -> Elements {
        let (lengths, columns) = (Whole::up_to(shape.lights), Whole::up_to(shape.lights.saturating_sub(1)));
        let starts = Vec::with_capacity(shape.rows().div_ceil(BLOCK_ROWS));
        Elements { pattern: Pattern { lengths, starts, columns }, values: Vec::new(), before: 0 }
    }

    /// The next element of this row; columns ascend.
    pub(crate) fn push(&mut self, col: usize, value: f32) {
        self.pattern.columns.push(col);
        self.values.push(value);
    }

    /// Goes on to the next row.
    pub(crate) fn end_row(&mut self) {
        if self.pattern.lengths.len().is_multiple_of(BLOCK_ROWS) {
            self.pattern.starts.push(self.before as u64);
        }
        self.pattern.lengths.push(self.values.len() - self.before);
        self.before = self.values.len();
    }

    /// The pattern in its narrowest widths, and the values.
    pub(crate) fn finish(self) -> (Pattern, Vec<f32>) {
        let Elements { mut pattern, values, .. } = self;
        pattern.lengths = pattern.lengths.narrowed(pattern.lengths.max());
        pattern.columns.shrink_to_fit();
        (pattern, values)
    }
}

fn ascending_below<I: Column>(columns: &[I], lights: usize) -> bool {
    columns.windows(2).all(|w| w[0].at() < w[1].at()) && columns.last().is_none_or(|c| c.at() < lights)
}
