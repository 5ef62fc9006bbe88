//! Texels of a cube are not alike: the energy of dropped coefficients is the error over the sphere in one metric only.

use super::rows;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{distance, encoded, errors};
use ndarray::Array2;
use prt_transfer::{Compressed, Result};

pub(super) const CASE: Case = Case {
    name: "solid-angles",
    title: "Texels of unequal solid angle",
    source: "Ng et al. 2003, §4: the largest coefficients",
    parameter: "texels along an edge of the cube",
    values: &[2.0, 4.0, 8.0, 16.0, 32.0],
    quantity: "error over the sphere against energy dropped, relative difference",
    printed: Form { name: "haar", figure: |resolution| off(resolution, "haar") },
    here: Form { name: "haar:scale=sphere", figure: |resolution| off(resolution, "haar:scale=sphere") },
    bound: |_| 1e-4,
    promise: "1e-4: what is dropped is what is lost",
    breaks: Some(4.0),
};

fn off(resolution: f64, transform: &str) -> Result<f64> {
    let matrix = rows(resolution as usize)?;
    let kept = encoded(&format!("{transform}+truncate:terms={}", (matrix.lights() / 8).max(1)), &matrix)?;
    let all = encoded(&format!("{transform}+csr"), &matrix)?;
    let dropped = distance(coefficients(&kept).view(), coefficients(&all).view());
    Ok((errors(&kept, &matrix)?[1] / dropped - 1.0).abs())
}

/// Rows of C.
fn coefficients(compressed: &Compressed) -> Array2<f64> {
    let mut rows = Array2::zeros((compressed.shape().rows(), compressed.shape().lights));
    compressed.coefficient_rows_into(0, rows.view_mut());
    rows.mapv(f64::from)
}
