//! Biclusters of visibility.

mod incoherence;
mod residual;
mod values;

use super::case::Part;
use super::ground::{self, direction, dot};
use ndarray::Array2;
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const PART: Part =
    Part { name: "biclusters", title: "Biclusters", cases: &[residual::CASE, values::CASE, incoherence::CASE] };

/// What 300 places along a path see of the sky between two walls: sparse rows of 0 and 1.
fn visibility() -> Result<TransferMatrix> {
    let basis = LightBasis::Cubemap { resolution: 12 };
    let texels = basis.directions().unwrap_or_default();
    let mut random = Random(71);
    let walls: Vec<[f64; 3]> = (0..5).map(|_| direction(&mut random)).collect();
    let rows = Array2::from_shape_fn((300, texels.len()), |(i, k)| {
        let at = i as f64 / 300.0;
        let free = |(j, wall): (usize, &[f64; 3])| dot(*wall, texels[k]) < 0.35 + 0.5 * (at * (j + 2) as f64).sin();
        f64::from(u8::from(walls.iter().enumerate().all(free)))
    });
    let dense = ground::on(rows.view(), 1, basis.clone())?;
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..dense.rows() {
        for (column, value) in dense.row(row).non_zeros() {
            columns.push(column as u32);
            values.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, 1, basis)
}

/// Operations, as a part of two for each non-zero.
fn operations(label: &str, matrix: &TransferMatrix) -> Result<f64> {
    let flops = ground::encoded(label, matrix)?.flops(&vec![1.0; matrix.lights()])?;
    Ok((flops.multiplications + flops.additions) as f64 / (2 * matrix.non_zeros()) as f64)
}

/// As the paper grows them.
const PAPER: &str = "bicluster:objective=flops:levels=1:seeds=random";
