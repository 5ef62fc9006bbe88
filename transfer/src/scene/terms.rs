//! `terms`: light transfer of a BRDF that is factored into views and lights (Tsai and Shih 2006, Eq. 9 and 10). Rows
//! are (vertex, term), columns cubemap texels: `T_k = ∫ ψ_k(η) V(η) (η·n) dη` over each texel, so that exit radiance
//! towards v is `Σ_k φ_k(v) (T x)_k` for radiance `x`.

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::responses::ResponseBasis;
use crate::scene::brdf::Brdf;
use crate::scene::dense::DenseSignal;
use crate::scene::separable::{SeparableBrdf, Terms, Views};
use crate::scene::signal::{Samples, Sampling, Surface, Visible};

/// How views are weighted when a BRDF is cut to few terms: as much as a picture shows of the surface.
pub(crate) const VIEWS: Views = Views::Projected;

/// Light transfer of the terms of one BRDF.
pub struct TermTransfer {
    samples: Samples,
    basis: LightBasis,
    brdf: String,
    separable: SeparableBrdf,
}

impl TermTransfer {
    /// Of a surface of one BRDF everywhere, on a cubemap of the sampling's resolution.
    ///
    /// # Errors
    /// A BRDF that has not so many terms or too narrow a lobe.
    pub fn new(brdf: &Brdf, terms: Terms, sampling: &Sampling) -> Result<TermTransfer> {
        Ok(TermTransfer {
            samples: sampling.samples()?,
            basis: LightBasis::Cubemap { resolution: sampling.resolution },
            brdf: brdf.in_full(),
            separable: SeparableBrdf::new(brdf, terms, VIEWS)?,
        })
    }
}

impl DenseSignal for TermTransfer {
    fn basis(&self) -> LightBasis {
        self.basis.clone()
    }
    fn responses(&self) -> ResponseBasis {
        ResponseBasis::Terms { terms: self.separable.terms(), brdf: self.brdf.clone() }
    }
    fn samples(&self) -> &Samples {
        &self.samples
    }
    fn rows_into(&self, surface: &Surface, point: usize, visible: &Visible, out: &mut [f32]) -> Result<()> {
        let (frame, terms, texels) = (&surface.frames[point], self.separable.terms(), self.basis.lights());
        Error::expect_size("elements of a point's rows", terms * texels, out.len())?;
        let mut psi = vec![0f32; terms];
        // The terms of a texel side by side while they are added to, since they come together.
        let mut sums = vec![0f32; out.len()];
        for lane in visible.lanes() {
            let sample = &self.samples.lanes()[lane];
            self.separable.light(frame.to_local(sample.direction), &mut psi);
            let weight = sample.solid_angle as f32;
            let sums = &mut sums[sample.texel as usize * terms..][..terms];
            sums.iter_mut().zip(&psi).for_each(|(sum, psi)| *sum += weight * psi);
        }
        for (k, row) in out.chunks_exact_mut(texels).enumerate() {
            row.iter_mut().zip(sums[k..].iter().step_by(terms)).for_each(|(out, sum)| *out = *sum);
        }
        Ok(())
    }
}
