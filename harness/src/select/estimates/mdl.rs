//! The rank of a covariance in white noise by the minimum description length.
//!
//! Wax and Kailath, *Detection of Signals by Information Theoretic Criteria* (1985), eqs. 16 and 17: the k that minimises
//!
//! ```text
//! MDL(k) = -N (p - k) ln(g_k / a_k) + ½ k (2p - k) ln N
//! ```
//!
//! where g_k and a_k are the geometric and the arithmetic mean of the p - k smallest eigenvalues and N the observations.

/// Whose estimate it is.
pub(super) const NAME: &str = "MDL";

/// Eigenvalues below this part of the largest are rounding.
const ROUNDING: f64 = 1e-14;

/// The rank by descending eigenvalues.
pub(super) fn rank(values: &[f64], observations: usize) -> usize {
    let (p, n) = (values.len(), observations.max(2) as f64);
    let least = values.first().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE) * ROUNDING;
    let values: Vec<f64> = values.iter().map(|value| value.max(least)).collect();
    let (mut sum, mut logarithms, mut best) = (0.0, 0.0, (f64::INFINITY, 0));
    for k in (0..p).rev() {
        sum += values[k];
        logarithms += values[k].ln();
        let rest = (p - k) as f64;
        let spread = logarithms / rest - (sum / rest).ln();
        let length = -n * rest * spread + 0.5 * (k * (2 * p - k)) as f64 * n.ln();
        // Of equal lengths the shorter model.
        if length <= best.0 {
            best = (length, k);
        }
    }
    best.1
}
