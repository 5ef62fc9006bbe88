//! What a point of a surface makes of light: the BRDF in the point's frame, and directions drawn from it.

use super::super::brdf::{Brdf, cosine_hemisphere};
use super::super::world::{SurfacePoint, World};
use crate::image::tone::luminance;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// Which part of a BRDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Both.
    Whole,
    /// What it reflects in all directions alike.
    Diffuse,
    /// The rest.
    Lobe,
}

/// A point from which light is reflected towards a view.
pub(super) struct Scattering<'a> {
    brdf: &'a Brdf,
    /// Lifted off the surface: where rays start.
    pub(super) origin: Vec3,
    geometric: DVec3,
    /// Tangent, bitangent, normal.
    frame: [DVec3; 3],
    /// In the frame.
    view: DVec3,
    /// The albedo of the diffuse part.
    diffuse: Vec3,
    /// Factor on the lobe.
    specular: Vec3,
    /// The probability that a direction is drawn from the lobe.
    share: f64,
}

/// A direction drawn from a BRDF.
pub(super) struct Scattered {
    /// Unit.
    pub(super) direction: DVec3,
    /// ρ cos θ, per steradian.
    pub(super) value: Vec3,
    /// Density per steradian.
    pub(super) density: f64,
}

impl<'a> Scattering<'a> {
    /// `view` is a unit direction above the face; `None` where nothing is reflected towards it. The diffuse part is seen from everywhere
    /// above the face, the lobe from above the horizon of the normal.
    pub(super) fn new(world: &'a World, point: &SurfacePoint, view: DVec3, part: Part) -> Option<Scattering<'a>> {
        let material = &world.objects()[point.object as usize].material;
        let brdf = &material.brdf;
        let (normal, tangent) = (point.normal.as_dvec3(), point.tangent.as_dvec3());
        let frame = [tangent, normal.cross(tangent), normal];
        let view = DVec3::from(frame.map(|axis| axis.dot(view)));
        let mut diffuse = Vec3::ZERO;
        if part != Part::Lobe && brdf.diffuse() > 0.0 {
            diffuse = brdf.diffuse() as f32 * material.diffuse.at(point.uv);
        }
        let lobe = if part != Part::Diffuse && view.z > 0.0 { brdf.lobe_estimate(view) } else { 0.0 };
        let weights = [luminance(diffuse.to_array()), lobe as f32 * luminance(material.specular.to_array())];
        if weights == [0.0; 2] {
            return None;
        }
        let [low, high] = weights.map(f64::from);
        // A colour that is no number gives 0 here, so that the density is one: it is found in the sum.
        let share = (high / (low + high)).max(0.0);
        let specular = if share > 0.0 { material.specular } else { Vec3::ZERO };
        let origin = point.position + world.occluders().offset() * point.geometric;
        Some(Scattering { brdf, origin, geometric: point.geometric.as_dvec3(), frame, view, diffuse, specular, share })
    }

    /// ρ cos θ of a unit direction that light comes from, and the density with which [`Scattering::sample`] draws it, both per steradian;
    /// `None` where no light from there is reflected.
    pub(super) fn towards(&self, direction: DVec3) -> Option<(Vec3, f64)> {
        let light = DVec3::from(self.frame.map(|axis| axis.dot(direction)));
        (light.z > 0.0 && self.geometric.dot(direction) > 0.0).then(|| self.local(light))
    }

    fn local(&self, light: DVec3) -> (Vec3, f64) {
        let cosine = light.z * FRAC_1_PI;
        let (mut value, mut density) = (cosine as f32 * self.diffuse, (1.0 - self.share) * cosine);
        if self.share > 0.0 {
            value += (self.brdf.lobe(self.view, light) * light.z) as f32 * self.specular;
            density += self.share * self.brdf.lobe_pdf(self.view, light);
        }
        (value, density)
    }

    /// A direction that light may come from; `None` is a sample of value 0.
    pub(super) fn sample(&self, choice: f64, u: [f64; 2]) -> Option<Scattered> {
        let lobe = choice < self.share;
        let light = if lobe { self.brdf.sample_lobe(self.view, u)? } else { cosine_hemisphere(u) };
        let direction = (0..3).map(|k| light[k] * self.frame[k]).sum::<DVec3>().normalize();
        let (value, density) = self.towards(direction)?;
        (density > 0.0).then_some(Scattered { direction, value, density })
    }
}
