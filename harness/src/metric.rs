//! In which a squared error is one of radiance.

use prt_transfer::responses::Coordinates;
use prt_transfer::sh::HemisphereSh;
use prt_transfer::{LightBasis, ResponseBasis, Result, TransferMatrix};

/// The metric of a transfer matrix, on both sides.
///
/// An error ΔM of a sample's rows is worth `Σ_ij A_ij ΔM_i G⁻¹ ΔM_jᵀ`: the expected squared error of exit radiance over
/// the hemisphere under light that is white noise over the sphere, A being the Gram matrix of the responses' functions
/// and G that of the light basis.
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
        let orthonormal = matches!(matrix.basis(), LightBasis::SphericalHarmonics { .. });
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

    /// The squared norm of a sample's rows, responses x lights; they are overwritten.
    pub fn square_of(&self, rows: &mut [f64], lights: usize) -> f64 {
        self.to_orthonormal(rows);
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
                self.to_orthonormal(sample);
                sample.iter().map(|y| y * y).sum::<f64>()
            })
            .sum()
    }

    fn to_orthonormal(&self, rows: &mut [f64]) {
        if let Some(exit) = &self.exit {
            exit.to_orthonormal(rows).expect("rows are whole samples of as many responses as there are functions");
        }
    }
}
