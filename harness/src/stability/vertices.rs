//! Few vertices, down to one: what neighbours share is not there.

use super::study::{Sweep, doublings};
use prt_transfer::{Result, TransferMatrix};

pub(super) const SWEEP: Sweep = Sweep {
    name: "vertices",
    title: "Few vertices: the rows of the first vertices only",
    parameter: "vertices",
    values: |base| doublings(base.shape().samples.min(MOST)),
    matrix: |base, samples| first_samples(base, samples as usize),
};

/// Far from the end of the curve.
const MOST: usize = 256;

/// The rows of the first `samples` samples; all rows where there are fewer.
pub fn first_samples(base: &TransferMatrix, samples: usize) -> Result<TransferMatrix> {
    let responses = base.shape().responses;
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..base.rows().min(samples * responses) {
        for (col, value) in base.row(row).non_zeros() {
            columns.push(col as u32);
            values.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, responses, base.basis().clone())
}
