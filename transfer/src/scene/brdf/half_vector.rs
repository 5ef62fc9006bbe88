//! Integrals over the hemisphere of lights in coordinates of the half vector, in which microfacet lobes are smooth.

use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::TAU;

/// Radial nodes, and sectors of the azimuth.
const RINGS: usize = 64;
const SECTORS: usize = 128;

/// ∫ `lobe`(light) cos θ dω over the hemisphere, for a lobe that falls with the slope (p, q) of the half vector like
/// exp(-p²/αx² - q²/αy²), seen from `view` above the horizon.
///
/// With p = αx t cos ψ and q = αy t sin ψ, dω_h = cos³θ_h αx αy t dt dψ, and dω = 4 (v·h) dω_h.
pub(super) fn lobe_albedo(view: DVec3, [alpha_x, alpha_y]: [f64; 2], lobe: impl Fn(DVec3) -> f64) -> f64 {
    // exp(-t²) < 3e-19 beyond.
    const REACH: f64 = 6.5;
    let mut sum = 0.0;
    for (x, weight) in gauss_legendre(RINGS) {
        let t = 0.5 * REACH * (1.0 + x);
        for sector in 0..SECTORS {
            let (sin, cos) = (TAU * (sector as f64 + 0.5) / SECTORS as f64).sin_cos();
            let half = DVec3::new(alpha_x * t * cos, alpha_y * t * sin, 1.0).normalize();
            let cosine = view.dot(half);
            let light = 2.0 * cosine * half - view;
            if cosine > 0.0 && light.z > 0.0 {
                sum += weight * t * half.z.powi(3) * 4.0 * cosine * lobe(light) * light.z;
            }
        }
    }
    sum * 0.5 * REACH * alpha_x * alpha_y * TAU / SECTORS as f64
}
