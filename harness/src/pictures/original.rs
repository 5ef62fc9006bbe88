//! A picture that others are compared with.

use prt_transfer::Result;
use prt_transfer::image::flip::{PIXELS_PER_DEGREE, Perceived};
use prt_transfer::image::{Flip, Image, Picture, Tone};
use serde::Serialize;

/// An image with how it is exposed and what is seen of it.
pub struct Original {
    image: Image,
    /// Stops, and the curve to the screen: of everything that is compared with it.
    exposure: f64,
    tone: Tone,
    picture: Picture,
    perceived: Perceived,
}

/// How far a picture is from the original over the pixels that the surface covers; what is infinite is null.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Of linear radiance.
    pub relative_squared_error: f64,
    /// Of the 8-bit pictures; infinite between equal ones.
    pub psnr_db: f64,
    /// Mean FLIP of them, 0 to 1.
    pub flip: f64,
}

/// A picture beside the original.
pub struct Comparison {
    /// Its errors.
    pub errors: Errors,
    /// Developed as the original is.
    pub picture: Picture,
    /// Of each pixel.
    pub flip: Flip,
}

impl Original {
    /// Linear radiance, which is raised by `exposure` stops.
    pub fn new(image: Image, exposure: f64, tone: Tone) -> Result<Original> {
        let picture = image.develop(exposure, tone);
        let perceived = Perceived::new(&picture, PIXELS_PER_DEGREE)?;
        Ok(Original { image, exposure, tone, picture, perceived })
    }

    /// Linear radiance.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// As a screen shows it.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Stops.
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    /// The picture of other radiance at the same exposure.
    pub fn develop(&self, image: &Image) -> Picture {
        image.develop(self.exposure, self.tone)
    }

    /// Errors of an image of the same view, over the pixels whose `coverage` is 1.
    ///
    /// # Errors
    /// An image of another size, a coverage that is not one number a pixel, and no covered pixel.
    pub fn compare(&self, image: &Image, coverage: &[f32]) -> Result<Comparison> {
        let relative_squared_error = image.relative_squared_error(&self.image, coverage)?;
        let picture = self.develop(image);
        let psnr_db = picture.psnr(&self.picture, coverage)?;
        let flip = Perceived::new(&picture, PIXELS_PER_DEGREE)?.flip(&self.perceived)?;
        let errors = Errors { relative_squared_error, psnr_db, flip: flip.mean_over(coverage)? };
        Ok(Comparison { errors, picture, flip })
    }
}
