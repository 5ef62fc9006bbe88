//! Variable projection: the error as a function of centres and bandwidths alone, their coefficients being the best ones.

use super::design::{Design, product, square};
use super::target::Target;
use crate::kernel::Kernel;
use crate::lobe::Lobe;
use ndarray::Array2;
use prt_transfer::linalg::Cholesky;
use rayon::prelude::*;

/// Weight of Σ ĉ² beside the relative squared error, ĉ being coefficients of normalised lobes in units of the light's norm: it keeps
/// lobes that nearly coincide from cancelling each other in large numbers, and costs nothing where they do not.
pub(super) const RIDGE: f64 = 1e-8;

/// Lobes with coefficients, and what they leave of the target.
pub(super) struct Residual<'a> {
    pub(super) design: Design<'a>,
    /// Of normalised lobes: lobes x channels.
    pub(super) coefficients: Array2<f64>,
    /// Y - A C of every tile: channels x directions.
    pub(super) residuals: Vec<Vec<f64>>,
    /// ‖Y - A C‖², relative to ‖Y‖².
    pub(super) error: f64,
    /// What is minimised: the error and the ridge's share.
    pub(super) objective: f64,
}

/// `lobes` with their best coefficients: min over C of ‖Y - A C‖² + ridge ‖C‖².
pub(super) fn solve<'a>(target: &'a Target, kernel: Kernel, lobes: &'a [Lobe]) -> Residual<'a> {
    solve_and_factor(target, kernel, lobes).0
}

/// As [`solve`], with the factor of AᵀA + ridge.
pub(super) fn solve_and_factor<'a>(target: &'a Target, kernel: Kernel, lobes: &'a [Lobe]) -> (Residual<'a>, Cholesky) {
    let design = Design::new(target, kernel, lobes);
    let normal = design.normal();
    let (factor, coefficients) = least_squares(normal.gram, normal.right);
    (Residual::new(design, coefficients), factor)
}

/// `lobes` with coefficients from elsewhere.
pub(super) fn fixed<'a>(
    target: &'a Target,
    kernel: Kernel,
    lobes: &'a [Lobe],
    coefficients: &Array2<f64>,
) -> Residual<'a> {
    Residual::new(Design::new(target, kernel, lobes), coefficients.clone())
}

fn least_squares(gram: Array2<f64>, right: Array2<f64>) -> (Cholesky, Array2<f64>) {
    // Far beyond what rounding takes from the least eigenvalue, so that the first attempt holds; sums of infinities never end here.
    let mut ridge = RIDGE;
    loop {
        let mut shifted = gram.clone();
        shifted.diag_mut().iter_mut().for_each(|d| *d += ridge);
        if let Some(factor) = Cholesky::factor(shifted) {
            let mut coefficients = right.clone();
            factor.solve(coefficients.view_mut());
            return (factor, coefficients);
        }
        ridge *= 10.0;
    }
}

impl<'a> Residual<'a> {
    fn new(design: Design<'a>, coefficients: Array2<f64>) -> Residual<'a> {
        let residuals = design.residuals(&coefficients);
        let error = square(&residuals);
        let objective = error + RIDGE * coefficients.iter().map(|c| c * c).sum::<f64>();
        Residual { design, coefficients, residuals, error, objective }
    }

    /// Gradient of the objective for each lobe: in the centre as a free vector (its tangential part is what counts), and in the
    /// bandwidth's coordinate. Coefficients are either fixed or at their minimum, so that only the lobes' own change matters.
    pub(super) fn gradient(&self) -> Vec<[f64; 4]> {
        let Design { target, lobes, .. } = &self.design;
        let parts: Vec<Vec<[f64; 4]>> =
            (0..target.tiles.len()).into_par_iter().map(|tile| self.gradient_on(tile)).collect();
        let mut gradient = vec![[0.0; 4]; lobes.len()];
        for (part, tile) in parts.iter().zip(&self.design.tiles) {
            for (part, &j) in part.iter().zip(&tile.active) {
                gradient[j].iter_mut().zip(part).for_each(|(sum, p)| *sum += p);
            }
        }
        gradient
    }

    /// What one tile adds, for its active lobes.
    fn gradient_on(&self, tile: usize) -> Vec<[f64; 4]> {
        let Design { target, kernel, lobes, tiles, .. } = &self.design;
        let (tile, design, residual) = (&target.tiles[tile], &tiles[tile], &self.residuals[tile]);
        let mut product_of = vec![0.0; tile.len()];
        let mut by_bandwidth = vec![0.0; tile.len()];
        let rows = design.values.chunks(tile.len()).zip(&design.active);
        rows.map(|(row, &j)| {
            let lobe = &lobes[j];
            // -2 Σ_c r_c ĉ_jc Ĝ_j
            product_of.fill(0.0);
            for (residual, c) in residual.chunks(tile.len()).zip(self.coefficients.row(j)) {
                product_of.iter_mut().zip(residual).for_each(|(p, r)| *p -= 2.0 * c * r);
            }
            product_of.iter_mut().zip(row).for_each(|(p, v)| *p *= v);
            let (slope, norm_slope) = (kernel.coordinate_slope(lobe.bandwidth), kernel.norm_slope(lobe.bandwidth));
            for (i, (p, b)) in product_of.iter_mut().zip(&mut by_bandwidth).enumerate() {
                let [by_mu, by_lambda] = kernel.logarithmic_slopes(lobe.cosine(tile.direction(i)), lobe.bandwidth);
                *b = *p * slope * (by_lambda - norm_slope);
                *p *= by_mu;
            }
            let [x, y, z] = [0, 1, 2].map(|axis| product(&product_of, &tile.directions[axis]));
            [x, y, z, by_bandwidth.iter().sum()]
        })
        .collect()
    }
}
