//! The cheapest solver that keeps the energy left over within 1e-6 of the optimum.
//!
//! Measured by `cargo bench -p prt-benches --bench solvers` with k = 8 on one thread of a busy server, milliseconds;
//! where two figures stand, singular values fall as i^-2 and as i^-1/2:
//!
//! | m x n | gram | krylov | svd | power |
//! | --- | --- | --- | --- | --- |
//! | 140 x 25 | 0.14 | too small: svd | 0.25 | 0.47, 1.0 |
//! | 140 x 155 | 4.0 | 2.5, 10 | 5.5 | 8.5, 26 |
//! | 140 x 600 | 5.3 | 6.2, 20 | 11 to 13 | 14, 30 |
//! | 300 x 300 | 21 | 6.0, 13 | 26 | 44, 113 |
//! | 600 x 600 | 121 | 18, 34 | 158 | 160, 406 |
//! | 2000 x 600 | 163 | 95, 139 | 258 | 448, 662 |

use super::{Pairs, Question, gram, krylov, svd};
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

pub(super) fn leading(question: Question) -> Result<Pairs> {
    let Question { f, components, .. } = question;
    let large = f.nrows().min(f.ncols()) > COLUMNS * (components + BEYOND);
    if large && let Some(pairs) = krylov::attempt(question)? {
        return Ok(pairs);
    }
    let pairs = gram::leading(question)?;
    if good(f, &pairs, components) {
        return Ok(pairs);
    }
    // Squaring loses what is wanted.
    let pairs = if large { None } else { krylov::attempt(question)? };
    pairs.map_or_else(|| svd::leading(question), Ok)
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
