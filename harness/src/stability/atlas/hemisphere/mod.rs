//! Spherical harmonics on the hemisphere, where they are not orthonormal: Sloan et al. 2003, appendix.

mod coordinates;
mod gram;
mod projection;
mod rounding;

use super::case::Part;
use prt_transfer::basis::Direction;
use prt_transfer::quadrature::gauss_legendre;
use prt_transfer::sh::HemisphereSh;
use std::f64::consts::TAU;

pub(super) const PART: Part = Part {
    name: "hemisphere",
    title: "Harmonics on the hemisphere",
    cases: &[projection::CASE, rounding::CASE, gram::CASE, coordinates::CASE],
};

const ORDERS: &[f64] = &[3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];

fn harmonics(order: f64) -> prt_transfer::Result<HemisphereSh> {
    HemisphereSh::new((order * order) as usize)
}

/// Directions and weights that integrate products of two harmonics of up to ten bands over the hemisphere exactly.
fn rule() -> Vec<(Direction, f64)> {
    const RING: usize = 40;
    let ring = |(x, weight): (f64, f64)| {
        let z = 0.5 * (1.0 + x);
        let r = (1.0 - z * z).sqrt();
        (0..RING).map(move |i| {
            let phi = TAU * i as f64 / RING as f64;
            ([r * phi.cos(), r * phi.sin(), z], 0.5 * weight * TAU / RING as f64)
        })
    };
    gauss_legendre(32).into_iter().flat_map(ring).collect()
}

/// cᵀ A c: ∫_H f² of f = Σ c_i y_i.
fn norm(gram: &[f64], c: &[f64]) -> f64 {
    let n = c.len();
    (0..n).map(|i| c[i] * (0..n).map(|j| gram[i * n + j] * c[j]).sum::<f64>()).sum()
}
