//! A light at one resolution and, where it is large, at half of it before.

use crate::light::ScatteredLight;
use ndarray::{Array2, ArrayView2};
use prt_transfer::basis::Direction;
use prt_transfer::{Error, LightBasis, Result};
use rayon::prelude::*;

/// A light of more texels is first fitted at half its resolution: two cubemaps of 32 texels an edge.
const LARGE: usize = 12_288;

/// A light on texels.
pub(super) struct Level {
    pub(super) directions: Vec<Direction>,
    /// Solid angle of each texel, sr.
    pub(super) angles: Vec<f64>,
    /// Texels x channels.
    pub(super) values: Vec<f32>,
}

impl Level {
    /// Σ L² dω.
    pub(super) fn energy(&self) -> f64 {
        let channels = self.values.len() / self.angles.len();
        let rows = self.values.chunks(channels).zip(&self.angles);
        rows.map(|(row, angle)| angle * row.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>()).sum()
    }

    /// Relative squared error of a light at the texels' centres, and that of the flux of each channel.
    pub(super) fn errors(&self, light: &ScatteredLight, channels: usize) -> (f64, Vec<f64>) {
        let radiance: Vec<Vec<f64>> = self.directions.par_iter().map(|d| light.radiance(*d)).collect();
        let (mut error, mut flux) = (0.0, vec![0.0; channels]);
        for ((row, values), angle) in radiance.iter().zip(self.values.chunks(channels)).zip(&self.angles) {
            for ((a, &b), flux) in row.iter().zip(values).zip(&mut flux) {
                error += angle * (a - f64::from(b)).powi(2);
                *flux += angle * f64::from(b);
            }
        }
        let relative = |(found, texels): (f64, &f64)| if *texels == 0.0 { 0.0 } else { found / texels - 1.0 };
        let flux = light.flux().into_iter().zip(&flux).map(relative).collect();
        (if error == 0.0 { 0.0 } else { error / self.energy() }, flux)
    }
}

/// From the coarsest to the light itself.
pub(super) fn levels(basis: &LightBasis, light: ArrayView2<f32>, coarse: bool) -> Result<Vec<Level>> {
    let unsupported = || Error::Unsupported {
        what: "light basis for fit-light".into(),
        expected: "texels: cubemap or latlong".into(),
        found: basis.to_string(),
    };
    let (directions, angles) = basis.directions().zip(basis.solid_angles()).ok_or_else(unsupported)?;
    Error::expect_size("light coefficients", angles.len(), light.nrows())?;
    if light.ncols() == 0 || light.nrows() == 0 {
        return Err(Error::Unsupported {
            what: "light".into(),
            expected: "at least one texel and one channel".into(),
            found: format!("{} x {}", light.nrows(), light.ncols()),
        });
    }
    let mut levels = match half(basis, light, &angles) {
        Some((smaller, light)) if coarse && angles.len() > LARGE => levels(&smaller, light.view(), coarse)?,
        _ => Vec::new(),
    };
    levels.push(Level { directions, angles, values: light.iter().copied().collect() });
    Ok(levels)
}

/// Means over 2 x 2 texels, by solid angle; `None` where texels do not pair up.
fn half(basis: &LightBasis, light: ArrayView2<f32>, angles: &[f64]) -> Option<(LightBasis, Array2<f32>)> {
    let even = |n: usize| n.is_multiple_of(2).then_some(n / 2);
    // Width of a row and of a row of the smaller one; faces follow each other as rows do.
    let (width, smaller) = match *basis {
        LightBasis::Cubemap { resolution } => (resolution, LightBasis::Cubemap { resolution: even(resolution)? }),
        LightBasis::LatLong { width, height } => {
            (width, LightBasis::LatLong { width: even(width)?, height: even(height)? })
        }
        _ => return None,
    };
    let mean = |k: usize, channel: usize| {
        let (row, column) = (k / (width / 2), k % (width / 2));
        let corner = 2 * row * width + 2 * column;
        let members = [corner, corner + 1, corner + width, corner + width + 1];
        let sum: f64 = members.iter().map(|&i| angles[i] * f64::from(light[[i, channel]])).sum();
        (sum / members.iter().map(|&i| angles[i]).sum::<f64>()) as f32
    };
    let means = Array2::from_shape_fn((smaller.lights(), light.ncols()), |(k, channel)| mean(k, channel));
    Some((smaller, means))
}
