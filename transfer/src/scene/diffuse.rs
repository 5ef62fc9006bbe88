//! `diffuse`: irradiance of every vertex, shadowed (Sloan et al. 2003; Ng et al. 2003). One row a vertex: the moments
//! `T_k = ∫ V(ω) max(n·ω, 0) b_k(ω) dω` over cubemap texels or real spherical harmonics, so that `y = T x` is irradiance in
//! W/m² for radiance `x` in W/m²/sr; exit radiance of a Lambertian surface is albedo/π times that.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::scene::dense::{self, DenseSignal};
use crate::scene::signal::{Samples, Sampling, Surface, Traced};
use crate::sh::Harmonics;
use rayon::prelude::*;

/// Shadowed irradiance in one light basis.
pub struct Diffuse {
    samples: Samples,
    basis: LightBasis,
    /// Bands of the light's harmonics; 0 for texels.
    order: usize,
    /// Harmonics of every lane, lanes x order².
    harmonics: Vec<f64>,
}

impl Diffuse {
    /// In `basis`: a cubemap of the sampling's resolution, or spherical harmonics.
    pub fn new(sampling: &Sampling, basis: &LightBasis) -> Result<Diffuse> {
        let samples = sampling.samples()?;
        let order = order_of(sampling, basis)?;
        let harmonics_at = Harmonics::new(order.max(1))?;
        let mut harmonics = vec![0f64; samples.lanes().len() * order * order];
        harmonics.par_chunks_exact_mut((order * order).max(1)).zip(samples.lanes()).for_each(|(y, sample)| {
            harmonics_at.evaluate(sample.direction.to_array().map(f64::from), y);
        });
        Ok(Diffuse { samples, basis: basis.clone(), order, harmonics })
    }
}

impl DenseSignal for Diffuse {
    fn basis(&self) -> LightBasis {
        self.basis.clone()
    }
    fn responses(&self) -> ResponseBasis {
        ResponseBasis::Irradiance
    }
    fn samples(&self) -> &Samples {
        &self.samples
    }
    fn rows_into(&self, surface: &Surface, point: usize, visible: &mut dyn Iterator<Item = usize>, out: &mut [f32]) {
        let (normal, order) = (surface.frames[point].normal, self.order);
        let mut row = vec![0f64; out.len()];
        for lane in visible {
            let sample = &self.samples.lanes()[lane];
            let weight = f64::from(sample.direction.dot(normal).max(0.0)) * sample.solid_angle;
            if order == 0 {
                row[sample.texel as usize] += weight;
            } else {
                let y = &self.harmonics[lane * order * order..][..order * order];
                row.iter_mut().zip(y).for_each(|(t, y)| *t += weight * y);
            }
        }
        out.iter_mut().zip(row).for_each(|(out, t)| *out = t as f32);
    }
}

/// The matrix `points x lights` of `basis`: a cubemap of the sampling's resolution, or spherical harmonics.
pub fn diffuse(
    surface: &Surface,
    sampling: &Sampling,
    basis: &LightBasis,
    progress: &dyn Progress,
) -> Result<(TransferMatrix, Traced)> {
    dense::matrix(&Diffuse::new(sampling, basis)?, surface, progress)
}

/// The order of the spherical harmonics, 0 for the sampled cubemap; any other basis is refused.
fn order_of(sampling: &Sampling, basis: &LightBasis) -> Result<usize> {
    match *basis {
        LightBasis::Cubemap { resolution } if resolution == sampling.resolution => Ok(0),
        LightBasis::SphericalHarmonics { order } if (1..=16).contains(&order) => Ok(order),
        _ => Err(Error::Unsupported {
            what: "light basis of a diffuse signal".into(),
            expected: format!("cubemap:{} (as it is sampled) or sh:ORDER with ORDER from 1 to 16", sampling.resolution),
            found: basis.to_string(),
        }),
    }
}
