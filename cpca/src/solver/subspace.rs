//! Leading eigenpairs of a Gram matrix from a good guess, checked: the inner step of iterative clustering.
//!
//! Block Davidson without a preconditioner: a basis Q grows by the residuals of its best pairs (θ_i, v_i), i ≤ k, until
//! they are small. The answer is proved, so that a guess may be as bad as it likes: with Θ = diag(θ) and τ < θ_k, where
//! τI − (G − VᵀΘV) has a Cholesky factor no eigenvalue of G outside of the span of V exceeds τ, and the sum of the k
//! leading ones is above Σ θ_i by ‖R‖²/(θ_k − τ) at most, R the residuals. Where the proof fails the direct method
//! answers.

use super::basis::{Basis, product};
use super::scale::Scale;
use super::{Pairs, Principal, checked, fix_signs, norm, residual};
use ndarray::{Array2, ArrayView2, Axis, s};
use prt_transfer::random::Random;
use prt_transfer::{Error, Result, linalg};

/// Columns for each component from which iterating is faster. Measured by `cargo bench -p prt-benches --bench solvers`,
/// one thread of a busy server, milliseconds:
///
/// | n, k | decomposition | iteration, members moved by 0.1 %, 1 %, 10 % |
/// | --- | --- | --- |
/// | 25, 2 | 0.12 | 0.02, 0.04, 0.07 |
/// | 64, 4 | 0.68 | 0.28, 0.27, 0.49 |
/// | 100, 8 | 0.97 | 0.31, 0.48, 0.70 |
/// | 155, 8 | 2.5 | 0.54, 0.74, 0.98 |
const COLUMNS: usize = 12;
/// Vectors beyond those wanted.
const BEYOND: usize = 2;
/// Excess energy, of what is left over, at which the iteration ends.
const EXCESS: f64 = 1e-6;
/// Steps at most.
const STEPS: usize = 6;
const SEED: u64 = 0x6772_616d;

/// Leading `components` eigenpairs of a symmetric matrix G = FᵀF (n x n), fewer where the rank is smaller: squares of
/// the singular values of F down to n·ε of the first, and its right singular vectors. `start` (j x n) spans a guess of
/// them.
///
/// With a good guess and n of 12·k or more this is up to five times as fast as a decomposition. The energy that is left
/// over, tr G − Σ s², is then above the optimum by the larger of 1e-6 of it and n·ε·s₁² at most.
///
/// # Errors
/// A matrix that is not square or has an element that is not finite; a start that has not n columns.
pub fn leading_of_gram(gram: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Principal> {
    let n = gram.ncols();
    Error::expect_size("rows of a Gram matrix", n, gram.nrows())?;
    let start = checked(start, n)?;
    let (scale, gram) = Scale::normalise(gram)?;
    let components = components.min(n);
    if components == 0 || scale.is_zero() {
        return Ok(Principal::empty(n));
    }
    let found = match start {
        Some(start) if components * COLUMNS <= n => iterated(gram.view(), components, start.view())?,
        _ => None,
    };
    let mut pairs = found.map_or_else(|| direct(gram.view(), components), Ok)?;
    fix_signs(&mut pairs.vectors);
    let images = product(pairs.vectors.view(), gram.view());
    let residual = residual(&pairs, &images);
    let squares = pairs.squares.iter().map(|&s| scale.restore(s, 1)).collect::<Result<_>>()?;
    Ok(Principal { squares, vectors: pairs.vectors, residual, iterations: pairs.iterations })
}

fn direct(gram: ArrayView2<f64>, components: usize) -> Result<Pairs> {
    let spectrum = linalg::eigen(gram)?;
    Ok(Pairs::leading(&spectrum.values, spectrum.vectors.view(), components, super::zero(gram.dim())))
}

/// None where the answer is not proved after a few steps.
fn iterated(gram: ArrayView2<f64>, components: usize, start: ArrayView2<f64>) -> Result<Option<Pairs>> {
    let energy = gram.diag().sum();
    let mut basis = first_basis(components, start);
    let mut images = Array2::<f64>::zeros((0, gram.ncols()));
    for step in 1..=STEPS {
        let fresh = product(basis.since(images.nrows()), gram);
        images.append(Axis(0), fresh.view()).expect("n columns");
        let ritz = Ritz::of(&basis, images.view(), components + BEYOND)?;
        if let Some(tau) = ritz.converged(components, energy) {
            let pairs = Pairs::leading(&ritz.values, ritz.vectors.view(), components, super::zero(gram.dim()));
            if pairs.squares.len() < components {
                // The rank is at hand, or nearly: for the direct method to say.
                return Ok(None);
            }
            if nothing_above(tau, gram, &pairs) {
                return Ok(Some(Pairs { iterations: step, ..pairs }));
            }
        }
        basis.extend(ritz.residuals, f64::EPSILON * energy);
        if basis.len() == images.nrows() {
            return Ok(None);
        }
    }
    Ok(None)
}

/// The guess and random vectors.
fn first_basis(components: usize, start: ArrayView2<f64>) -> Basis {
    let (n, wanted) = (start.ncols(), components + BEYOND);
    let mut basis = Basis::new(wanted * STEPS, n);
    let used = start.nrows().min(components);
    basis.extend(start.slice(s![..used, ..]).to_owned(), f64::EPSILON.sqrt());
    let mut random = Random(SEED);
    let rest = Array2::from_shape_simple_fn((wanted - basis.len(), n), || random.normal());
    basis.extend(rest, f64::EPSILON.sqrt());
    basis
}

/// The best pairs that a basis holds.
struct Ritz {
    values: Vec<f64>,
    vectors: Array2<f64>,
    /// G v_i − θ_i v_i.
    residuals: Array2<f64>,
}

impl Ritz {
    fn of(basis: &Basis, images: ArrayView2<f64>, wanted: usize) -> Result<Ritz> {
        let mut small = Array2::zeros((basis.len(), basis.len()));
        linalg::times_transposed_f64(images, basis.view(), small.view_mut());
        let spectrum = linalg::eigen(small.view())?;
        let weights = spectrum.vectors.slice(s![..wanted.min(basis.len()), ..]);
        let (vectors, mut residuals) = (product(weights, basis.view()), product(weights, images));
        for (i, mut row) in residuals.rows_mut().into_iter().enumerate() {
            row.scaled_add(-spectrum.values[i], &vectors.row(i));
        }
        Ok(Ritz { values: spectrum.values, vectors, residuals })
    }

    /// A τ, above the next value and its error, for which the excess ‖R‖²/(θ_k − τ) is small enough.
    fn converged(&self, components: usize, energy: f64) -> Option<f64> {
        let (last, next) = (*self.values.get(components - 1)?, *self.values.get(components)?);
        let left = energy - self.values[..components].iter().sum::<f64>();
        let rounding = self.vectors.ncols() as f64 * f64::EPSILON * self.values[0];
        let squared: f64 = self.residuals.slice(s![..components, ..]).iter().map(|r| r * r).sum();
        let tau = last - (last - next) / 4.0;
        let excess_is_small = squared <= (EXCESS * left).max(rounding) * (last - tau);
        (excess_is_small && next + norm(self.residuals.row(components)) <= tau).then_some(tau)
    }
}

/// Whether G − VᵀΘV has all eigenvalues below τ.
fn nothing_above(tau: f64, gram: ArrayView2<f64>, pairs: &Pairs) -> bool {
    let mut scaled = pairs.vectors.clone();
    for (mut row, square) in scaled.rows_mut().into_iter().zip(&pairs.squares) {
        row.mapv_inplace(|v| v * square);
    }
    let mut rest = product(scaled.t().as_standard_layout().view(), pairs.vectors.view()) - gram;
    rest.diag_mut().mapv_inplace(|v| v + tau);
    linalg::is_positive_definite(rest.view_mut())
}
