//! BRDFs as sums of products, ρ(v, s) ≈ Σ_k φ_k(v) ψ_k(s): what makes a glossy transfer matrix `terms` (Tsai and Shih
//! 2006, §5.1, eq. 8-10; after Liu et al. 2004; Wang, Tran and Luebke 2004).
//!
//! Exit radiance is then Σ_k φ_k(v) ∫ L(s) T_k(s) ds with T_k(s) = ψ_k(s) V(s) (s·n).
//!
//! The terms are those of the singular value decomposition of ρ(v, s) cos θ_s over two hemispheres. The cosine is in,
//! since it is in T; so for every K the sum is the one that has the least squared error of exit radiance, over all
//! views and under white-noise light. φ_k are orthonormal over the hemisphere of views (∫ φ_j φ_k dμ = δ_jk) and carry
//! no scale; ψ_k cos θ_s are orthogonal, and their lengths are the singular values. So whatever the light and the
//! occlusion, errors e_k of the K integrals make a squared error of Σ_k e_k² in exit radiance over all views: plain
//! squared error on T is radiometric error. [`Views`] says what μ is.
//!
//! An isotropic BRDF has pairs of terms with one singular value, cos mφ and sin mφ times the same function of θ, and
//! any rotation within a pair would be as good. All models here are unchanged by mirrors in x and in y: blocks of even
//! and odd functions are decomposed apart, and no block holds both of a pair. So terms do not depend on how a machine
//! rounds. K may cut a pair in two: the cosine comes first.
//!
//! Near the horizon lobes become arbitrarily narrow in azimuth, and singular values fall slowly. Relative squared
//! errors of `cook-torrance:roughness=0.3`:
//!
//! | K | 1 | 4 | 8 | 16 | 24 | 64 |
//! | --- | --- | --- | --- | --- | --- | --- |
//! | `solid_angle` | 0.914 | 0.739 | 0.584 | 0.405 | 0.308 | 0.134 |
//! | `projected` | 0.769 | 0.459 | 0.268 | 0.123 | 0.069 | 0.013 |

mod extension;
pub(super) mod factor;
pub(super) mod kernel;
mod svd;
mod table;
mod terms;
#[cfg(test)]
mod tests;

pub use terms::Terms;

use crate::error::{Error, Result};
use crate::scene::brdf::Brdf;
use extension::Extension;
use factor::factor;
use glam::Vec3;
use kernel::{Kernel, Resolution};
use table::Table;

crate::choices! {
    /// The measure μ of views, over which error is counted and φ_k are orthonormal.
    pub enum Views {
        /// Solid angle dω: all views alike.
        SolidAngle = "solid_angle",
        /// Projected solid angle cos θ dω: views as much as a picture shows of the surface.
        Projected = "projected",
    }
}

/// The terms of a BRDF, ready to be evaluated at any direction.
pub struct SeparableBrdf {
    singular_values: Vec<f64>,
    /// ∫∫ (ρ cos θ)² over all views and lights: the sum of all squared singular values, those that were never computed
    /// included.
    energy: f64,
    terms: usize,
    view: Table,
    light: Table,
}

impl SeparableBrdf {
    /// Decomposes `brdf`, on rayon's current pool. The same terms on any number of threads.
    ///
    /// # Errors
    /// [`Error::Parameter`] for more terms than there are (`lambert` has one, and a black BRDF none), or a percentage
    /// out of range. [`Error::Unsupported`] for lobes too narrow to be resolved: a roughness of less than 0.05, a Phong
    /// exponent of more than 200, a Ward width of less than 0.1 (0.05 if both are equal).
    pub fn new(brdf: &Brdf, terms: Terms, views: Views) -> Result<SeparableBrdf> {
        let resolution = Resolution::of(brdf)?;
        let (factors, energy) = factor(&Kernel::new(brdf, views, resolution), resolution)?;
        let singular_values: Vec<f64> = factors.iter().map(|f| f.sigma).collect();
        let terms = terms.count(&singular_values)?;
        let (view, light) = Table::tabulate(&Extension::new(brdf, views, resolution, &factors[..terms]));
        Ok(SeparableBrdf { singular_values, energy, terms, view, light })
    }

    /// K, the number of terms.
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// Singular values, descending: those of the K terms, and all others up to Fourier order 47 of the azimuth (23
    /// where anisotropic).
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// The part of ∫∫ (ρ cos θ_s)² that the first `terms` terms lack, from 0 to 1: the relative squared error of exit
    /// radiance.
    pub fn relative_error(&self, terms: usize) -> f64 {
        let kept: f64 = self.singular_values.iter().take(terms).map(|sigma| sigma * sigma).sum();
        (1.0 - kept / self.energy).max(0.0)
    }

    /// `out[k]` = ψ_k(`light`) cos θ for a unit vector in local coordinates; zeros at the horizon and below.
    ///
    /// Interpolated in a table: of 16 terms with a roughness of 0.3, each is off by less than 1.2 % (root mean square
    /// over the hemisphere, relative to the term's own), most by less than 0.5 %; of 64 terms the last by some 5 %.
    ///
    /// # Panics
    /// If `out` has not one place for each term.
    #[inline]
    pub fn light(&self, light: Vec3, out: &mut [f32]) {
        self.light.read(light, out);
    }

    /// `out[k]` = φ_k(`view`) for a unit vector in local coordinates; zeros at the horizon and below. Interpolated as
    /// [`SeparableBrdf::light`] is.
    ///
    /// # Panics
    /// If `out` has not one place for each term.
    #[inline]
    pub fn view(&self, view: Vec3, out: &mut [f64]) {
        self.view.read(view, out);
    }
}

impl Resolution {
    /// Enough for `brdf`: twice as many rings and sectors change the first 16 singular values by less than 2e-5 of the
    /// largest. Orders bound only the tail of small singular values.
    fn of(brdf: &Brdf) -> Result<Resolution> {
        let (width, isotropic) = (brdf.width(), brdf.is_isotropic());
        let least = if isotropic { 0.05 } else { 0.1 };
        if width < least {
            return Err(Error::Unsupported {
                what: format!("separable terms of {brdf}"),
                expected: format!("a lobe of half vector slopes at least {least} wide"),
                found: width.to_string(),
            });
        }
        let rings = |scale: f64, low, high| ((scale / width) as usize).clamp(low, high);
        Ok(if isotropic {
            Resolution { rings: rings(3.2, 40, 64), orders: 48, sectors: 1 }
        } else {
            Resolution { rings: rings(3.6, 24, 32), orders: 24, sectors: 16 }
        })
    }
}
