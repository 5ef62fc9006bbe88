//! Deflated power iteration in single precision: Miandji, Kronander and Unger 2011, Algorithm 1, as it has to read.
//!
//! Against the printed form: v is normalised before σ = ‖v − v̂‖ is taken; σ̂ starts at infinity; the branch on Gram
//! matrices of rows is for M ≤ N; F is deflated by U_p V_pᵀ; the iterate of the least σ is kept. The scale κ = √(max|V|
//! λ / max|U|), which shares out the range of numbers between U and V for storage, leaves the product U_p V_pᵀ as it is
//! and is left out.
//!
//! What no correction mends: the stop "σ > σ̂" fires while a start still turns towards the leading vector, a start
//! orthogonal to it finds the second, and FᵀF in single precision loses singular values below 1e-3 of the first. The
//! block method cures all three.

use super::{Pairs, Question};
use ndarray::{Array1, Array2, Axis};
use prt_transfer::random::Random;
use prt_transfer::{Result, linalg};

/// c: iterations at most, of each component.
const MOST: usize = 1000;
/// ε: distance of two unit vectors at which they are one.
const TOLERANCE: f32 = 1e-12;

pub(super) fn leading(Question { f, components, start, progress }: Question) -> Result<Pairs> {
    let (m, n) = f.dim();
    let mut random = Random(0);
    let mut f = f.mapv(|v| v as f32);
    let bound = (4.0 * m.max(n) as f32 * f32::EPSILON).powi(2);
    let (mut found, mut iterations) = (Vec::<(f32, Array1<f32>)>::new(), 0);
    for p in 0..components {
        progress.advance(0)?;
        let guess = start.filter(|s| p < s.nrows()).map(|s| s.row(p).mapv(|v| v as f32));
        // A_p = FᵀF (n x n) or F Fᵀ (m x m), formed anew of what is left.
        let tall = m > n;
        let a = if tall { gram(&f.t().as_standard_layout().into_owned()) } else { gram(&f) };
        let guess = guess.map(|v| if tall { v } else { f.dot(&v) }).filter(|v| length(v) > 0.0);
        let guess = guess.unwrap_or_else(|| Array1::from_shape_simple_fn(a.ncols(), || random.normal() as f32));
        let (vector, lambda, steps) = iterate(&a, guess);
        iterations += steps;
        // λ = σ².
        if lambda <= bound * found.first().map_or(0.0, |first| first.0) || lambda == 0.0 {
            break;
        }
        // V_p = U_pᵀ F/σ, where U_p was found.
        let mut v = if tall { vector } else { vector.dot(&f) };
        v /= length(&v);
        // F ← F − (F V_p) V_pᵀ, where σ U_p = F V_p.
        let u = f.dot(&v);
        for (mut row, u) in f.rows_mut().into_iter().zip(&u) {
            row.scaled_add(-u, &v);
        }
        found.push((lambda, v));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(in_double(found, n, iterations))
}

/// v̂, λ = ‖A v̂‖ and iterations.
pub(super) fn iterate(a: &Array2<f32>, start: Array1<f32>) -> (Array1<f32>, f32, usize) {
    let mut best = &start / length(&start);
    let mut least = f32::INFINITY;
    for step in 1..=MOST {
        let mut v = a.dot(&best);
        let lambda = length(&v);
        if lambda == 0.0 {
            return (best, 0.0, step);
        }
        v /= lambda;
        let sigma = length(&(&v - &best));
        if sigma < TOLERANCE || sigma > least || step == MOST {
            return (best, lambda, step);
        }
        (best, least) = (v, sigma);
    }
    (best, 0.0, MOST)
}

/// Products of rows with one another.
pub(super) fn gram(rows: &Array2<f32>) -> Array2<f32> {
    let mut out = Array2::zeros((rows.nrows(), rows.nrows()));
    linalg::times_transposed(rows.view(), rows.view(), out.view_mut());
    out
}

pub(super) fn length(v: &Array1<f32>) -> f32 {
    v.dot(v).sqrt()
}

fn in_double(found: Vec<(f32, Array1<f32>)>, n: usize, iterations: usize) -> Pairs {
    let mut vectors = Array2::zeros((found.len(), n));
    for (mut row, (_, v)) in vectors.axis_iter_mut(Axis(0)).zip(&found) {
        row.assign(&v.mapv(f64::from));
        let length = super::norm(row.view());
        row.mapv_inplace(|v| v / length);
    }
    Pairs { squares: found.iter().map(|f| f64::from(f.0)).collect(), vectors, iterations }
}
