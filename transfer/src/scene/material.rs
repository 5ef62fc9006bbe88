//! What a surface is made of: a grey reflectance model, coloured, and light of its own.

use super::brdf::Brdf;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::texels::{Border, Texels};
use glam::{DVec3, Vec2, Vec3};

/// Linear RGB reflectance, each channel from 0 to 1, by texture coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Uniform(Vec3),
    /// A function of the texture coordinates. Nothing checks its values.
    Pattern(fn(Vec2) -> Vec3),
    /// Bilinear between the middles of pixels; v runs from 0 at the top of the first row to 1 at the bottom of the last, and coordinates
    /// outside of the unit square are taken for the nearest inside.
    Image(Image),
}

impl Texture {
    /// The colour at a place.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        match self {
            Texture::Uniform(colour) => *colour,
            Texture::Pattern(colour) => colour(uv),
            Texture::Image(image) => {
                let texels = Texels { width: image.width, height: image.height, border: Border::Clamp };
                let pixel = |(texel, weight): (u32, f32)| weight * Vec3::from(image.pixels[texel as usize]);
                texels.taps(uv.to_array()).into_iter().map(pixel).sum()
            }
        }
    }

    fn check(&self) -> Result<()> {
        match self {
            Texture::Uniform(colour) => check_reflectance("diffuse colour", *colour),
            Texture::Pattern(_) => Ok(()),
            Texture::Image(image) => {
                image.check()?;
                image.pixels.iter().enumerate().try_for_each(|(i, &pixel)| {
                    let place = format!("texture: pixel at column {}, row {}", i % image.width, i / image.width);
                    check_reflectance(&place, pixel.into())
                })
            }
        }
    }
}

/// A surface. It reflects ρ(v, s) = `diffuse` · ρ_d + `specular` · ρ_s(v, s), with ρ_d the diffuse part of the BRDF and ρ_s its lobe. Its
/// back is black.
#[derive(Clone, Debug)]
pub struct Material {
    /// Grey.
    pub brdf: Brdf,
    /// Factor on the BRDF's diffuse part.
    pub diffuse: Texture,
    /// Factor on its lobe, each channel from 0 to 1.
    pub specular: Vec3,
    /// Radiance that leaves the front side in every direction, W/m²/sr; zero for most.
    pub emission: Vec3,
}

impl Material {
    /// A BRDF without colour or light of its own.
    pub fn grey(brdf: Brdf) -> Material {
        Material { brdf, diffuse: Texture::Uniform(Vec3::ONE), specular: Vec3::ONE, emission: Vec3::ZERO }
    }

    /// Whether radiance depends on the direction it is seen from.
    pub fn has_lobe(&self) -> bool {
        self.brdf.lobe_estimate(DVec3::Z) > 0.0 && self.specular != Vec3::ZERO
    }

    /// Whether anything is reflected alike in all directions.
    pub fn has_diffuse(&self) -> bool {
        self.brdf.diffuse() > 0.0
    }

    /// Refuses colours that reflect more than they receive or less than nothing, and emission that is negative or not finite.
    pub fn check(&self) -> Result<()> {
        self.diffuse.check()?;
        check_reflectance("specular colour", self.specular)?;
        if self.emission.is_finite() && self.emission.min_element() >= 0.0 {
            return Ok(());
        }
        Err(refuse("emission", "finite and not negative", self.emission))
    }
}

fn check_reflectance(what: &str, colour: Vec3) -> Result<()> {
    let fits = colour.to_array().iter().all(|c| (0.0..=1.0).contains(c));
    if fits { Ok(()) } else { Err(refuse(what, "three numbers from 0 to 1", colour)) }
}

fn refuse(what: &str, expected: &str, found: Vec3) -> Error {
    Error::Unsupported { what: format!("material: {what}"), expected: expected.into(), found: found.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        Image { width: 2, height: 2, pixels: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }
    }

    #[test]
    fn images_are_bilinear_from_the_top_row_and_clamped() {
        let texture = Texture::Image(image());
        let near = |uv: [f32; 2], expected: [f32; 3]| {
            let found = texture.at(uv.into());
            assert!((found - Vec3::from(expected)).length() < 1e-6, "{uv:?}: {found}");
        };
        near([0.75, 0.25], [1.0, 0.0, 0.0]);
        near([0.25, 0.75], [0.0, 1.0, 0.0]);
        near([0.5, 0.5], [0.25; 3]);
        near([0.5, 0.25], [0.5, 0.0, 0.0]);
        near([7.0, 9.0], [0.0, 0.0, 1.0]);
        near([-7.0, -0.1], [0.0; 3]);
    }

    #[test]
    fn what_no_surface_is_made_of_is_refused_with_the_number() {
        let good = Material::grey("lambert".parse().unwrap());
        good.check().unwrap();
        let refused = |material: Material, part: &str| {
            let message = material.check().unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        };
        refused(Material { emission: Vec3::new(0.0, -1.0, 0.0), ..good.clone() }, "emission");
        refused(Material { emission: Vec3::splat(f32::INFINITY), ..good.clone() }, "inf");
        refused(Material { specular: Vec3::splat(1.5), ..good.clone() }, "specular");
        refused(Material { diffuse: Texture::Uniform(Vec3::NAN), ..good.clone() }, "diffuse");
        let mut bright = image();
        bright.pixels[3][1] = 2.0;
        refused(Material { diffuse: Texture::Image(bright), ..good.clone() }, "column 1, row 1");
        let empty = Image { width: 0, height: 0, pixels: Vec::new() };
        refused(Material { diffuse: Texture::Image(empty), ..good }, "at least one pixel");
    }
}
