//! Bounded L-BFGS over centres and bandwidths.

use super::chart::{Chart, VARIABLES, charts, lobes_at};
use super::objective::{Residual, fixed, solve};
use super::target::Target;
use crate::kernel::Kernel;
use crate::lobe::Lobe;
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, Executor, FirstOrderState, Gradient,
    Lbfgsb,
};
use ndarray::Array2;
use std::convert::Infallible;

/// Pairs of steps and gradients from which curvature is known.
const MEMORY: usize = 20;

/// Where the largest slope is below this, relative to the light's square, the descent ends.
const LEAST_SLOPE: f64 = 1e-12;

/// Which variables move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Free {
    All,
    Centres,
    Bandwidths,
}

struct Problem<'a> {
    target: &'a Target,
    kernel: Kernel,
    charts: Vec<Chart>,
    free: Free,
    /// `None`: the best ones at every step.
    coefficients: Option<&'a Array2<f64>>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Free {
    /// Variables of a lobe that move.
    fn range(self) -> std::ops::Range<usize> {
        match self {
            Free::All => 0..VARIABLES,
            Free::Centres => 0..VARIABLES - 1,
            Free::Bandwidths => VARIABLES - 1..VARIABLES,
        }
    }
}

impl<'a> Problem<'a> {
    fn at<'l>(&self, lobes: &'l [Lobe]) -> Residual<'l>
    where
        'a: 'l,
    {
        match self.coefficients {
            Some(coefficients) => fixed(self.target, self.kernel, lobes, coefficients),
            None => solve(self.target, self.kernel, lobes),
        }
    }

    /// Values for the variables that move, in all of them.
    fn spread_out(&self, values: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.charts.len() * VARIABLES];
        let range = self.free.range();
        for (all, values) in all.chunks_mut(VARIABLES).zip(values.chunks(range.len())) {
            all[range.clone()].copy_from_slice(values);
        }
        all
    }
}

impl Constraints for Problem<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;
    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;
    fn cost(&self, values: &Vec<f64>) -> Result<f64, Infallible> {
        let lobes = lobes_at(&self.charts, &self.spread_out(values));
        Ok(self.at(&lobes).objective)
    }
}

impl Gradient for Problem<'_> {
    type Gradient = Vec<f64>;
    fn gradient(&self, values: &Vec<f64>) -> Result<Vec<f64>, Infallible> {
        Ok(self.cost_and_gradient(values)?.1)
    }
    fn cost_and_gradient(&self, values: &Vec<f64>) -> Result<(f64, Vec<f64>), Infallible> {
        let all = self.spread_out(values);
        let lobes = lobes_at(&self.charts, &all);
        let solution = self.at(&lobes);
        let gradient = solution.gradient();
        let charts = self.charts.iter().zip(all.chunks(VARIABLES)).zip(gradient);
        let free = charts.flat_map(|((chart, v), g)| chart.gradient(v, g)[self.free.range()].to_vec()).collect();
        Ok((solution.objective, free))
    }
}

/// At most `steps` steps down from `lobes`, of the best coefficients or of given ones.
pub(super) fn descend(
    target: &Target,
    kernel: Kernel,
    lobes: &[Lobe],
    bandwidths: [f64; 2],
    free: Free,
    coefficients: Option<&Array2<f64>>,
    steps: usize,
) -> Vec<Lobe> {
    let charts = || charts(lobes, kernel);
    let bounds = |end: usize| charts().iter().flat_map(|c| c.bounds(bandwidths)[end][free.range()].to_vec()).collect();
    let problem =
        || Problem { target, kernel, charts: charts(), free, coefficients, lower: bounds(0), upper: bounds(1) };
    let state = FirstOrderState::new(vec![0.0; lobes.len() * free.range().len()]);
    let solver = Lbfgsb::new().with_m_capacity(MEMORY).with_absolute_projected_gradient_tolerance(LEAST_SLOPE);
    match Executor::new(problem(), solver, state).max_iter(steps as u64).run() {
        Ok(result) => lobes_at(&charts(), &problem().spread_out(result.param())),
        // It stops so where no step along its direction lowers the error: where it stands is all there is to be had.
        Err(_) => lobes.to_vec(),
    }
}
