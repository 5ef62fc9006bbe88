//! Leading principal components of centred rows: the first right singular vectors of F (m x n).
//!
//! All solvers answer the same question and differ in what they promise. With s₁ ≥ s₂ ≥ … the singular values of F, V
//! (k x n) what is returned and ε = 2⁻⁵²: the energy left over, ‖F − F VᵀV‖², is at least Σ s_i² over i > k (Eckart and
//! Young), and
//!
//! | solver | excess over that optimum | a singular value is zero up to |
//! | --- | --- | --- |
//! | `svd` | rounding | s₁·max(m, n)·ε |
//! | `krylov` | 1e-6 of the optimum, by a residual test with a margin of 100; else `svd` answers | s₁·max(m, n)·ε |
//! | `gram` | (max(m, n)·ε)²·s₁⁴/s_k², since s² is known to ε·s₁² only | s₁·(max(m, n)·ε)^½ |
//! | `auto` | 1e-6 of the optimum: `gram` where its bound is below, else `krylov` | s₁·max(m, n)·ε |
//! | `power` | none: see [`Solver::Power`] | 4·s₁·max(m, n)·2⁻²³ |
//!
//! Pairs whose singular value counts as zero are left out: the exact smaller model. Rows are brought to the same scale
//! by a power of two first, so that `F·2^j` has the same vectors to the bit.

mod auto;
mod basis;
mod gram;
mod krylov;
mod power;
mod scale;
mod subspace;
mod svd;
#[cfg(test)]
mod tests;

pub(crate) use basis::product_transposed;
pub use subspace::leading_of_gram;

use crate::params::Solver;
use basis::product;
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use prt_transfer::progress::Quiet;
use prt_transfer::{Error, Progress, Result};
use scale::Scale;

/// Leading right singular pairs of rows F (m x n).
#[derive(Clone, Debug, PartialEq)]
pub struct Principal {
    /// Squares of singular values, descending.
    pub squares: Vec<f64>,
    /// Unit vectors of n numbers, one a row; of each the element of largest magnitude is positive (the first of
    /// several).
    pub vectors: Array2<f64>,
    /// The greatest ‖FᵀF·v − s²·v‖/s₁² of the pairs, measured on what is returned; 0 where there is none. A solver that
    /// stopped early says so here.
    pub residual: f64,
    /// Multiplications by FᵀF, of one vector or of a block at once; 0 for a direct method.
    pub iterations: usize,
}

/// A way to compute leading singular pairs.
///
/// ```
/// use ndarray::array;
/// use prt_cpca::Solver;
/// use prt_cpca::solver::EigenSolver;
///
/// let rows = array![[3.0, 0.0, 4.0], [-3.0, 0.0, -4.0], [0.0, 1.0, 0.0]];
/// let principal = Solver::Auto.solver().leading(rows.view(), 3, None)?;
/// // The rank is 2: the third pair is left out.
/// assert_eq!(principal.vectors.nrows(), 2);
/// assert!((principal.squares[0] - 50.0).abs() < 1e-12 && (principal.squares[1] - 1.0).abs() < 1e-12);
/// assert!((principal.vectors[[0, 2]] - 0.8).abs() < 1e-12);
/// # Ok::<(), prt_transfer::Error>(())
/// ```
pub trait EigenSolver: Sync {
    /// Leading `components` pairs of `rows` (m x n), fewer where the rank is smaller. `start` (j x n) spans a guess of
    /// the vectors; it may save time, or be ignored.
    ///
    /// # Errors
    /// An element that is not finite; a start that has not n columns; squares beyond the range of `f64` (elements above
    /// 1e150).
    fn leading(&self, rows: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Principal>;
}

impl Solver {
    /// What computes it.
    pub fn solver(self) -> Box<dyn EigenSolver + Send> {
        self.watched(&Quiet)
    }

    /// What computes it, and asks after each step whether to stop (by [`Progress::advance`] of 0 units); direct methods are one step.
    pub fn watched(self, progress: &dyn Progress) -> Box<dyn EigenSolver + Send + '_> {
        let solve = match self {
            Solver::Auto => auto::leading,
            Solver::Power => power::leading,
            Solver::Krylov => krylov::leading,
            Solver::Gram => gram::leading,
            Solver::Svd => svd::leading,
        };
        Box::new(Prepared { solve, progress })
    }
}

/// What is asked of a method.
#[derive(Clone, Copy)]
struct Question<'a> {
    /// F with elements of magnitude 1 to 2 at most, row-major.
    f: ArrayView2<'a, f64>,
    /// 1 to min(m, n).
    components: usize,
    /// A guess with n finite columns.
    start: Option<ArrayView2<'a, f64>>,
    progress: &'a dyn Progress,
}

type Solve = fn(Question) -> Result<Pairs>;

/// Pairs by descending square, those of zero left out, and iterations.
struct Pairs {
    squares: Vec<f64>,
    vectors: Array2<f64>,
    iterations: usize,
}

impl Pairs {
    /// The first of them, down to what counts as zero: `bound` times the first square.
    fn leading(squares: &[f64], vectors: ArrayView2<f64>, components: usize, bound: f64) -> Pairs {
        let above = |square: &&f64| **square > bound * squares[0] && **square > 0.0;
        let squares: Vec<f64> = squares.iter().take(components).take_while(above).copied().collect();
        let vectors = vectors.slice_axis(Axis(0), (..squares.len()).into()).to_owned();
        Pairs { squares, vectors, iterations: 0 }
    }
}

/// What all solvers have in common: checks, scale, signs, residual.
struct Prepared<'a> {
    solve: Solve,
    progress: &'a dyn Progress,
}

impl EigenSolver for Prepared<'_> {
    fn leading(&self, rows: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Principal> {
        let (m, n) = rows.dim();
        let start = checked(start, n)?;
        let (scale, rows) = Scale::normalise(rows)?;
        let components = components.min(m).min(n);
        if components == 0 || scale.is_zero() {
            return Ok(Principal::empty(n));
        }
        let (start, progress) = (start.as_ref().map(|s| s.view()), self.progress);
        let mut pairs = (self.solve)(Question { f: rows.view(), components, start, progress })?;
        fix_signs(&mut pairs.vectors);
        let images = product(product_transposed(pairs.vectors.view(), rows.view()).view(), rows.view());
        let residual = residual(&pairs, &images);
        let squares = pairs.squares.iter().map(|&s| scale.restore(s, 2)).collect::<Result<_>>()?;
        Ok(Principal { squares, vectors: pairs.vectors, residual, iterations: pairs.iterations })
    }
}

impl Principal {
    fn empty(n: usize) -> Principal {
        Principal { squares: Vec::new(), vectors: Array2::zeros((0, n)), residual: 0.0, iterations: 0 }
    }
}

/// The guess, row-major.
fn checked(start: Option<ArrayView2<f64>>, n: usize) -> Result<Option<Array2<f64>>> {
    let Some(start) = start else { return Ok(None) };
    Error::expect_size("columns of the guess of an eigen-solver", n, start.ncols())?;
    Scale::normalise(start).map(|(_, start)| Some(start))
}

/// The greatest ‖image − s²·v‖/s₁² where images are the products of FᵀF with the vectors.
fn residual(pairs: &Pairs, images: &Array2<f64>) -> f64 {
    let mut worst = 0f64;
    for (i, square) in pairs.squares.iter().enumerate() {
        let difference = &images.row(i) - &(&pairs.vectors.row(i) * *square);
        worst = worst.max(norm(difference.view()) / pairs.squares[0]);
    }
    worst
}

fn fix_signs(vectors: &mut Array2<f64>) {
    for mut row in vectors.rows_mut() {
        let largest = row.iter().fold(0f64, |largest, v| if v.abs() > largest.abs() { *v } else { largest });
        if largest < 0.0 {
            row.mapv_inplace(|v| -v);
        }
    }
}

fn norm(vector: ArrayView1<f64>) -> f64 {
    vector.dot(&vector).sqrt()
}

/// Up to this part of the first, a singular value counts as zero: max(m, n)·ε.
fn zero((m, n): (usize, usize)) -> f64 {
    m.max(n) as f64 * f64::EPSILON
}
