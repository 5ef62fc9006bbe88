//! sinh r outgrows every format; the product of two lobes does not.

use super::series;
use crate::stability::atlas::case::{Case, Form};
use prt_srbf::Kernel;
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "overflow",
    title: "Inner product of two Gaussian lobes",
    source: "Tsai and Shih 2006, Eq. 27",
    parameter: "bandwidth λ of both lobes",
    values: &[0.01, 0.1, 1.0, 10.0, 40.0, 162.9, 1000.0, 10000.0],
    quantity: "relative error",
    printed: Form { name: "as printed: 4π sinh(r)/r", figure: |bandwidth| Ok(off(printed(bandwidth), bandwidth)) },
    here: Form { name: "2π e^-δ (1 - e^-2r)/r", figure: |bandwidth| Ok(off(here(bandwidth), bandwidth)) },
    bound: |_| 1e-9,
    promise: "1e-9 at every bandwidth; the reference is a Legendre series",
    breaks: Some(0.01),
};

/// Centres at one standard deviation from each other, or a right angle.
fn angle(bandwidth: f64) -> f64 {
    (1.0 / bandwidth.sqrt()).min(0.5 * PI)
}

fn off(found: f64, bandwidth: f64) -> f64 {
    let count = 60 + (9.0 * bandwidth.sqrt()) as usize;
    let expected = series(Kernel::Gaussian, [bandwidth; 2], angle(bandwidth).cos(), count);
    (found / expected - 1.0).abs()
}

fn printed(bandwidth: f64) -> f64 {
    let r = bandwidth * (2.0 + 2.0 * angle(bandwidth).cos()).sqrt();
    4.0 * PI * r.sinh() / r
}

fn here(bandwidth: f64) -> f64 {
    let (sin, cos) = angle(bandwidth).sin_cos();
    Kernel::Gaussian.inner_product([[0.0, 0.0, 1.0], [sin, 0.0, cos]], [bandwidth; 2])
}
