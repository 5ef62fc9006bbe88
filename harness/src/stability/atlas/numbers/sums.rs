//! A running sum in single precision loses what is small beside it.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::random::Random;
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const CASE: Case = Case {
    name: "sums",
    title: "Sums of high-dynamic-range radiance",
    source: "what a reader would write: sum += t * x in f32",
    parameter: "terms of the sum",
    values: &[1024.0, 8192.0, 65536.0, 524288.0, 4194304.0],
    quantity: "relative error",
    printed: Form { name: "a running sum in single precision", figure: printed },
    here: Form { name: "relighting by dense", figure: here },
    bound: |_| 1e-5,
    promise: "1e-5 up to 4 million light coefficients",
    breaks: Some(524288.0),
};

/// A sky of 1 with suns of 10,000.
fn light(terms: usize) -> Vec<f32> {
    let mut random = Random(91);
    (0..terms).map(|_| if random.uniform() < 1e-3 { 1e4 } else { random.uniform() as f32 }).collect()
}

fn off(sum: f32, light: &[f32]) -> f64 {
    let exact: f64 = light.iter().map(|x| f64::from(*x)).sum();
    (f64::from(sum) / exact - 1.0).abs()
}

fn printed(terms: f64) -> Result<f64> {
    let light = light(terms as usize);
    Ok(off(light.iter().fold(0f32, |sum, x| sum + x), &light))
}

fn here(terms: f64) -> Result<f64> {
    let light = light(terms as usize);
    let basis = LightBasis::Plain { lights: light.len() };
    let matrix = TransferMatrix::from_dense(vec![1.0; light.len()], 1, 1, basis)?;
    let mut out = Array2::zeros((1, 1));
    let column = ndarray::ArrayView2::from_shape((light.len(), 1), &light);
    ground::encoded("dense", &matrix)?
        .apply_into(column.unwrap_or_else(|_| ndarray::aview2::<f32, 1>(&[])), out.view_mut())?;
    Ok(off(out[[0, 0]], &light))
}
