//! How much is added to the diagonal of a Gram matrix before it is factored.

use super::params::Ridge;
use ndarray::Array2;
use prt_transfer::linalg::Cholesky;

/// The condition that [`Ridge::Auto`] allows: coefficients of lobes are then at most 1e4 times as large as what they add up to, which f32
/// still holds to three digits.
const CONDITION: f64 = 1e8;

/// Steps of inverse iteration: whatever the spectrum, the estimate of the least eigenvalue is then within a fifth.
const STEPS: usize = 32;

/// G + share · mean(diag G) · I as its factor, and the share.
pub(super) struct Regularised {
    pub(super) factor: Cholesky,
    pub(super) share: f64,
}

impl Regularised {
    /// `None` where the matrix is singular with the ridge that was asked for.
    pub(super) fn new(gram: &Array2<f64>, ridge: Ridge) -> Option<Regularised> {
        match ridge {
            Ridge::Share(share) => Regularised::with_share(gram, share),
            Ridge::Auto => {
                let plain = Regularised::with_share(gram, 0.0);
                let least = plain.as_ref().map_or(0.0, |plain| least_eigenvalue(&plain.factor));
                let share = missing(largest_row(gram), least) / mean_diagonal(gram);
                if share == 0.0 { plain } else { Regularised::with_share(gram, share) }
            }
        }
    }

    fn with_share(gram: &Array2<f64>, share: f64) -> Option<Regularised> {
        let mut shifted = gram.clone();
        let ridge = share * mean_diagonal(gram);
        shifted.diag_mut().iter_mut().for_each(|d| *d += ridge);
        Cholesky::factor(shifted).map(|factor| Regularised { factor, share })
    }
}

/// The smallest r ≥ 0 with (largest + r) / (least + r) ≤ [`CONDITION`].
fn missing(largest: f64, least: f64) -> f64 {
    ((largest - CONDITION * least) / (CONDITION - 1.0)).max(0.0)
}

fn mean_diagonal(gram: &Array2<f64>) -> f64 {
    gram.diag().mean().unwrap_or_default()
}

/// The largest sum of a row's magnitudes: no eigenvalue is above it, and of lobes spread evenly the largest is nearly that.
fn largest_row(gram: &Array2<f64>) -> f64 {
    gram.outer_iter().map(|row| row.iter().map(|g| g.abs()).sum()).fold(0.0, f64::max)
}

/// The least eigenvalue, by inverse iteration from a fixed vector; never below it but for rounding.
fn least_eigenvalue(factor: &Cholesky) -> f64 {
    let n = factor.lower().nrows();
    // Fractions of multiples of the golden ratio: no symmetry of the centres makes such a vector orthogonal to an eigenvector.
    let mut x = Array2::from_shape_fn((n, 1), |(i, _)| (0.618_033_988_749_895 * (i + 1) as f64).fract() - 0.5);
    let mut least = f64::INFINITY;
    for _ in 0..STEPS {
        let norm = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        x /= norm;
        factor.solve(x.view_mut());
        least = 1.0 / x.iter().map(|v| v * v).sum::<f64>().sqrt();
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::linalg::eigenvalues;

    /// A matrix with this spectrum in mixed directions.
    fn gram(spectrum: &[f64]) -> Array2<f64> {
        let n = spectrum.len();
        // A reflection H = I - 2 v vᵀ is orthogonal and its own inverse.
        let v = Array2::from_shape_fn((n, 1), |(i, _)| (1 + i % 5) as f64);
        let reflection = Array2::eye(n) - 2.0 / v.iter().map(|v| v * v).sum::<f64>() * v.dot(&v.t());
        reflection.dot(&Array2::from_diag(&ndarray::Array1::from_vec(spectrum.to_vec()))).dot(&reflection)
    }

    fn condition(gram: &Array2<f64>, regularised: &Regularised) -> f64 {
        let shifted = gram + regularised.share * mean_diagonal(gram) * Array2::<f64>::eye(gram.nrows());
        let values = eigenvalues(shifted.view()).unwrap();
        values[0] / values[values.len() - 1]
    }

    #[test]
    fn a_ridge_is_added_only_where_the_condition_asks_for_it_and_then_bounds_it() {
        let spectrum = |least: f64| (0..20).map(|i| least.powf(f64::from(i) / 19.0)).collect::<Vec<f64>>();
        for least in [1.0, 1e-3, 1e-6] {
            let gram = gram(&spectrum(least));
            let regularised = Regularised::new(&gram, Ridge::Auto).unwrap();
            assert_eq!(regularised.share, 0.0, "{least}");
        }
        for least in [1e-10, 1e-13, 0.0] {
            let gram = gram(&spectrum(least));
            let regularised = Regularised::new(&gram, Ridge::Auto).unwrap();
            assert!(regularised.share > 0.0, "{least}");
            let condition = condition(&gram, &regularised);
            assert!((1e7..1.2e8).contains(&condition), "{least}: {condition:e}");
        }
    }

    #[test]
    fn the_least_eigenvalue_is_found_within_a_fifth() {
        for spectrum in [vec![3.0], vec![1.0, 1.01, 1.02, 5.0], (1..300).map(|i| 1.0 + f64::from(i) * 1e-3).collect()] {
            let least = spectrum.iter().copied().fold(f64::INFINITY, f64::min);
            let found = least_eigenvalue(&Cholesky::factor(gram(&spectrum)).unwrap());
            assert!((1.0 - 1e-9..1.2).contains(&(found / least)), "{found} {least}");
        }
    }

    #[test]
    fn a_share_is_taken_at_its_word() {
        let gram = gram(&[2.0, 1.0, 0.0]);
        assert!(Regularised::new(&gram, Ridge::Share(0.0)).is_none_or(|r| r.factor.lower()[[2, 2]] < 1e-6));
        let regularised = Regularised::new(&gram, Ridge::Share(0.25)).unwrap();
        assert!((condition(&gram, &regularised) - 9.0).abs() < 1e-9, "2.25 / 0.25");
    }
}
