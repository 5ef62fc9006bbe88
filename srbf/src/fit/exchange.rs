//! Lobes that matter least, tried where the error is largest.

use super::greedy::Candidates;
use super::objective::{solve, solve_and_factor};
use super::solver::Work;
use super::target::Target;
use crate::lobe::Lobe;
use ndarray::Array2;

/// The first rounds exchange one lobe in so many; every [`ROUNDS`] rounds half as many.
const FIRST: usize = 16;

/// Rounds between two halvings.
const ROUNDS: usize = 4;

/// Steps of the solver in a round, of which the lobes that stay take some before the new ones come.
const STEPS: [usize; 2] = [2, 20];

/// The lobes after a round, or as they were where it does not pay.
pub(super) fn exchange(
    work: &mut Work,
    target: &Target,
    candidates: &Candidates,
    lobes: Vec<Lobe>,
    bandwidths: [f64; 2],
    round: usize,
) -> Vec<Lobe> {
    let kernel = work.params.kernel;
    let count = ((lobes.len() / FIRST) >> (round / ROUNDS).min(8)).max(1);
    let (before, factor) = solve_and_factor(target, kernel, &lobes);
    // Without lobe j the squared error grows by ‖ĉ_j‖² / (AᵀA)⁻¹_jj.
    let mut inverse = Array2::eye(lobes.len());
    factor.solve(inverse.view_mut());
    let cost = |j: usize| before.coefficients.row(j).dot(&before.coefficients.row(j)) / inverse[[j, j]];
    let mut order: Vec<(f64, usize)> = (0..lobes.len()).map(|j| (cost(j), j)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Which of those that matter little is left to chance: a round that did not pay must not be tried again as it was.
    let mut pool: Vec<usize> = order.iter().take(2 * count).map(|o| o.1).collect();
    while pool.len() > count {
        pool.swap_remove(work.random.below(pool.len()));
    }
    let kept: Vec<Lobe> = (0..lobes.len()).filter(|j| !pool.contains(j)).map(|j| lobes[j]).collect();
    let mut trial = work.moved(target, &kept, bandwidths, STEPS[0]);
    let more = candidates.best(&solve(target, kernel, &trial), lobes.len() - trial.len());
    trial.extend(more);
    let trial = work.moved(target, &trial, bandwidths, STEPS[1]);
    let pays = trial.len() == lobes.len() && solve(target, kernel, &trial).objective < before.objective;
    drop(before);
    if pays { trial } else { lobes }
}
