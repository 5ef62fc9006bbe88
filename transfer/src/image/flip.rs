//! How different two pictures look when one flips into the other in place: LDR-FLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and
//! Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020).

mod colour;
mod features;
mod filter;

use super::difference::{covered, heat, same_size, some};
use super::tone::Picture;
use crate::error::{Error, Result};
use colour::{Lab, hyab};
use rayon::prelude::*;

/// Pixels within a degree of the field of view: a screen of 3840 pixels over 0.7 m, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.0206;

/// q_c: differences of colour are compressed by this power.
const COLOUR_POWER: f32 = 0.7;
/// p_c and p_t: differences up to this share of the largest are spread over this share of the range, since a screen shows hardly any larger.
const KNEE: [f32; 2] = [0.4, 0.95];
/// What is seen of a picture: colours through the contrast sensitivity of the eye, and edges and points. A reference is looked at once and
/// compared with many.
#[derive(Clone, Debug)]
pub struct Perceived {
    size: [usize; 2],
    colours: Vec<Lab>,
    /// Strength of edge and point.
    features: Vec<[f32; 2]>,
}

/// The visible difference of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// For each pixel ΔE from 0, no difference, to 1.
    pub map: Vec<f32>,
    /// Over all pixels.
    pub mean: f64,
}

impl Perceived {
    /// Looks at a picture from where `pixels_per_degree` (usually [`PIXELS_PER_DEGREE`]) of it fill a degree. Beyond its edges a picture goes
    /// on as it ends. The result is the same on any number of threads.
    ///
    /// # Errors
    /// Pixels that are not width x height or none, and pixels per degree not above 0 or more than 1000.
    pub fn new(picture: &Picture, pixels_per_degree: f64) -> Result<Perceived> {
        let Picture { width, height, pixels } = picture;
        let refuse = |what: &str, expected: &str, found: String| {
            Err(Error::Unsupported { what: what.into(), expected: expected.into(), found })
        };
        Error::expect_size("pixels of the picture", width.saturating_mul(*height), pixels.len())?;
        if pixels.is_empty() {
            return refuse("FLIP of a picture", "at least one pixel", format!("{width} x {height}"));
        }
        if !(pixels_per_degree > 0.0 && pixels_per_degree <= 1000.0) {
            return refuse("FLIP: pixels per degree", "above 0, at most 1000", pixels_per_degree.to_string());
        }
        let opponent = colour::opponent(picture);
        let features = features::of(&opponent[0], pixels_per_degree);
        Ok(Perceived { size: [*width, *height], colours: colour::seen(&opponent, pixels_per_degree), features })
    }

    /// The difference from a reference that was looked at from the same distance. It is symmetric.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn flip(&self, reference: &Perceived) -> Result<Flip> {
        same_size(self.size, reference.size)?;
        let [width, height] = self.size;
        let redistribution = Redistribution::new();
        let of_pixel = |i: usize| {
            let colour = redistribution.apply(hyab(self.colours[i], reference.colours[i]).powf(COLOUR_POWER));
            let [edge, point] = [0, 1].map(|f| (self.features[i][f] - reference.features[i][f]).abs());
            // q_f = 1/2: differences of features are stretched by a square root.
            let feature = (edge.max(point) / 2f32.sqrt()).sqrt();
            colour.powf(1.0 - feature)
        };
        let map: Vec<f32> = (0..width * height).into_par_iter().map(of_pixel).collect();
        let mean = mean(&map, 0..map.len());
        Ok(Flip { width, height, map, mean })
    }
}

impl Picture {
    /// The visible difference from a reference, at [`PIXELS_PER_DEGREE`]; see [`Perceived`].
    ///
    /// # Errors
    /// Pictures of different sizes, and what [`Perceived::new`] refuses.
    pub fn flip(&self, reference: &Picture) -> Result<Flip> {
        let [this, reference] = [self, reference].map(|picture| Perceived::new(picture, PIXELS_PER_DEGREE));
        this?.flip(&reference?)
    }
}

impl Flip {
    /// The mean over the covered pixels: those whose coverage is 1, as of every error of images. What their surroundings differ in is seen at
    /// some pixels' distance, but a wide background that is equal in both pictures does not lower the figure.
    ///
    /// # Errors
    /// A coverage that is not one number a pixel, and no covered pixel.
    pub fn mean_over(&self, coverage: &[f32]) -> Result<f64> {
        Ok(mean(&self.map, some(covered(self.map.len(), coverage)?)?))
    }

    /// The map in the colours of [`super::Image::error_map`], here evenly from 0 (black) to 1 (pale yellow), in 256 steps.
    pub fn picture(&self) -> Picture {
        let pixels = self.map.iter().map(|&e| heat((255.0 * f64::from(e)).round() / 255.0)).collect();
        Picture { width: self.width, height: self.height, pixels }
    }
}

fn mean(map: &[f32], pixels: impl Iterator<Item = usize>) -> f64 {
    let (sum, count) = pixels.fold((0.0, 0u64), |(sum, count), i| (sum + f64::from(map[i]), count + 1));
    sum / count as f64
}

/// How compressed differences of colour spread over 0 to 1: steeply up to the knee, the rare large ones above it.
struct Redistribution {
    /// The largest difference that there is: of pure green and blue.
    largest: f32,
}

impl Redistribution {
    fn new() -> Redistribution {
        Redistribution { largest: colour::largest_difference().powf(COLOUR_POWER) }
    }

    fn apply(&self, difference: f32) -> f32 {
        let [p_c, p_t] = KNEE;
        let knee = p_c * self.largest;
        if difference < knee {
            p_t / knee * difference
        } else {
            // Colours that filtering left a rounding error outside of the cube are no more different than that.
            (p_t + (difference - knee) / (self.largest - knee) * (1.0 - p_t)).min(1.0)
        }
    }
}

#[cfg(test)]
mod tests;
