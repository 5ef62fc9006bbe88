//! Cholesky factors of symmetric matrices.

use super::{lent, lent_mut};
use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use ndarray::{Array2, ArrayView2, ArrayViewMut2};

/// L with A = L Lᵀ: lower triangular, its diagonal above zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Cholesky(Array2<f64>);

impl Cholesky {
    /// The factor of a symmetric matrix, of which the lower half is read; `None` where it is not positive definite to
    /// rounding, or has an element that is not finite.
    ///
    /// # Panics
    /// A matrix that is not square or not contiguous.
    pub fn factor(mut matrix: Array2<f64>) -> Option<Cholesky> {
        let n = matrix.nrows();
        assert_eq!(n, matrix.ncols(), "a symmetric matrix is square");
        let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
        let stack = MemStack::new(&mut memory);
        let factor = cholesky_in_place(
            lent_mut(&mut matrix.view_mut()),
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        );
        // A comparison with NaN is false: it is no factor either.
        if factor.is_err() || !matrix.diag().iter().all(|pivot| *pivot > 0.0) {
            return None;
        }
        for (i, mut row) in matrix.rows_mut().into_iter().enumerate() {
            row.iter_mut().skip(i + 1).for_each(|above| *above = 0.0);
        }
        matrix.iter().all(|l| l.is_finite()).then_some(Cholesky(matrix))
    }

    /// A factor that is there already: n x n, of which the lower half is read.
    ///
    /// # Panics
    /// A matrix that is not square or not contiguous.
    pub fn from_lower(lower: Array2<f64>) -> Cholesky {
        assert!(lower.is_square() && lower.is_standard_layout(), "a factor is square, row-major and contiguous");
        Cholesky(lower)
    }

    /// L, n x n.
    pub fn lower(&self) -> ArrayView2<'_, f64> {
        self.0.view()
    }

    /// `b` (n x right-hand sides) becomes A⁻¹ b.
    ///
    /// # Panics
    /// Sizes that do not agree, an array that is not contiguous.
    pub fn solve(&self, mut b: ArrayViewMut2<f64>) {
        self.solve_lower(b.view_mut());
        self.solve_upper(b);
    }

    /// `b` (n x right-hand sides) becomes L⁻ᵀ b.
    ///
    /// # Panics
    /// Sizes that do not agree, an array that is not contiguous.
    pub fn solve_upper(&self, mut b: ArrayViewMut2<f64>) {
        let lower = self.0.view();
        solve_upper_triangular_in_place(lent(&lower).transpose(), lent_mut(&mut b), Par::Seq);
    }

    /// `b` (n x right-hand sides) becomes L⁻¹ b.
    ///
    /// # Panics
    /// Sizes that do not agree, an array that is not contiguous.
    pub fn solve_lower(&self, mut b: ArrayViewMut2<f64>) {
        let lower = self.0.view();
        solve_lower_triangular_in_place(lent(&lower), lent_mut(&mut b), Par::Seq);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{close, matrix};
    use super::*;

    #[test]
    fn a_factor_makes_the_matrix_again_and_solves_it_for_every_right_hand_side() {
        for n in [1, 2, 9, 70, 200] {
            // Columns that are independent: the identity keeps the condition small.
            let a = matrix(n, n) + 2.0 * n as f64 * Array2::<f64>::eye(n);
            let gram = a.t().dot(&a).as_standard_layout().to_owned();
            let scale = gram.iter().fold(0f64, |m, v| m.max(v.abs()));
            let cholesky = Cholesky::factor(gram.clone()).unwrap();
            let lower = cholesky.lower();
            close(&lower.dot(&lower.t()), &gram, 1e-12 * scale);
            assert!(lower.indexed_iter().all(|((i, j), l)| j <= i || *l == 0.0), "{n}");
            for sides in [1, 3, 17] {
                let x = matrix(n, sides);
                let mut solved = gram.dot(&x);
                cholesky.solve(solved.view_mut());
                close(&solved, &x, 1e-11);
                let mut solved = lower.dot(&x);
                Cholesky::from_lower(lower.to_owned()).solve_lower(solved.view_mut());
                close(&solved, &x, 1e-11);
            }
        }
    }

    #[test]
    fn only_the_lower_half_is_read() {
        let mut gram = Array2::eye(5) * 2.0;
        let expected = Cholesky::factor(gram.clone());
        (0..5).for_each(|j| (0..j).for_each(|i| gram[[i, j]] = f64::NAN));
        assert_eq!(Cholesky::factor(gram), expected);
    }

    #[test]
    fn what_is_singular_indefinite_or_not_finite_has_no_factor() {
        assert!(Cholesky::factor(Array2::zeros((0, 0))).is_some());
        assert!(Cholesky::factor(Array2::zeros((2, 2))).is_none());
        assert!(Cholesky::factor(Array2::ones((3, 3))).is_none());
        assert!(Cholesky::factor(-Array2::<f64>::eye(3)).is_none());
        for bad in [f64::NAN, f64::INFINITY] {
            for (i, j) in [(0, 0), (2, 2), (2, 0)] {
                let mut gram = Array2::eye(3);
                gram[[i, j]] = bad;
                assert!(Cholesky::factor(gram).is_none(), "{bad} at {i} {j}");
            }
        }
    }
}
