//! Spherical radial basis functions: Tsai and Shih 2006, §3 and §4.

mod abel_poisson;
mod coincident;
mod flat;
mod overflow;

use super::case::Part;
use super::ground::{self, direction, dot};
use ndarray::Array2;
use prt_srbf::Kernel;
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, TransferMatrix};
use std::f64::consts::PI;

pub(super) const PART: Part = Part {
    name: "lobes",
    title: "Spherical radial basis functions",
    cases: &[overflow::CASE, abel_poisson::CASE, flat::CASE, coincident::CASE],
};

/// ∫ G_g G_h dω of lobes with this cosine between their centres, by Legendre series (Eq. 2): another way than the closed forms.
fn series(kernel: Kernel, [g, h]: [f64; 2], mu: f64, count: usize) -> f64 {
    let [a, b] = [g, h].map(|bandwidth| kernel.legendre(bandwidth, count));
    let (mut before, mut this, mut sum) = (0.0, 1.0, 0.0);
    for l in 0..count {
        sum += a[l] * b[l] * 4.0 * PI / (2 * l + 1) as f64 * this;
        (before, this) = (this, ((2 * l + 1) as f64 * mu * this - l as f64 * before) / (l + 1) as f64);
    }
    sum
}

/// Surfaces under a sky, some of them behind a window: 40 rows on a cubemap of 6 x 16 x 16 texels.
fn rows() -> Result<TransferMatrix> {
    let basis = LightBasis::Cubemap { resolution: 16 };
    let texels = basis.directions().unwrap_or_default();
    let mut random = Random(8);
    let normals: Vec<_> = (0..40).map(|_| (direction(&mut random), 1.0 + 20.0 * random.uniform())).collect();
    let rows = Array2::from_shape_fn((normals.len(), texels.len()), |(i, k)| {
        dot(normals[i].0, texels[k]).max(0.0).powf(normals[i].1)
    });
    ground::on(rows.view(), 1, basis)
}
