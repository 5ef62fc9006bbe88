//! What a bicluster gets wrong has to go into the residual; subtracting the submatrix in place of the bicluster loses it.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "residual",
    title: "Exceptions inside a bicluster",
    source: "biclustering, Algorithm 1, line 16: T ← T - T_b",
    parameter: "share of a bicluster's elements that have another value",
    values: &[1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3],
    quantity: "Σ(T-T̃)²/ΣT²",
    printed: Form { name: "as printed: the submatrix is subtracted", figure: printed },
    here: Form { name: "bicluster", figure: |share| ground::error("bicluster", &ground::plain(matrix(share).view())?) },
    bound: |_| 0.0,
    promise: "exact, bit for bit",
    breaks: Some(1e-3),
};

/// Constant columns, but for exceptions.
fn matrix(share: f64) -> Array2<f64> {
    let mut random = Random(72);
    Array2::from_shape_fn((80, 60), |(_, column)| {
        let value = if column % 3 == 0 { 0.5 } else { 1.0 };
        if random.uniform() < share { 0.75 } else { value }
    })
}

/// One bicluster of all rows and columns: t_k is each column's commonest value, and T - T_b is nothing.
fn printed(share: f64) -> Result<f64> {
    let t = matrix(share);
    let common = matrix(0.0);
    Ok(ground::distance(common.view(), t.view()))
}
