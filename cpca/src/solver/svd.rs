//! All singular pairs, then the first of them.

use super::Pairs;
use ndarray::ArrayView2;
use prt_transfer::{Result, linalg};

pub(super) fn leading(f: ArrayView2<f64>, components: usize, _: Option<ArrayView2<f64>>) -> Result<Pairs> {
    let spectrum = linalg::singular(f)?;
    let squares: Vec<f64> = spectrum.values.iter().map(|s| s * s).collect();
    let bound = super::zero(f.dim());
    Ok(Pairs::leading(&squares, spectrum.vectors.view(), components, bound * bound))
}
