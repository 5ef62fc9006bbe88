//! Orthonormal functions on the hemisphere: by way of A the condition counts whole, by way of the functions half.

use super::{ORDERS, harmonics, rule};
use crate::stability::atlas::case::{Case, Form};
use ndarray::Array2;
use prt_transfer::Result;
use prt_transfer::linalg::Cholesky;

pub(super) const CASE: Case = Case {
    name: "gram",
    title: "Functions orthonormal on the hemisphere",
    source: "Sloan et al. 2003, appendix: A_ik = ∫_H y_i y_k",
    parameter: "order (bands)",
    values: ORDERS,
    quantity: "the largest |∫_H q_i q_k - δ_ik|",
    printed: Form { name: "the Cholesky factor of A", figure: printed },
    here: Form { name: "the functions, orthonormalised", figure: here },
    bound: |_| 1e-9,
    promise: "1e-9",
    breaks: Some(7.0),
};

/// Of functions at the directions of [`rule`], functions x directions.
fn off(values: &Array2<f64>) -> f64 {
    let weights = ndarray::Array1::from_iter(rule().into_iter().map(|(_, weight)| weight));
    let gram = (values * &weights).dot(&values.t());
    gram.indexed_iter().map(|((i, k), g)| (g - f64::from(u8::from(i == k))).abs()).fold(0.0, f64::max)
}

fn here(order: f64) -> Result<f64> {
    let harmonics = harmonics(order)?;
    let mut values = Array2::zeros((rule().len(), harmonics.coefficients()));
    for (mut row, (direction, _)) in values.outer_iter_mut().zip(rule()) {
        harmonics.evaluate_orthonormal(direction, row.as_slice_mut().expect("rows of a new array"));
    }
    Ok(off(&values.reversed_axes()))
}

fn printed(order: f64) -> Result<f64> {
    let harmonics = harmonics(order)?;
    let n = harmonics.coefficients();
    let gram = Array2::from_shape_fn((n, n), |(i, k)| harmonics.gram()[i * n + k]);
    let Some(factor) = Cholesky::factor(gram) else { return Ok(f64::NAN) };
    let mut values = Array2::zeros((n, rule().len()));
    let mut y = vec![0.0; n];
    for (mut column, (direction, _)) in values.columns_mut().into_iter().zip(rule()) {
        harmonics.evaluate(direction, &mut y);
        column.iter_mut().zip(&y).for_each(|(out, y)| *out = *y);
    }
    factor.solve_lower(values.view_mut());
    Ok(off(&values))
}
