//! The sky as a light: its background by a table of luminance, its caps one by one.

use super::super::environment::{Cap, Environment};
use super::super::resample::texel_of;
use super::choice::Choice;
use crate::basis::{Direction, LightBasis, latlong_direction};
use crate::error::Result;
use crate::image::tone::luminance;
use glam::DVec3;
use std::f64::consts::TAU;

/// Texels of the table, around the horizon and from pole to pole.
const WIDTH: usize = 256;
const HEIGHT: usize = 128;
const TABLE: LightBasis = LightBasis::LatLong { width: WIDTH, height: HEIGHT };

/// A density of directions, constant over each texel.
pub(super) struct Background {
    rows: Choice,
    /// Of each row that is ever picked.
    columns: Vec<Option<Choice>>,
    /// Per steradian, by texel.
    density: Vec<f64>,
    /// ∫ luminance dω.
    pub(super) energy: f64,
}

impl Background {
    /// In proportion to mean luminance; `None` where the background is black.
    pub(super) fn of(sky: &Environment) -> Result<Option<Background>> {
        let means = sky.background_texels(&TABLE)?;
        let ring = |row: usize| TAU * (z_of(row as f64) - z_of(row as f64 + 1.0)) / WIDTH as f64;
        let weight = |(k, mean): (usize, &DVec3)| brightness(*mean) * ring(k / WIDTH);
        let weights: Vec<f64> = means.iter().enumerate().map(weight).collect();
        let energy: f64 = weights.iter().sum();
        let Some(rows) = Choice::new(weights.chunks(WIDTH).map(|row| row.iter().sum())) else { return Ok(None) };
        let columns = weights.chunks(WIDTH).map(|row| Choice::new(row.iter().copied())).collect();
        let density = weights.iter().enumerate().map(|(k, weight)| weight / (energy * ring(k / WIDTH))).collect();
        Ok(Some(Background { rows, columns, density, energy }))
    }

    /// A direction and where it lies is drawn with [`Background::density`].
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> Option<DVec3> {
        let (row, down) = self.rows.pick(u);
        let (column, right) = self.columns[row].as_ref()?.pick(v);
        // Uniform by solid angle: in longitude, and in z.
        let [top, bottom] = [row, row + 1].map(|row| z_of(row as f64));
        let (z, [x, y, _]) =
            (top + down * (bottom - top), latlong_direction((column as f64 + right) / WIDTH as f64, 0.5));
        let sine = (1.0 - z * z).max(0.0).sqrt();
        Some(DVec3::new(sine * x, sine * y, z))
    }

    /// The density of a unit direction.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        texel_of(&TABLE, direction.to_array()).map_or(0.0, |texel| self.density[texel])
    }
}

/// Caps that shine, each uniformly.
pub(super) struct Caps {
    list: Vec<Cap>,
    choice: Choice,
    pub(super) energy: f64,
}

impl Caps {
    /// In proportion to luminance times solid angle; `None` where none shines.
    pub(super) fn of(sky: &Environment) -> Option<Caps> {
        let weight = |cap: &Cap| brightness(cap.radiance.into()) * cap.solid_angle();
        let list = sky.caps().to_vec();
        let weights: Vec<f64> = list.iter().map(weight).collect();
        let energy = weights.iter().sum();
        Some(Caps { choice: Choice::new(weights)?, list, energy })
    }

    pub(super) fn sample(&self, choice: f64, [u, v]: [f64; 2]) -> DVec3 {
        let cap = &self.list[self.choice.pick(choice).0];
        let (a, b) = cap.centre.any_orthonormal_pair();
        // 1 - cos, uniform from 0 to that of the rim.
        let below = u * cap.solid_angle() / TAU;
        let (sine, (y, x)) = ((below * (2.0 - below)).sqrt(), (TAU * v).sin_cos());
        (1.0 - below) * cap.centre + sine * (x * a + y * b)
    }

    /// The density of a unit direction.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let caps = self.list.iter().enumerate().filter(|(_, cap)| cap.contains(direction));
        caps.map(|(k, cap)| self.choice.probability(k) / cap.solid_angle()).sum()
    }
}

/// cos θ at a border between rows, counted from the north pole.
fn z_of(row: f64) -> f64 {
    latlong_direction(0.0, row / HEIGHT as f64)[2]
}

fn brightness(radiance: DVec3) -> f64 {
    f64::from(luminance(radiance.max(DVec3::ZERO).as_vec3().to_array()))
}

/// Radiance of a unit direction.
pub(super) fn radiance(sky: &Environment, direction: DVec3) -> glam::Vec3 {
    sky.radiance(Direction::from(direction)).into()
}
