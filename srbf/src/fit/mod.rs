//! Scattered lobes that approximate a light (Tsai and Shih 2006, section 5.3), by better means than the paper's.
//!
//! The error is linear in the coefficients, so they are eliminated: what is minimised is the error of the best coefficients, over centres
//! and bandwidths alone (variable projection). Lobes are added in stages where the residual is largest, all of them move after each stage,
//! and at the end those that matter least are tried elsewhere.

mod chart;
mod coverage;
mod curvature;
mod descent;
mod design;
mod exchange;
mod greedy;
mod objective;
mod params;
mod pyramid;
mod solver;
mod starts;
mod target;

pub use params::{FitParams, Solver, Starts};

use crate::light::ScatteredLight;
use crate::lobe::Lobe;
use ndarray::{Array2, ArrayView2};
use prt_transfer::{Error, LightBasis, Progress, Result};
use solver::Work;
use target::Target;

/// A fitted light and how it came about.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The light.
    pub light: ScatteredLight,
    /// Σ (L - L̃)² dω / Σ L² dω over the texels' centres, all channels together; 0 for a black light.
    pub relative_squared_error: f64,
    /// ∫ L̃ dω over the sphere, of each channel, relative to that of the texels; less 1. What narrow lobes gain or lose because texels see
    /// their centres only. 0 where a channel is black.
    pub flux_error: Vec<f64>,
    /// The error after each stage, in order.
    pub history: Vec<Stage>,
}

/// What a fit did, and where it stood then.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// `start` (before lobes that were not found greedily move), `grow`, `exchange`, `refine`.
    pub name: &'static str,
    /// Texels that the error is taken over.
    pub texels: usize,
    /// Lobes then.
    pub lobes: usize,
    /// Relative squared error then.
    pub relative_squared_error: f64,
}

/// Fits lobes to a light on texels, lights x channels.
///
/// The same light, parameters and seed give the same lobes on any number of threads. Negative radiance is fitted as it is.
///
/// # Errors
/// Parameters out of range, a basis without texels, a light of another size or without a channel, NaN or infinite radiance, a progress
/// that cancels.
pub fn fit(params: &FitParams, basis: &LightBasis, light: ArrayView2<f32>, progress: &dyn Progress) -> Result<Fit> {
    params.check()?;
    let levels = pyramid::levels(basis, light, params.coarse)?;
    let mut work = Work::new(params, progress);
    let mut lobes: Vec<Lobe> = Vec::new();
    for (i, level) in levels.iter().enumerate() {
        let target = Target::new(&level.directions, &level.angles, &level.values, light.ncols())?;
        if target.is_black() {
            break;
        }
        lobes = if i == 0 { work.begin(&target)? } else { work.refine(&target, lobes)? };
    }
    let finest = levels.last().ok_or_else(|| Error::Unsupported {
        what: "light".into(),
        expected: "at least one texel".into(),
        found: "none".into(),
    })?;
    work.finish(finest, lobes, light.ncols())
}

/// Unnormalised coefficients: those of Ĝ = G/‖G‖ over ‖G‖, in the light's units.
fn coefficients(solution: &objective::Residual, energy: f64) -> Array2<f64> {
    let mut coefficients = solution.coefficients.mapv(|c| c * energy.sqrt());
    for (mut row, norm) in coefficients.outer_iter_mut().zip(&solution.design.norms) {
        row /= *norm;
    }
    coefficients
}

#[cfg(test)]
mod tests;
