//! Radiance of a surface at any place in any direction.

use super::{RadianceField, Sphere};
use prt_transfer::texels::Texels;
use prt_transfer::{Error, Result};

/// What is done between texels and between directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Bilinear on the surface and on the sphere: continuous, exact to the second order.
    #[default]
    Bilinear,
    /// The paper's: the inverse of the distance from each of four texels, and e^{d·d_i} for each of four directions, both made to add up to 1.
    /// Between directions close to each other the latter hardly differ: nearly the mean of the four, with a jump at the middle of each texel.
    Paper,
}

/// Radiance f(r, s, θ, φ) of a surface from what is known on its texels and in the directions of a sphere.
///
/// ```
/// use prt_slf::{Interpolation, Rows, Sphere, SurfaceLightField};
/// use prt_transfer::Shape;
/// use prt_transfer::texels::{Border, Texels};
///
/// // A grey slope: radiance grows from left to right, and is the same in all directions.
/// let (texels, sphere) = (Texels { width: 2, height: 1, border: Border::Clamp }, Sphere { z: 4, w: 2 });
/// let values = (0..2 * 3 * 8).map(|i| if i < 24 { 1.0 } else { 3.0 }).collect();
/// let rows = Rows::new(values, Shape::new(2, 3, 8)?)?;
/// let field = SurfaceLightField::new(texels, sphere, rows, Interpolation::Bilinear)?;
/// assert!((field.radiance([0.5, 0.5], [0.0, 0.6, 0.8])[0] - 2.0).abs() < 1e-6);
/// # Ok::<(), prt_transfer::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceLightField<F> {
    texels: Texels,
    sphere: Sphere,
    field: F,
    interpolation: Interpolation,
    /// Of the sphere's directions; none where they are not needed.
    centres: Vec<[f32; 3]>,
}

impl<F: RadianceField> SurfaceLightField<F> {
    /// A field on the texels of a surface and the directions of a sphere.
    ///
    /// # Errors
    /// Another number of either.
    pub fn new(texels: Texels, sphere: Sphere, field: F, interpolation: Interpolation) -> Result<SurfaceLightField<F>> {
        Error::expect_size(format!("texels of a light field on {texels}"), texels.count(), field.texels())?;
        let Sphere { z, w } = sphere;
        Error::expect_size(format!("directions of a light field on {z} x {w}"), sphere.count(), field.directions())?;
        if texels.count() == 0 || sphere.count() == 0 {
            return Err(Error::Unsupported {
                what: "radiance of a light field".into(),
                expected: "one texel and one direction, or more".into(),
                found: format!("{texels} texels, {z} x {w} directions"),
            });
        }
        let centres = if interpolation == Interpolation::Paper { sphere.centres() } else { Vec::new() };
        Ok(SurfaceLightField { texels, sphere, field, interpolation, centres })
    }

    /// Red, green and blue that leave the place with texture coordinates `uv` towards a direction of any length, in the axes of the sphere.
    pub fn radiance(&self, uv: [f32; 2], direction: [f32; 3]) -> [f32; 3] {
        let texels = self.texels.taps(uv);
        match self.interpolation {
            Interpolation::Bilinear => self.field.blend(&texels, &self.sphere.taps(direction)),
            Interpolation::Paper => {
                let nearest = self.sphere.nearest(direction);
                let length = direction.iter().map(|d| d * d).sum::<f32>().sqrt().max(f32::MIN_POSITIVE);
                let cosine = |at: u32| {
                    let centre = self.centres[at as usize];
                    direction.iter().zip(centre).map(|(d, c)| d * c).sum::<f32>() / length
                };
                let weights = normalised(nearest.map(|at| cosine(at).exp()));
                let directions: [(u32, f32); 4] = std::array::from_fn(|i| (nearest[i], weights[i]));
                self.field.blend(&self.by_distance(texels), &directions)
            }
        }
    }

    /// The field itself.
    pub fn field(&self) -> &F {
        &self.field
    }

    /// Texels weighted by the inverse of their distance in texture coordinates, which bilinear weights tell.
    fn by_distance(&self, texels: [(u32, f32); 4]) -> [(u32, f32); 4] {
        let (across, down) = (texels[1].1 + texels[3].1, texels[2].1 + texels[3].1);
        let weights = std::array::from_fn(|i| {
            let (x, y) = (if i % 2 == 0 { across } else { 1.0 - across }, if i < 2 { down } else { 1.0 - down });
            let (x, y) = (x / self.texels.width as f32, y / self.texels.height as f32);
            // In the middle of a texel it is alone.
            1.0 / x.hypot(y).max(f32::EPSILON)
        });
        let weights = normalised(weights);
        std::array::from_fn(|i| (texels[i].0, weights[i]))
    }
}

fn normalised(weights: [f32; 4]) -> [f32; 4] {
    let sum: f32 = weights.iter().sum();
    weights.map(|w| w / sum)
}
