//! How far an image is from its reference, over the pixels that a surface covers.
//!
//! A pixel counts where its coverage is 1, that is where every sample of it met the surface: the background, which is
//! the same in both images and may hold the sun, stays out of the figures.

use super::tone::{Picture, srgb};
use super::{Image, Tone};
use crate::error::{Error, Result};

/// Decades of error that an error map shows, up to 1 (white at the exposure).
const DECADES: f64 = 3.0;

/// Black, violet, red, orange, pale yellow: sRGB codes, perceived as evenly brighter.
const HEAT: [[f64; 3]; 5] =
    [[0.0, 0.0, 4.0], [81.0, 18.0, 124.0], [183.0, 55.0, 121.0], [252.0, 137.0, 97.0], [252.0, 253.0, 191.0]];

/// The pixels that count.
pub(super) fn covered(pixels: usize, coverage: &[f32]) -> Result<impl Iterator<Item = usize>> {
    Error::expect_size("coverage, one number a pixel", pixels, coverage.len())?;
    Ok(coverage.iter().enumerate().filter(|(_, c)| **c == 1.0).map(|(i, _)| i))
}

impl Image {
    /// Σ (I − R)² / Σ R² over the covered pixels, R, G and B together, of linear radiance. Without an error it is 0,
    /// and infinite against a reference that is black.
    ///
    /// # Errors
    /// Images of different sizes, a coverage that is not one number a pixel, and no covered pixel.
    pub fn relative_squared_error(&self, reference: &Image, coverage: &[f32]) -> Result<f64> {
        same_size([self.width, self.height], [reference.width, reference.height])?;
        let (mut error, mut energy) = (0.0, 0.0);
        for i in some(covered(self.pixels.len(), coverage)?)? {
            for (&a, &b) in self.pixels[i].iter().zip(&reference.pixels[i]) {
                error += (f64::from(a) - f64::from(b)).powi(2);
                energy += f64::from(b).powi(2);
            }
        }
        Ok(if error == 0.0 { 0.0 } else { error / energy })
    }

    /// A picture of the error: for each covered pixel the root mean square of I − R over the channels, exposed by
    /// `exposure` stops, on a logarithmic scale from 0.001 (black) over violet (0.006), red (0.03) and orange (0.2) to
    /// 1 and more (pale yellow). What is not covered is black.
    ///
    /// # Errors
    /// As [`Image::relative_squared_error`].
    pub fn error_map(&self, reference: &Image, coverage: &[f32], exposure: f64) -> Result<Picture> {
        same_size([self.width, self.height], [reference.width, reference.height])?;
        let mut pixels = vec![[srgb(0.0); 3]; self.pixels.len()];
        for i in some(covered(self.pixels.len(), coverage)?)? {
            let channels = self.pixels[i].iter().zip(&reference.pixels[i]);
            let squares: f64 = channels.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
            pixels[i] = heat(1.0 + ((squares / 3.0).sqrt() * exposure.exp2()).log10() / DECADES);
        }
        Ok(Picture { width: self.width, height: self.height, pixels })
    }

    /// [`Picture::psnr`] of both images developed alike.
    ///
    /// # Errors
    /// As [`Image::relative_squared_error`].
    pub fn psnr(&self, reference: &Image, coverage: &[f32], exposure: f64, tone: Tone) -> Result<f64> {
        self.develop(exposure, tone).psnr(&reference.develop(exposure, tone), coverage)
    }
}

impl Picture {
    /// Peak signal-to-noise ratio in dB: 10 log₁₀ (255² / mean squared error) of the 8-bit codes of covered pixels, R,
    /// G and B together; infinite between equal ones.
    ///
    /// # Errors
    /// As [`Image::relative_squared_error`].
    pub fn psnr(&self, reference: &Picture, coverage: &[f32]) -> Result<f64> {
        same_size([self.width, self.height], [reference.width, reference.height])?;
        let (mut sum, mut count) = (0u64, 0u64);
        for i in some(covered(self.pixels.len(), coverage)?)? {
            let channels = self.pixels[i].iter().zip(&reference.pixels[i]);
            sum += channels.map(|(&a, &b)| u64::from(a.abs_diff(b)).pow(2)).sum::<u64>();
            count += 3;
        }
        Ok(10.0 * (255.0 * 255.0 * count as f64 / sum as f64).log10())
    }
}

pub(super) fn same_size([width, height]: [usize; 2], [other_width, other_height]: [usize; 2]) -> Result<()> {
    Error::expect_size("width of the image", other_width, width)?;
    Error::expect_size("height of the image", other_height, height)
}

/// The pixels, of which there must be one.
pub(super) fn some(pixels: impl Iterator<Item = usize>) -> Result<impl Iterator<Item = usize>> {
    let mut pixels = pixels.peekable();
    match pixels.peek() {
        Some(_) => Ok(pixels),
        None => Err(Error::Unsupported {
            what: "comparison of images".into(),
            expected: "a pixel that the surface covers wholly".into(),
            found: "none".into(),
        }),
    }
}

/// The colour of a place from 0 to 1 on the way from black to pale yellow.
pub(super) fn heat(place: f64) -> [u8; 3] {
    let steps = (HEAT.len() - 1) as f64;
    let place = (steps * place).clamp(0.0, steps);
    let low = (place as usize).min(HEAT.len() - 2);
    let mix = |c: usize| HEAT[low][c] + (place - low as f64) * (HEAT[low + 1][c] - HEAT[low][c]);
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn image(pixels: &[[f32; 3]]) -> Image {
        Image { width: pixels.len(), height: 1, pixels: pixels.to_vec() }
    }

    proptest! {
        #[test]
        fn a_relative_perturbation_is_its_own_square_and_uncovered_pixels_do_not_count(
            pixels in prop::collection::vec(prop::array::uniform3(0.01f32..5.0), 1..30), by in -0.5f32..0.5, other in 0f32..1e6,
        ) {
            let mut reference = image(&pixels);
            let mut changed = image(&pixels.iter().map(|p| p.map(|c| c * (1.0 + by))).collect::<Vec<_>>());
            reference.pixels.push([1.0; 3]);
            changed.pixels.push([other; 3]);
            (reference.width, changed.width) = (pixels.len() + 1, pixels.len() + 1);
            let mut coverage = vec![1.0; pixels.len()];
            coverage.push(0.99);
            let error = changed.relative_squared_error(&reference, &coverage).unwrap();
            prop_assert!((error - f64::from(by).powi(2)).abs() < 1e-5, "{} {}", error, by);
            prop_assert_eq!(reference.relative_squared_error(&reference, &coverage).unwrap(), 0.0);
        }
    }

    #[test]
    fn psnr_is_that_of_its_definition() {
        let picture = |code: u8| Picture { width: 2, height: 1, pixels: vec![[code; 3], [7; 3]] };
        // One of two pixels off by 51 = 255/5: mean squared error 255²/50.
        let ratio = picture(0).psnr(&picture(51), &[1.0, 1.0]).unwrap();
        assert!((ratio - 10.0 * 50f64.log10()).abs() < 1e-12);
        assert_eq!(picture(0).psnr(&picture(51), &[0.0, 1.0]).unwrap(), f64::INFINITY);
        // What the screen cannot show is no error of the picture.
        let [bright, brighter] = [[[2.0f32; 3]], [[9.0; 3]]].map(|pixels| image(&pixels));
        assert_eq!(bright.psnr(&brighter, &[1.0], 0.0, Tone::Clip).unwrap(), f64::INFINITY);
        assert!(bright.psnr(&brighter, &[1.0], -4.0, Tone::Clip).unwrap() < 20.0);
    }

    #[test]
    fn error_maps_brighten_with_the_error_by_decades() {
        let reference = image(&[[1.0; 3]; 6]);
        let errors = [0.0, 1e-3, 1e-2, 1e-1, 1.0, 50.0];
        let found = image(&errors.map(|e| [1.0 + e; 3]));
        let map = found.error_map(&reference, &[1.0; 6], 0.0).unwrap();
        let brightness: Vec<u32> = map.pixels.iter().map(|p| p.iter().map(|&c| u32::from(c)).sum()).collect();
        assert_eq!((map.pixels[0], map.pixels[4], map.pixels[5]), ([0, 0, 4], [252, 253, 191], [252, 253, 191]));
        assert!(brightness[1] <= 6 && brightness.windows(2).all(|pair| pair[0] <= pair[1]), "{brightness:?}");
        // A stop more shows twice the error.
        let [a, b] = [(0.02, 1.0), (0.04, 0.0)].map(|(e, exposure)| {
            image(&[[1.0 + e; 3]]).error_map(&image(&[[1.0; 3]]), &[1.0], exposure).unwrap().pixels[0]
        });
        assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1), "{a:?} {b:?}");
        assert_eq!(found.error_map(&reference, &[1.0, 1.0, 1.0, 1.0, 0.5, 1.0], 0.0).unwrap().pixels[4], [0; 3]);
    }

    #[test]
    fn images_that_do_not_fit_are_refused() {
        let (a, b) = (image(&[[1.0; 3]; 2]), image(&[[1.0; 3]; 3]));
        let message = a.relative_squared_error(&b, &[1.0; 2]).unwrap_err().to_string();
        assert!(message.contains("width") && message.contains("expected 3, found 2"), "{message}");
        assert!(a.relative_squared_error(&a, &[1.0; 3]).is_err());
        assert!(a.error_map(&a, &[0.5; 2], 0.0).is_err_and(|e| e.to_string().contains("covers")));
    }
}
