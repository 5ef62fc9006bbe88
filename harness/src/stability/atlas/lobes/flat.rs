//! The flat limit: wide lobes are nearly the same function, and their coefficients large and opposite.

use super::rows;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{encoded, errors};
use prt_transfer::Result;

pub(super) const CASE: Case = Case {
    name: "flat",
    title: "Wide lobes, stored in 16 bits",
    source: "Tsai and Shih 2006, §4.1: least squares in 162 uniform lobes",
    parameter: "bandwidth λ (40.9 is the paper's overlap)",
    values: &[160.0, 80.0, 40.0, 20.0, 10.0, 5.0, 2.5, 1.0],
    quantity: "squared error over the sphere, beyond that before rounding, relative",
    printed: Form { name: "coefficients of lobes, no ridge", figure: |b| added(b, ":ridge=0:coordinates=lobes") },
    here: Form { name: "orthonormal coordinates, ridge=auto", figure: |bandwidth| added(bandwidth, "") },
    bound: |_| 0.01,
    promise: "1 % more than before rounding",
    breaks: Some(5.0),
};

fn added(bandwidth: f64, how: &str) -> Result<f64> {
    let (matrix, srbf) = (rows()?, format!("srbf:centers=162:bandwidth={bandwidth}"));
    let sphere = |label: &str| Ok(errors(&encoded(label, &matrix)?, &matrix)?[1]);
    // What the same lobes hold of it in single precision.
    let exact: f64 = sphere(&format!("{srbf}+csr"))?;
    let rounded: Result<f64> = sphere(&format!("{srbf}{how}+truncate:terms=162:bits=16"));
    Ok((rounded? / exact - 1.0).max(0.0))
}
