//! Haar wavelets on the cubemap: Ng et al. 2003.

mod flicker;
mod solid_angles;

use super::case::Part;
use super::ground::{self, direction, dot};
use ndarray::Array2;
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const PART: Part =
    Part { name: "wavelets", title: "Haar wavelets", cases: &[solid_angles::CASE, flicker::CASE] };

/// Transfer of 40 surfaces with solid angles, as `diffuse` and `terms` have it.
fn rows(resolution: usize) -> Result<TransferMatrix> {
    let basis = LightBasis::Cubemap { resolution };
    let (texels, angles) = (basis.directions().unwrap_or_default(), basis.solid_angles().unwrap_or_default());
    let mut random = Random(61);
    let normals: Vec<_> = (0..40).map(|_| (direction(&mut random), 4.0 + 60.0 * random.uniform())).collect();
    let rows = Array2::from_shape_fn((normals.len(), texels.len()), |(i, k)| {
        dot(normals[i].0, texels[k]).max(0.0).powf(normals[i].1) * angles[k]
    });
    ground::on(rows.view(), 1, basis)
}
