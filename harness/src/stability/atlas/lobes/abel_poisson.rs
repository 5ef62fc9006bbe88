//! The inner product of Abel-Poisson kernels without its 4π.

use super::series;
use crate::stability::atlas::case::{Case, Form};
use prt_srbf::Kernel;
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "abel-poisson",
    title: "Inner product of two Abel-Poisson lobes",
    source: "Tsai and Shih 2006, Eq. 5",
    parameter: "1 - λ of both lobes",
    values: &[0.9, 0.5, 0.3, 0.1, 0.03, 0.01, 0.003],
    quantity: "relative error",
    printed: Form { name: "as printed: G(μ; λ_g λ_h)", figure: |narrow| Ok(off(here(narrow) / (4.0 * PI), narrow)) },
    here: Form { name: "4π G(μ; λ_g λ_h)", figure: |narrow| Ok(off(here(narrow), narrow)) },
    bound: |_| 1e-9,
    promise: "1e-9; the reference is a Legendre series",
    breaks: Some(0.9),
};

fn off(found: f64, narrow: f64) -> f64 {
    let count = 60 + (20.0 / narrow) as usize;
    let expected = series(Kernel::AbelPoisson, [1.0 - narrow; 2], narrow.cos(), count);
    (found / expected - 1.0).abs()
}

/// Centres at the width of a lobe.
fn here(narrow: f64) -> f64 {
    let centres = [[0.0, 0.0, 1.0], [narrow.sin(), 0.0, narrow.cos()]];
    Kernel::AbelPoisson.inner_product(centres, [1.0 - narrow; 2])
}
