//! `diffuse`: irradiance of every vertex, shadowed (Sloan et al. 2003; Ng et al. 2003). One row a vertex: the moments
//! `T_k = ∫ V(ω) max(n·ω, 0) b_k(ω) dω` over cubemap texels or real spherical harmonics, so that `y = T x` is
//! irradiance in W/m² for radiance `x` in W/m²/sr; exit radiance of a Lambertian surface is albedo/π times that.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::scene::bounce::{Arrival, Interreflecting};
use crate::scene::dense::{self, DenseSignal};
use crate::scene::moments::VisibilityMoments;
use crate::scene::signal::{Samples, Sampling, Surface, Traced, Visible};
use crate::sh::Products;
use glam::Vec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Shadowed irradiance in one light basis.
pub struct Diffuse {
    samples: Samples,
    basis: LightBasis,
    /// Of the surface, for light that it reflects onto itself.
    albedo: f64,
    /// `None` for texels.
    harmonics: Option<InHarmonics>,
}

/// `T_k = Σ_j γ n_m V_j`: the cosine is linear in the direction, so that the moments of visibility, one band more than
/// the light's, hold everything.
struct InHarmonics {
    moments: VisibilityMoments,
    /// Rows k of the light's bands, columns of bands 0 and 1.
    products: Products,
}

impl Diffuse {
    /// In `basis`: a cubemap of the sampling's resolution, or spherical harmonics. The albedo is 1, see
    /// [`Diffuse::with_albedo`].
    pub fn new(sampling: &Sampling, basis: &LightBasis) -> Result<Diffuse> {
        let samples = sampling.samples()?;
        let harmonics = match order_of(sampling, basis)? {
            0 => None,
            order => Some(InHarmonics {
                moments: VisibilityMoments::new(&samples, Products::bands(order, 2))?,
                products: Products::new(order, 2)?,
            }),
        };
        Ok(Diffuse { samples, basis: basis.clone(), albedo: 1.0, harmonics })
    }

    /// With a surface that reflects this part of its irradiance onto itself; of no matter without bounces.
    ///
    /// # Errors
    /// An albedo outside of 0 to 1.
    pub fn with_albedo(self, albedo: f64) -> Result<Diffuse> {
        if !(0.0..=1.0).contains(&albedo) {
            return Err(Error::Parameter {
                method: "diffuse".into(),
                name: "albedo".into(),
                value: albedo.to_string(),
                expected: "from 0 to 1".into(),
            });
        }
        Ok(Diffuse { albedo, ..self })
    }
}

impl InHarmonics {
    fn row_into(&self, normal: Vec3, visible: &Visible, out: &mut [f32]) {
        let mut moments = vec![0f64; self.moments.coefficients()];
        self.moments.sum_into(visible, &mut moments);
        let mut products = vec![0f64; 4 * out.len()];
        self.products.matrix_into(&moments, &mut products);
        // n·ω = √(4π/3) (n_y y_1 + n_z y_2 + n_x y_3)
        let scale = (4.0 * PI / 3.0).sqrt();
        let cosine = [0.0, normal.y, normal.z, normal.x].map(|c| scale * f64::from(c));
        for (out, row) in out.iter_mut().zip(products.chunks_exact(4)) {
            *out = row.iter().zip(cosine).map(|(t, c)| t * c).sum::<f64>() as f32;
        }
    }
}

impl DenseSignal for Diffuse {
    fn basis(&self) -> LightBasis {
        self.basis.clone()
    }
    fn responses(&self) -> ResponseBasis {
        ResponseBasis::Irradiance { brdf: None }
    }
    fn samples(&self) -> &Samples {
        &self.samples
    }
    fn rows_into(&self, surface: &Surface, point: usize, visible: &Visible, out: &mut [f32]) -> Result<()> {
        let normal = surface.frames[point].normal;
        if let Some(harmonics) = &self.harmonics {
            harmonics.row_into(normal, visible, out);
            return Ok(());
        }
        for lane in visible.lanes() {
            let sample = &self.samples.lanes()[lane];
            let weight = f64::from(sample.direction.dot(normal).max(0.0)) * sample.solid_angle;
            out[sample.texel as usize] += weight as f32;
        }
        Ok(())
    }
}

impl Interreflecting for Diffuse {
    fn bounced(&self) -> ResponseBasis {
        ResponseBasis::Irradiance { brdf: Some(format!("lambert:albedo={}", self.albedo)) }
    }

    fn bounce_into(
        &self,
        surface: &Surface,
        point: usize,
        arrivals: &[Arrival],
        leaving: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let normal = surface.frames[point].normal;
        // Every corner once, however many directions meet it.
        let mut shares: BTreeMap<u32, f64> = BTreeMap::new();
        for arrival in arrivals {
            let cosine = arrival.direction.dot(normal).max(0.0);
            let weight = f64::from(cosine * arrival.solid_angle) * self.albedo / PI;
            for (corner, share) in arrival.corners.into_iter().zip(arrival.shares) {
                *shares.entry(corner).or_default() += weight * f64::from(share);
            }
        }
        for (corner, share) in shares {
            let irradiance = &leaving[corner as usize * out.len()..][..out.len()];
            out.iter_mut().zip(irradiance).for_each(|(out, e)| *out += share as f32 * e);
        }
        Ok(())
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
