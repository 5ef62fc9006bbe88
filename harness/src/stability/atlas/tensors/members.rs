//! A cluster of fewer members than its rank: Eq. 16 normalises rows of zeros.

use super::{LIGHTS, VIEWS, samples};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::{Result, TransferMatrix, linalg};

pub(super) const CASE: Case = Case {
    name: "members",
    title: "Clusters of fewer members than the rank",
    source: "Tsai and Shih 2006, Eq. 16",
    parameter: "members of a cluster of sample rank 8",
    values: &[8.0, 7.0, 6.0, 4.0, 2.0, 1.0],
    quantity: "Σ(T-T̃)²/ΣT²",
    printed: Form {
        name: "each of the 8 rows of uf(Z) normalised",
        figure: |members| printed(&samples(members as usize, 8)?),
    },
    here: Form { name: "cta, no more rows than the data have", figure: |members| here(&samples(members as usize, 8)?) },
    bound: |_| 1e-10,
    promise: "exact to single precision",
    breaks: Some(7.0),
};

pub(super) const RANK: usize = 8;

/// With all views and lights, so that uf(Z) = U_vertᵀ uf(T), of as many rows as the rank.
pub(super) fn printed(matrix: &TransferMatrix) -> Result<f64> {
    let dense: Vec<f64> = matrix.as_dense().unwrap_or_default().iter().map(|v| f64::from(*v)).collect();
    let x = Array2::from_shape_vec((matrix.shape().samples, VIEWS * LIGHTS), dense).unwrap_or_default();
    // Left singular vectors from eigenvectors of X Xᵀ; where there are no more, U_vert has columns of zeros.
    let left = linalg::eigen(x.dot(&x.t()).as_standard_layout().view())?.vectors;
    let mut dual = Array2::zeros((RANK, VIEWS * LIGHTS));
    for (mut row, u) in dual.outer_iter_mut().zip(left.outer_iter()) {
        row.assign(&u.dot(&x));
    }
    for mut row in dual.outer_iter_mut() {
        let length = row.dot(&row).sqrt();
        row /= length;
    }
    let rebuilt = x.dot(&dual.t()).dot(&dual);
    Ok(ground::distance(rebuilt.view(), x.view()))
}

pub(super) fn here(matrix: &TransferMatrix) -> Result<f64> {
    ground::error(&format!("cta:clusters=1:view={VIEWS}:light={LIGHTS}:sample={RANK}:numbers=f32"), matrix)
}
