//! Coefficients of nearly dependent functions are large and cancel: rounding them is amplified by the condition.

use super::{ORDERS, harmonics, norm};
use crate::stability::atlas::case::{Case, Form};
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "rounding",
    title: "Half-precision functions on the hemisphere",
    source: "Sloan et al. 2003, appendix: c = A⁻¹b",
    parameter: "order (bands)",
    values: ORDERS,
    quantity: "∫_H (f - f̃)² / ∫_H f² of random f, the worst of 50",
    printed: Form { name: "harmonic coefficients c", figure: |order| lost(order, false) },
    here: Form { name: "orthonormal coordinates d", figure: |order| lost(order, true) },
    bound: |_| 2.4e-7,
    promise: "2⁻²², a half-precision number's relative error squared",
    breaks: Some(3.0),
};

fn lost(order: f64, orthonormal: bool) -> Result<f64> {
    let (harmonics, mut random) = (harmonics(order)?, Random(5));
    let (gram, n) = (harmonics.gram(), harmonics.coefficients());
    let mut worst = 0f64;
    for _ in 0..50 {
        // A function that is as large in every direction of function space.
        let d: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let square: f64 = d.iter().map(|d| d * d).sum();
        let lost = if orthonormal {
            d.iter().map(|&d| (half(d) - d).powi(2)).sum()
        } else {
            let mut c = d.clone();
            harmonics.to_harmonic(&mut c)?;
            let rounding: Vec<f64> = c.iter().map(|&c| half(c) - c).collect();
            norm(&gram, &rounding)
        };
        worst = worst.max(lost / square);
    }
    Ok(worst)
}

/// To 11 binary digits, of any size: what half precision with a scale holds.
fn half(v: f64) -> f64 {
    let step = 2f64.powi(v.abs().log2().floor() as i32 - 10);
    if v == 0.0 { 0.0 } else { (v / step).round_ties_even() * step }
}
