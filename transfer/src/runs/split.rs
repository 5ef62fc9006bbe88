//! Takes a matrix apart into runs and single elements.

use super::intervals::Intervals;
use crate::error::Result;
use crate::kernel::BLOCK_ROWS;
use crate::matrix::{Row, TransferMatrix};
use crate::narrow::{Elements, Narrow, Values, Whole};
use crate::progress::Progress;

/// A run of equal values in a row: value, first column, columns.
type Run = (f32, usize, usize);

/// The elements that have no equal neighbour, and the runs of those that have.
pub(super) fn split(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<(Narrow, Intervals)> {
    let (shape, rows) = (matrix.shape(), matrix.rows());
    progress.start("encode", rows as u64);
    let mut singles = Elements::new(shape);
    let mut groups = Groups::new(shape.lights);
    let mut runs = Vec::new();
    for row in 0..rows {
        runs_of(matrix.row(row), &mut runs);
        runs.iter().filter(|run| run.2 == 1).for_each(|&(value, start, _)| singles.push(start, value));
        runs.retain(|run| run.2 > 1);
        singles.end_row();
        groups.push_row(row, &mut runs);
        progress.advance(1)?;
    }
    let (pattern, values) = singles.finish();
    Ok((Narrow::sparse(shape, pattern, Values::narrowest(values)), groups.finish()))
}

/// Every maximal run of a row, columns ascending.
fn runs_of(row: Row, runs: &mut Vec<Run>) {
    runs.clear();
    for (col, value) in row.non_zeros() {
        match runs.last_mut() {
            Some((last, start, columns)) if *last == value && *start + *columns == col => *columns += 1,
            _ => runs.push((value, col, 1)),
        }
    }
}

/// Intervals while rows are added.
struct Groups {
    blocks: Vec<[u64; 2]>,
    rows: Vec<u8>,
    counts: Whole,
    values: Vec<f32>,
    starts: Whole,
    lengths: Whole,
}

impl Groups {
    fn new(lights: usize) -> Groups {
        Groups {
            blocks: Vec::new(),
            rows: Vec::new(),
            counts: Whole::up_to(lights),
            values: Vec::new(),
            starts: Whole::up_to(lights.saturating_sub(1)),
            lengths: Whole::up_to(lights),
        }
    }

    /// The runs of the next row, of one value together.
    fn push_row(&mut self, row: usize, runs: &mut [Run]) {
        if row.is_multiple_of(BLOCK_ROWS) {
            self.blocks.push([self.rows.len() as u64, self.starts.len() as u64]);
        }
        // Stable, so that columns ascend within a value.
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        for group in runs.chunk_by(|a, b| a.0 == b.0) {
            self.rows.push((row % BLOCK_ROWS) as u8);
            self.counts.push(group.len());
            self.values.push(group[0].0);
            for &(_, start, columns) in group {
                self.starts.push(start);
                self.lengths.push(columns);
            }
        }
    }

    fn finish(self) -> Intervals {
        let Groups { blocks, mut rows, counts, values, mut starts, lengths } = self;
        rows.shrink_to_fit();
        starts.shrink_to_fit();
        let (counts, lengths) = (counts.narrowed(counts.max()), lengths.narrowed(lengths.max()));
        Intervals { blocks, rows, counts, values: Values::narrowest(values), starts, lengths }
    }
}

/// Less than any sparse form of the matrix takes: a column and a byte for each element, and a byte a row.
pub(super) fn least_sparse_bytes(matrix: &TransferMatrix) -> usize {
    let column = Whole::up_to(matrix.lights().saturating_sub(1)).width() as usize;
    matrix.non_zeros() * (1 + column) + matrix.rows()
}
