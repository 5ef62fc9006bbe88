//! FᵀF squares the condition: in single precision a singular value of 1e-3 of the first has three digits left, one of 1e-5 none.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::eigensolvers::spectra::Known;
use ndarray::Array2;
use prt_cpca::Solver;
use prt_transfer::{Result, linalg};

pub(super) const CASE: Case = Case {
    name: "condition",
    title: "Small singular values beside large ones",
    source: "Miandji et al. 2011, Algorithm 1: A = FᵀF",
    parameter: "condition of F",
    values: &[1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7],
    quantity: "relative error of the smallest of 12 singular values",
    printed: Form { name: "eigenvalues of FᵀF formed in single precision", figure: printed },
    here: Form { name: "auto", figure: here },
    bound: |condition| 1e-13 * condition,
    promise: "1e-13 times the condition, as of a singular value decomposition in double precision",
    breaks: Some(1e1),
};

const VALUES: usize = 12;

fn known(condition: f64) -> Known {
    Known::new(40, VALUES, 3, |i| condition.powf(-(i as f64) / (VALUES - 1) as f64))
}

fn off(square: f64, condition: f64) -> f64 {
    // A square below 0 is no square of anything.
    (square.max(0.0).sqrt() * condition - 1.0).abs()
}

fn printed(condition: f64) -> Result<f64> {
    let f = known(condition).matrix.mapv(|v| v as f32);
    let mut gram = Array2::<f32>::zeros((VALUES, VALUES));
    let transposed = f.t().as_standard_layout().into_owned();
    linalg::times_transposed(transposed.view(), transposed.view(), gram.view_mut());
    let values = linalg::eigenvalues(gram.mapv(f64::from).view())?;
    Ok(off(values[VALUES - 1], condition))
}

fn here(condition: f64) -> Result<f64> {
    let found = Solver::Auto.solver().leading(known(condition).matrix.view(), VALUES, None)?;
    Ok(found.squares.get(VALUES - 1).map_or(f64::NAN, |square| off(*square, condition)))
}
