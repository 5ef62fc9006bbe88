//! The stop of Algorithm 1 compares a vector of length λ with one of length 1.

use super::{ALGORITHM_1, PROMISE, beyond, excess};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::eigensolvers::spectra::Known;
use ndarray::Array1;
use prt_cpca::Solver;
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "units",
    title: "Radiance in other units",
    source: ALGORITHM_1,
    parameter: "factor on F, whose largest singular value is 1 at first",
    values: &[1.0, 1.1, 1.3, 2.0, 4.0, 10.0, 100.0],
    quantity: "excess over the least error of one component, relative",
    printed: Form { name: "as printed: v not normalised before |v - v̂|", figure: printed },
    here: Form { name: "auto", figure: |factor| excess(&known(factor), Solver::Auto, 1, None) },
    bound: |_| 1e-6,
    promise: PROMISE,
    breaks: Some(1.1),
};

fn known(factor: f64) -> Known {
    Known::new(60, 40, 3, |i| factor * 0.8f64.powi(i as i32))
}

/// c and ε of the paper.
const MOST: usize = 1000;
const TOLERANCE: f64 = 1e-12;

fn printed(factor: f64) -> Result<f64> {
    let known = known(factor);
    let a = known.matrix.t().dot(&known.matrix);
    let mut random = Random(1);
    let mut guess = Array1::from_shape_simple_fn(a.nrows(), || random.normal());
    let length = |v: &Array1<f64>| v.dot(v).sqrt();
    guess /= length(&guess);
    // The least that is not said; whatever it is, the second comparison is with the first σ.
    let mut before = f64::INFINITY;
    for _ in 0..MOST {
        let v = a.dot(&guess);
        let sigma = length(&(&v - &guess));
        if sigma < TOLERANCE || sigma > before || sigma.is_nan() {
            break;
        }
        (before, guess) = (sigma, v);
    }
    let vector = &guess / length(&guess);
    Ok(beyond(&known, known.lost(&vector.insert_axis(ndarray::Axis(0))), 1))
}
