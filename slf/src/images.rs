//! Maps as images: in memory the numbers of all images lie side by side for each pixel.

use crate::encoded::rounded;
use crate::haar;
use prt_transfer::numbers::{Numbers, code};
use rayon::prelude::*;

/// Images of one size in groups, memory being groups x pixels x images of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Images {
    pub(crate) groups: usize,
    /// In a group.
    pub(crate) images: usize,
    /// Width and height.
    pub(crate) size: [usize; 2],
}

/// The greatest code.
const MOST: f64 = i16::MAX as f64;

impl Images {
    pub(crate) fn pixels(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Images of all groups.
    pub(crate) fn count(&self) -> usize {
        self.groups * self.images
    }

    /// The image that each number belongs to where images lie one after the other.
    pub(crate) fn each(&self) -> impl Iterator<Item = usize> + Clone {
        let pixels = self.pixels();
        (0..self.count()).flat_map(move |image| std::iter::repeat_n(image, pixels))
    }

    /// One image after the other, in the Haar basis or as they are.
    pub(crate) fn taken(&self, values: &[f32], waves: bool) -> Vec<f64> {
        let (pixels, images) = (self.pixels(), self.images);
        let mut taken = vec![0f64; values.len()];
        taken.par_chunks_mut(pixels.max(1)).enumerate().for_each(|(image, out)| {
            let group = &values[image / images * pixels * images..];
            let own = group.iter().skip(image % images).step_by(images);
            out.iter_mut().zip(own).for_each(|(out, v)| *out = f64::from(*v));
            if waves {
                haar::forward(out, self.size);
            }
        });
        taken
    }

    /// The way back from [`Images::taken`] of what was stored.
    pub(crate) fn restored(&self, numbers: &Numbers, waves: bool) -> Vec<f32> {
        let (pixels, images) = (self.pixels(), self.images);
        let mut restored = vec![0f32; numbers.len()];
        restored.par_chunks_mut((pixels * images).max(1)).enumerate().for_each(|(group, out)| {
            let mut image = vec![0f64; pixels];
            for (i, number) in (group * images..(group + 1) * images).enumerate() {
                let scale = f64::from(numbers.scale(number));
                let stored = (number * pixels..).map(|at| f64::from(numbers.stored(at)) * scale);
                image.iter_mut().zip(stored).for_each(|(v, stored)| *v = stored);
                if waves {
                    haar::inverse(&mut image, self.size);
                }
                out.iter_mut().skip(i).step_by(images).zip(&image).for_each(|(out, v)| *out = rounded(*v));
            }
        });
        restored
    }
}

/// Numbers in steps of the scales of their images, one image after the other.
pub(crate) fn coded(taken: &[f64], pixels: usize, scales: &[f32]) -> Numbers {
    let code = |(at, v): (usize, &f64)| code(*v, f64::from(scales[at / pixels.max(1)]));
    Numbers::I16 { codes: taken.par_iter().enumerate().map(code).collect(), scales: scales.to_vec() }
}

/// The step of an image: at least what its largest number needs; 0 where all are.
pub(crate) fn scale(image: &[f64], step: f64) -> f32 {
    let largest = image.iter().fold(0f64, |largest, v| largest.max(v.abs()));
    // Rounded up, so that the largest number has a code.
    let least = (largest / MOST) as f32;
    let least = if f64::from(least) * MOST < largest { least.next_up() } else { least };
    if largest > 0.0 { (step as f32).max(least) } else { 0.0 }
}
