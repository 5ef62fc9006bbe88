//! Whole matrices through a light transform.

use crate::error::Result;
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::transform::LightTransform;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

/// Rows that are transformed together: a fixed number, so that rounding does not depend on threads, and no more than a few megabytes.
fn block_of(lights: usize) -> usize {
    ((1 << 20) / lights.max(1)).clamp(1, 128)
}

/// C of T ≈ C·B: sparse where T is.
pub fn transform_rows(
    matrix: &TransferMatrix,
    transform: &dyn LightTransform,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    progress.start("transform", matrix.rows() as u64);
    let transformed = match matrix.as_dense() {
        Some(values) => transform_dense(values, matrix, transform, progress)?,
        None => transform_sparse(matrix, transform, progress)?,
    };
    transformed.with_responses(matrix.responses().clone())
}

fn transform_dense(
    from: &[f32],
    matrix: &TransferMatrix,
    transform: &dyn LightTransform,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    let (rows, lights, basis) = (matrix.rows(), matrix.lights(), transform.output());
    let (to, block) = (basis.lights(), block_of(lights));
    let mut values = vec![0f32; rows * to];
    values.par_chunks_mut((block * to).max(1)).enumerate().try_for_each(|(i, out)| {
        let count = block.min(rows - i * block);
        let from = ArrayView2::from_shape((count, lights), &from[i * block * lights..][..count * lights]);
        let out = ArrayViewMut2::from_shape((count, to), out);
        transform.rows_into(from.expect(WHOLE_ROWS), out.expect(WHOLE_ROWS));
        progress.advance(count as u64)
    })?;
    TransferMatrix::from_dense(values, rows, matrix.shape().responses, basis)
}

const WHOLE_ROWS: &str = "a block is whole rows";

fn transform_sparse(
    matrix: &TransferMatrix,
    transform: &dyn LightTransform,
    progress: &dyn Progress,
) -> Result<TransferMatrix> {
    let (rows, basis) = (matrix.rows(), transform.output());
    let block = block_of(matrix.lights());
    // Blocks keep the sparse rows in order while threads fill them.
    let blocks: Vec<(Vec<usize>, Vec<u32>, Vec<f32>)> = (0..rows.div_ceil(block))
        .into_par_iter()
        .map(|i| {
            let numbers = i * block..rows.min((i + 1) * block);
            let mut from = Array2::zeros((numbers.len(), matrix.lights()));
            for (mut from, row) in from.outer_iter_mut().zip(numbers.clone()) {
                matrix.gather(row, from.as_slice_mut().expect(WHOLE_ROWS));
            }
            let mut out = Array2::zeros((numbers.len(), basis.lights()));
            transform.rows_into(from.view(), out.view_mut());
            progress.advance(numbers.len() as u64)?;
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
    TransferMatrix::from_csr(offsets, columns, values, matrix.shape().responses, basis)
}

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
