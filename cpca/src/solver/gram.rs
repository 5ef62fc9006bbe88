//! All eigenpairs of the smaller Gram matrix ("Clustered principal components", §4.1).

use super::basis::Basis;
use super::{Pairs, Question};
use ndarray::{Array2, ArrayView2};
use prt_transfer::{Result, linalg};

/// FᵀF = V S² Vᵀ, or F Fᵀ = U S² Uᵀ and Vᵀ = S⁻¹ Uᵀ F where that is smaller.
pub(super) fn leading(Question { f, components, .. }: Question) -> Result<Pairs> {
    let (m, n) = f.dim();
    let bound = super::zero(f.dim());
    if m >= n {
        let spectrum = linalg::eigen(of_columns(f).view())?;
        return Ok(Pairs::leading(&spectrum.values, spectrum.vectors.view(), components, bound));
    }
    let transposed = f.t().as_standard_layout().into_owned();
    let spectrum = linalg::eigen(of_columns(transposed.view()).view())?;
    let left = Pairs::leading(&spectrum.values, spectrum.vectors.view(), components, bound);
    let mut right = Array2::zeros((left.squares.len(), n));
    linalg::times(left.vectors.view(), f, right.view_mut());
    Ok(Pairs { vectors: orthonormal(right, left.squares[0].sqrt()), ..left })
}

/// FᵀF.
pub(super) fn of_columns(f: ArrayView2<f64>) -> Array2<f64> {
    let mut gram = Array2::zeros((f.ncols(), f.ncols()));
    linalg::add_gram(f, gram.view_mut());
    gram
}

/// Rows UᵀF are orthogonal up to ε·s₁²/(s_i s_j) only: in their order, each is freed of those before it.
fn orthonormal(rows: Array2<f64>, scale: f64) -> Array2<f64> {
    let mut basis = Basis::new(rows.nrows(), rows.ncols());
    basis.extend(rows, f64::EPSILON * scale);
    basis.into_rows()
}
