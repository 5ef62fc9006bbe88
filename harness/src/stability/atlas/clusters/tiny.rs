//! A cluster of as many members as components, or fewer: D⁻¹ divides by the singular values that it does not have.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::{Array2, Axis};
use prt_cpca::Solver;
use prt_transfer::{Result, linalg};

pub(super) const CASE: Case = Case {
    name: "tiny",
    title: "Clusters of few members",
    source: "Sloan et al. 2003, §4.1: V = D⁻¹UᵀC from the members' Gram matrix",
    parameter: "members of a cluster of 8 components",
    values: &[9.0, 8.0, 6.0, 4.0, 3.0, 2.0],
    quantity: "the largest |v_i · v_j - δ_ij| of the components",
    printed: Form { name: "V = D⁻¹UᵀC of as many as there are members", figure: printed },
    here: Form { name: "no more than the rank, as cpca takes them", figure: here },
    bound: |_| 1e-12,
    promise: "1e-12: orthonormal",
    breaks: Some(8.0),
};

const COMPONENTS: usize = 8;

/// Members of which the mean is taken out: their rank is one less than their number.
fn centred(members: f64) -> Array2<f64> {
    let x = ground::noise(members as usize, 30, 7);
    &x - &x.mean_axis(Axis(0)).unwrap_or_default()
}

/// The largest |v_i · v_j - δ_ij| of vectors, one a row; NaN where one of them is no vector.
fn off(vectors: &Array2<f64>) -> f64 {
    let products = vectors.dot(&vectors.t());
    let off = products.indexed_iter().map(|((i, j), product)| (product - f64::from(u8::from(i == j))).abs());
    off.fold(0.0, |most, off| if off <= most { most } else { off })
}

fn printed(members: f64) -> Result<f64> {
    let c = centred(members);
    // C Cᵀ = U D² Uᵀ of m x m.
    let spectrum = linalg::eigen(c.dot(&c.t()).as_standard_layout().view())?;
    let components = spectrum.values.len().min(COMPONENTS);
    let mut vectors = Array2::zeros((components, c.ncols()));
    for (i, mut v) in vectors.outer_iter_mut().enumerate() {
        v.assign(&(spectrum.vectors.row(i).dot(&c) / spectrum.values[i].sqrt()));
    }
    Ok(off(&vectors))
}

fn here(members: f64) -> Result<f64> {
    Ok(off(&Solver::Auto.solver().leading(centred(members).view(), COMPONENTS, None)?.vectors))
}
