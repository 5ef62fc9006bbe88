//! A BRDF as an integral operator, in rings of constant cosine and Fourier orders of the azimuth.

use super::Views;
use crate::quadrature::gauss_legendre;
use crate::scene::brdf::Brdf;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// How finely a BRDF is taken apart.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Resolution {
    /// Rings of constant cosine over the hemisphere, of views and of lights.
    pub(in crate::scene) rings: usize,
    /// Fourier orders of the azimuth: 0 to `orders` - 1.
    pub(in crate::scene) orders: usize,
    /// Nodes of the view's azimuth in a quarter turn; 1 where only relative azimuths matter.
    pub(in crate::scene) sectors: usize,
}

/// One ring of directions.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Ring {
    /// Cosine with the normal.
    pub(in crate::scene) z: f64,
    /// For lights, ∫ f dω = Σ weight ∫ f dφ.
    pub(in crate::scene) light: f64,
    /// For views, ∫ f dμ = Σ weight ∫ f dφ.
    pub(in crate::scene) view: f64,
}

/// The operator ρ and the nodes at which its integrals are taken.
pub(in crate::scene) struct Kernel<'a> {
    brdf: &'a Brdf,
    isotropic: bool,
    /// Gauss-Legendre nodes and weights on \[0, 1\].
    azimuths: Vec<(f64, f64)>,
    /// The rings.
    pub(in crate::scene) rings: Vec<Ring>,
}

/// Integrals over the azimuth Δ of the light relative to the view, at one view and one cosine of the light.
pub(in crate::scene) struct Moments {
    /// ∫ ρ cos mΔ dΔ for m = 0, 1, …
    pub(in crate::scene) cos: Vec<f64>,
    /// ∫ ρ sin mΔ dΔ: zeros where only relative azimuths matter.
    pub(in crate::scene) sin: Vec<f64>,
    /// ∫ ρ² dΔ
    pub(in crate::scene) square: f64,
}

impl Moments {
    pub(in crate::scene) fn new(orders: usize) -> Moments {
        Moments { cos: vec![0.0; orders], sin: vec![0.0; orders], square: 0.0 }
    }
}

impl Kernel<'_> {
    pub(in crate::scene) fn new(brdf: &Brdf, views: Views, resolution: Resolution) -> Kernel<'_> {
        let unit = |n| gauss_legendre(n).into_iter().map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight));
        // z = t²: rings lie closer towards the horizon, where lobes narrow.
        let ring = |(t, weight): (f64, f64)| {
            let (z, light) = (t * t, 2.0 * t * weight);
            Ring { z, light, view: light * if views == Views::Projected { z } else { 1.0 } }
        };
        let rings = unit(resolution.rings).map(ring).collect();
        Kernel { brdf, isotropic: brdf.is_isotropic(), azimuths: unit(24 + resolution.orders).collect(), rings }
    }

    /// The moments at the view with cosine `view_z` and azimuth (cos, sin), and at lights with cosine `light_z`.
    ///
    /// The diffuse part is exact. The lobe lies about Δ = π, where it can be arbitrarily narrow near the horizon: Δ = π
    /// + w sinh x with w its width makes it smooth.
    pub(in crate::scene) fn moments(&self, view_z: f64, azimuth: (f64, f64), light_z: f64, out: &mut Moments) {
        let sine = |z: f64| (1.0 - z * z).max(0.0).sqrt();
        let view = DVec3::new(sine(view_z) * azimuth.0, sine(view_z) * azimuth.1, view_z);
        let light_sine = sine(light_z);
        let diffuse = self.brdf.diffuse() * FRAC_1_PI;
        out.cos.fill(0.0);
        out.sin.fill(0.0);
        out.cos[0] = TAU * diffuse;
        out.square = TAU * diffuse * diffuse;
        if let Brdf::Lambert(_) = self.brdf {
            return;
        }
        let width = self.brdf.azimuth_width(view_z, light_z);
        let reach = (PI / width).asinh();
        for &(x, weight) in &self.azimuths {
            // e^x by itself: sinh and cosh would take two exponentials.
            let grown = (reach * x).exp();
            let t = 0.5 * width * (grown - grown.recip());
            let weight = 0.5 * width * (grown + grown.recip()) * weight * reach;
            let (sin, cos) = t.sin_cos();
            let lobe = |sin: f64| {
                let (x, y) = (azimuth.0 * cos - azimuth.1 * sin, azimuth.1 * cos + azimuth.0 * sin);
                self.brdf.evaluate(view, DVec3::new(-light_sine * x, -light_sine * y, light_z)) - diffuse
            };
            let after = lobe(sin);
            let before = if self.isotropic { after } else { lobe(-sin) };
            let square = after * after + before * before;
            out.square += weight * (square + 2.0 * diffuse * (after + before));
            let (even, odd) = (weight * (after + before), weight * (after - before));
            // cos mΔ and sin mΔ at Δ = π + t.
            let mut turn = (1.0, 0.0);
            for (c, s) in out.cos.iter_mut().zip(&mut out.sin) {
                *c += even * turn.0;
                *s += odd * turn.1;
                turn = (-turn.0 * cos + turn.1 * sin, -turn.0 * sin - turn.1 * cos);
            }
        }
    }
}
