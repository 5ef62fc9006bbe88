//! All singular pairs, then the first of them.

use super::{Pairs, Question};
use prt_transfer::{Result, linalg};

pub(super) fn leading(Question { f, components, .. }: Question) -> Result<Pairs> {
    let spectrum = linalg::singular(f)?;
    let squares: Vec<f64> = spectrum.values.iter().map(|s| s * s).collect();
    let bound = super::zero(f.dim());
    Ok(Pairs::leading(&squares, spectrum.vectors.view(), components, bound * bound))
}
