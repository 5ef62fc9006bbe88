//! The estimator: a path from the eye, and at each of its points the lights.

use super::super::world::{SurfacePoint, World};
use super::lights::{Lights, Source};
use super::params::PathParams;
use super::scattering::{Part, Scattering};
use super::sequence::Sequence;
use super::sky::radiance;
use super::tally::Tally;
use crate::error::Result;
use crate::image::tone::luminance;
use glam::{DVec3, Vec3};

/// A world with all that is needed to trace paths through it.
///
/// A sample is told by a `key` (a pixel, a texel: keys are independent of each other) and an `index` (the samples of one key complement
/// each other, best in powers of two). Its value depends on nothing else.
pub struct PathTracer<'a> {
    world: &'a World,
    params: PathParams,
    lights: Lights,
    /// How much the two strategies are relied on, light and BRDF: Veach's numbers of samples in the heuristic. Any will do, if both
    /// are not 0.
    pub(super) efforts: [f64; 2],
}

impl<'a> PathTracer<'a> {
    /// Tables the lights.
    ///
    /// # Errors
    /// A clamp that is not positive.
    pub fn new(world: &'a World, params: PathParams) -> Result<PathTracer<'a>> {
        params.check()?;
        Ok(PathTracer { world, params, lights: Lights::of(world)?, efforts: [1.0; 2] })
    }

    /// The world.
    pub fn world(&self) -> &'a World {
        self.world
    }

    /// The parameters.
    pub fn params(&self) -> &PathParams {
        &self.params
    }

    /// Radiance that arrives at `origin` from the unit direction: the sky where nothing is met, and black backs.
    pub fn incoming(&self, origin: Vec3, direction: Vec3, key: u64, index: u32, tally: &mut Tally) -> Vec3 {
        let sequence = self.sequence(key, index);
        self.seen(origin, direction.as_dvec3(), &sequence, tally).unwrap_or_else(|| self.sky(direction.as_dvec3()))
    }

    /// Radiance that the diffuse part of the point's BRDF reflects, the same in all directions; all orders of light.
    pub fn diffuse(&self, point: &SurfacePoint, key: u64, index: u32, tally: &mut Tally) -> Vec3 {
        let view = point.geometric.as_dvec3();
        self.reflected(point, view, Part::Diffuse, &self.sequence(key, index), tally)
    }

    /// Radiance that the lobe of the point's BRDF reflects towards the unit direction `view`, which points away from the surface; all
    /// orders of light. 0 where the back is seen.
    pub fn lobe(&self, point: &SurfacePoint, view: Vec3, key: u64, index: u32, tally: &mut Tally) -> Vec3 {
        // Numbers of its own: a caller adds this to the diffuse part, and errors of one sign would add up.
        let sequence = self.sequence(!key, index);
        self.reflected(point, view.as_dvec3(), Part::Lobe, &sequence, tally)
    }

    pub(super) fn sequence(&self, key: u64, index: u32) -> Sequence {
        Sequence::new(self.params.seed, key, index)
    }

    /// Radiance of what a ray meets; `None` where it meets nothing.
    pub(super) fn seen(&self, origin: Vec3, direction: DVec3, sequence: &Sequence, tally: &mut Tally) -> Option<Vec3> {
        tally.rays += 1;
        let Some(hit) = self.world.occluders().nearest(origin, direction.as_vec3()) else {
            tally.paths += 1;
            return None;
        };
        let point = self.world.met(&hit);
        let reflected = self.reflected(&point, -direction, Part::Whole, sequence, tally);
        let front = point.geometric.as_dvec3().dot(direction) < 0.0;
        Some(if front { self.emission(&point) + reflected } else { Vec3::ZERO })
    }

    /// Radiance reflected towards a unit direction, as one sample has it.
    fn reflected(&self, point: &SurfacePoint, view: DVec3, part: Part, sequence: &Sequence, tally: &mut Tally) -> Vec3 {
        tally.paths += 1;
        if point.geometric.as_dvec3().dot(view) <= 0.0 {
            return Vec3::ZERO;
        }
        let sum = Scattering::new(self.world, point, view, part)
            .map_or(Vec3::ZERO, |scattering| self.path(scattering, sequence, tally));
        if !sum.is_finite() {
            tally.not_finite += 1;
            return Vec3::ZERO;
        }
        let brightness = f64::from(luminance(sum.to_array()));
        match self.params.clamp {
            Some(most) if brightness > most => {
                tally.clamped += 1;
                sum * (most / brightness) as f32
            }
            _ => sum,
        }
    }

    /// Follows a path from its first reflection on.
    fn path(&self, mut at: Scattering<'a>, sequence: &Sequence, tally: &mut Tally) -> Vec3 {
        let (mut sum, mut throughput) = (Vec3::ZERO, Vec3::ONE);
        for bounce in 1..=self.params.bounces {
            sum += throughput * self.lit(&at, sequence.light(bounce), tally);
            let [u, v, choice, survive] = sequence.scattering(bounce);
            let Some(scattered) = at.sample(choice, [u, v]) else { break };
            throughput *= scattered.value * scattered.density.recip() as f32;
            let (direction, density) = (scattered.direction, scattered.density);
            tally.rays += 1;
            let Some(hit) = self.world.occluders().nearest(at.origin, direction.as_vec3()) else {
                let weight = self.weight(density, 1, self.lights.density_of_sky(direction));
                sum += throughput * weight as f32 * self.sky(direction);
                break;
            };
            let point = self.world.met(&hit);
            let cosine = -direction.dot(point.geometric.as_dvec3());
            if cosine <= 0.0 {
                break;
            }
            let emission = self.emission(&point);
            if emission != Vec3::ZERO {
                let other = self.lights.density_of_face(emission, f64::from(hit.t).powi(2), cosine);
                sum += throughput * self.weight(density, 1, other.unwrap_or(0.0)) as f32 * emission;
            }
            if bounce == self.params.bounces {
                break;
            }
            if bounce >= self.params.roulette {
                let chance = throughput.max_element().min(1.0);
                if f64::from(chance) <= survive {
                    break;
                }
                throughput /= chance;
            }
            let Some(next) = Scattering::new(self.world, &point, -direction, Part::Whole) else { break };
            at = next;
        }
        sum
    }

    /// Light of one source, reflected.
    fn lit(&self, at: &Scattering, u: [f64; 4], tally: &mut Tally) -> Vec3 {
        let offset = self.world.occluders().offset();
        let Some(light) = self.lights.sample(at.origin.as_dvec3(), u, offset.into()) else { return Vec3::ZERO };
        let Some((value, density)) = at.towards(light.direction).filter(|(value, _)| *value != Vec3::ZERO) else {
            return Vec3::ZERO;
        };
        tally.rays += 1;
        let occluders = self.world.occluders();
        let (hidden, emitted) = match light.source {
            Source::Face(emission, before) => (occluders.between(at.origin, before), emission),
            Source::Sky => (occluders.occluded(at.origin, light.direction.as_vec3()), Vec3::ZERO),
        };
        if hidden {
            return Vec3::ZERO;
        }
        let emitted = if let Source::Sky = light.source { self.sky(light.direction) } else { emitted };
        value * emitted * (self.weight(light.density, 0, density) / light.density) as f32
    }

    /// The power heuristic: the weight of a strategy that draws with `density` what the other one draws with `other`.
    fn weight(&self, density: f64, strategy: usize, other: f64) -> f64 {
        let [own, other] = [self.efforts[strategy] * density, self.efforts[1 - strategy] * other].map(|p| p * p);
        if own > 0.0 { own / (own + other) } else { 0.0 }
    }

    fn emission(&self, point: &SurfacePoint) -> Vec3 {
        self.world.objects()[point.object as usize].material.emission
    }

    fn sky(&self, direction: DVec3) -> Vec3 {
        self.world.sky().map_or(Vec3::ZERO, |sky| radiance(sky, direction))
    }
}
