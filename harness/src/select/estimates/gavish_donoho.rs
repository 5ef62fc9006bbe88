//! The optimal hard threshold of singular values in white noise of unknown strength.
//!
//! Gavish and Donoho, *The Optimal Hard Threshold for Singular Values is 4/√3* (2014), eq. 4: singular values above ω(β) times their median are
//! kept, β ≤ 1 being the ratio of the matrix's sides, with eq. 5: ω(β) ≈ 0.56 β³ - 0.95 β² + 1.82 β + 1.43.

use super::Spectrum;

/// Whose estimate it is.
pub(super) const NAME: &str = "Gavish-Donoho";

/// How many singular values stand out of noise.
pub(super) fn rank(spectrum: &Spectrum) -> usize {
    let singular: Vec<f64> = spectrum.values.iter().map(|square| square.max(0.0).sqrt()).collect();
    let Some(median) = median(&singular) else { return 0 };
    let beta = singular.len() as f64 / spectrum.observations.max(1) as f64;
    let threshold = omega(beta.min(1.0)) * median;
    singular.iter().filter(|value| **value > threshold).count()
}

/// Of descending values.
fn median(values: &[f64]) -> Option<f64> {
    let half = values.len() / 2;
    match values.len() % 2 {
        1 => Some(values[half]),
        _ => Some(0.5 * (values.get(half.checked_sub(1)?)? + values.get(half)?)),
    }
}

fn omega(beta: f64) -> f64 {
    0.56 * beta.powi(3) - 0.95 * beta.powi(2) + 1.82 * beta + 1.43
}
