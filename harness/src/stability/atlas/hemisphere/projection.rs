//! ∫_H f y_k are not the coefficients of f.

use super::{ORDERS, harmonics, norm};
use crate::stability::atlas::case::{Case, Form};
use prt_transfer::Result;
use prt_transfer::random::Random;
use prt_transfer::sh::HemisphereSh;

pub(super) const CASE: Case = Case {
    name: "projection",
    title: "Projecting what is zero below the horizon",
    source: "Sloan et al. 2003, appendix",
    parameter: "order (bands)",
    values: ORDERS,
    quantity: "∫_H (f - f̃)² / ∫_H f² of random f, mean of 50",
    printed: Form { name: "zero-hemisphere projection, ∫_H f y", figure: |order| lost(order, |_, _| Ok(())) },
    here: Form { name: "least squares", figure: |order| lost(order, |harmonics, b| harmonics.project_harmonic(b)) },
    bound: |_| 1e-12,
    promise: "1e-12: what condition 3e12 at order 10 costs the coefficients is hardly seen of the function",
    breaks: Some(3.0),
};

fn lost(order: f64, project: fn(&HemisphereSh, &mut [f64]) -> Result<()>) -> Result<f64> {
    let (harmonics, mut random) = (harmonics(order)?, Random(4));
    let (gram, n) = (harmonics.gram(), harmonics.coefficients());
    let mut sum = 0.0;
    for _ in 0..50 {
        let c: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        // b = A c.
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| gram[i * n + j] * c[j]).sum()).collect();
        project(&harmonics, &mut b)?;
        let difference: Vec<f64> = b.iter().zip(&c).map(|(b, c)| b - c).collect();
        sum += norm(&gram, &difference).max(0.0) / norm(&gram, &c) / 50.0;
    }
    Ok(sum)
}
