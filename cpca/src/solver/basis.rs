//! Orthonormal rows that grow.

use super::norm;
use ndarray::{Array2, ArrayView2, s};
use prt_transfer::linalg;

/// Orthonormal rows of n numbers.
pub(super) struct Basis {
    /// Room for all; the first `len` are there.
    rows: Array2<f64>,
    len: usize,
}

/// A row that keeps less than this part of its norm is made orthogonal once more (Daniel et al. 1976; twice is enough).
const CANCELLED: f64 = 0.5;

impl Basis {
    /// Room for as many rows as the dimension allows, `most` at most.
    pub(super) fn new(most: usize, dimension: usize) -> Basis {
        Basis { rows: Array2::zeros((most.min(dimension), dimension)), len: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The rows.
    pub(super) fn view(&self) -> ArrayView2<'_, f64> {
        self.rows.slice(s![..self.len, ..])
    }

    /// The rows from `first` on.
    pub(super) fn since(&self, first: usize) -> ArrayView2<'_, f64> {
        self.rows.slice(s![first..self.len, ..])
    }

    pub(super) fn into_rows(self) -> Array2<f64> {
        self.rows.slice_move(s![..self.len, ..]).as_standard_layout().into_owned()
    }

    /// Takes in what is outside of each row of `block` (b x n), unless its norm is at most `noise` or there is no room.
    /// Returns C (b x len): block = C · rows, but for what was not taken in.
    pub(super) fn extend(&mut self, mut block: Array2<f64>, noise: f64) -> Array2<f64> {
        let before = self.len;
        let mut coefficients = Array2::zeros((block.nrows(), self.rows.nrows()));
        if before > 0 {
            for _ in 0..2 {
                let inside = product_transposed(block.view(), self.view());
                block -= &product(inside.view(), self.view());
                let mut sum = coefficients.slice_mut(s![.., ..before]);
                sum += &inside;
            }
        }
        for (i, mut row) in block.rows_mut().into_iter().enumerate() {
            // Against what the block itself brought; against everything where little is left of the row.
            let (mut first, mut left) = (before, norm(row.view()));
            loop {
                for j in first..self.len {
                    let inside = self.rows.row(j).dot(&row);
                    row.scaled_add(-inside, &self.rows.row(j));
                    coefficients[[i, j]] += inside;
                }
                let now = norm(row.view());
                let cancelled = now < CANCELLED * left;
                left = now;
                if !cancelled || left <= noise {
                    break;
                }
                first = 0;
            }
            if left > noise && self.len < self.rows.nrows() {
                self.rows.row_mut(self.len).assign(&(&row / left));
                coefficients[[i, self.len]] = left;
                self.len += 1;
            }
        }
        coefficients.slice_move(s![.., ..self.len])
    }
}

/// A (m x k) · B (k x n).
pub(super) fn product(a: ArrayView2<f64>, b: ArrayView2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros((a.nrows(), b.ncols()));
    linalg::times_on_all(a, b, out.view_mut());
    out
}

/// A (m x k) · B (n x k)ᵀ.
pub(crate) fn product_transposed(a: ArrayView2<f64>, b: ArrayView2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros((a.nrows(), b.nrows()));
    linalg::times_transposed_on_all(a, b, out.view_mut());
    out
}
