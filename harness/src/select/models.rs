//! What is expected of the points of a grid that were not tried.

use super::bound::{Bound, NEXT_TO_EXACT};
use super::surrogate::{Place, Prior, Surrogate};
use super::tried::Log;

/// The logarithms of what is bounded, over its bound, and of what is least, over the grid.
pub(super) struct Models {
    excess: Surrogate,
    price: Surrogate,
    /// The price that has to be bettered.
    best: f64,
}

/// What trying a point is likely to bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Promise {
    /// The expected decrease of the logarithm of the price.
    pub(super) gain: f64,
    /// The expected logarithm of what is bounded over its bound.
    pub(super) excess: f64,
}

/// By how much a bound is kept counts up to a factor of exp(4): far within it nothing has to be told apart.
const FAR: f64 = 4.0;
/// A label without a model exceeds the bound by a factor of exp(8).
const NO_MODEL: f64 = 8.0;
/// Where no model keeps the bound, the first that does may cost so much more than the dearest that was tried.
const DEARER: f64 = 1.0;
/// From one end of the first axis to the other errors and bytes are expected to change so much.
const OF_EXCESS: f64 = -6.0;
/// As [`OF_EXCESS`].
const OF_PRICE: f64 = 3.0;

impl Models {
    /// Learned from what was tried; `best` is the price of the best model that keeps the bound. None where nothing was tried.
    pub(super) fn of(log: &Log, best: Option<f64>) -> Option<Models> {
        let (mut points, mut excesses, mut priced, mut prices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for entry in &log.entries {
            let Some(point) = &entry.point else { continue };
            let places = log.grid.places(point);
            if let Some(trial) = entry.trial() {
                priced.push(places.clone());
                prices.push(log.goal.price(trial).max(NEXT_TO_EXACT));
            }
            points.push(places);
            excesses.push(entry.trial().map_or(NO_MODEL, |trial| log.goal.excess(trial).max(-FAR)));
        }
        let sign = if log.goal.is_kept_by_large_models() { 1.0 } else { -1.0 };
        let (of_error, of_bytes) = (log.grid.scales_of_error(), vec![1.0; log.grid.axes()]);
        let (of_excess, of_price) = match log.goal.bound {
            Bound::Error(_) => (of_error, of_bytes),
            Bound::Bytes(_) | Bound::Relight(_) => (of_bytes, of_error),
        };
        let middle = prices.iter().sum::<f64>() / prices.len().max(1) as f64;
        let dearest = prices.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (prior, price_prior) =
            (Prior { mean: 0.0, slope: OF_EXCESS * sign }, Prior { mean: middle, slope: OF_PRICE * sign });
        Some(Models {
            excess: Surrogate::new(points, of_excess, &excesses, prior)?,
            price: Surrogate::new(priced, of_price, &prices, price_prior)?,
            best: best.unwrap_or(dearest + DEARER),
        })
    }

    /// The expected improvement under a constraint (Gardner et al., *Bayesian Optimization with Inequality Constraints*, 2014): the chance that the
    /// bound is kept, times the part by which the price is expected to fall below the best.
    pub(super) fn promise(&self, places: &[Place]) -> Promise {
        let (excess, price) = (self.excess.at(places), self.price.at(places));
        let chance = logistic(-excess.mean / excess.deviation);
        let gain = chance * softplus((self.best - price.mean) / price.deviation) * price.deviation;
        Promise { gain, excess: excess.mean }
    }
}

/// The normal distribution as a logistic one, within 0.01 (Bowling et al. 2009).
fn logistic(z: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * z).exp())
}

/// The integral of [`logistic`]: the expected part above 0 of what has a mean of z and a deviation of 1.
fn softplus(z: f64) -> f64 {
    let x = 1.702 * z;
    (x.max(0.0) + (-x.abs()).exp().ln_1p()) / 1.702
}
