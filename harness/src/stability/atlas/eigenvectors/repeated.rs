//! Repeated singular values have no vectors of their own, which compression does not need.

use super::{ALGORITHM_1, PROMISE, excess};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::eigensolvers::spectra::Known;
use prt_cpca::Solver;

pub(super) const CASE: Case = Case {
    name: "repeated",
    title: "Repeated singular values",
    source: ALGORITHM_1,
    parameter: "how often each singular value is there",
    values: &[2.0, 4.0, 8.0, 16.0],
    quantity: "excess over the least error of 8 components, relative",
    printed: Form {
        name: "power iteration, otherwise corrected",
        figure: |n| excess(&known(n), Solver::Power, 8, None),
    },
    here: Form { name: "auto", figure: |times| excess(&known(times), Solver::Auto, 8, None) },
    bound: |_| 1e-6,
    promise: PROMISE,
    breaks: Some(2.0),
};

fn known(times: f64) -> Known {
    Known::new(60, 40, 3, |i| 0.7f64.powi(i as i32 / times as i32))
}
