//! The modified Phong model: a cosine power about the mirror direction.
//!
//! Phong (1975) shades; Lewis, "Making Shaders More Physically Plausible" (1994), and Lafortune and Willems, "Using the
//! Modified Phong Reflectance Model for Physically Based Rendering" (1994), make a BRDF of it: reciprocal, since no
//! cosine of the incidence divides the lobe, and normalised by (n+2)/2π so that the lobe's albedo is 1 at normal
//! incidence and less elsewhere.

use super::{check, check_weights};
use crate::codec::Configure;
use crate::error::Result;
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

crate::params! {
    /// Cosine power about the mirror direction, energy-normalised and reciprocal (Lewis 1994; Lafortune and Willems
    /// 1994).
    pub struct PhongParams: "phong" {
        /// Albedo of the diffuse part, from 0 to 1.
        diffuse: f64 = 0.0,
        /// Albedo of the lobe at normal incidence, from 0 to 1 - diffuse.
        specular: f64 = 1.0,
        /// Power n of the cosine, from 1 (broad) to 10000 (nearly a mirror).
        exponent: f64 = 20.0,
    }
}

/// ρ = kd/π + ks (n+2)/(2π) max(cos α, 0)ⁿ, with α the angle between the view and the mirrored light.
#[derive(Clone, Debug, PartialEq)]
pub struct Phong {
    params: PhongParams,
    /// kd/π
    diffuse: f64,
    /// ks (n+2)/(2π)
    scale: f64,
}

impl Configure for Phong {
    type Params = PhongParams;
    fn new(params: PhongParams) -> Result<Phong> {
        check_weights::<PhongParams>(params.diffuse, params.specular)?;
        check::<PhongParams>("exponent", params.exponent, 1.0, 1e4)?;
        let scale = params.specular * (params.exponent + 2.0) / TAU;
        Ok(Phong { diffuse: params.diffuse * FRAC_1_PI, scale, params })
    }
    fn params(&self) -> &PhongParams {
        &self.params
    }
}

impl Phong {
    #[inline]
    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> f64 {
        self.diffuse + self.lobe(view, light)
    }

    #[inline]
    pub(super) fn lobe(&self, view: DVec3, light: DVec3) -> f64 {
        let cosine = view.z * light.z - (view.x * light.x + view.y * light.y);
        self.scale * cosine.max(0.0).powf(self.params.exponent)
    }

    /// The lobe in polar coordinates (α, ψ) about the mirror direction, as far as it is above rounding.
    pub(super) fn albedo(&self, view: DVec3) -> f64 {
        const RINGS: usize = 48;
        const SECTORS: usize = 128;
        let n = self.params.exponent;
        // cosⁿ α ≤ exp(-n α²/2) < 1e-17 beyond.
        let reach = (80.0 / n).sqrt().min(FRAC_PI_2);
        let sine = view.x.hypot(view.y);
        let mut lobe = 0.0;
        for (x, weight) in gauss_legendre(RINGS) {
            let (sin, cos) = (0.5 * reach * (1.0 + x)).sin_cos();
            // z = cos θ of the light: the mirror direction's, tilted by α towards azimuth ψ.
            let z = |j: usize| cos * view.z + sin * sine * (TAU * (j as f64 + 0.5) / SECTORS as f64).cos();
            let cosines: f64 = (0..SECTORS).map(|j| z(j).max(0.0)).sum();
            lobe += 0.5 * reach * weight * sin * cos.powf(n) * cosines * (TAU / SECTORS as f64);
        }
        self.params.diffuse + self.scale * lobe
    }
}
