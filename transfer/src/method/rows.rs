//! Whole matrices through a light transform.

use crate::error::Result;
use crate::footprint::{Extent, by};
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::transform::LightTransform;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

/// Rows that are transformed together: a fixed number, so that rounding does not depend on threads, and no more than a few megabytes.
fn block_of(lights: usize) -> usize {
    ((1 << 20) / lights.max(1)).clamp(1, 128)
}

/// Rows, evenly spread, that tell whether C is dense.
const PROBED: usize = 64;

/// C of T ≈ C·B: sparse where T is, unless most of its elements are not 0.
pub fn transform_rows(
    matrix: &TransferMatrix,
    transform: &dyn LightTransform,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    progress.start("transform", matrix.rows() as u64);
    let rows = Rows { matrix, transform };
    let transformed = if matrix.is_sparse() && !rows.fill() { rows.sparse(progress)? } else { rows.dense(progress)? };
    transformed.with_responses(matrix.responses().clone())
}

struct Rows<'a> {
    matrix: &'a TransferMatrix,
    transform: &'a dyn LightTransform,
}

impl Rows<'_> {
    /// Rows of C for consecutive rows of T into `out`.
    fn block(&self, first: usize, out: ArrayViewMut2<f32>) {
        let (lights, count) = (self.matrix.lights(), out.nrows());
        if let Some(values) = self.matrix.as_dense() {
            let from = ArrayView2::from_shape((count, lights), &values[first * lights..][..count * lights]);
            return self.transform.rows_into(from.expect(WHOLE_ROWS), out);
        }
        let mut from = Array2::zeros((count, lights));
        for (mut from, row) in from.outer_iter_mut().zip(first..) {
            self.matrix.gather(row, from.as_slice_mut().expect(WHOLE_ROWS));
        }
        self.transform.rows_into(from.view(), out);
    }

    /// Whether compressed rows of C would take more memory than all of its elements.
    fn fill(&self) -> bool {
        let (rows, to) = (self.matrix.rows(), self.transform.output().lights());
        let (mut non_zeros, mut probed) = (0, 0);
        let mut out = Array2::zeros((1, to));
        for row in (0..rows).step_by(rows.div_ceil(PROBED).max(1)) {
            self.block(row, out.view_mut());
            non_zeros += out.iter().filter(|v| **v != 0.0).count();
            probed += to;
        }
        2 * non_zeros > probed
    }

    fn dense(&self, progress: &dyn Progress) -> Result<TransferMatrix> {
        let (rows, basis) = (self.matrix.rows(), self.transform.output());
        let (to, block) = (basis.lights(), block_of(self.matrix.lights()));
        let mut values = vec![0f32; rows * to];
        values.par_chunks_mut((block * to).max(1)).enumerate().try_for_each(|(i, out)| {
            let count = block.min(rows - i * block);
            self.block(i * block, ArrayViewMut2::from_shape((count, to), out).expect(WHOLE_ROWS));
            progress.advance(count as u64)
        })?;
        TransferMatrix::from_dense(values, rows, self.matrix.shape().responses, basis)
    }

    fn sparse(&self, progress: &dyn Progress) -> Result<TransferMatrix> {
        let (rows, basis) = (self.matrix.rows(), self.transform.output());
        let block = block_of(self.matrix.lights());
        // Blocks keep the sparse rows in order while threads fill them.
        let blocks: Vec<(Vec<usize>, Vec<u32>, Vec<f32>)> = (0..rows.div_ceil(block))
            .into_par_iter()
            .map(|i| {
                let mut out = Array2::zeros((block.min(rows - i * block), basis.lights()));
                self.block(i * block, out.view_mut());
                progress.advance(out.nrows() as u64)?;
                Ok(non_zeros(out.view()))
            })
            .collect::<Result<_>>()?;
        let mut offsets = vec![0];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for (lengths, block_columns, block_values) in blocks {
            for length in lengths {
                offsets.push(offsets[offsets.len() - 1] + length);
            }
            columns.extend(block_columns);
            values.extend(block_values);
        }
        TransferMatrix::from_csr(offsets, columns, values, self.matrix.shape().responses, basis)
    }
}

/// What C of T ≈ C·B is like, and the most bytes held while it is made, itself included. A sparse T stays so where C has as many columns: rows
/// of fewer are mostly full.
pub(super) fn footprint(extent: &Extent, transform: &dyn LightTransform) -> (Extent, u64) {
    let lights = transform.output().lights();
    let shape = Shape { lights, ..extent.shape };
    let sparse = extent.sparse && lights >= extent.shape.lights;
    let cells = extent.rows().saturating_mul(lights as u64);
    // Every edge of what is not 0 costs wavelets of every scale.
    let wavelets = by(1.15, extent.non_zeros) + by(13.0, extent.rows());
    let coefficients = Extent { shape, non_zeros: if sparse { wavelets.min(cells) } else { cells }, sparse };
    let block = block_of(extent.shape.lights) * (extent.shape.lights + lights) * size_of::<f32>();
    // Sparse blocks, each grown to twice its length at worst, beside the whole, which grows too.
    let made = if sparse { by(24.0, coefficients.non_zeros) + by(48.0, extent.rows()) } else { coefficients.bytes() };
    (coefficients, made + (block * rayon::current_num_threads()) as u64)
}

const WHOLE_ROWS: &str = "a block is whole rows";

/// Elements of each row that are not 0, and their columns and values.
fn non_zeros(rows: ArrayView2<f32>) -> (Vec<usize>, Vec<u32>, Vec<f32>) {
    let (mut lengths, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows.outer_iter() {
        let before = columns.len();
        for (col, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            columns.push(col as u32);
            values.push(*value);
        }
        lengths.push(columns.len() - before);
    }
    (lengths, columns, values)
}
