//! All that shines in a world, and how a point looks for it.

use super::super::world::World;
use super::choice::Choice;
use super::sky::{Background, Caps};
use super::triangles::Triangles;
use crate::error::Result;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Faces, the sky's background and the sky's caps: three kinds of light, of which a sample picks one.
pub(super) struct Lights {
    triangles: Option<Triangles>,
    background: Option<Background>,
    caps: Option<Caps>,
    /// `None` in the dark.
    kinds: Option<Choice>,
}

/// A light seen from a point.
pub(super) struct Towards {
    /// Unit.
    pub(super) direction: DVec3,
    /// Density per steradian.
    pub(super) density: f64,
    pub(super) source: Source,
}

/// Where light comes from.
pub(super) enum Source {
    /// A face: its radiance, and a point just in front of it.
    Face(Vec3, Vec3),
    /// Beyond all objects.
    Sky,
}

const FACES: usize = 0;
const BACKGROUND: usize = 1;
const CAPS: usize = 2;

impl Lights {
    pub(super) fn of(world: &World) -> Result<Lights> {
        let background = world.sky().map(Background::of).transpose()?.flatten();
        let (triangles, caps) = (Triangles::of(world), world.sky().and_then(Caps::of));
        // The sky sends through the sphere around the objects, of radius r, π r² times its energy.
        let section = PI * (0.5 * f64::from(world.occluders().diagonal())).powi(2);
        let powers = [
            triangles.as_ref().map_or(0.0, Triangles::power),
            background.as_ref().map_or(0.0, |background| section * background.energy),
            caps.as_ref().map_or(0.0, |caps| section * caps.energy),
        ];
        Ok(Lights { kinds: kinds(powers), triangles, background, caps })
    }

    /// A light for a point; `None` where what is picked does not face it. Rays towards faces end `offset` in front of them.
    pub(super) fn sample(&self, from: DVec3, [u, v, choice, _]: [f64; 4], offset: f64) -> Option<Towards> {
        let kinds = self.kinds.as_ref()?;
        let (kind, rest) = kinds.pick(choice);
        if kind == FACES {
            let shining = self.triangles.as_ref()?.sample(rest, [u, v]);
            let across = shining.position - from;
            let direction = across.try_normalize()?;
            let density =
                self.density_of_face(shining.emission, across.length_squared(), -direction.dot(shining.normal))?;
            let before = (shining.position + offset * shining.normal).as_vec3();
            return Some(Towards { direction, density, source: Source::Face(shining.emission, before) });
        }
        let direction = match kind {
            BACKGROUND => self.background.as_ref()?.sample([u, v])?,
            _ => self.caps.as_ref()?.sample(rest, [u, v]),
        };
        Some(Towards { direction, density: self.density_of_sky(direction), source: Source::Sky })
    }

    /// The density per steradian with which a point of a face is drawn at this squared distance and cosine; `None` where its back is seen.
    pub(super) fn density_of_face(&self, emission: Vec3, square: f64, cosine: f64) -> Option<f64> {
        let (kinds, triangles) = (self.kinds.as_ref()?, self.triangles.as_ref()?);
        (cosine > 0.0).then(|| kinds.probability(FACES) * triangles.density(emission) * square / cosine)
    }

    /// The density per steradian with which a direction is drawn that meets nothing.
    pub(super) fn density_of_sky(&self, direction: DVec3) -> f64 {
        let Some(kinds) = &self.kinds else { return 0.0 };
        let background = self.background.as_ref().map_or(0.0, |background| background.density(direction));
        let caps = self.caps.as_ref().map_or(0.0, |caps| caps.density(direction));
        kinds.probability(BACKGROUND) * background + kinds.probability(CAPS) * caps
    }
}

/// Half by power, half evenly: which of them matters to a point, nothing here knows.
fn kinds(powers: [f64; 3]) -> Option<Choice> {
    let (total, shining) = (powers.iter().sum::<f64>(), powers.iter().filter(|&&power| power > 0.0).count());
    Choice::new(powers.map(|power| if power > 0.0 { power / total + 1.0 / shining as f64 } else { 0.0 }))
}
