//! Singular value decompositions that hold where the rank is small.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, SymmetricEigen};

/// `A = U diag(σ) Vᵀ`, σ descending. Columns of U with σ = 0 are zero.
pub(super) struct Svd {
    pub(super) u: DMatrix<f64>,
    pub(super) sigma: Vec<f64>,
    pub(super) v: DMatrix<f64>,
}

/// Cosine between columns that are taken for orthogonal.
const ORTHOGONAL: f64 = 1e-15;

/// Below this part of the largest a column is rounding.
const NOTHING: f64 = 1e-15;

/// Sweeps of rotations at most; after the eigenvectors one to three are enough.
const SWEEPS: usize = 30;

impl Svd {
    /// Jacobi's rotations of the columns of A V, with V the eigenvectors of AᵀA for a start (Drmač and Veselić 2008
    /// start from a QR): every singular value to a few roundings of the largest and vectors that are orthogonal by
    /// construction, whatever the rank. Bidiagonal QR iterations, nalgebra's own, lose a tenth of the only vector of a
    /// matrix of rank 1.
    ///
    /// # Errors
    /// Rotations that do not come to an end, as with values that are not finite.
    pub(super) fn new(a: &DMatrix<f64>) -> Result<Svd> {
        let failed = || Error::Unsupported {
            what: format!("singular values of a {} x {} matrix", a.nrows(), a.ncols()),
            expected: format!("convergence within {SWEEPS} sweeps"),
            found: "none".into(),
        };
        let gram = SymmetricEigen::try_new(a.tr_mul(a), f64::EPSILON, 100 * a.ncols().max(10)).ok_or_else(failed)?;
        let mut v = gram.eigenvectors;
        let mut w = a * &v;
        let mut settled = false;
        for _ in 0..SWEEPS {
            settled = !sweep(&mut w, &mut v);
            if settled {
                break;
            }
        }
        if !settled {
            return Err(failed());
        }
        let norms: Vec<f64> = w.column_iter().map(|column| column.norm()).collect();
        let mut order: Vec<usize> = (0..norms.len()).collect();
        order.sort_by(|&i, &j| norms[j].total_cmp(&norms[i]));
        let sigma: Vec<f64> = order.iter().map(|&i| norms[i]).collect();
        let unit = |i: usize| if norms[i] > 0.0 { 1.0 / norms[i] } else { 0.0 };
        let u = DMatrix::from_columns(&order.iter().map(|&i| w.column(i) * unit(i)).collect::<Vec<_>>());
        let v = DMatrix::from_columns(&order.iter().map(|&i| v.column(i).into_owned()).collect::<Vec<_>>());
        Ok(Svd { u, sigma, v })
    }
}

/// Makes every pair of columns of `w` orthogonal once, and turns those of `v` along; whether anything had to be turned.
fn sweep(w: &mut DMatrix<f64>, v: &mut DMatrix<f64>) -> bool {
    let largest = w.column_iter().map(|column| column.norm_squared()).fold(0.0, f64::max);
    let mut turned = false;
    for i in 0..w.ncols() {
        for j in i + 1..w.ncols() {
            let (a, b, c) = (w.column(i).norm_squared(), w.column(j).norm_squared(), w.column(i).dot(&w.column(j)));
            if a.min(b) <= NOTHING * NOTHING * largest || c.abs() <= ORTHOGONAL * (w.nrows() as f64) * (a * b).sqrt() {
                continue;
            }
            turned = true;
            // The rotation by tan t that makes c vanish, the smaller of the two.
            let zeta = (b - a) / (2.0 * c);
            let tangent = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            for matrix in [&mut *w, &mut *v] {
                rotate(matrix, [i, j], cosine, cosine * tangent);
            }
        }
    }
    turned
}

/// Columns i < j become c i - s j and s i + c j.
fn rotate(matrix: &mut DMatrix<f64>, [i, j]: [usize; 2], cosine: f64, sine: f64) {
    let rows = matrix.nrows();
    let (before, from_j) = matrix.as_mut_slice().split_at_mut(j * rows);
    for (x, y) in before[i * rows..][..rows].iter_mut().zip(&mut from_j[..rows]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(a: &DMatrix<f64>) {
        let Svd { u, sigma, v } = Svd::new(a).unwrap();
        let scale = sigma[0].max(f64::MIN_POSITIVE);
        let back = &u * DMatrix::from_diagonal(&sigma.clone().into()) * v.transpose();
        assert!((back - a).norm() < 1e-13 * scale * a.ncols() as f64);
        let identity = DMatrix::identity(a.ncols(), a.ncols());
        assert!((v.tr_mul(&v) - &identity).norm() < 1e-12);
        let rank = sigma.iter().take_while(|s| **s > 1e-12 * scale).count();
        let u = u.columns(0, rank);
        assert!((u.tr_mul(&u) - identity.view((0, 0), (rank, rank))).norm() < 1e-11, "{sigma:?}");
        assert!(sigma.is_sorted_by(|a, b| a >= b));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn factors_are_orthonormal_and_multiply_to_the_matrix_whatever_the_rank(
            rank in 1usize..9, rows in 1usize..24, columns in 1usize..24, decay in 0.0f64..3.0, seed in prop::collection::vec(-1f64..1.0, 24 * 18),
        ) {
            let left = DMatrix::from_fn(rows, rank, |i, k| seed[i * 9 + k] * 10f64.powf(-decay * k as f64));
            let right = DMatrix::from_fn(rank, columns, |k, j| seed[24 * 9 + j * 9 + k]);
            check(&(left * right));
        }
    }

    #[test]
    fn matrices_of_one_vector_of_equal_values_and_of_none_are_no_exception() {
        let ring = |i: usize| (i as f64 + 0.5) / 40.0;
        for scale in [0.3, 0.6, 1.0] {
            check(&DMatrix::from_fn(40, 40, |i, j| scale * (ring(i) * ring(j)).sqrt()));
        }
        check(&DMatrix::identity(12, 12));
        check(&DMatrix::zeros(5, 5));
        assert!(Svd::new(&DMatrix::from_element(3, 3, f64::NAN)).is_err());
    }
}
