//! Path-traced pictures.

use super::super::camera::Camera;
use super::tally::Tally;
use super::tracer::PathTracer;
use crate::basis::Direction;
use crate::error::Result;
use crate::image::Image;
use crate::params::Params;
use crate::progress::Progress;
use glam::DVec3;
use rayon::prelude::*;

/// Most samples of a pixel.
pub const MAX_SAMPLES: u32 = 1 << 24;

/// A picture, and what it took.
#[derive(Clone, Debug)]
pub struct Traced {
    /// Linear RGB radiance, W/m²/sr.
    pub image: Image,
    /// For every pixel the share of its samples that met a surface, from 0 to 1.
    pub coverage: Vec<f32>,
    /// What tracing took.
    pub tally: Tally,
}

/// What a camera sees: `samples` directions spread evenly over each pixel (a box filter), before `background`, linear RGB by unit
/// direction. The same picture on any number of threads.
///
/// # Errors
/// A number of samples that is not from 1 to [`MAX_SAMPLES`], and a background that is not finite, with its pixel.
pub fn image(
    tracer: &PathTracer,
    camera: &Camera,
    samples: u32,
    background: impl Fn(Direction) -> [f32; 3] + Sync,
    progress: &dyn Progress,
) -> Result<Traced> {
    if !(1..=MAX_SAMPLES).contains(&samples) {
        return Err(super::PathParams::refuse("samples", samples, format!("from 1 to {MAX_SAMPLES} a pixel")));
    }
    let (width, height) = (camera.width(), camera.height());
    let mut pixels = vec![([0.0; 3], 0.0); width * height];
    progress.start("path", pixels.len() as u64);
    let rows = pixels.par_chunks_mut(width).enumerate().map(|(y, row)| {
        let mut tally = Tally::default();
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = mean(tracer, camera, [x, y], samples, &background, &mut tally);
        }
        progress.advance(width as u64)?;
        Ok(tally)
    });
    let tally = rows.try_reduce(Tally::default, |mut sum, row| {
        sum += row;
        Ok(sum)
    })?;
    let (pixels, coverage) = pixels.into_iter().unzip();
    let image = Image { width, height, pixels };
    image.check()?;
    Ok(Traced { image, coverage, tally })
}

/// One pixel and its coverage.
fn mean(
    tracer: &PathTracer,
    camera: &Camera,
    [x, y]: [usize; 2],
    samples: u32,
    background: &impl Fn(Direction) -> [f32; 3],
    tally: &mut Tally,
) -> ([f32; 3], f32) {
    let (key, mut sum, mut met) = ((y * camera.width() + x) as u64, DVec3::ZERO, 0);
    for index in 0..samples {
        let sequence = tracer.sequence(key, index);
        let [right, down, ..] = sequence.set(0);
        let direction = camera.ray(x as f64 + right, y as f64 + down);
        let seen = tracer.seen(camera.eye(), direction, &sequence, tally);
        met += u32::from(seen.is_some());
        sum += seen.unwrap_or_else(|| background(direction.to_array()).into()).as_dvec3();
    }
    ((sum / f64::from(samples)).as_vec3().to_array(), met as f32 / samples as f32)
}
