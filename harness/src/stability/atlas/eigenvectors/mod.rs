//! Leading components of a matrix with known singular values: Miandji et al. 2011, Algorithm 1, against block methods.

mod condition;
mod gap;
mod repeated;
mod start;
mod units;

use super::case::Part;
use crate::stability::eigensolvers::spectra::Known;
use ndarray::ArrayView2;
use prt_cpca::Solver;
use prt_transfer::Result;

pub(super) const PART: Part = Part {
    name: "eigenvectors",
    title: "Eigenvectors",
    cases: &[units::CASE, start::CASE, gap::CASE, repeated::CASE, condition::CASE],
};

/// What a promise of [`Solver::Auto`] leaves for rounding where the optimum is next to nothing.
const PROMISE: &str = "1e-6 of the optimum, by a residual test";

const ALGORITHM_1: &str = "Miandji et al. 2011, Algorithm 1";

/// What is lost beyond the optimum of `components`, as a part of it.
fn excess(known: &Known, solver: Solver, components: usize, start: Option<ArrayView2<f64>>) -> Result<f64> {
    let found = solver.solver().leading(known.matrix.view(), components, start)?;
    Ok(beyond(known, known.lost(&found.vectors), components))
}

fn beyond(known: &Known, lost: f64, components: usize) -> f64 {
    let least = known.least(components);
    ((lost - least) / least).max(0.0)
}
