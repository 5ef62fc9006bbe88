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

/// What 300 places along a path see of the sky between walls: rows of 0 and 1, of which sweeps take the non-zeros.
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
    ground::on(rows.view(), 1, basis)
}

/// Operations, as a part of two for each non-zero.
fn operations(label: &str, matrix: &TransferMatrix) -> Result<f64> {
    let flops = ground::encoded(label, matrix)?.flops(&vec![1.0; matrix.lights()])?;
    Ok((flops.multiplications + flops.additions) as f64 / (2 * matrix.non_zeros()) as f64)
}

/// As the paper grows them.
const PAPER: &str = "bicluster:objective=flops:levels=1:seeds=random";
