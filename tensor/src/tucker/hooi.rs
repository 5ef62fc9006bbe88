//! Higher-order orthogonal iteration (De Lathauwer, De Moor and Vandewalle 2000b, Algorithm 4.2).

use super::leading::{self, Want};
use super::model::Model;
use super::report::Report;
use super::truncate::Task;
use super::unfold::{self, Unfolding};
use prt_transfer::Result;

/// A part of the energy that is rounding: errors below are zero.
const ROUNDING: f64 = 1e-13;

impl Task<'_> {
    /// Improves a model of given ranks: U_n becomes the leading vectors of T ×_k U_kᵀ over all k ≠ n, mode after mode, until a sweep
    /// hardly changes the error.
    pub(super) fn improve(&self, model: &mut Model, zero: f64) -> Result<Report> {
        let mut report = Report::start(self.relative(model));
        self.progress.start("HOOI", self.params.sweeps as u64);
        while !report.converged && report.sweeps.len() < self.params.sweeps {
            let converged = self.sweep(model, zero)?;
            report.add(self.relative(model), self.params.tolerance, ROUNDING, converged);
            self.progress.advance(1)?;
        }
        Ok(report)
    }

    fn sweep(&self, model: &mut Model, zero: f64) -> Result<bool> {
        let mut converged = true;
        for mode in 0..model.factors.len() {
            let projected = unfold::project(self.tensor.view(), &model.factors, Some(mode));
            let want = Want { rank: model.factors[mode].ncols(), tail: zero };
            let view = projected.view();
            let leading = leading::leading(&Unfolding::new(&view, mode), want, self.params, mode, self.progress)?;
            converged &= leading.converged;
            model.core = unfold::product(view, mode, leading.vectors.view());
            model.factors[mode] = leading.vectors;
        }
        Ok(converged)
    }

    /// (‖T‖² - ‖G‖²)/‖T‖², known to 1e-14 or so.
    pub(super) fn relative(&self, model: &Model) -> f64 {
        ((self.energy - model.energy()) / self.energy).max(0.0)
    }
}
