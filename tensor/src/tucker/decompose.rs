//! From parameters and an array to a decomposition.

use super::Tucker;
use super::model::Model;
use super::params::{Algorithm, Ranks, TuckerParams};
use super::report::Report;
use super::truncate::Task;
use super::unfold;
use ndarray::{ArrayD, ArrayViewD};
use prt_transfer::{Error, Progress, Result};
use rayon::prelude::*;

/// Of all energy, what all modes together may lose as rounding.
const ZERO: f64 = 5e-13;
/// A relative squared error below is measured on the reconstruction: ‖T‖² - ‖G‖² is exact to 1e-14 of ‖T‖² or so.
const MEASURED: f64 = 1e-8;

/// Decomposes arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposer {
    params: TuckerParams,
}

impl Decomposer {
    /// Parameters, checked.
    ///
    /// # Errors
    /// One outside of its range.
    pub fn new(params: TuckerParams) -> Result<Decomposer> {
        params.check()?;
        Ok(Decomposer { params })
    }

    /// What was asked for.
    pub fn params(&self) -> &TuckerParams {
        &self.params
    }

    /// T ≈ G ×_1 U_1 … ×_N U_N for an array of any number of modes but none. A view that is not in C order is copied.
    ///
    /// An array of zeros, or of no elements, has ranks of 0 and an empty core.
    ///
    /// # Errors
    /// Ranks or an order of another number of modes; an element that is not finite (its row is the index in the first mode, its
    /// column counts the others in C order); a progress that stops.
    pub fn decompose(&self, tensor: ArrayViewD<f32>, progress: &dyn Progress) -> Result<Tucker> {
        let order = self.params.modes(tensor.shape())?;
        let copy = tensor.as_standard_layout();
        let tensor = copy.view();
        let energy = unfold::energy(&tensor);
        if !energy.is_finite() {
            return Err(not_finite(&tensor));
        }
        if energy == 0.0 {
            let report = Report { converged: true, ..Report::start(0.0) };
            return Ok(Tucker { model: Model::empty(tensor.shape()), energy, relative_error: 0.0, report });
        }
        let allowance = match self.params.ranks {
            Ranks::Given(_) => ZERO * energy,
            Ranks::MaxError(error) => (error - ZERO) * energy,
        };
        progress.start("Tucker", order.len() as u64);
        let task = Task { tensor, energy, allowance, params: &self.params, progress };
        let (mut model, converged) =
            if self.params.algorithm == Algorithm::Hosvd { task.hosvd()? } else { task.sequential(&order)? };
        let mut report = Report { converged: true, ..Report::start(task.relative(&model)) };
        if self.params.algorithm == Algorithm::Hooi {
            report = task.improve(&mut model, ZERO * energy / order.len() as f64)?;
        }
        report.converged &= converged;
        task.finish(&mut model)?;
        let relative_error = task.error(&model);
        Ok(Tucker { model, energy, relative_error, report })
    }
}

impl Task<'_> {
    /// The core of orthogonal slices, less what the bound leaves room for.
    fn finish(&self, model: &mut Model) -> Result<()> {
        let zero = ZERO * self.energy;
        model.turn(zero)?;
        if let Ranks::Given(_) = self.params.ranks {
            return Ok(());
        }
        while model.drop_slices(self.room(model)) {
            model.turn(zero)?;
        }
        Ok(())
    }

    /// What may still be left out.
    fn room(&self, model: &Model) -> f64 {
        self.allowance - (self.energy - model.energy())
    }

    /// ‖T - T̃‖²/‖T‖²: since factors are orthonormal and G the projection of T, 1 - ‖G‖²/‖T‖²; by its definition where that is near 0.
    fn error(&self, model: &Model) -> f64 {
        let relative = self.relative(model);
        if relative > MEASURED { relative } else { self.measured(&model.reconstruct()) / self.energy }
    }

    fn measured(&self, reconstruction: &ArrayD<f64>) -> f64 {
        let (exact, near) = (unfold::values(&self.tensor), reconstruction.as_slice().expect("products are in C order"));
        let part = |(exact, near): (&[f32], &[f64])| {
            exact.iter().zip(near).map(|(t, near)| (f64::from(*t) - near).powi(2)).sum::<f64>()
        };
        let parts: Vec<f64> = exact.par_chunks(1 << 18).zip(near.par_chunks(1 << 18)).map(part).collect();
        parts.iter().sum()
    }
}

fn not_finite(tensor: &ArrayViewD<f32>) -> Error {
    let values = unfold::values(tensor);
    let at =
        values.iter().position(|v| !v.is_finite()).expect("squares of finite numbers of 32 bits have a finite sum");
    let columns = values.len() / tensor.shape()[0];
    Error::NotFinite { row: at / columns, col: at % columns, value: f64::from(values[at]) }
}
