//! What flickers: changes of relit output while a light turns that the exact matrix does not have.

use crate::error_sums::relative;
use crate::lights::Light;
use crate::operator::Operator;
use ndarray::{Array2, s};
use prt_transfer::{Error, Metric};

/// Steps of the turn, and degrees of each.
const STEPS: usize = 16;
const DEGREES: f64 = 2.0;

/// Numbers of relit output that are held at once, about: 64 MB.
const HELD: usize = 1 << 24;

/// A light that turns about z step by step, and what the exact matrix answers.
pub struct Turning {
    /// Lights x 3 channels of each step, the first one before it turns.
    lights: Array2<f32>,
    /// The exact output, rows x 3 channels of each step.
    exact: Array2<f32>,
    /// Σ_t |y_t − y_t-1|².
    size: f64,
}

impl Turning {
    /// A light that turns by 32 degrees in 16 steps, relit by the exact matrix.
    ///
    /// # Errors
    /// A basis without a place on the sphere.
    pub fn new(matrix: &dyn Operator, light: &Light, metric: &Metric) -> prt_transfer::Result<Turning> {
        let mut lights = Array2::zeros((matrix.shape().lights, 3 * (STEPS + 1)));
        for step in 0..=STEPS {
            let radiance = light.on(matrix.basis(), step as f64 * DEGREES)?;
            let light = matrix.responses().light(matrix.basis(), radiance)?;
            Error::expect_size("channels of a light that turns", 3, light.ncols())?;
            lights.slice_mut(s![.., 3 * step..3 * (step + 1)]).assign(&light);
        }
        let exact = matrix.relit(lights.view())?;
        let size = metric.square_of_output(changes(&exact), 3 * STEPS);
        Ok(Turning { lights, exact, size })
    }

    /// `Σ_t |(y_t − y_t-1) − (ỹ_t − ỹ_t-1)|² / Σ_t |y_t − y_t-1|²` of another matrix, in the metric of errors of relit output: 0 where every
    /// error of ỹ stays as it is while the light turns.
    pub fn flicker(&self, matrix: &dyn Operator, metric: &Metric) -> prt_transfer::Result<f64> {
        let at_once = (HELD / (3 * self.exact.nrows()).max(1)).clamp(2, STEPS + 1) - 1;
        self.flicker_of(matrix, metric, at_once)
    }

    /// [`Turning::flicker`], so many steps relit at once.
    pub(super) fn flicker_of(
        &self,
        matrix: &dyn Operator,
        metric: &Metric,
        at_once: usize,
    ) -> prt_transfer::Result<f64> {
        let mut sum = 0.0;
        for first in (0..STEPS).step_by(at_once) {
            let last = (first + at_once).min(STEPS);
            let columns = 3 * first..3 * (last + 1);
            let mut error = matrix.relit(self.lights.slice(s![.., columns.clone()]))?;
            error -= &self.exact.slice(s![.., columns]);
            sum += metric.square_of_output(changes(&error), 3 * (last - first));
        }
        Ok(relative(sum, self.size))
    }
}

/// From each step to the next, row by row.
fn changes(output: &Array2<f32>) -> impl Iterator<Item = f64> + '_ {
    let change = |row: usize, column: usize| f64::from(output[[row, column]]) - f64::from(output[[row, column - 3]]);
    (0..output.nrows()).flat_map(move |row| (3..output.ncols()).map(move |column| change(row, column)))
}
