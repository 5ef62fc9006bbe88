//! Half of a latitude-longitude grid's directions crowd around its poles, where there is little of the sphere.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{self, dot};
use ndarray::{Array1, Array2, Axis};
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, linalg};

pub(super) const CASE: Case = Case {
    name: "poles",
    title: "Directions that crowd around the poles",
    source: "Miandji et al. 2011, §3.1: latitude-longitude samples, all alike",
    parameter: "directions from pole to pole",
    values: &[4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0],
    quantity: "squared error over the sphere beyond the least of 4 components, relative",
    printed: Form { name: "each direction alike", figure: |rows| beyond(rows as usize, "coefficients") },
    here: Form { name: "norm=radiance: by solid angle", figure: |rows| beyond(rows as usize, "radiance") },
    bound: |_| 1e-3,
    promise: "the least, to 1e-3",
    breaks: Some(4.0),
};

const COMPONENTS: usize = 4;

fn beyond(height: usize, norm: &str) -> Result<f64> {
    let basis = LightBasis::LatLong { width: 2 * height, height };
    let (texels, angles) = (basis.directions().unwrap_or_default(), basis.solid_angles().unwrap_or_default());
    let mut random = Random(81);
    // As much that changes at the poles as at the equator.
    let lobes: Vec<[f64; 3]> = (0..12)
        .map(|i| {
            let (t, phi) = (std::f64::consts::PI * (i as f64 + 0.5) / 12.0, std::f64::consts::TAU * random.uniform());
            [t.sin() * phi.cos(), t.sin() * phi.sin(), t.cos()]
        })
        .collect();
    let shares = ground::noise(120, lobes.len(), 82);
    let shapes =
        Array2::from_shape_fn((lobes.len(), texels.len()), |(i, k)| (8.0 * (dot(lobes[i], texels[k]) - 1.0)).exp());
    // Rows hold moments: radiance times solid angle.
    let angles = Array1::from_vec(angles);
    let rows = shares.dot(&shapes) * &angles;
    let matrix = ground::on(rows.view(), 1, basis)?;
    let metric = &rows / &angles.mapv(f64::sqrt);
    let centred = &metric - &metric.mean_axis(Axis(0)).unwrap_or_default();
    let least = linalg::singular(centred.view())?.values[COMPONENTS..].iter().map(|s| s * s).sum::<f64>();
    let compressed = ground::encoded(&format!("pca:components={COMPONENTS}:norm={norm}"), &matrix)?;
    let lost = ground::errors(&compressed, &matrix)?[1] * ground::square(metric.view());
    Ok((lost / least - 1.0).max(0.0))
}
