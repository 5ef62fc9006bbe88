//! The picture of an exact matrix under a light, and others like it.

use super::original::{Comparison, Original};
use super::scenery::fill_behind;
use super::viewpoint::Viewpoint;
use crate::operator::Operator;
use ndarray::Array2;
use prt_transfer::image::{Image, Tone};

/// What is behind the scene: a dark grey of the screen, linear. A light there would be the same in all pictures and the largest part of their files.
const BEHIND: f32 = 0.03;

/// A picture to compare with, and what others need to be taken like it.
pub struct Portrait {
    light: Array2<f32>,
    original: Original,
}

impl Portrait {
    /// Of the exact matrix under a light, lights x 3 of radiance; exposed so that 95 percent of the surface stay below 0.6 of white.
    pub fn taken(viewpoint: &Viewpoint, matrix: &dyn Operator, light: Array2<f32>) -> anyhow::Result<Portrait> {
        let light = matrix.responses().light(matrix.basis(), light)?;
        let mut image = viewpoint.image(matrix, light.view())?;
        let exposure = image.automatic_exposure(viewpoint.coverage())?;
        fill_behind(&mut image, viewpoint.coverage(), behind(exposure));
        Ok(Portrait { light, original: Original::new(image, exposure, Tone::Clip)? })
    }

    /// The exact picture.
    pub fn original(&self) -> &Original {
        &self.original
    }

    /// What is behind the scene, linear RGB.
    pub fn behind(&self) -> [f32; 3] {
        behind(self.original.exposure())
    }

    /// What another matrix makes of the same light.
    pub fn image(&self, viewpoint: &Viewpoint, matrix: &dyn Operator) -> anyhow::Result<Image> {
        let mut image = viewpoint.image(matrix, self.light.view())?;
        fill_behind(&mut image, viewpoint.coverage(), self.behind());
        Ok(image)
    }

    /// The picture of another matrix, and its errors.
    pub fn compare(&self, viewpoint: &Viewpoint, matrix: &dyn Operator) -> anyhow::Result<Comparison> {
        Ok(self.original.compare(&self.image(viewpoint, matrix)?, viewpoint.coverage())?)
    }
}

/// [`BEHIND`] as radiance that is exposed to it.
fn behind(exposure: f64) -> [f32; 3] {
    [BEHIND / exposure.exp2() as f32; 3]
}
