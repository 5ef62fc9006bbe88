//! Power iteration takes as many steps as the inverse of the relative gap, and Algorithm 1 has a thousand and a doubtful stop.

use super::{ALGORITHM_1, PROMISE, excess};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::eigensolvers::spectra::Known;
use prt_cpca::Solver;

pub(super) const CASE: Case = Case {
    name: "gap",
    title: "Singular values close to each other",
    source: ALGORITHM_1,
    parameter: "ratio of neighbouring singular values, up to the fourth",
    values: &[0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 0.999, 0.9999, 0.999999],
    quantity: "excess over the least error of 4 components, relative",
    printed: Form {
        name: "power iteration, otherwise corrected",
        figure: |r| excess(&known(r), Solver::Power, 4, None),
    },
    here: Form { name: "auto", figure: |ratio| excess(&known(ratio), Solver::Auto, 4, None) },
    bound: |_| 1e-6,
    promise: PROMISE,
    breaks: Some(0.7),
};

/// Five of them close together, the rest half as large and falling.
fn known(ratio: f64) -> Known {
    Known::new(60, 40, 3, |i| ratio.powi(i.min(4) as i32) * if i > 4 { 0.5 * 0.7f64.powi(i as i32 - 5) } else { 1.0 })
}
