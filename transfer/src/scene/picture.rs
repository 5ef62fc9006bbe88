//! Pictures of a world whose radiance someone else knows.

use super::camera::Camera;
use super::view::MAX_SAMPLES;
use super::world::{SurfacePoint, World};
use crate::basis::Direction;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::progress::Progress;
use glam::Vec3;
use rayon::prelude::*;

/// Who looks, how closely, and what is behind.
pub struct Shot<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Samples along an edge of a pixel, 1 to [`MAX_SAMPLES`], on a regular grid.
    pub samples: usize,
    /// Linear RGB by unit direction where nothing is met.
    pub background: &'a (dyn Fn(Direction) -> [f32; 3] + Sync),
}

/// The picture of `radiance`, linear RGB that leaves a point towards a unit direction, and for every pixel the share of its samples that meet
/// the world. The back of a surface is black. The result is the same on any number of threads.
///
/// # Errors
/// A number of samples out of range, and radiance that is not finite, with its pixel.
pub fn picture(
    world: &World,
    shot: &Shot,
    radiance: impl Fn(&SurfacePoint, Vec3) -> [f32; 3] + Sync,
    progress: &dyn Progress,
) -> Result<(Image, Vec<f32>)> {
    let (camera, samples) = (shot.camera, shot.samples);
    if !(1..=MAX_SAMPLES).contains(&samples) {
        let expected = format!("from 1 to {MAX_SAMPLES} along an edge of a pixel");
        let (method, name) = ("picture".into(), "samples".into());
        return Err(Error::Parameter { method, name, value: samples.to_string(), expected });
    }
    let (width, height) = (camera.width(), camera.height());
    let mut pixels = vec![([0f32; 3], 0f32); width * height];
    progress.start("picture", height as u64);
    pixels.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        for (x, (pixel, covered)) in row.iter_mut().enumerate() {
            let (mut sum, mut met) = ([0f64; 3], 0u32);
            for sample in 0..samples * samples {
                let place = |pixel: usize, within: usize| pixel as f64 + (within as f64 + 0.5) / samples as f64;
                let ray = camera.ray(place(x, sample % samples), place(y, sample / samples));
                let direction = ray.as_vec3();
                let colour = match world.occluders().nearest(camera.eye(), direction) {
                    None => (shot.background)(ray.to_array()),
                    Some(hit) => {
                        met += 1;
                        let point = world.met(&hit);
                        let front = point.geometric.dot(direction) < 0.0;
                        if front { radiance(&point, -direction) } else { [0.0; 3] }
                    }
                };
                sum.iter_mut().zip(colour).for_each(|(sum, c)| *sum += f64::from(c));
            }
            let count = (samples * samples) as f64;
            (*pixel, *covered) = (sum.map(|sum| (sum / count) as f32), (f64::from(met) / count) as f32);
        }
        progress.advance(1)
    })?;
    let (pixels, coverage) = pixels.into_iter().unzip();
    let image = Image { width, height, pixels };
    image.check()?;
    Ok((image, coverage))
}
