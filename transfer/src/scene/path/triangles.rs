//! Faces that shine, as lights.

use super::super::world::World;
use super::choice::Choice;
use crate::image::tone::luminance;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Emissive faces. One is picked in proportion to area times luminance, and a point on it uniformly: the density by area is then
/// luminance over [`Triangles::total`], whichever it is.
pub(super) struct Triangles {
    list: Vec<Triangle>,
    choice: Choice,
    /// Σ area · luminance.
    total: f64,
}

struct Triangle {
    corner: DVec3,
    sides: [DVec3; 2],
    normal: DVec3,
    emission: Vec3,
}

/// A point on a light.
pub(super) struct Shining {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    pub(super) emission: Vec3,
}

impl Triangles {
    /// `None` where nothing shines.
    pub(super) fn of(world: &World) -> Option<Triangles> {
        let (mut list, mut weights) = (Vec::new(), Vec::new());
        for object in world.objects().iter().filter(|object| object.material.emission != Vec3::ZERO) {
            let emission = object.material.emission;
            for &face in &object.mesh.faces {
                let [a, b, c] = object.mesh.corners(face);
                let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
                list.push(Triangle { corner: a, sides: [b - a, c - a], normal, emission });
                weights.push(object.mesh.area_vector(face).length() * f64::from(luminance(emission.to_array())));
            }
        }
        let total = weights.iter().sum();
        Some(Triangles { list, choice: Choice::new(weights)?, total })
    }

    /// The flux that leaves all of them, W or what stands for it.
    pub(super) fn power(&self) -> f64 {
        PI * self.total
    }

    pub(super) fn sample(&self, choice: f64, [u, v]: [f64; 2]) -> Shining {
        let Triangle { corner, sides: [b, c], normal, emission } = self.list[self.choice.pick(choice).0];
        let root = u.sqrt();
        let position = corner + root * ((1.0 - v) * b + v * c);
        Shining { position, normal, emission }
    }

    /// The density by area of a point of this emission.
    pub(super) fn density(&self, emission: Vec3) -> f64 {
        f64::from(luminance(emission.to_array())) / self.total
    }
}
