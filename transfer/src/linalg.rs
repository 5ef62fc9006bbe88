//! Large dense products and decompositions, by faer.
//!
//! The only module that names the library: its code is generic and compiles where it is called, so everything here is not. Functions run
//! on the calling thread, so that results do not depend on the number of threads, and callers share the work out by blocks of a fixed
//! size; those whose names end in `on_all` do that themselves. Arrays are row-major and contiguous.

mod cholesky;

pub use cholesky::Cholesky;

use crate::error::{Error, Result};
use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::householder;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::qr::no_pivoting::factor::{qr_in_place, qr_in_place_scratch, recommended_block_size};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par};
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

/// Eigenvalues or singular values in descending order, and their vectors.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// Descending.
    pub values: Vec<f64>,
    /// Unit vectors, one a row.
    pub vectors: Array2<f64>,
}

fn lent<'a, T>(matrix: &'a ArrayView2<'_, T>) -> MatRef<'a, T> {
    let values = matrix.as_slice().expect(CONTIGUOUS);
    MatRef::from_row_major_slice(values, matrix.nrows(), matrix.ncols())
}

fn lent_mut<'a, T>(matrix: &'a mut ArrayViewMut2<'_, T>) -> MatMut<'a, T> {
    let (rows, columns) = matrix.dim();
    MatMut::from_row_major_slice_mut(matrix.as_slice_mut().expect(CONTIGUOUS), rows, columns)
}

const CONTIGUOUS: &str = "matrices of linear algebra are row-major and contiguous";

/// Makes what products keep for the calling thread once and for all, twice the last cache's size: whoever measures memory calls it on every
/// thread before, so that it is not counted for the method that happens to come first.
pub fn warm_up() {
    // Larger than what is multiplied without packing.
    let ones = Array2::<f64>::ones((WARM_UP, WARM_UP));
    let mut product = Array2::zeros(ones.dim());
    times(ones.view(), ones.view(), product.view_mut());
    let (single, mut product) = (Array2::<f32>::ones(ones.dim()), Array2::zeros(ones.dim()));
    times_single(single.view(), single.view(), product.view_mut());
}

/// Rows and columns of what [`warm_up`] multiplies.
const WARM_UP: usize = 128;

/// `out` (m x n) = `a` (m x k) · `b` (n x k)ᵀ in single precision.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times_transposed(a: ArrayView2<f32>, b: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
    matmul(lent_mut(&mut out), Accum::Replace, lent(&a), lent(&b).transpose(), 1.0, Par::Seq);
}

/// `out` (m x n) = `a` (m x k) · `b` (k x n) in single precision.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times_single(a: ArrayView2<f32>, b: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
    matmul(lent_mut(&mut out), Accum::Replace, lent(&a), lent(&b), 1.0, Par::Seq);
}

/// As [`times_transposed`] in double precision.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times_transposed_f64(a: ArrayView2<f64>, b: ArrayView2<f64>, mut out: ArrayViewMut2<f64>) {
    matmul(lent_mut(&mut out), Accum::Replace, lent(&a), lent(&b).transpose(), 1.0, Par::Seq);
}

/// `out` (m x n) = `a` (m x k) · `b` (k x n) in double precision.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times(a: ArrayView2<f64>, b: ArrayView2<f64>, mut out: ArrayViewMut2<f64>) {
    matmul(lent_mut(&mut out), Accum::Replace, lent(&a), lent(&b), 1.0, Par::Seq);
}

/// As [`times_transposed_f64`], on all threads.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times_transposed_on_all(a: ArrayView2<f64>, b: ArrayView2<f64>, mut out: ArrayViewMut2<f64>) {
    in_strips(lent_mut(&mut out), lent(&a), lent(&b).transpose());
}

/// As [`times`], on all threads.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn times_on_all(a: ArrayView2<f64>, b: ArrayView2<f64>, mut out: ArrayViewMut2<f64>) {
    in_strips(lent_mut(&mut out), lent(&a), lent(&b));
}

/// Columns of a product that a thread computes at a time.
const STRIP: usize = 256;

fn in_strips(out: MatMut<f64>, a: MatRef<f64>, b: MatRef<f64>) {
    // A product checks its strip only.
    assert_eq!((out.nrows(), out.ncols(), a.ncols()), (a.nrows(), b.ncols(), b.nrows()), "sizes of a product");
    out.par_col_chunks_mut(STRIP).enumerate().for_each(|(strip, out)| {
        let b = b.subcols(strip * STRIP, out.ncols());
        matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
    });
}

/// `gram` (n x n) += `a` (m x n)ᵀ · `a`; half of it is computed, and copied.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn add_gram(a: ArrayView2<f64>, mut gram: ArrayViewMut2<f64>) {
    let n = a.ncols();
    let full = BlockStructure::Rectangular;
    let half = BlockStructure::TriangularLower;
    let a = lent(&a);
    triangular::matmul(lent_mut(&mut gram), half, Accum::Add, a.transpose(), full, a, full, 1.0, Par::Seq);
    for i in 0..n {
        for j in 0..i {
            gram[[j, i]] = gram[[i, j]];
        }
    }
}

/// The lower half of `gram` (m x m) += that of `a` (m x n) · `a`ᵀ; above the diagonal it stays as it is.
///
/// # Panics
/// Sizes that do not agree, arrays that are not contiguous.
pub fn add_half_gram_of_rows(a: ArrayView2<f64>, mut gram: ArrayViewMut2<f64>) {
    let full = BlockStructure::Rectangular;
    let half = BlockStructure::TriangularLower;
    let a = lent(&a);
    triangular::matmul(lent_mut(&mut gram), half, Accum::Add, a, full, a.transpose(), full, 1.0, Par::Seq);
}

/// Orthonormal columns (m x n) of which the first j span those of `a` (m x n, m ≥ n), for each j: Householder's Q of A = Q R.
/// Where columns of `a` depend on those before them, whatever completes the basis.
///
/// # Panics
/// More columns than rows.
pub fn orthonormal_columns(a: ArrayView2<f64>) -> Array2<f64> {
    let (m, n) = a.dim();
    assert!(m >= n, "{n} columns of {m} numbers cannot be orthonormal");
    let (mut basis, block) = (Mat::from_fn(m, n, |i, j| a[[i, j]]), recommended_block_size::<f64>(m, n));
    let (mut coefficients, mut q) = (Mat::<f64>::zeros(block, n), Mat::<f64>::identity(m, n));
    let factor = qr_in_place_scratch::<f64>(m, n, block, Par::Seq, Default::default());
    let apply = householder::apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(m, block, n);
    let mut memory = MemBuffer::new(factor.or(apply));
    let stack = MemStack::new(&mut memory);
    qr_in_place(basis.as_mut(), coefficients.as_mut(), Par::Seq, stack, Default::default());
    householder::apply_block_householder_sequence_on_the_left_in_place_with_conj(
        basis.as_ref(),
        coefficients.as_ref(),
        Conj::No,
        q.as_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
    );
    Array2::from_shape_fn((m, n), |(i, j)| q[(i, j)])
}

/// All eigenpairs of a symmetric matrix, of which the lower half is read.
///
/// # Errors
/// A matrix with an element that is not finite, or one that the iteration does not end on.
pub fn eigen(matrix: ArrayView2<f64>) -> Result<Spectrum> {
    let n = matrix.nrows();
    Error::expect_size("columns of a symmetric matrix", n, matrix.ncols())?;
    check_finite(&matrix)?;
    if n == 0 {
        return Ok(Spectrum { values: Vec::new(), vectors: Array2::zeros((0, 0)) });
    }
    let (mut values, mut vectors) = (vec![0f64; n], Mat::<f64>::zeros(n, n));
    let requirement = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(requirement);
    let diagonal = DiagMut::from_slice_mut(&mut values);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(lent(&matrix), diagonal, Some(vectors.as_mut()), Par::Seq, stack, Default::default())
        .map_err(|_| stuck("eigenvalues"))?;
    // faer's ascend.
    values.reverse();
    Ok(Spectrum { values, vectors: Array2::from_shape_fn((n, n), |(i, j)| vectors[(j, n - 1 - i)]) })
}

/// Eigenvalues of a symmetric matrix in descending order; its lower half is read.
///
/// # Errors
/// As [`eigen`].
pub fn eigenvalues(matrix: ArrayView2<f64>) -> Result<Vec<f64>> {
    let n = matrix.nrows();
    Error::expect_size("columns of a symmetric matrix", n, matrix.ncols())?;
    check_finite(&matrix)?;
    let mut values = vec![0f64; n];
    let requirement = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::No, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(requirement);
    let (diagonal, stack) = (DiagMut::from_slice_mut(&mut values), MemStack::new(&mut memory));
    self_adjoint_evd(lent(&matrix), diagonal, None, Par::Seq, stack, Default::default())
        .map_err(|_| stuck("eigenvalues"))?;
    values.reverse();
    Ok(values)
}

/// Singular values of `matrix` (m x n) and its right singular vectors: min(m, n) rows of n.
///
/// # Errors
/// A matrix with an element that is not finite, or one that the iteration does not end on.
pub fn singular(matrix: ArrayView2<f64>) -> Result<Spectrum> {
    let (m, n) = matrix.dim();
    check_finite(&matrix)?;
    let rank = m.min(n);
    if rank == 0 {
        return Ok(Spectrum { values: Vec::new(), vectors: Array2::zeros((0, n)) });
    }
    let (mut values, mut vectors) = (vec![0f64; rank], Mat::<f64>::zeros(n, rank));
    let (no, thin) = (ComputeSvdVectors::No, ComputeSvdVectors::Thin);
    let mut memory = MemBuffer::new(svd_scratch::<f64>(m, n, no, thin, Par::Seq, Default::default()));
    let (diagonal, stack) = (DiagMut::from_slice_mut(&mut values), MemStack::new(&mut memory));
    svd(lent(&matrix), diagonal, None, Some(vectors.as_mut()), Par::Seq, stack, Default::default())
        .map_err(|_| stuck("singular values"))?;
    Ok(Spectrum { values, vectors: Array2::from_shape_fn((rank, n), |(i, j)| vectors[(j, i)]) })
}

/// Whether a symmetric matrix, of which the lower half is read, is positive definite: whether it has a Cholesky factor.
/// What it holds is lost. An element that is not finite makes it none.
///
/// # Panics
/// A matrix that is not square or not contiguous.
pub fn is_positive_definite(mut matrix: ArrayViewMut2<f64>) -> bool {
    let n = matrix.nrows();
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    let factor = cholesky_in_place(lent_mut(&mut matrix), Default::default(), Par::Seq, stack, Default::default());
    factor.is_ok() && matrix.diag().iter().all(|pivot| *pivot > 0.0)
}

fn check_finite(matrix: &ArrayView2<f64>) -> Result<()> {
    match matrix.indexed_iter().find(|(_, v)| !v.is_finite()) {
        Some(((row, col), &value)) => Err(Error::NotFinite { row, col, value }),
        None => Ok(()),
    }
}

fn stuck(what: &str) -> Error {
    Error::Unsupported {
        what: format!("{what} of a finite matrix"),
        expected: "an iteration that converges".into(),
        found: "one that does not".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn matrix(m: usize, n: usize) -> Array2<f64> {
        Array2::from_shape_fn((m, n), |(i, j)| ((i * 37 + j * 101 + i * j * 13) % 97) as f64 / 48.0 - 1.0)
    }

    pub(super) fn close(a: &Array2<f64>, b: &Array2<f64>, bound: f64) {
        let worst = (a - b).iter().fold(0f64, |worst, d| worst.max(d.abs()));
        assert!(worst <= bound, "{worst:e}");
    }

    #[test]
    fn products_on_all_threads_are_the_whole_products() {
        for columns in [0, 1, STRIP, 2 * STRIP + 3] {
            let (a, b) = (matrix(7, 12), matrix(12, columns));
            let mut product = Array2::ones((7, columns));
            times_on_all(a.view(), b.view(), product.view_mut());
            close(&product, &a.dot(&b), 1e-12);
            let rows = b.t().as_standard_layout().into_owned();
            product.fill(1.0);
            times_transposed_on_all(a.view(), rows.view(), product.view_mut());
            close(&product, &a.dot(&b), 1e-12);
        }
    }

    #[test]
    #[should_panic(expected = "sizes of a product")]
    fn a_factor_of_too_many_columns_is_no_factor_of_a_product_on_all_threads() {
        times_on_all(matrix(2, 3).view(), matrix(3, 5).view(), Array2::zeros((2, 4)).view_mut());
    }

    #[test]
    fn products_are_those_of_ndarray() {
        let (a, b) = (matrix(7, 12), matrix(5, 12));
        let mut out = Array2::zeros((7, 5));
        times_transposed_f64(a.view(), b.view(), out.view_mut());
        close(&out, &a.dot(&b.t()), 1e-13);
        let single = |m: &Array2<f64>| m.mapv(|v| v as f32);
        let mut narrow = Array2::zeros((7, 5));
        times_transposed(single(&a).view(), single(&b).view(), narrow.view_mut());
        close(&narrow.mapv(f64::from), &out, 1e-5);
        let mut narrow = Array2::zeros((7, 12));
        times_single(single(&matrix(7, 5)).view(), single(&b).view(), narrow.view_mut());
        close(&narrow.mapv(f64::from), &matrix(7, 5).dot(&b), 1e-5);
        let mut out = Array2::zeros((7, 12));
        times(matrix(7, 5).view(), b.view(), out.view_mut());
        close(&out, &matrix(7, 5).dot(&b), 1e-13);
        let mut gram = Array2::from_elem((12, 12), 0.5);
        add_gram(a.view(), gram.view_mut());
        close(&gram, &(a.t().dot(&a) + 0.5), 1e-13);
        let mut half = Array2::from_elem((7, 7), 0.5);
        add_half_gram_of_rows(a.view(), half.view_mut());
        let expected = a.dot(&a.t());
        for ((i, j), value) in half.indexed_iter() {
            let gram = if j <= i { expected[[i, j]] } else { 0.0 };
            assert!((value - gram - 0.5).abs() <= 1e-13);
        }
    }

    #[test]
    fn a_spectrum_makes_the_matrix_again_and_descends() {
        for (m, n) in [(9, 6), (6, 9), (4, 4), (1, 3), (40, 200)] {
            let a = matrix(m, n);
            let (by_svd, by_gram) = (singular(a.view()).unwrap(), eigen(a.t().dot(&a).view()).unwrap());
            let alone = eigenvalues(a.t().dot(&a).view()).unwrap();
            assert!(alone.iter().zip(&by_gram.values).all(|(a, v)| (a - v).abs() <= 1e-11 * by_gram.values[0]));
            assert!(by_svd.values.is_sorted_by(|x, y| x >= y) && by_gram.values.is_sorted_by(|x, y| x >= y));
            for (s, square) in by_svd.values.iter().zip(&by_gram.values) {
                assert!((s * s - square).abs() <= 1e-11 * by_gram.values[0], "{s} {square}");
            }
            // A = A V Vᵀ, and V is orthonormal.
            let v = &by_svd.vectors;
            close(&a.dot(&v.t()).dot(v), &a, 1e-11);
            close(&v.dot(&v.t()), &Array2::eye(m.min(n)), 1e-12);
            close(&by_gram.vectors.dot(&by_gram.vectors.t()), &Array2::eye(n), 1e-12);
        }
    }

    #[test]
    fn orthonormal_columns_span_those_before_them() {
        let repeated = ndarray::concatenate![ndarray::Axis(1), matrix(9, 2), matrix(9, 2)];
        for a in
            [matrix(9, 6), matrix(4, 4), matrix(300, 70), matrix(5, 1), matrix(5, 0), repeated, Array2::zeros((4, 2))]
        {
            let (q, n) = (orthonormal_columns(a.view()), a.ncols());
            close(&q.t().dot(&q), &Array2::eye(n), 1e-13);
            let r = q.t().dot(&a);
            close(&q.dot(&r), &a, 1e-12);
            assert!(r.indexed_iter().all(|((i, j), r)| i <= j || r.abs() <= 1e-12));
        }
    }

    #[test]
    fn a_matrix_is_positive_definite_where_its_least_eigenvalue_is_above_zero() {
        for n in [1, 2, 9, 70] {
            let a = matrix(n + 3, n);
            let gram = a.t().dot(&a);
            let values = eigen(gram.view()).unwrap().values;
            for (part, expected) in [(0.999_999, true), (1.000_001, false), (1e3, false)] {
                let shift = values[n - 1] * part + 1e-13 * values[0] * f64::from(u8::from(!expected));
                let mut shifted = &gram - shift * Array2::<f64>::eye(n);
                assert_eq!(is_positive_definite(shifted.view_mut()), expected, "{n} {part}");
            }
        }
        assert!(is_positive_definite(Array2::zeros((0, 0)).view_mut()));
        assert!(!is_positive_definite(Array2::zeros((2, 2)).view_mut()));
        assert!(!is_positive_definite(Array2::from_elem((2, 2), f64::NAN).view_mut()));
    }

    #[test]
    fn what_is_empty_zero_or_not_finite_is_handled() {
        assert!(eigen(Array2::zeros((0, 0)).view()).unwrap().values.is_empty());
        assert_eq!(eigen(Array2::zeros((3, 3)).view()).unwrap().values, [0.0; 3]);
        assert_eq!(singular(Array2::zeros((2, 3)).view()).unwrap().values, [0.0; 2]);
        assert!(singular(Array2::zeros((0, 3)).view()).unwrap().values.is_empty());
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(eigen(Array2::from_elem((2, 2), bad).view()).is_err());
            assert!(eigenvalues(Array2::from_elem((2, 2), bad).view()).is_err());
            assert!(singular(Array2::from_elem((2, 3), bad).view()).is_err());
        }
        assert!(eigen(Array2::zeros((2, 3)).view()).is_err());
        assert!(eigenvalues(Array2::zeros((2, 3)).view()).is_err());
        assert!(eigenvalues(Array2::zeros((0, 0)).view()).unwrap().is_empty());
    }
}
