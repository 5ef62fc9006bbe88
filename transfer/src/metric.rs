//! In which a squared error is one of radiance.

use crate::basis::LightBasis;
use crate::error::Result;
use crate::matrix::TransferMatrix;
use crate::responses::{Coordinates, ResponseBasis};
use crate::sh::HemisphereSh;

/// The metric of a transfer matrix, on both sides.
///
/// An error ΔM of a sample's rows is worth `Σ_ij A_ij ΔM_i G⁻¹ ΔM_jᵀ`: the expected squared error of exit radiance over the hemisphere under
/// light that is white noise over the sphere, A being the Gram matrix of the responses' functions and G that of the light basis
/// ([`ResponseBasis::light_weights`]). A codec that works in orthonormal coordinates minimises radiometric error: with A = L Lᵀ
/// the coordinates `Lᵀ ΔM G^-½` are orthonormal: there it is the plain sum of squares.
pub struct Metric {
    /// The diagonal of G⁻¹; `None` where it is the identity or not known.
    weights: Option<Vec<f64>>,
    /// Exit radiance in functions that are not orthonormal; `None` where A is the identity or not known.
    exit: Option<HemisphereSh>,
    known: bool,
}

impl Metric {
    /// What the matrix's bases say.
    ///
    /// # Errors
    /// Responses that do not exist.
    pub fn of(matrix: &TransferMatrix) -> Result<Metric> {
        let weights = matrix.responses().light_weights(matrix.basis());
        let exit = match *matrix.responses() {
            ResponseBasis::Exit { coefficients, coordinates: Coordinates::Harmonics } => {
                Some(HemisphereSh::new(coefficients)?)
            }
            _ => None,
        };
        let orthonormal = matches!(
            matrix.basis(),
            LightBasis::SphericalHarmonics { .. } | LightBasis::Lobes { orthonormal: true, .. }
        );
        Ok(Metric { known: orthonormal || weights.is_some(), weights, exit })
    }

    /// Whether lights have a place on the sphere.
    pub fn is_known(&self) -> bool {
        self.known
    }

    /// Weights of the columns.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Whether an error of a sample is more than the sum of those of its rows.
    pub fn mixes_responses(&self) -> bool {
        self.exit.is_some()
    }

    /// A sample's rows, responses x lights, to coordinates in which Euclidean error is radiometric: `Lᵀ M G^-½`, in place.
    pub fn to_orthonormal(&self, rows: &mut [f64], lights: usize) {
        self.mix_to_orthonormal(rows);
        self.each_column(rows, lights, |value, weight| *value *= weight.sqrt());
    }

    /// The way back from [`Metric::to_orthonormal`], in place.
    pub fn from_orthonormal(&self, rows: &mut [f64], lights: usize) {
        self.each_column(rows, lights, |value, weight| *value /= weight.sqrt());
        if let Some(exit) = &self.exit {
            exit.to_harmonic(rows).expect(WHOLE);
        }
    }

    /// A vector over the lights as [`Metric::from_orthonormal`] takes it back: a sample of one rank, responses ⊗ lights, is taken back factor by
    /// factor.
    pub fn lights_from_orthonormal(&self, lights: &mut [f64]) {
        let count = lights.len();
        self.each_column(lights, count, |value, weight| *value /= weight.sqrt());
    }

    /// As [`Metric::lights_from_orthonormal`], a vector over the responses.
    pub fn responses_from_orthonormal(&self, responses: &mut [f64]) {
        if let Some(exit) = &self.exit {
            exit.to_harmonic(responses).expect(WHOLE);
        }
    }

    /// The squared norm of a sample's rows, responses x lights; they are overwritten.
    pub fn square_of(&self, rows: &mut [f64], lights: usize) -> f64 {
        self.mix_to_orthonormal(rows);
        let weight = |k: usize| self.weights.as_ref().map_or(1.0, |w| w[k]);
        rows.iter().enumerate().map(|(i, d)| weight(i % lights) * d * d).sum()
    }

    /// The squared norm of relit output, rows x channels in row-major order, over all samples.
    pub fn square_of_output(&self, output: impl Iterator<Item = f64>, channels: usize) -> f64 {
        let Some(exit) = &self.exit else { return output.map(|y| y * y).sum() };
        let mut output: Vec<f64> = output.collect();
        output
            .chunks_mut(exit.coefficients() * channels)
            .map(|sample| {
                self.mix_to_orthonormal(sample);
                sample.iter().map(|y| y * y).sum::<f64>()
            })
            .sum()
    }

    fn mix_to_orthonormal(&self, rows: &mut [f64]) {
        if let Some(exit) = &self.exit {
            exit.to_orthonormal(rows).expect(WHOLE);
        }
    }

    fn each_column(&self, rows: &mut [f64], lights: usize, scale: impl Fn(&mut f64, f64)) {
        let Some(weights) = &self.weights else { return };
        for row in rows.chunks_mut(lights.max(1)) {
            row.iter_mut().zip(weights).for_each(|(value, &weight)| scale(value, weight));
        }
    }
}

const WHOLE: &str = "rows are whole samples of as many responses as there are functions";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orthonormal_coordinates_carry_the_metric_and_lead_back() {
        for (responses, basis) in
            [("exit:8", "cubemap:2"), ("plain:8", "cubemap:2"), ("exit:8", "sh:3"), ("plain:8", "lobes:12:orthonormal")]
        {
            let basis: LightBasis = basis.parse().unwrap();
            let lights = basis.lights();
            let matrix = TransferMatrix::from_dense(vec![0.0; 8 * lights], 8, 8, basis).unwrap();
            let metric = Metric::of(&matrix.with_responses(responses.parse().unwrap()).unwrap()).unwrap();
            let rows: Vec<f64> = (0..8 * lights).map(|i| (i * 37 % 101) as f64 - 50.0).collect();
            let (square, mut moved) = (metric.square_of(&mut rows.clone(), lights), rows.clone());
            metric.to_orthonormal(&mut moved, lights);
            let plain: f64 = moved.iter().map(|d| d * d).sum();
            assert!((plain / square - 1.0).abs() < 1e-12, "{responses}: {plain} {square}");
            assert!(metric.is_known(), "{responses}");
            metric.from_orthonormal(&mut moved, lights);
            assert!(moved.iter().zip(&rows).all(|(a, b)| (a - b).abs() < 1e-9), "{responses}");
        }
    }

    #[test]
    fn columns_of_which_only_their_number_is_known_have_no_metric() {
        for basis in ["plain:12", "lobes:12"] {
            let matrix = TransferMatrix::from_dense(vec![1.0; 12], 1, 1, basis.parse().unwrap()).unwrap();
            assert!(!Metric::of(&matrix).unwrap().is_known(), "{basis}");
        }
    }
}
