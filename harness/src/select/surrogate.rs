//! What a figure is likely to be where nothing has been tried: a Gaussian process over the points of a grid.
//!
//! Rasmussen and Williams, *Gaussian Processes for Machine Learning* (2006), eqs. 2.25, 2.26 and 2.30. The kernel is a sum of a line and a
//! curve along each axis and of what axes do together (Matérn 5/2), since the logarithms of errors and of bytes are nearly such sums. The
//! length of the curves is the likeliest of a few, the variance has an inverse gamma prior.

use ndarray::{Array1, Array2};
use prt_transfer::linalg::Cholesky;

/// A place along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// A number, from 0 to 1.
    Number(f64),
    /// A choice of which only the name is known.
    Name(usize),
}

/// A figure as it is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Expected {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
}

/// A figure over a grid, learned from some of its points.
pub(super) struct Surrogate {
    points: Vec<Vec<Place>>,
    scales: Vec<f64>,
    prior: Prior,
    length: f64,
    variance: f64,
    factor: Cholesky,
    /// (K + ridge)⁻¹ (y - m).
    weights: Array1<f64>,
}

/// What is expected before anything is known: a line along the first axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prior {
    /// In the middle of the axis.
    pub mean: f64,
    /// From one end of the axis to the other.
    pub slope: f64,
}

impl Prior {
    fn at(&self, point: &[Place]) -> f64 {
        match point.first() {
            Some(Place::Number(x)) => self.mean + self.slope * (x - 0.5),
            _ => self.mean,
        }
    }
}

/// Lengths of the curves that are tried, in lengths of an axis.
const LENGTHS: [f64; 3] = [0.4, 0.8, 1.6];
/// Of the inverse gamma prior of the variance: so many figures of a variance of …
const PRIOR_COUNT: f64 = 4.0;
/// … this much.
const PRIOR_VARIANCE: f64 = 0.04;
/// Variance that no other point explains, as a part of the kernel's: errors of neighbouring models scatter a little.
const RIDGE: f64 = 1e-4;

impl Surrogate {
    /// Learns `values` at `points`, each axis of which matters as much as its scale, from 0 to 1; `None` where there are no points.
    pub(super) fn new(points: Vec<Vec<Place>>, scales: Vec<f64>, values: &[f64], prior: Prior) -> Option<Surrogate> {
        let count = points.len();
        let residual = || points.iter().zip(values).map(|(point, value)| value - prior.at(point));
        let fit = |length: f64| {
            let gram = Array2::from_shape_fn((count, count), |(i, j)| {
                kernel(&points[i], &points[j], &scales, length) + if i == j { RIDGE } else { 0.0 }
            });
            let factor = Cholesky::factor(gram)?;
            let residual = Array1::from_iter(residual());
            let mut weights = residual.clone().insert_axis(ndarray::Axis(1));
            factor.solve(weights.view_mut());
            let weights = weights.remove_axis(ndarray::Axis(1));
            let variance =
                (PRIOR_COUNT * PRIOR_VARIANCE + residual.dot(&weights)) / (PRIOR_COUNT + residual.len() as f64);
            let determinant: f64 = factor.lower().diag().iter().map(|pivot| pivot.ln()).sum();
            let likelihood = -0.5 * (PRIOR_COUNT + count as f64) * variance.ln() - determinant;
            Some((likelihood, length, variance, factor, weights))
        };
        let fits = LENGTHS.iter().filter_map(|&length| fit(length));
        let (_, length, variance, factor, weights) = fits.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| count > 0)?;
        Some(Surrogate { points, scales, prior, length, variance, factor, weights })
    }

    /// The figure at a point.
    pub(super) fn at(&self, point: &[Place]) -> Expected {
        let near = Array1::from_iter(self.points.iter().map(|other| kernel(point, other, &self.scales, self.length)));
        let mut solved = near.clone().insert_axis(ndarray::Axis(1));
        self.factor.solve_lower(solved.view_mut());
        let explained: f64 = solved.iter().map(|v| v * v).sum();
        let unexplained = (kernel(point, point, &self.scales, self.length) + RIDGE - explained).max(RIDGE);
        Expected {
            mean: self.prior.at(point) + near.dot(&self.weights),
            deviation: (self.variance * unexplained).sqrt(),
        }
    }
}

/// The covariance of two points, over the variance.
fn kernel(a: &[Place], b: &[Place], scales: &[f64], length: f64) -> f64 {
    let (mut sum, mut product) = (4.0, 1.0);
    for ((a, b), scale) in a.iter().zip(b).zip(scales) {
        let alike = match (a, b) {
            (Place::Number(a), Place::Number(b)) => {
                sum += 16.0 * scale * (a - 0.5) * (b - 0.5);
                matern((a - b).abs() / length)
            }
            (a, b) => f64::from(u8::from(a == b)),
        };
        sum += scale * alike;
        product *= 1.0 - 0.8 * scale * (1.0 - alike);
    }
    sum + product
}

/// Matérn's kernel with ν = 5/2, at a distance in lengths (eq. 4.17).
fn matern(distance: f64) -> f64 {
    let r = 5f64.sqrt() * distance;
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(x: f64, name: usize) -> Vec<Place> {
        vec![Place::Number(x), Place::Name(name)]
    }

    const PRIOR: Prior = Prior { mean: 0.0, slope: 0.0 };

    #[test]
    fn what_was_seen_is_known_and_doubt_grows_with_the_distance() {
        let points = vec![place(0.0, 0), place(0.5, 0), place(0.6, 0)];
        let surrogate = Surrogate::new(points.clone(), vec![1.0; 2], &[3.0, 1.0, 0.7], PRIOR).unwrap();
        for (point, value) in points.iter().zip([3.0, 1.0, 0.7]) {
            assert!((surrogate.at(point).mean - value).abs() < 0.02, "{:?}", surrogate.at(point));
        }
        let doubt = |x: f64, name: usize| surrogate.at(&place(x, name)).deviation;
        assert!(doubt(0.55, 0) < doubt(0.8, 0) && doubt(0.8, 0) < doubt(1.0, 0) && doubt(0.55, 0) < doubt(0.55, 1));
    }

    #[test]
    fn sums_over_the_axes_are_foretold_from_a_change_of_each() {
        let value = |x: f64, name: usize| 5.0 - 6.0 * x + [0.0, 1.5][name];
        let seen: Vec<(f64, usize)> = vec![(0.2, 0), (0.5, 0), (0.9, 0), (0.5, 1)];
        let values: Vec<f64> = seen.iter().map(|&(x, name)| value(x, name)).collect();
        let points = seen.iter().map(|&(x, name)| place(x, name)).collect();
        let surrogate = Surrogate::new(points, vec![1.0; 2], &values, PRIOR).unwrap();
        for x in [0.3, 0.7] {
            let Expected { mean, deviation } = surrogate.at(&place(x, 1));
            assert!((mean - value(x, 1)).abs() < 2.0 * deviation && deviation < 0.7, "{mean} {deviation}");
        }
    }

    #[test]
    fn nothing_teaches_nothing() {
        assert!(Surrogate::new(Vec::new(), vec![1.0; 2], &[], PRIOR).is_none());
    }
}
