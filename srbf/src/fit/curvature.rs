//! Damped Gauss-Newton steps of the variable projection (Kaufman 1975), which see the curvature that L-BFGS has to learn.

use super::chart::{VARIABLES, charts, lobes_at};
use super::design::{Design, TileDesign, in_runs};
use super::objective::{Residual, solve, solve_and_factor};
use super::target::{Target, Tile};
use crate::kernel::Kernel;
use crate::lobe::{Lobe, dot};
use ndarray::{Array2, ArrayView2};
use prt_transfer::basis::Direction;
use prt_transfer::linalg::{self, Cholesky};

/// Rows for each lobe: its value, and its derivatives in its variables.
const ROWS: usize = 1 + VARIABLES;

/// As in [`super::design`], but fewer: their sums are larger.
const RUNS: usize = 4;

/// The damping at the start, relative to the curvature's diagonal.
const DAMPING: f64 = 1e-3;

/// A step that gains less than this share of the objective ends the descent.
const LEAST_GAIN: f64 = 1e-5;

/// At most `steps` steps down from `lobes`; every one of them lowers the objective.
pub(super) fn descend(
    target: &Target,
    kernel: Kernel,
    lobes: &[Lobe],
    bandwidths: [f64; 2],
    steps: usize,
) -> Vec<Lobe> {
    let mut lobes = lobes.to_vec();
    let (mut damping, mut growth) = (DAMPING, 2.0);
    let mut tries = 0;
    while tries < steps {
        let (here, factor) = solve_and_factor(target, kernel, &lobes);
        let (curvature, gradient) = model(&here, &factor);
        let mut next = None;
        while tries < steps && next.is_none() {
            tries += 1;
            let (moved, promised) = step(&lobes, kernel, bandwidths, &curvature, &gradient, damping);
            let gain = here.objective - solve(target, kernel, &moved).objective;
            if gain > 0.0 {
                // Nielsen 1999.
                damping *= (1.0 - (2.0 * gain / promised - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
                next = Some((moved, gain));
            } else {
                damping *= growth;
                growth *= 2.0;
                if damping > 1e10 {
                    return lobes;
                }
            }
        }
        let Some((moved, gain)) = next else { break };
        let settled = gain < LEAST_GAIN * here.objective;
        lobes = moved;
        if settled {
            break;
        }
    }
    lobes
}

/// Lobes after the step that minimises the damped quadratic model, and the gain which the model promises.
fn step(
    lobes: &[Lobe],
    kernel: Kernel,
    bandwidths: [f64; 2],
    curvature: &Array2<f64>,
    gradient: &[f64],
    damping: f64,
) -> (Vec<Lobe>, f64) {
    let n = gradient.len();
    let mut damped = curvature.clone();
    // Variables that do not act at all keep a little of what the others have.
    let floor = 1e-9 * damped.diag().iter().fold(0f64, |m, d| m.max(*d)) + f64::MIN_POSITIVE;
    let diagonal: Vec<f64> = damped.diag().iter().map(|d| d.max(floor)).collect();
    let charts = charts(lobes, kernel);
    let bounds: Vec<[[f64; VARIABLES]; 2]> = charts.iter().map(|c| c.bounds(bandwidths)).collect();
    let bound = |end: usize, i: usize| bounds[i / VARIABLES][end][i % VARIABLES];
    // A variable that stands at its bound and is pushed against it stays.
    let stuck: Vec<bool> = (0..n)
        .map(|i| (gradient[i] > 0.0 && bound(0, i) > -1e-9) || (gradient[i] < 0.0 && bound(1, i) < 1e-9))
        .collect();
    for i in 0..n {
        damped[[i, i]] += damping * diagonal[i];
        if stuck[i] {
            damped.row_mut(i).fill(0.0);
            damped.column_mut(i).fill(0.0);
            damped[[i, i]] = 1.0;
        }
    }
    let Some(factor) = Cholesky::factor(damped) else { return (lobes.to_vec(), 0.0) };
    let mut delta = Array2::from_shape_fn((n, 1), |(i, _)| if stuck[i] { 0.0 } else { -0.5 * gradient[i] });
    factor.solve(delta.view_mut());
    for (i, d) in delta.iter_mut().enumerate() {
        *d = d.clamp(bound(0, i), bound(1, i));
    }
    let delta = delta.into_raw_vec_and_offset().0;
    let curved: f64 = curvature
        .outer_iter()
        .zip(&delta)
        .map(|(row, d)| d * row.iter().zip(&delta).map(|(c, e)| c * e).sum::<f64>())
        .sum();
    let promised = -gradient.iter().zip(&delta).map(|(g, d)| g * d).sum::<f64>() - curved;
    (lobes_at(&charts, &delta), promised)
}

/// JᵀJ of the projected residuals and the gradient of the objective, in the variables of charts at the lobes.
///
/// With A the normalised lobes, D their derivatives and S = (AᵀA + ε)^-½ Aᵀ D, Kaufman's approximation of the Jacobian has the Gram
/// matrix (DᵀD - SᵀS) ∘ (Ĉ Ĉᵀ), each lobe's entry of the last factor standing for all its variables: channels need no copies.
fn model(solution: &Residual, factor: &Cholesky) -> (Array2<f64>, Vec<f64>) {
    let design = &solution.design;
    let charts = charts(design.lobes, design.kernel);
    let zeros = [0.0; VARIABLES];
    let gradient = charts.iter().zip(solution.gradient()).flat_map(|(c, g)| c.gradient(&zeros, g)).collect();
    let axes: Vec<[Direction; 2]> = charts.iter().map(|c| c.axes()).collect();
    let gram = gram(design, &axes);
    let n = design.lobes.len();
    // Rows of `gram` are ordered lobe by lobe: value, then derivatives.
    let mut cross =
        Array2::from_shape_fn((n, n * VARIABLES), |(i, q)| gram[[i * ROWS, q / VARIABLES * ROWS + 1 + q % VARIABLES]]);
    factor.solve_lower(cross.view_mut());
    let mut curvature = Array2::zeros((n * VARIABLES, n * VARIABLES));
    linalg::add_gram(cross.view(), curvature.view_mut());
    let colours = &solution.coefficients;
    let weights = colours.dot(&colours.t());
    for ((p, q), c) in curvature.indexed_iter_mut() {
        let (i, j) = (p / VARIABLES, q / VARIABLES);
        let own = gram[[i * ROWS + 1 + p % VARIABLES, j * ROWS + 1 + q % VARIABLES]];
        *c = (own - *c) * weights[[i, j]];
    }
    (curvature, gradient)
}

/// Gram matrix of all lobes' values and derivatives.
fn gram(design: &Design, axes: &[[Direction; 2]]) -> Array2<f64> {
    let n = design.lobes.len() * ROWS;
    let parts = in_runs(design.tiles.len(), RUNS, |run| {
        let mut sums = Array2::zeros((n, n));
        for (tile, of_tile) in design.pairs(run) {
            add_gram(design, tile, of_tile, axes, &mut sums);
        }
        sums
    });
    let mut all = Array2::zeros((n, n));
    parts.iter().for_each(|part| all += part);
    all
}

fn add_gram(design: &Design, tile: &Tile, of_tile: &TileDesign, axes: &[[Direction; 2]], sums: &mut Array2<f64>) {
    let (t, active) = (tile.len(), &of_tile.active);
    let mut rows = vec![0.0; active.len() * ROWS * t];
    for ((rows, values), &j) in rows.chunks_mut(ROWS * t).zip(of_tile.values.chunks(t)).zip(active) {
        derivatives(design, tile, j, values, axes[j], rows);
    }
    let rows = ArrayView2::from_shape((active.len() * ROWS, t), &rows[..]).expect("rows of a tile");
    let mut gram = Array2::zeros((rows.nrows(), rows.nrows()));
    linalg::times_transposed_f64(rows, rows, gram.view_mut());
    let place = |i: usize| active[i / ROWS] * ROWS;
    for (i, row) in gram.outer_iter().enumerate() {
        let row = row.to_slice().expect("contiguous");
        let mut sums = sums.row_mut(place(i) + i % ROWS);
        let sums = sums.as_slice_mut().expect("contiguous");
        for (part, &j) in row.chunks(ROWS).zip(active) {
            sums[j * ROWS..][..ROWS].iter_mut().zip(part).for_each(|(s, p)| *s += p);
        }
    }
}

/// Lobe `j`'s values, then their derivatives along both axes and in the bandwidth's coordinate.
fn derivatives(design: &Design, tile: &Tile, j: usize, values: &[f64], axes: [Direction; 2], rows: &mut [f64]) {
    let (lobe, kernel, t) = (&design.lobes[j], design.kernel, tile.len());
    let (slope, norm_slope) = (kernel.coordinate_slope(lobe.bandwidth), kernel.norm_slope(lobe.bandwidth));
    for (i, value) in values.iter().enumerate() {
        let direction = tile.direction(i);
        let [by_mu, by_lambda] = kernel.logarithmic_slopes(lobe.cosine(direction), lobe.bandwidth);
        rows[i] = *value;
        rows[t + i] = value * by_mu * dot(axes[0], direction);
        rows[2 * t + i] = value * by_mu * dot(axes[1], direction);
        rows[3 * t + i] = value * slope * (by_lambda - norm_slope);
    }
}
