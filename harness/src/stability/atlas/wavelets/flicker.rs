//! A light that is cut to its largest coefficients jumps while it turns: which they are changes from one frame to the next.

use super::rows;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{distance, dot, encoded};
use ndarray::{Array2, s};
use prt_transfer::Result;

pub(super) const CASE: Case = Case {
    name: "flicker",
    title: "A light that turns, cut to 64 coefficients",
    source: "Ng et al. 2003, §4: the largest coefficients of each light",
    parameter: "turn from one frame to the next, degrees",
    values: &[10.0, 3.0, 1.0, 0.3, 0.1, 0.03],
    quantity: "Σ|Δỹ - Δy|²/Σ|Δy|² of the change Δ between frames",
    printed: Form {
        name: "the light's largest coefficients",
        figure: |degrees| flicker(degrees, "haar:light_terms=64+csr"),
    },
    here: Form {
        name: "the matrix's: linear in the light",
        figure: |degrees| flicker(degrees, "haar+truncate:terms=64"),
    },
    bound: |_| 0.2,
    promise: "0.2, however small the turn",
    breaks: Some(3.0),
};

const FRAMES: usize = 12;

fn flicker(degrees: f64, label: &str) -> Result<f64> {
    let matrix = rows(16)?;
    let compressed = encoded(label, &matrix)?;
    let texels = matrix.basis().directions().unwrap_or_default();
    let light = Array2::from_shape_fn((texels.len(), FRAMES), |(k, frame)| {
        let (sin, cos) = (frame as f64 * degrees).to_radians().sin_cos();
        let sun = [0.6 * cos, 0.6 * sin, 0.8];
        let lamp = [-0.8 * cos, -0.8 * sin, -0.6];
        let shine = |d, width: f64| (width * (dot(d, texels[k]) - 1.0)).exp();
        (20.0 * shine(sun, 80.0) + 4.0 * shine(lamp, 20.0) + 0.3 * (1.0 + texels[k][2])) as f32
    });
    let [mut exact, mut found] = [(); 2].map(|()| Array2::<f32>::zeros((matrix.rows(), FRAMES)));
    matrix.apply_into(light.view(), exact.view_mut())?;
    compressed.apply_into(light.view(), found.view_mut())?;
    let changes = |y: &Array2<f32>| (&y.slice(s![.., 1..]) - &y.slice(s![.., ..-1])).mapv(f64::from);
    let (exact, found) = (changes(&exact), changes(&found));
    Ok(distance(found.view(), exact.view()))
}
