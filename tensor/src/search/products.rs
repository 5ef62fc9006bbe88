//! Large products in blocks of a fixed number of rows, on all threads: results do not depend on their number.

use ndarray::{Array2, ArrayView2, Axis, s};
use prt_transfer::{Result, linalg};
use rayon::prelude::*;

/// Rows that a thread multiplies at a time.
const ROWS: usize = 256;
/// Strips that a Gram matrix is summed in, each by one thread.
const STRIPS: usize = 8;
/// Squares of singular values below this part of the largest are rounding of single precision.
const ROUNDING: f64 = 1e-13;

/// `a` (m x k) · `b` (n x k)ᵀ.
pub(crate) fn times_transposed(a: ArrayView2<f32>, b: ArrayView2<f32>) -> Array2<f32> {
    by_blocks(a, b.nrows(), |a, out| linalg::times_transposed(a, b, out))
}

/// `a` (m x k) · `b` (k x n).
pub(crate) fn times(a: ArrayView2<f32>, b: ArrayView2<f32>) -> Array2<f32> {
    by_blocks(a, b.ncols(), |a, out| linalg::times_single(a, b, out))
}

fn by_blocks(
    a: ArrayView2<f32>,
    columns: usize,
    multiply: impl Fn(ArrayView2<f32>, ndarray::ArrayViewMut2<f32>) + Sync,
) -> Array2<f32> {
    let mut out = Array2::zeros((a.nrows(), columns));
    out.axis_chunks_iter_mut(Axis(0), ROWS).into_par_iter().enumerate().for_each(|(block, out)| {
        let first = block * ROWS;
        multiply(a.slice(s![first..first + out.nrows(), ..]), out);
    });
    out
}

/// `a` (m x n)ᵀ · `a` in double precision.
pub(crate) fn gram(a: ArrayView2<f32>) -> Array2<f64> {
    let n = a.ncols();
    let rows = a.nrows().div_ceil(STRIPS).next_multiple_of(ROWS);
    let strips: Vec<Array2<f64>> = a
        .axis_chunks_iter(Axis(0), rows)
        .into_par_iter()
        .map(|strip| {
            let mut gram = Array2::zeros((n, n));
            for block in strip.axis_chunks_iter(Axis(0), ROWS) {
                linalg::add_gram(block.mapv(f64::from).view(), gram.view_mut());
            }
            gram
        })
        .collect();
    strips.into_iter().fold(Array2::zeros((n, n)), |sum, strip| sum + strip)
}

/// Right singular vectors of a matrix and the squares of their singular values, descending.
pub(crate) struct Leading {
    /// Orthonormal rows.
    pub(crate) rows: Array2<f64>,
    pub(crate) squares: Vec<f64>,
}

impl Leading {
    pub(crate) fn single(&self) -> Array2<f32> {
        self.rows.mapv(|v| v as f32)
    }
}

/// The leading right singular vectors of `a` (m x n): `rank` of them, fewer where the matrix has a lower rank.
pub(crate) fn leading(a: ArrayView2<f32>, rank: usize) -> Result<Leading> {
    let (m, n) = a.dim();
    if n <= m {
        return leading_of_gram(&gram(a), rank);
    }
    // By the smaller Gram matrix: Aᵀu = σ v.
    let wide = a.mapv(f64::from);
    let mut small = Array2::zeros((m, m));
    let columns = wide.t().as_standard_layout().into_owned();
    linalg::add_gram(columns.view(), small.view_mut());
    let left = leading_of_gram(&small, rank)?;
    let mut rows = Array2::zeros((left.squares.len(), n));
    linalg::times(left.rows.view(), wide.view(), rows.view_mut());
    // Those of small singular values have lost some of their orthogonality.
    let rows = linalg::orthonormal_columns(rows.t()).reversed_axes().as_standard_layout().into_owned();
    Ok(Leading { rows, squares: left.squares })
}

/// As [`leading`], given AᵀA.
pub(crate) fn leading_of_gram(gram: &Array2<f64>, rank: usize) -> Result<Leading> {
    let spectrum = linalg::eigen(gram.view())?;
    let least = ROUNDING * spectrum.values.first().copied().unwrap_or_default().max(0.0);
    let kept = spectrum.values.iter().take(rank).take_while(|square| **square > least).count();
    let mut rows = spectrum.vectors.slice(s![..kept, ..]).as_standard_layout().into_owned();
    rows.outer_iter_mut().for_each(|mut row| {
        // Of a vector and its opposite the one whose sum is positive.
        if row.sum() < 0.0 {
            row.mapv_inplace(|v| -v);
        }
    });
    Ok(Leading { rows, squares: spectrum.values[..kept].to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(m: usize, n: usize) -> Array2<f32> {
        Array2::from_shape_fn((m, n), |(i, j)| ((i * 37 + j * 101 + i * j * 13) % 97) as f32 / 48.0 - 1.0)
    }

    #[test]
    fn blocks_are_the_whole_product() {
        let (a, b) = (matrix(700, 20), matrix(30, 20));
        let close = |found: &Array2<f32>, expected: &Array2<f32>| {
            assert!((found - expected).iter().all(|d| d.abs() < 1e-4), "{found} {expected}");
        };
        close(&times_transposed(a.view(), b.view()), &a.dot(&b.t()));
        close(&times(a.view(), b.t().as_standard_layout().view()), &a.dot(&b.t()));
        close(&gram(a.view()).mapv(|v| v as f32), &a.t().dot(&a));
    }

    #[test]
    fn leading_vectors_are_orthonormal_and_hold_the_leading_energy() {
        for (m, n) in [(40, 9), (9, 40), (1, 5), (5, 1), (6, 6)] {
            let a = matrix(m, n);
            let whole = leading(a.view(), 100).unwrap();
            let wide = a.mapv(f64::from);
            let rank = whole.squares.len();
            assert!((whole.rows.dot(&whole.rows.t()) - Array2::<f64>::eye(rank)).iter().all(|d| d.abs() < 1e-12));
            // A = A V Vᵀ, and each vector holds its square.
            let lost = &wide - wide.dot(&whole.rows.t()).dot(&whole.rows);
            assert!(lost.iter().all(|d| d.abs() < 1e-6), "{m} x {n}");
            for (v, square) in whole.rows.outer_iter().zip(&whole.squares) {
                let along = wide.dot(&v);
                assert!((along.dot(&along) - square).abs() < 1e-9 * whole.squares[0]);
            }
            assert_eq!(leading(a.view(), 2).unwrap().squares, whole.squares[..rank.min(2)]);
        }
        assert!(leading(Array2::zeros((3, 4)).view(), 2).unwrap().squares.is_empty());
        assert!(leading(Array2::zeros((0, 4)).view(), 2).unwrap().squares.is_empty());
        assert_eq!(leading(Array2::from_elem((3, 4), 2.0).view(), 2).unwrap().squares.len(), 1);
    }
}
