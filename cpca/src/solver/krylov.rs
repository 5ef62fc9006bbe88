//! Block Golub-Kahan bidiagonalisation with Rayleigh-Ritz and a residual test (Golub, Luk and Overton 1981; Musco and
//! Musco 2015).
//!
//! Q (q x n) are orthonormal rows that span random vectors, the guess, and what FᵀF makes of them again and again; P (p
//! x m) those that span Q Fᵀ. Both are kept orthogonal to working precision, and Q Fᵀ = C P with a small C (q x p),
//! whose singular pairs are the best that the span of Q holds. FᵀF is never formed, so small singular values are as
//! exact as large ones.
//!
//! **The stop.** Let s_i and v_i be those pairs, ρ_i = ‖FᵀF v_i − s_i² v_i‖ and t² the (k+1)-th square. Then s_i² is
//! short of an eigenvalue by ρ_i at most, and by ρ_i²/(s_i² − t²) where the two are apart (Parlett 1980, §11.7). The
//! sum of the smaller bounds is the excess of the energy that is left over; it has to be a small part of what is left
//! over.
//!
//! **Starts.** The block holds more random vectors than components are wanted, guess or not: neither a guess orthogonal
//! to the leading vectors nor a singular value that is repeated k times can hide them.

use super::basis::{Basis, product};
use super::{Pairs, norm, svd};
use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use prt_transfer::random::Random;
use prt_transfer::{Result, linalg};

/// Random vectors beyond the components wanted.
const BEYOND: usize = 4;
/// Excess energy, of what is left over, at which the iteration ends. A hundredth of what is promised, since t is not
/// exact.
const EXCESS: f64 = 1e-8;
/// Blocks before a guess is believed, so that what is orthogonal to it has grown.
const BELIEF: usize = 3;
/// Columns and rows, in blocks, below which the direct method is faster.
const BLOCKS: usize = 4;
const SEED: u64 = 0x6b72_796c_6f76;

pub(super) fn leading(f: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Pairs> {
    attempt(f, components, start)?.map_or_else(|| svd::leading(f, components, None), Ok)
}

/// None where the matrix is small or half of all directions do not suffice.
pub(super) fn attempt(f: ArrayView2<f64>, components: usize, start: Option<ArrayView2<f64>>) -> Result<Option<Pairs>> {
    if f.nrows().min(f.ncols()) < BLOCKS * (components + BEYOND) {
        return Ok(None);
    }
    Search::new(f, components, start).run()
}

struct Search<'a> {
    f: ArrayView2<'a, f64>,
    components: usize,
    /// ‖F‖².
    energy: f64,
    /// C, a row for each of Q and a column for each of P.
    coefficients: Array2<f64>,
    right: Basis,
    left: Basis,
    /// Of Q, those whose images are not in P yet.
    block: Array2<f64>,
    /// Blocks that the test waits for.
    least: usize,
}

impl<'a> Search<'a> {
    fn new(f: ArrayView2<'a, f64>, components: usize, start: Option<ArrayView2<f64>>) -> Search<'a> {
        let (m, n) = f.dim();
        let block = first_block(n, components, start);
        let least = if start.is_some() { BELIEF } else { 1 };
        // Beyond half of all directions the direct method is faster; a block more, so that the last is whole.
        let most = m.min(n) / 2 + block.nrows();
        let mut right = Basis::new(most, n);
        right.extend(block, 1e-10);
        let (block, left) = (right.view().to_owned(), Basis::new(most, m));
        let energy = f.iter().map(|v| v * v).sum();
        Search { f, components, energy, coefficients: Array2::zeros((most, most)), right, left, block, least }
    }

    /// None where half of all directions do not suffice.
    fn run(mut self) -> Result<Option<Pairs>> {
        let most = self.f.nrows().min(self.f.ncols()) / 2;
        let (mut blocks, mut tested) = (0, 0);
        while self.right.len() <= most {
            let closed = self.advance();
            blocks += 1;
            // What a test costs grows with Q: one every eighth of it.
            if closed || (blocks >= self.least && blocks * 8 >= tested * 9) {
                tested = blocks;
                let (pairs, converged) = self.test()?;
                if converged || closed {
                    return Ok(Some(Pairs { iterations: blocks, ..pairs }));
                }
            }
        }
        Ok(None)
    }

    /// Takes the images of the block into P and what Fᵀ makes of those into Q. True where nothing was new: Q spans what
    /// FᵀF maps into itself.
    fn advance(&mut self) -> bool {
        let noise = f64::EPSILON * self.energy.sqrt();
        let (q, p) = (self.right.len(), self.left.len());
        let mut images = Array2::zeros((self.block.nrows(), self.f.nrows()));
        linalg::times_transposed_f64(self.block.view(), self.f, images.view_mut());
        let coefficients = self.left.extend(images, noise);
        self.coefficients.slice_mut(s![q - self.block.nrows()..q, ..self.left.len()]).assign(&coefficients);
        self.right.extend(product(self.left.since(p), self.f), noise);
        self.block = self.right.since(q).to_owned();
        self.block.is_empty()
    }

    /// The best pairs of the span of Q as far as its images are known, and whether they are good enough.
    fn test(&self) -> Result<(Pairs, bool)> {
        let q = self.right.len() - self.block.nrows();
        let coefficients = self.coefficients.slice(s![..q, ..self.left.len()]);
        let spectrum = linalg::singular(coefficients.t().as_standard_layout().view())?;
        let mut squares: Vec<f64> = spectrum.values.iter().map(|s| s * s).collect();
        squares.resize(squares.len().max(self.components + 1), 0.0);
        let bound = super::zero(self.f.dim());
        let pairs = Pairs::leading(&squares, spectrum.vectors.view(), self.components, bound * bound);
        let known = self.right.view();
        let vectors = product(pairs.vectors.view(), known.slice(s![..q, ..]));
        let pairs = Pairs { vectors, ..pairs };
        let converged = self.converged(&pairs, squares[self.components]);
        Ok((pairs, converged))
    }

    fn converged(&self, pairs: &Pairs, next: f64) -> bool {
        let mut images = Array2::zeros((pairs.squares.len(), self.f.nrows()));
        linalg::times_transposed_f64(pairs.vectors.view(), self.f, images.view_mut());
        let back = product(images.view(), self.f);
        let short = |(i, &square): (usize, &f64)| {
            let residual = norm((&back.row(i) - &(&pairs.vectors.row(i) * square)).view());
            shortfall(residual, square - next)
        };
        let excess: f64 = pairs.squares.iter().enumerate().map(short).sum();
        let rounding = super::zero(self.f.dim()).powi(2) * self.energy;
        excess <= rounding || excess <= EXCESS * self.left_over(pairs, images.view())
    }

    /// ‖F − F VᵀV‖².
    fn left_over(&self, pairs: &Pairs, images: ArrayView2<f64>) -> f64 {
        let difference = self.energy - pairs.squares.iter().sum::<f64>();
        if difference > 1e-6 * self.energy {
            return difference;
        }
        let images = images.t().as_standard_layout().into_owned();
        let rest = product(images.view(), pairs.vectors.view()) - self.f;
        rest.iter().map(|v| v * v).sum()
    }
}

/// By how much an eigenvalue can be above the square of a pair with this residual, that the next square is `gap` below.
pub(super) fn shortfall(residual: f64, gap: f64) -> f64 {
    if gap > residual { residual * residual / gap } else { residual }
}

/// The guess, then random rows.
fn first_block(n: usize, components: usize, start: Option<ArrayView2<f64>>) -> Array2<f64> {
    let mut random = Random(SEED);
    let mut block = Array2::from_shape_simple_fn((components + BEYOND, n), || random.normal());
    if let Some(start) = start {
        let start = start.slice_axis(Axis(0), (..start.nrows().min(components)).into());
        // In front, so that what it spans stays as it is.
        block = concatenate(Axis(0), &[start, block.view()]).expect("both have n columns");
    }
    for mut row in block.rows_mut() {
        let length = norm(row.view());
        row.mapv_inplace(|v| v / length.max(f64::MIN_POSITIVE));
    }
    block
}
