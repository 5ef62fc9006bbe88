//! The number of distinct values: visibility has a handful, interreflection as many as there are elements.

use super::study::Sweep;
use prt_transfer::{Result, TransferMatrix};
use std::f64::consts::TAU;

pub(super) const SWEEP: Sweep = Sweep {
    name: "values",
    title: "Many distinct values: a smooth field on the pattern of visibility, quantised",
    parameter: "levels of the quantised field",
    values: |_| [2.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0, 16384.0, 65536.0].into(),
    matrix: |base, levels| quantised(base, levels as usize),
};

/// The pattern of `base` with values 1/levels, 2/levels, … 1 that vary slowly along rows and columns, as interreflected light
/// does, and not from one to the next, as noise does. Exact in `f32` where `levels` is a power of two up to 2²⁴.
pub fn quantised(base: &TransferMatrix, levels: usize) -> Result<TransferMatrix> {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..base.rows() {
        let along = row as f64 / base.rows() as f64;
        for (col, _) in base.row(row).non_zeros() {
            let level = (field(along, col as f64 / base.lights() as f64) * levels as f64).floor();
            columns.push(col as u32);
            values.push(((1.0 + level.min(levels as f64 - 1.0)) / levels as f64) as f32);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, base.shape().responses, base.basis().clone())
}

/// From 0 to 1, of waves that are a few times as short as the matrix; `u`, `v` from 0 to 1 down and along it.
fn field(u: f64, v: f64) -> f64 {
    0.5 + 0.25 * (TAU * (3.0 * u + v)).sin() + 0.25 * (TAU * (2.0 * v - u)).cos()
}
