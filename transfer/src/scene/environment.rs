//! Distant light as a function of direction: a smooth background, and small bright caps that no grid could sample.

use super::resample::texel_of;
use crate::basis::{Direction, LightBasis, cubemap_direction, latlong_direction};
use crate::error::{Error, Result};
use crate::image::Image;
use glam::DVec3;
use ndarray::Array2;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Samples along each side of a texel over which the background is averaged: at least so many, and at least so many around
/// the equator, for lights have edges.
const SUPERSAMPLES: usize = 4;
const AROUND: usize = 1024;

/// A disk on the sphere of constant radiance: the sun, or a lamp seen from afar.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    /// Towards its centre, unit.
    pub centre: DVec3,
    /// Angular radius in radians.
    pub radius: f64,
    /// Linear RGB, W/m²/sr or relative to it; it hides the background.
    pub radiance: [f64; 3],
}

impl Cap {
    /// Solid angle in sr.
    pub fn solid_angle(&self) -> f64 {
        // 1 − cos r without cancellation.
        4.0 * PI * (0.5 * self.radius).sin().powi(2)
    }

    pub(super) fn contains(&self, direction: DVec3) -> bool {
        // Chord against chord: exact for small radii, where the cosine is not.
        direction.distance(self.centre) < 2.0 * (0.5 * self.radius).sin()
    }

    /// `n` directions spread evenly over the cap (a sunflower: equal areas, golden angle).
    fn directions(&self, n: usize) -> impl Iterator<Item = DVec3> {
        let (a, b) = self.centre.any_orthonormal_pair();
        let (cap, golden) = (*self, PI * (3.0 - 5.0_f64.sqrt()));
        (0..n).map(move |i| {
            let below = (i as f64 + 0.5) / n as f64 * cap.solid_angle() / (2.0 * PI);
            let (sine, (y, x)) = ((below * (2.0 - below)).sqrt(), (i as f64 * golden).sin_cos());
            (1.0 - below) * cap.centre + sine * (x * a + y * b)
        })
    }
}

/// A distant light. Total energy is the same at every resolution: caps are integrated over their own area and given to the
/// texels that they cover.
pub struct Environment {
    background: Box<dyn Fn(DVec3) -> DVec3 + Send + Sync>,
    caps: Vec<Cap>,
}

impl Environment {
    /// A background (linear RGB of a unit direction, z up) and caps, which must not overlap.
    pub fn new(background: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static, caps: Vec<Cap>) -> Environment {
        Environment { background: Box::new(background), caps }
    }

    /// The light turned about z by an angle in degrees, counter-clockwise seen from above.
    pub fn turned(self, degrees: f64) -> Environment {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let turn = move |d: DVec3, sine: f64| DVec3::new(cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z);
        let caps = self.caps.into_iter().map(|cap| Cap { centre: turn(cap.centre, sine), ..cap }).collect();
        Environment::new(move |d| (self.background)(turn(d, -sine)), caps)
    }

    /// The caps.
    pub fn caps(&self) -> &[Cap] {
        &self.caps
    }

    /// Linear RGB radiance from a unit direction.
    pub fn radiance(&self, direction: Direction) -> [f32; 3] {
        let direction = DVec3::from(direction);
        let cap = self.caps.iter().find(|cap| cap.contains(direction));
        cap.map_or_else(|| (self.background)(direction).to_array(), |cap| cap.radiance).map(|c| c as f32)
    }

    /// Mean radiance of each texel of a cubemap or a lat-long basis: lights x 3.
    ///
    /// # Errors
    /// A basis without texels.
    pub fn texels(&self, basis: &LightBasis) -> Result<Array2<f32>> {
        let angles = solid_angles(basis)?;
        let mut means = self.background_texels(basis)?;
        for cap in &self.caps {
            // At least 64 samples to a texel of mean size, and enough for a smooth rim where the cap is smaller than one.
            let texels = cap.solid_angle() / (4.0 * PI) * angles.len() as f64;
            let n = (64.0 * texels).max(4096.0) as usize;
            let share = cap.solid_angle() / n as f64;
            for d in cap.directions(n) {
                // The basis has texels, or there would be no angles.
                let Some(k) = texel_of(basis, d.to_array()) else { continue };
                means[k] += (DVec3::from(cap.radiance) - (self.background)(d)) * share / angles[k];
            }
        }
        Ok(Array2::from_shape_fn((means.len(), 3), |(k, channel)| means[k][channel].max(0.0) as f32))
    }

    /// Mean radiance of the background in each texel, without the caps.
    ///
    /// # Errors
    /// A basis without texels.
    pub(super) fn background_texels(&self, basis: &LightBasis) -> Result<Vec<DVec3>> {
        let texels = solid_angles(basis)?.len();
        Ok((0..texels).into_par_iter().map(|k| self.background_mean(basis, k)).collect())
    }

    /// A lat-long image of the light: the texels of [`LightBasis::LatLong`] of this size.
    ///
    /// # Errors
    /// An empty image.
    pub fn image(&self, width: usize, height: usize) -> Result<Image> {
        let texels = self.texels(&LightBasis::LatLong { width, height })?;
        let pixels = texels.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
        let image = Image { width, height, pixels };
        image.check()?;
        Ok(image)
    }

    /// The background averaged over texel `k`, weighted by solid angle.
    fn background_mean(&self, basis: &LightBasis, k: usize) -> DVec3 {
        let around = match *basis {
            LightBasis::Cubemap { resolution } => 4 * resolution,
            _ => (PI * basis.lights() as f64).sqrt() as usize,
        };
        let side = AROUND.div_ceil(around.max(1)).max(SUPERSAMPLES);
        let at = |i: usize, fine: usize, n: usize| (i as f64 + (fine as f64 + 0.5) / side as f64) / n as f64;
        let samples = (0..side * side).map(|s| (s % side, s / side));
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (i, j) in samples {
            let (direction, weight) = match *basis {
                LightBasis::Cubemap { resolution: r } => {
                    let [u, v] = [at(k % r, i, r), at(k / r % r, j, r)].map(|s| 2.0 * s - 1.0);
                    (cubemap_direction(k / (r * r), u, v), (1.0 + u * u + v * v).powf(-1.5))
                }
                LightBasis::LatLong { width, height } => {
                    let t = at(k / width, j, height);
                    (latlong_direction(at(k % width, i, width), t), (PI * t).sin())
                }
                _ => continue,
            };
            sum += weight * (self.background)(DVec3::from(direction));
            weights += weight;
        }
        sum / weights
    }
}

fn solid_angles(basis: &LightBasis) -> Result<Vec<f64>> {
    basis.solid_angles().ok_or_else(|| Error::Unsupported {
        what: "texels of a light".into(),
        expected: "a basis of texels (cubemap, latlong)".into(),
        found: basis.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energy(light: &Environment, basis: &LightBasis) -> f64 {
        let texels = light.texels(basis).unwrap();
        basis.solid_angles().unwrap().iter().zip(texels.column(0)).map(|(a, &l)| a * f64::from(l)).sum()
    }

    #[test]
    fn a_cap_keeps_its_energy_at_every_resolution_and_wherever_it_lies() {
        for (centre, radius) in [(DVec3::Z, 0.01), (DVec3::new(0.6, 0.0, -0.8), 0.005), (DVec3::ONE.normalize(), 0.3)] {
            let cap = Cap { centre, radius, radiance: [1e4, 0.0, 0.0] };
            let light = Environment::new(|_| DVec3::splat(2.0), vec![cap]);
            let expected = 8.0 * PI + (1e4 - 2.0) * cap.solid_angle();
            for basis in ["cubemap:3", "cubemap:40", "latlong:7x5", "latlong:256x128"] {
                let found = energy(&light, &basis.parse().unwrap());
                assert!((found / expected - 1.0).abs() < 1e-5, "{basis} {centre} {radius}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_directions_of_a_cap_lie_in_it_and_average_to_its_centroid() {
        let cap = Cap { centre: DVec3::new(0.0, 0.6, 0.8), radius: 0.7, radiance: [1.0; 3] };
        let directions: Vec<DVec3> = cap.directions(5000).collect();
        assert!(directions.iter().all(|&d| cap.contains(d) && d.is_normalized()));
        // ∫ d dω over a cap is π sin² r along its axis.
        let mean: DVec3 = directions.iter().sum::<DVec3>() / 5000.0;
        let expected = PI * cap.radius.sin().powi(2) / cap.solid_angle() * cap.centre;
        assert!((mean - expected).length() < 1e-4, "{mean} {expected}");
    }

    #[test]
    fn a_turned_light_is_seen_in_turned_directions() {
        let background = |d: DVec3| DVec3::new(2.0 + d.x, 2.0 - d.y, 2.0 + d.x * d.y * d.z);
        let cap = Cap { centre: DVec3::new(0.0, 0.6, 0.8), radius: 0.1, radiance: [50.0; 3] };
        let light = Environment::new(background, vec![cap]).turned(30.0);
        let basis = LightBasis::Cubemap { resolution: 9 };
        for d in basis.directions().unwrap().into_iter().map(DVec3::from) {
            // Back by 30 degrees, as glam turns.
            let before = glam::DQuat::from_rotation_z(-30f64.to_radians()) * d;
            let expected = if cap.contains(before) { DVec3::splat(50.0) } else { background(before) };
            let found = DVec3::from(light.radiance(d.to_array()).map(f64::from));
            assert!((found - expected).length() < 1e-5, "{d} {found} {expected}");
        }
    }

    #[test]
    fn texels_are_means_of_the_radiance() {
        // L = 1 + z: exact means over rings of the lat-long grid.
        let light = Environment::new(|d| DVec3::splat(1.0 + d.z), Vec::new());
        let image = light.image(6, 9).unwrap();
        for (row, pixels) in image.pixels.chunks(6).enumerate() {
            let [top, bottom] = [row, row + 1].map(|t| (PI * t as f64 / 9.0).cos());
            let expected = 1.0 + 0.5 * (top + bottom);
            assert!(pixels.iter().all(|p| (f64::from(p[1]) - expected).abs() < 1e-3), "{row} {expected} {pixels:?}");
        }
        assert!(light.texels(&LightBasis::Plain { lights: 4 }).is_err());
        assert!(light.image(0, 4).is_err());
    }
}
