//! Microfacets: a rough surface of mirrors that shadow each other (Cook and Torrance, "A Reflectance Model for Computer
//! Graphics", 1982).
//!
//! With h the half vector of view v and light s: ρ = F D G / (4 (n·v)(n·s)), where
//!
//! - D = exp(-tan²θ_h / m²) / (π m² cos⁴θ_h), the Beckmann distribution of slopes; ∫ D cos θ dω = 1;
//! - G = min(1, 2 (n·h) min(n·v, n·s) / (v·h)), masking and shadowing of V-grooves;
//! - F = f0 + (1 - f0)(1 - v·h)⁵, which stands for the Fresnel equations of the paper (Schlick 1994, eq. 15).
//!
//! The paper divides by π (n·v)(n·s): its D = exp(…) / (m² cos⁴θ_h) lacks the 1/π and its Jacobian the 4. The form here
//! conserves energy: with F = 1 the V-grooves reflect all but what they shadow (Heitz, "Understanding the
//! Masking-Shadowing Function", 2014).

use super::half_vector::lobe_albedo;
use super::{check, check_weights};
use crate::codec::Configure;
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

crate::params! {
    /// Microfacets with Beckmann slopes, V-groove shadowing and Schlick's Fresnel term (Cook and Torrance 1982).
    pub struct CookTorranceParams: "cook-torrance" {
        /// Root mean square slope m of the facets, from 0.01 (nearly a mirror) to 1.
        roughness: f64 = 0.3,
        /// Reflectance of a facet at normal incidence, from 0 to 1: 0.04 for plastics, 0.5 to 1 for metals.
        f0: f64 = 0.9,
        /// Albedo of the diffuse part, from 0 to 1.
        diffuse: f64 = 0.0,
        /// Weight of the lobe, from 0 to 1 - diffuse.
        specular: f64 = 1.0,
    }
}

/// ρ = kd/π + ks F D G / (4 (n·v)(n·s)).
#[derive(Clone, Debug, PartialEq)]
pub struct CookTorrance {
    params: CookTorranceParams,
    /// kd/π
    diffuse: f64,
    /// ks / (4π m²)
    scale: f64,
    /// 1/m²
    sharpness: f64,
}

impl Configure for CookTorrance {
    type Params = CookTorranceParams;
    fn new(params: CookTorranceParams) -> Result<CookTorrance> {
        check_weights::<CookTorranceParams>(params.diffuse, params.specular)?;
        check::<CookTorranceParams>("roughness", params.roughness, 0.01, 1.0)?;
        check::<CookTorranceParams>("f0", params.f0, 0.0, 1.0)?;
        let sharpness = params.roughness.powi(-2);
        let scale = params.specular * sharpness / (4.0 * PI);
        Ok(CookTorrance { diffuse: params.diffuse * FRAC_1_PI, scale, sharpness, params })
    }
    fn params(&self) -> &CookTorranceParams {
        &self.params
    }
}

impl CookTorrance {
    #[inline]
    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> f64 {
        self.diffuse + self.lobe(view, light)
    }

    #[inline]
    pub(super) fn lobe(&self, view: DVec3, light: DVec3) -> f64 {
        // H = v + s is not normalised: n·h = H_z/|H|, and v·h = |H|/2.
        let half = view + light;
        let (square, z_square) = (half.length_squared(), half.z * half.z);
        let d = (-self.sharpness * (half.x * half.x + half.y * half.y) / z_square).exp() * (square / z_square).powi(2);
        let g = (4.0 * half.z * view.z.min(light.z) / square).min(1.0);
        self.scale * self.fresnel(0.5 * square.sqrt()) * d * g / (view.z * light.z)
    }

    /// Schlick's F of the cosine v·h.
    #[inline]
    pub(super) fn fresnel(&self, cosine: f64) -> f64 {
        self.params.f0 + (1.0 - self.params.f0) * (1.0 - cosine).powi(5)
    }

    pub(super) fn albedo(&self, view: DVec3) -> f64 {
        self.params.diffuse + lobe_albedo(view, [self.params.roughness; 2], |light| self.lobe(view, light))
    }
}
