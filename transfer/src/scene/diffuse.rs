//! `diffuse`: irradiance of every vertex, shadowed (Sloan et al. 2003; Ng et al. 2003). One row a vertex: the moments
//! `T_k = ∫ V(ω) max(n·ω, 0) b_k(ω) dω` over cubemap texels or real spherical harmonics, so that `y = T x` is irradiance in
//! W/m² for radiance `x` in W/m²/sr; exit radiance of a Lambertian surface is albedo/π times that.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::scene::signal::{Sampling, Surface, Traced, for_each_point};
use crate::sh::Harmonics;
use rayon::prelude::*;

/// The matrix `points x lights` of `basis`: a cubemap of the sampling's resolution, or spherical harmonics.
pub fn diffuse(
    surface: &Surface,
    sampling: &Sampling,
    basis: &LightBasis,
    progress: &dyn Progress,
) -> Result<(TransferMatrix, Traced)> {
    let samples = sampling.samples()?;
    let order = order_of(sampling, basis)?;
    let harmonics_at = Harmonics::new(order.max(1))?;
    let mut harmonics = vec![0f64; samples.lanes().len() * order * order];
    harmonics.par_chunks_exact_mut((order * order).max(1)).zip(samples.lanes()).for_each(|(y, sample)| {
        harmonics_at.evaluate(sample.direction.to_array().map(f64::from), y);
    });
    let (rows, traced) = for_each_point(surface, &samples, progress, |point, visible| {
        let normal = surface.frames[point].normal;
        let mut row = vec![0f64; basis.lights()];
        for lane in visible {
            let sample = &samples.lanes()[lane];
            let weight = f64::from(sample.direction.dot(normal).max(0.0)) * sample.solid_angle;
            if order == 0 {
                row[sample.texel as usize] += weight;
            } else {
                let y = &harmonics[lane * order * order..][..order * order];
                row.iter_mut().zip(y).for_each(|(t, y)| *t += weight * y);
            }
        }
        row.into_iter().map(|t| t as f32).collect::<Vec<f32>>()
    })?;
    let matrix = TransferMatrix::from_dense(rows.concat(), surface.points.len(), 1, basis.clone())?;
    Ok((matrix, traced))
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
