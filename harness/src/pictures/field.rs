//! A shape of a world, seen in its light field.

use crate::light_field::Field;
use crate::operator::Operator;
use crate::worlds::{self, Look, Needs};
use anyhow::Context;
use glam::Vec3;
use prt_slf::Interpolation;
use prt_transfer::image::Image;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::world::{SurfacePoint, World};
use rayon::prelude::*;

/// Samples along an edge of a pixel: a field is blurred already.
const SAMPLES: usize = 3;

/// The points of a shape that are seen, each with the direction towards the eye. Other shapes are not drawn, but hide what is behind them.
pub(super) struct SeenField {
    size: [usize; 2],
    /// By pixel, in rows from the top; of [`SAMPLES`]² samples those that meet the front of the shape.
    points: Vec<Vec<(SurfacePoint, Vec3)>>,
}

impl SeenField {
    /// A shape of a built-in world, as large as it fits, from where one stands to see the world; and the share of each pixel's samples that meet the shape.
    pub(super) fn new(name: &str, shape: &str, film: Film) -> anyhow::Result<(SeenField, Vec<f32>)> {
        let world = worlds::load(name, Look::default(), Needs::Charts)?;
        let object =
            world.objects().iter().position(|o| o.name == shape).with_context(|| format!("no shape {shape}"))?;
        let [eye, target] = worlds::view(name).with_context(|| format!("no view of {name}"))?;
        let camera = Camera::looking(eye, target, film)?.cropped(&world.objects()[object].mesh.positions)?;
        let pixels = (0..film.width * film.height).into_par_iter();
        let points: Vec<_> = pixels.map(|pixel| seen(&world, object, &camera, pixel)).collect();
        let coverage = points.iter().map(|seen| seen.len() as f32 / (SAMPLES * SAMPLES) as f32).collect();
        Ok((SeenField { size: [film.width, film.height], points }, coverage))
    }

    /// What leaves the shape towards the eye, by a matrix of its field.
    pub(super) fn image(&self, matrix: &dyn Operator) -> anyhow::Result<Image> {
        let field = Field::decoded(matrix, Interpolation::Bilinear)?;
        let pixel = |seen: &Vec<(SurfacePoint, Vec3)>| {
            let sum = seen.iter().fold([0f64; 3], |sum, (point, view)| {
                let radiance = field.radiance(point, *view);
                [0, 1, 2].map(|c| sum[c] + f64::from(radiance[c]))
            });
            sum.map(|sum| (sum / (SAMPLES * SAMPLES) as f64) as f32)
        };
        let pixels = self.points.par_iter().map(pixel).collect();
        let image = Image { width: self.size[0], height: self.size[1], pixels };
        image.check()?;
        Ok(image)
    }
}

/// What the samples of a pixel meet of an object.
fn seen(world: &World, object: usize, camera: &Camera, pixel: usize) -> Vec<(SurfacePoint, Vec3)> {
    let place = |pixel: usize, within: usize| pixel as f64 + (within as f64 + 0.5) / SAMPLES as f64;
    let of_sample = |sample: usize| {
        let (x, y) = (pixel % camera.width(), pixel / camera.width());
        let direction = camera.ray(place(x, sample % SAMPLES), place(y, sample / SAMPLES)).as_vec3();
        let point = world.met(&world.occluders().nearest(camera.eye(), direction)?);
        let front = point.geometric.dot(direction) < 0.0;
        (front && point.object as usize == object).then_some((point, -direction))
    };
    (0..SAMPLES * SAMPLES).filter_map(of_sample).collect()
}
