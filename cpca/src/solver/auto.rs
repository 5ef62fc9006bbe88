//! The cheapest solver that keeps the energy left over within 1e-6 of the optimum.
//!
//! Measured by `cargo bench -p prt-benches --bench solvers` with k = 8 on one thread of a server processor,
//! milliseconds; singular values that fall as i^-2 to i^-1/2. The upper figures of one size differ with where memory
//! lies more than with the values:
//!
//! | m x n | gram | krylov | svd |
//! | --- | --- | --- | --- |
//! | 140 x 25 | 0.06 | 0.1 | 0.1 |
//! | 140 x 155 | 1.5 | 1 to 12 | 2 to 7 |
//! | 140 x 600 | 2 to 6 | 2 to 20 | 8 to 13 |
//! | 300 x 300 | 17 to 24 | 5 to 13 | 21 to 34 |
//! | 600 x 600 | 120 to 150 | 20 to 45 | 160 to 200 |
//! | 2000 x 600 | 125 to 170 | 75 to 165 | 210 to 280 |

use super::{Pairs, gram, krylov, svd};
use ndarray::ArrayView2;
use prt_transfer::Result;

/// Smaller side, in columns for each vector of a block (k + 4), above which products with F are cheaper than its Gram
/// matrix and all eigenpairs.
const COLUMNS: usize = 20;
const BEYOND: usize = 4;
/// Part of the optimum that may be lost.
const EXCESS: f64 = 1e-6;
/// Part of ‖F‖² from which ‖F‖² − Σ s² is known well.
const KNOWN: f64 = 1e-12;

pub(super) fn leading(f: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Pairs> {
    let large = f.nrows().min(f.ncols()) > COLUMNS * (components + BEYOND);
    if large && let Some(pairs) = krylov::attempt(f, components, start)? {
        return Ok(pairs);
    }
    let pairs = gram::leading(f, components, None)?;
    if good(f, &pairs, components) {
        return Ok(pairs);
    }
    // Squaring loses what is wanted.
    let pairs = if large { None } else { krylov::attempt(f, components, start)? };
    pairs.map_or_else(|| svd::leading(f, components, None), Ok)
}

/// Whether squares known to ε·s₁² are exact enough: (max(m, n)·ε·s₁²)²/s_k² of energy may be lost.
fn good(f: ArrayView2<f64>, pairs: &Pairs, components: usize) -> bool {
    if pairs.squares.len() < components {
        return false;
    }
    let energy: f64 = f.iter().map(|v| v * v).sum();
    let left = energy - pairs.squares.iter().sum::<f64>();
    let lost = (super::zero(f.dim()) * pairs.squares[0]).powi(2) / pairs.squares[components - 1];
    left > KNOWN * energy && lost <= EXCESS * left
}
