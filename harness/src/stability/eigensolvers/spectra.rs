//! Matrices with given singular values, on which eigen-solvers stop too early, lose digits, or have nothing to find.

use ndarray::{Array1, Array2, ArrayView1, Axis, s};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A family of matrices.
pub struct Spectrum {
    /// On the command line and in the CSV.
    pub name: &'static str,
    /// What is hard about it.
    pub title: &'static str,
    /// The i-th of `rank` singular values, from 0; descending.
    pub value: fn(i: usize, rank: usize) -> f64,
    /// Whether solvers start from vectors that are orthogonal to every leading one.
    pub starts_orthogonal: bool,
}

/// Every spectrum of the study.
pub static SPECTRA: [Spectrum; 10] = [
    spectrum("repeated", "repeated in fours", |i, _| 0.5f64.powi(i as i32 / 4)),
    spectrum("clustered-1e-3", "relative gaps of 1e-3", |i, _| 1.0 - 1e-3 * i as f64),
    spectrum("clustered-1e-6", "relative gaps of 1e-6", |i, _| 1.0 - 1e-6 * i as f64),
    spectrum("slow", "slow decay, 1/√i", |i, _| 1.0 / (1.0 + i as f64).sqrt()),
    spectrum("zero-tail", "nothing after the sixth", |i, _| if i < 6 { 0.7f64.powi(i as i32) } else { 0.0 }),
    Spectrum {
        starts_orthogonal: true,
        ..spectrum("orthogonal-start", "start orthogonal to what is sought", |i, _| 0.8f64.powi(i as i32))
    },
    spectrum("condition-1e2", "condition 1e2", |i, rank| geometric(i, rank, 1e-2)),
    spectrum("condition-1e4", "condition 1e4", |i, rank| geometric(i, rank, 1e-4)),
    spectrum("condition-1e6", "condition 1e6", |i, rank| geometric(i, rank, 1e-6)),
    spectrum("condition-1e8", "condition 1e8", |i, rank| geometric(i, rank, 1e-8)),
];

const fn spectrum(name: &'static str, title: &'static str, value: fn(usize, usize) -> f64) -> Spectrum {
    Spectrum { name, title, value, starts_orthogonal: false }
}

/// From 1 down to `last` within the first 17, which are as many as are sought at most and one more, and on at the same rate.
fn geometric(i: usize, rank: usize, last: f64) -> f64 {
    let steps = rank.min(17).saturating_sub(1).max(1);
    last.powf(i as f64 / steps as f64)
}

/// A matrix F = U diag(s) Vᵀ with everything that is known of it.
pub struct Known {
    /// rows x columns.
    pub matrix: Array2<f64>,
    /// s, descending, min(rows, columns) of them.
    pub singular: Vec<f64>,
    /// The right singular vectors V, one a row.
    pub right: Array2<f64>,
}

impl Spectrum {
    /// A matrix of this spectrum; the same for the same size and seed.
    pub fn matrix(&self, rows: usize, columns: usize, seed: u64) -> Known {
        Known::new(rows, columns, seed, |i| (self.value)(i, rows.min(columns)))
    }

    /// Where a search for `components` starts: orthonormal, and orthogonal to the leading ones; none where solvers choose.
    pub fn start(&self, known: &Known, components: usize) -> Option<Array2<f64>> {
        let after = known.right.nrows().saturating_sub(components);
        let enough = self.starts_orthogonal && after >= components;
        enough.then(|| known.right.slice(s![components..2 * components, ..]).to_owned())
    }
}

impl Known {
    /// A matrix whose i-th singular value, from 0, is `value`; they must descend. The same for the same size and seed.
    pub fn new(rows: usize, columns: usize, seed: u64, value: impl Fn(usize) -> f64) -> Known {
        let (rank, mut rng) = (rows.min(columns), Pcg64Mcg::seed_from_u64(seed));
        let singular: Vec<f64> = (0..rank).map(value).collect();
        let (left, right) = (orthonormal(rank, rows, &mut rng), orthonormal(rank, columns, &mut rng));
        let scaled = &right * &Array1::from(singular.clone()).insert_axis(Axis(1));
        // As it lies in memory, which a transposed product does not promise.
        let matrix = left.t().dot(&scaled).as_standard_layout().into_owned();
        Known { matrix, singular, right }
    }

    /// ‖F - F VᵀV‖² / ‖F‖² for the rows of V: what is lost.
    pub fn lost(&self, vectors: &Array2<f64>) -> f64 {
        let residual = &self.matrix - &self.matrix.dot(&vectors.t()).dot(vectors);
        residual.iter().map(|v| v * v).sum::<f64>() / square(&self.singular)
    }

    /// Σ_{i>k} s_i² / ‖F‖²: what any k vectors lose at least (Eckart and Young 1936).
    pub fn least(&self, components: usize) -> f64 {
        square(&self.singular[components.min(self.singular.len())..]) / square(&self.singular)
    }
}

/// Σ s², the smallest first.
fn square(descending: &[f64]) -> f64 {
    descending.iter().rev().map(|s| s * s).sum()
}

/// `count` orthonormal vectors of `length` numbers, one a row: random ones, orthogonalised twice (Gram and Schmidt).
fn orthonormal(count: usize, length: usize, rng: &mut Pcg64Mcg) -> Array2<f64> {
    let mut vectors: Array2<f64> = Array2::zeros((count, length));
    for i in 0..count {
        let (before, mut rest) = vectors.view_mut().split_at(Axis(0), i);
        let mut vector = Array1::from_shape_fn(length, |_| normal(rng));
        for _ in 0..2 {
            let along = before.dot(&vector);
            vector -= &before.t().dot(&along);
            vector /= norm(vector.view());
        }
        rest.row_mut(0).assign(&vector);
    }
    vectors
}

fn norm(vector: ArrayView1<f64>) -> f64 {
    vector.dot(&vector).sqrt()
}

/// About normal, of variance 1: no direction is preferred enough to matter once it is orthogonalised.
fn normal(rng: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::linalg;

    #[test]
    fn a_matrix_has_the_singular_values_that_it_says() {
        for spectrum in &SPECTRA {
            for (rows, columns) in [(20, 33), (33, 20), (18, 18)] {
                let known = spectrum.matrix(rows, columns, 1);
                assert!(known.singular.windows(2).all(|w| w[0] >= w[1]), "{}", spectrum.name);
                let found = linalg::singular(known.matrix.view()).unwrap().values;
                for (a, b) in found.iter().zip(&known.singular) {
                    assert!((a - b).abs() < 1e-14 * 20.0, "{} {rows} x {columns}: {a} {b}", spectrum.name);
                }
            }
        }
    }

    #[test]
    fn nothing_loses_less_than_the_leading_vectors_and_a_bad_start_has_none_of_them() {
        for spectrum in &SPECTRA {
            let known = spectrum.matrix(20, 33, 2);
            for k in [1, 4, 9] {
                let best = known.right.slice(s![..k, ..]).to_owned();
                assert!((known.lost(&best) - known.least(k)).abs() < 1e-14, "{} {k}", spectrum.name);
                // The next ones instead: what is lost more is what these squares differ by.
                let next = known.right.slice(s![k..2 * k, ..]).to_owned();
                let [first, second] = [0..k, k..2 * k].map(|range| square(&known.singular[range]));
                let expected = (first - second) / square(&known.singular);
                assert!((known.lost(&next) - known.least(k) - expected).abs() < 1e-14, "{} {k}", spectrum.name);
                if let Some(start) = spectrum.start(&known, k) {
                    assert!(best.dot(&start.t()).iter().all(|v| v.abs() < 1e-14));
                }
            }
        }
        assert!(SPECTRA.iter().any(|s| s.starts_orthogonal));
    }

    #[test]
    fn a_condition_is_reached_within_what_is_sought() {
        for (name, condition) in [("condition-1e2", 1e2), ("condition-1e8", 1e8)] {
            let spectrum = SPECTRA.iter().find(|s| s.name == name).unwrap();
            let ratio = (spectrum.value)(0, 40) / (spectrum.value)(16, 40);
            assert!((ratio / condition - 1.0).abs() < 1e-9, "{ratio}");
        }
    }
}
