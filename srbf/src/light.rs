//! Lights as sums of scattered lobes.

use crate::kernel::Kernel;
use crate::lobe::{Lobe, dot, normalised};
use ndarray::{Array2, ArrayView2};
use prt_transfer::basis::Direction;
use prt_transfer::{Error, LightBasis, Result};
use rayon::prelude::*;

/// L(η) = Σ_j C_j G(η·ξ_j; λ_j), with coefficients for each channel (Tsai and Shih 2006, Eq. 21).
#[derive(Clone, Debug, PartialEq)]
pub struct ScatteredLight {
    kernel: Kernel,
    lobes: Vec<Lobe>,
    coefficients: Array2<f64>,
}

impl ScatteredLight {
    /// Lobes with their coefficients in W/m²/sr, lobes x channels. Centres are normalised.
    ///
    /// # Errors
    /// Coefficients of another number of lobes, or not finite; a centre that is not a unit vector to within 1e-3, a bandwidth outside
    /// [`Kernel::bandwidths`].
    pub fn new(kernel: Kernel, mut lobes: Vec<Lobe>, coefficients: Array2<f64>) -> Result<ScatteredLight> {
        Error::expect_size("coefficients of the light, one row for each lobe", lobes.len(), coefficients.nrows())?;
        if let Some(((row, col), &value)) = coefficients.indexed_iter().find(|(_, v)| !v.is_finite()) {
            return Err(Error::NotFinite { row, col, value });
        }
        for (i, lobe) in lobes.iter_mut().enumerate() {
            lobe.check(kernel).map_err(|(expected, found)| Error::Unsupported {
                what: format!("lobe {i} of the light"),
                expected,
                found,
            })?;
            lobe.centre = normalised(lobe.centre);
        }
        Ok(ScatteredLight { kernel, lobes, coefficients })
    }

    /// The function of the angle.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Centres and bandwidths.
    pub fn lobes(&self) -> &[Lobe] {
        &self.lobes
    }

    /// Lobes x channels, W/m²/sr at the centre of a Gaussian.
    pub fn coefficients(&self) -> ArrayView2<'_, f64> {
        self.coefficients.view()
    }

    /// Radiance of each channel from a unit direction.
    pub fn radiance(&self, direction: Direction) -> Vec<f64> {
        let mut sums = vec![0.0; self.coefficients.ncols()];
        for (lobe, row) in self.lobes.iter().zip(self.coefficients.outer_iter()) {
            let value = self.kernel.value(lobe.cosine(direction), lobe.bandwidth);
            sums.iter_mut().zip(row).for_each(|(sum, c)| *sum += c * value);
        }
        sums
    }

    /// ∫ L dω of each channel, W/m².
    pub fn flux(&self) -> Vec<f64> {
        let weights: Vec<f64> = self.lobes.iter().map(|lobe| self.kernel.integral(lobe.bandwidth)).collect();
        self.coefficients.columns().into_iter().map(|c| c.iter().zip(&weights).map(|(c, w)| c * w).sum()).collect()
    }

    /// Radiance at the centres of texels: lights x channels.
    ///
    /// # Errors
    /// A basis without texels.
    pub fn texels(&self, basis: &LightBasis) -> Result<Array2<f32>> {
        let directions = basis.directions().ok_or_else(|| Error::Unsupported {
            what: "texels of a light of lobes".into(),
            expected: "a basis of texels (cubemap, latlong)".into(),
            found: basis.to_string(),
        })?;
        let channels = self.coefficients.ncols();
        let rows: Vec<Vec<f64>> = directions.into_par_iter().map(|d| self.radiance(d)).collect();
        Ok(Array2::from_shape_fn((rows.len(), channels), |(k, channel)| rows[k][channel] as f32))
    }

    /// The light turned by a rotation, given by its rows: each centre ξ becomes R ξ.
    ///
    /// # Errors
    /// A matrix that is not a rotation to within 1e-6.
    pub fn rotated(&self, rotation: [Direction; 3]) -> Result<ScatteredLight> {
        let orthonormal = (0..9).all(|i| {
            let expected = if i / 3 == i % 3 { 1.0 } else { 0.0 };
            (dot(rotation[i / 3], rotation[i % 3]) - expected).abs() < 1e-6
        });
        let [x, y, z] = rotation;
        let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        if !orthonormal || dot(cross, z) < 0.0 {
            return Err(Error::Unsupported {
                what: "rotation of a light".into(),
                expected: "orthonormal rows of determinant 1".into(),
                found: format!("{rotation:?}"),
            });
        }
        let turned = |lobe: &Lobe| Lobe { centre: normalised(rotation.map(|row| dot(row, lobe.centre))), ..*lobe };
        Ok(ScatteredLight { lobes: self.lobes.iter().map(turned).collect(), ..self.clone() })
    }
}

#[cfg(test)]
mod tests;
