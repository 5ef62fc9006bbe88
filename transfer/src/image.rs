//! Images of linear radiance, how they become pictures ([`tone`]), how two of them differ ([`difference`]) and how different they look
//! ([`flip`]).

pub mod difference;
pub mod flip;
pub mod tone;

use crate::error::{Error, Result};
pub use flip::Flip;
pub use tone::{Picture, Tone};

/// RGB pixels in rows from the top, linear radiance in W/m²/sr (or relative to it).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// Makes a loaded image a light: negative values (lossy compression and colour conversion leave them) become 0.
    /// Returns how many pixels had any.
    ///
    /// # Errors
    /// A number of pixels that is not width times height or is 0, and NaN or infinite values, with column and row.
    pub fn clamp_negatives(&mut self) -> Result<usize> {
        self.check()?;
        let negative = |pixel: &&mut [f32; 3]| pixel.iter().any(|&c| c < 0.0);
        let clamp = |pixel: &mut [f32; 3]| *pixel = pixel.map(|c| c.max(0.0));
        Ok(self.pixels.iter_mut().filter(negative).map(clamp).count())
    }

    /// Refuses what is not an image of finite values; see [`Image::clamp_negatives`].
    pub fn check(&self) -> Result<()> {
        Error::expect_size("pixels of the image", self.width.saturating_mul(self.height), self.pixels.len())?;
        if self.pixels.is_empty() {
            return Err(Error::Unsupported {
                what: "image".into(),
                expected: "at least one pixel".into(),
                found: format!("{} x {}", self.width, self.height),
            });
        }
        match self.pixels.iter().position(|pixel| pixel.iter().any(|c| !c.is_finite())) {
            None => Ok(()),
            Some(i) => Err(Error::Unsupported {
                what: format!("image: pixel at column {}, row {}", i % self.width, i / self.width),
                expected: "finite radiance".into(),
                found: format!("{:?}", self.pixels[i]),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: &[[f32; 3]]) -> Image {
        Image { width: 2, height: pixels.len() / 2, pixels: pixels.into() }
    }

    #[test]
    fn negative_pixels_are_counted_once_and_become_zero() {
        let mut light = image(&[[1.0, -2.0, -3.0], [0.0, -0.0, 5.0], [-1e-9, 0.0, 0.0], [1.0; 3]]);
        assert_eq!(light.clamp_negatives().unwrap(), 2);
        assert_eq!(light.pixels, [[1.0, 0.0, 0.0], [0.0, 0.0, 5.0], [0.0; 3], [1.0; 3]]);
        assert_eq!(light.clamp_negatives().unwrap(), 0);
    }

    #[test]
    fn pixels_that_are_not_finite_are_refused_with_their_place() {
        let mut light = image(&[[0.0; 3], [0.0; 3], [0.0; 3], [0.0, f32::NAN, 0.0]]);
        let message = light.clamp_negatives().unwrap_err().to_string();
        assert!(message.contains("column 1, row 1") && message.contains("NaN"), "{message}");
        light.pixels.pop();
        assert!(light.clamp_negatives().unwrap_err().to_string().contains("expected 4, found 3"));
        assert!(image(&[]).clamp_negatives().is_err());
    }
}
