//! Where one more lobe takes most of the residual.

use super::objective::Residual;
use super::target::{Target, Tile};
use crate::icosphere;
use crate::kernel::Kernel;
use crate::lobe::Lobe;
use prt_transfer::basis::Direction;
use rayon::prelude::*;

/// Candidates' centres are about this many spreads apart.
const SPACING: f64 = 0.7;

/// A lobe whose values are below this share of its peak is not looked for there.
const NEGLIGIBLE: f64 = 1e-3;

/// Lobes of one batch may overlap by so much of their norm.
const OVERLAP: f64 = 0.5;

/// The spread of the widest candidates, rad.
const WIDEST: f64 = 1.2;

/// Lobes on a grid of centres and bandwidths.
pub(super) struct Candidates {
    kernel: Kernel,
    lobes: Vec<Lobe>,
}

impl Candidates {
    /// Spreads from the narrowest bandwidth to a hemisphere, each about 1.4 times the one before, centres as dense as they are narrow, but
    /// no denser than the target's directions.
    pub(super) fn new(target: &Target, kernel: Kernel, bandwidths: [f64; 2]) -> Candidates {
        let widest = kernel.spread(bandwidths[0]).min(WIDEST);
        let narrowest = kernel.spread(bandwidths[1]).min(widest);
        let own: Vec<Direction> =
            target.tiles.iter().flat_map(|tile| (0..tile.len()).map(|i| tile.direction(i))).collect();
        let mut lobes = Vec::new();
        let mut spread = narrowest;
        while spread < 1.001 * widest {
            let bandwidth = kernel.bandwidth_of_spread(spread).clamp(bandwidths[0], bandwidths[1]);
            // Centres of an icosahedron's subdivision are about √(4π/n) apart.
            let wanted = 4.0 * std::f64::consts::PI / (SPACING * spread).powi(2);
            let count = icosphere::COUNTS.into_iter().find(|&n| n as f64 >= wanted && n < own.len());
            let centres = count.and_then(icosphere::centers);
            let centres = centres.as_deref().unwrap_or(&own);
            lobes.extend(centres.iter().map(|&centre| Lobe { centre, bandwidth }));
            spread *= std::f64::consts::SQRT_2;
        }
        Candidates { kernel, lobes }
    }

    /// The `count` candidates that take most of the solution's residual, each one not much overlapped by those before it.
    pub(super) fn best(&self, solution: &Residual, count: usize) -> Vec<Lobe> {
        let target = solution.design.target;
        let mut gains: Vec<(f64, usize)> = (0..self.lobes.len())
            .into_par_iter()
            .map(|i| (gain(target, &solution.residuals, self.kernel, &self.lobes[i]), i))
            .collect();
        gains.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut chosen: Vec<Lobe> = Vec::new();
        for overlap in [OVERLAP, 1.1] {
            for &(_, i) in &gains {
                if chosen.len() == count {
                    break;
                }
                let lobe = &self.lobes[i];
                let apart = |other: &Lobe| other != lobe && other.overlap(lobe, self.kernel) < overlap;
                if chosen.iter().all(apart) {
                    chosen.push(*lobe);
                }
            }
        }
        chosen
    }
}

/// What the best multiple of a lobe takes from the squared residual.
fn gain(target: &Target, residuals: &[Vec<f64>], kernel: Kernel, lobe: &Lobe) -> f64 {
    let mut sums = vec![0.0; target.channels];
    let mut square = 0.0;
    let peak = kernel.value(1.0, lobe.bandwidth);
    for (tile, residual) in target.tiles.iter().zip(residuals) {
        if kernel.value(tile.nearest_cosine(lobe.centre), lobe.bandwidth) > NEGLIGIBLE * peak {
            square += add_products(tile, residual, kernel, lobe, &mut sums);
        }
    }
    if square > 0.0 { sums.iter().map(|s| s * s).sum::<f64>() / square } else { 0.0 }
}

/// Adds ⟨r, G⟩ of each channel, and returns ⟨G, G⟩.
fn add_products(tile: &Tile, residual: &[f64], kernel: Kernel, lobe: &Lobe, sums: &mut [f64]) -> f64 {
    let mut values: Vec<f64> = (0..tile.len()).map(|i| lobe.cosine(tile.direction(i))).collect();
    kernel.values(&mut values, lobe.bandwidth);
    values.iter_mut().zip(&tile.roots).for_each(|(v, root)| *v *= root);
    let square = super::design::product(&values, &values);
    for (sum, residual) in sums.iter_mut().zip(residual.chunks(tile.len())) {
        *sum += super::design::product(&values, residual);
    }
    square
}
