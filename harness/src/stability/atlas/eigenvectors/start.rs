//! A start that is nearly orthogonal to what is sought looks converged: to the second vector.

use super::{ALGORITHM_1, PROMISE, excess};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::eigensolvers::spectra::Known;
use ndarray::Axis;
use prt_cpca::Solver;
use prt_transfer::Result;

pub(super) const CASE: Case = Case {
    name: "start",
    title: "A start that points elsewhere",
    source: ALGORITHM_1,
    parameter: "cosine between the start and the leading vector",
    values: &[1.0, 0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8],
    quantity: "excess over the least error of one component, relative",
    printed: Form { name: "power iteration, otherwise corrected", figure: |cosine| from(Solver::Power, cosine) },
    here: Form { name: "auto", figure: |cosine| from(Solver::Auto, cosine) },
    bound: |_| 1e-6,
    promise: PROMISE,
    breaks: Some(0.3),
};

fn from(solver: Solver, cosine: f64) -> Result<f64> {
    let known = Known::new(60, 40, 3, |i| 0.8f64.powi(i as i32));
    let start = &known.right.row(0) * cosine + &known.right.row(1) * (1.0 - cosine * cosine).sqrt();
    excess(&known, solver, 1, Some(start.insert_axis(Axis(0)).view()))
}
