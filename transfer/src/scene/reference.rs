//! The picture that every method approximates: at each point that is seen, all directions of a sampled cubemap, traced.

use super::frames::Frame;
use super::shading::towards;
use super::signal::{Samples, Sampling, Surface, Visible};
use super::view::{Seen, View};
use crate::basis::{Direction, LightBasis};
use crate::error::{Error, Result};
use crate::image::Image;
use crate::progress::Progress;
use glam::Vec3;
use ndarray::ArrayView2;

/// A BRDF in 1/sr of unit local directions, out and in, z along the normal.
pub type Reflectance<'a> = dyn Fn(Vec3, Vec3) -> f32 + Sync + 'a;

/// Direct light on a surface: the exit radiance at point x towards v is
/// `Σ ρ(v, s) (n·s) L(s) dω_s` over the sampled directions s above the horizon of n that nothing hides.
///
/// It is the sum that the signals precompute at vertices, taken at every sample of a picture: n is the interpolated
/// vertex normal, and rays leave a point lifted along it ([`super::bvh::Occluders::visible`]), as they do at a vertex.
/// What differs between the two pictures is therefore interpolation over faces, and whatever a method did to the
/// matrix. Both have the shadow terminator of interpolated normals: where a face leans away from n, it hides directions
/// just above n's horizon.
pub struct Reference<'a> {
    /// The vertices that the view sees, and what casts shadows on them. Their frames are interpolated, for BRDFs that depend on the tangent.
    pub surface: Surface<'a>,
    /// How visibility is sampled.
    pub sampling: Sampling,
    /// Linear RGB radiance of each texel of the cubemap of the sampling's resolution: texels x 3.
    pub light: ArrayView2<'a, f32>,
    /// ρ(v, s).
    pub brdf: &'a Reflectance<'a>,
}

impl Reference<'_> {
    /// The image that a view has of the surface before `background`, linear RGB by unit direction. Every sample of a
    /// pixel is shaded by itself; the result is the same on any number of threads.
    ///
    /// # Errors
    /// Points or frames that are not one a vertex, a sampling out of range, a light that is not texels x 3 or not finite (row =
    /// texel), and a BRDF or background that is not finite, with its pixel.
    pub fn image(
        &self,
        view: &View,
        background: impl Fn(Direction) -> [f32; 3] + Sync,
        progress: &dyn Progress,
    ) -> Result<Image> {
        Error::expect_size("points, one for each vertex", view.vertices(), self.surface.points.len())?;
        Error::expect_size("frames, one for each vertex", view.vertices(), self.surface.frames.len())?;
        let samples = self.sampling.samples()?;
        let energy = self.energy(&samples)?;
        let surface = |seen: &Seen| Ok(self.radiance(view, seen, &samples, &energy));
        progress.start("reference", (view.camera().width() * view.camera().height()) as u64);
        view.shade(surface, background, |pixels| progress.advance(pixels))
    }

    /// L dω of each lane; 0 where a lane has no direction.
    fn energy(&self, samples: &Samples) -> Result<Vec<[f64; 3]>> {
        let basis = LightBasis::Cubemap { resolution: self.sampling.resolution };
        Error::expect_size(format!("light of a reference, texels of {basis}"), basis.lights(), self.light.nrows())?;
        Error::expect_size("channels of a reference's light", 3, self.light.ncols())?;
        if let Some(((row, col), &value)) = self.light.indexed_iter().find(|(_, l)| !l.is_finite()) {
            return Err(Error::NotFinite { row, col, value: f64::from(value) });
        }
        let lane = |(texel, angle): (u32, f64)| match texel {
            u32::MAX => [0.0; 3],
            texel => [0, 1, 2].map(|c| f64::from(self.light[[texel as usize, c]]) * angle),
        };
        Ok(samples.lanes().iter().map(|sample| lane((sample.texel, sample.solid_angle))).collect())
    }

    /// Exit radiance of one point towards the eye.
    fn radiance(&self, view: &View, seen: &Seen, samples: &Samples, energy: &[[f64; 3]]) -> [f32; 3] {
        let Surface { occluders, points, frames } = self.surface;
        let frame = Frame::interpolated(view.corners(seen, frames), seen.weights);
        let point = seen.mix(view.corners(seen, points));
        let out = towards(&frame, view.camera().eye() - point);
        let mut masks = vec![0; samples.directions().tiles()];
        occluders.visible(point, frame.normal, samples.directions(), &mut masks);
        let mut sum = [0f64; 3];
        for lane in (Visible { masks: &masks }).lanes() {
            let local = frame.to_local(samples.lanes()[lane].direction);
            let factor = f64::from((self.brdf)(out, local)) * f64::from(local.z);
            sum.iter_mut().zip(&energy[lane]).for_each(|(sum, energy)| *sum += factor * energy);
        }
        sum.map(|sum| sum as f32)
    }
}
