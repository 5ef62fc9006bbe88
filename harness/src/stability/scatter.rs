//! Random sparsity: from the pattern of visibility to no pattern at all.

use super::study::Sweep;
use prt_transfer::{Result, TransferMatrix};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub(super) const SWEEP: Sweep = Sweep {
    name: "sparsity",
    title: "Random sparsity: non-zeros moved to random columns of their rows",
    parameter: "fraction of the non-zeros that were moved",
    values: |_| [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0].into(),
    matrix: scattered,
};

const SEED: u64 = 3;

/// `base` with about `fraction` of the non-zeros, chosen at random, moved to free columns of their rows, chosen at random. Every
/// row keeps its values, in another order.
pub fn scattered(base: &TransferMatrix, fraction: f64) -> Result<TransferMatrix> {
    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
    let mut out = vec![0f32; base.lights()];
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..base.rows() {
        base.gather(row, &mut out);
        let places: Vec<usize> = base.row(row).non_zeros().map(|(col, _)| col).collect();
        for &col in places.iter().filter(|_| places.len() < base.lights()) {
            if !rng.random_bool(fraction) {
                continue;
            }
            // There is a free column, so that this ends.
            let free = std::iter::repeat_with(|| rng.random_range(0..base.lights())).find(|&to| out[to] == 0.0);
            if let Some(to) = free {
                out.swap(col, to);
            }
        }
        for (col, &value) in out.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            columns.push(col as u32);
            values.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, base.shape().responses, base.basis().clone())
}
