//! What the cheaper decomposition loses to the alternating one, from smooth data to noise.

use crate::stability::atlas::case::{Case, Form};
use ndarray::ArrayD;
use prt_tensor::tucker::{Algorithm, Decomposer, Ranks, TuckerParams};
use prt_transfer::random::Random;
use prt_transfer::{Quiet, Result};

pub(super) const CASE: Case = Case {
    name: "noise",
    title: "Decompositions of smooth data and of noise",
    source: "De Lathauwer et al. 2000; Vannieuwenhoven et al. 2012",
    parameter: "noise beside a smooth signal of size 1",
    values: &[1e-3, 1e-2, 1e-1, 0.3, 1.0, 3.0],
    quantity: "squared error beyond that of HOOI, relative",
    printed: Form { name: "HOSVD", figure: |noise| beyond(noise, Algorithm::Hosvd) },
    here: Form { name: "ST-HOSVD, the default", figure: |noise| beyond(noise, Algorithm::Sequential) },
    bound: |_| 0.1,
    promise: "a tenth; twice the least is what theory bounds it by",
    breaks: None,
};

fn tensor(noise: f64) -> ArrayD<f32> {
    let mut random = Random(51);
    ArrayD::from_shape_fn(vec![24, 20, 16], |i| {
        let [a, b, c] = [0, 1, 2].map(|n| i[n] as f64);
        let smooth = 1.0 / (1.0 + 0.2 * a + 0.1 * b + 0.3 * c) + (0.3 * a).sin() * (-0.2 * b).exp() * (0.1 * c).cos();
        (smooth + noise * random.normal()) as f32
    })
}

fn error(noise: f64, algorithm: Algorithm) -> Result<f64> {
    let params = TuckerParams { algorithm, ranks: Ranks::Given(vec![4, 4, 4]), ..TuckerParams::default() };
    Ok(Decomposer::new(params)?.decompose(tensor(noise).view(), &Quiet)?.relative_error())
}

fn beyond(noise: f64, algorithm: Algorithm) -> Result<f64> {
    Ok((error(noise, algorithm)? / error(noise, Algorithm::Hooi)? - 1.0).max(0.0))
}
