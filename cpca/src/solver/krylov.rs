//! Block Golub-Kahan bidiagonalisation with Rayleigh-Ritz and a residual test (Golub, Luk and Overton 1981; Musco and
//! Musco 2015).
//!
//! Q (q x n) are orthonormal rows that span random vectors, the guess, and what FᵀF makes of them again and again; P (p
//! x m) those that span Q Fᵀ. Both are kept orthogonal to working precision, and Q Fᵀ = C P with a small C (q x p),
//! whose singular pairs are the best that the span of Q holds. FᵀF is never formed, so small singular values are as
//! exact as large ones. What is left of P F = D Q beside Q, by which Q grows, is in D too: the residuals of the pairs
//! are those of small matrices, w C D - s² w for a vector w Q.
//!
//! **The stop.** Let s_i and v_i be those pairs, ρ_i = ‖FᵀF v_i − s_i² v_i‖ and t² the (k+1)-th square. Then s_i² is
//! short of an eigenvalue by ρ_i at most, and by ρ_i²/(s_i² − t²) where the two are apart (Parlett 1980, §11.7). The
//! sum of the smaller bounds is the excess of the energy that is left over; it has to be a small part of what is left
//! over.
//!
//! **Starts.** The block holds more random vectors than components are wanted, guess or not: neither a guess orthogonal
//! to the leading vectors nor a singular value that is repeated k times can hide them.

use super::basis::{Basis, product, product_transposed};
use super::{Pairs, Question, norm, svd};
use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use prt_transfer::random::Random;
use prt_transfer::{Progress, Result, linalg};

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

pub(super) fn leading(question: Question) -> Result<Pairs> {
    attempt(question)?.map_or_else(|| svd::leading(question), Ok)
}

/// None where the matrix is small or half of all directions do not suffice.
pub(super) fn attempt(question: Question) -> Result<Option<Pairs>> {
    if question.f.nrows().min(question.f.ncols()) < BLOCKS * (question.components + BEYOND) {
        return Ok(None);
    }
    Search::new(question).run()
}

struct Search<'a> {
    f: ArrayView2<'a, f64>,
    components: usize,
    /// ‖F‖².
    energy: f64,
    /// C, a row for each of Q and a column for each of P.
    coefficients: Array2<f64>,
    /// D, a row for each of P and a column for each of Q.
    back: Array2<f64>,
    right: Basis,
    left: Basis,
    /// Of Q, those whose images are not in P yet.
    block: Array2<f64>,
    /// Blocks that the test waits for.
    least: usize,
    progress: &'a dyn Progress,
}

impl<'a> Search<'a> {
    fn new(Question { f, components, start, progress }: Question<'a>) -> Search<'a> {
        let (m, n) = f.dim();
        let block = first_block(n, components, start);
        let least = if start.is_some() { BELIEF } else { 1 };
        // Beyond half of all directions the direct method is faster; a block more, so that the last is whole.
        let most = m.min(n) / 2 + block.nrows();
        let mut right = Basis::new(most, n);
        right.extend(block, 1e-10);
        let (block, left) = (right.view().to_owned(), Basis::new(most, m));
        let energy = f.iter().map(|v| v * v).sum();
        let (coefficients, back) = (Array2::zeros((most, most)), Array2::zeros((most, most)));
        Search { f, components, energy, coefficients, back, right, left, block, least, progress }
    }

    /// None where half of all directions do not suffice.
    fn run(mut self) -> Result<Option<Pairs>> {
        let most = self.f.nrows().min(self.f.ncols()) / 2;
        let (mut blocks, mut tested) = (0, 0);
        while self.right.len() <= most {
            self.progress.advance(0)?;
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
        let coefficients = self.left.extend(product_transposed(self.block.view(), self.f), noise);
        self.coefficients.slice_mut(s![q - self.block.nrows()..q, ..self.left.len()]).assign(&coefficients);
        let back = self.right.extend(product(self.left.since(p), self.f), noise);
        self.back.slice_mut(s![p..self.left.len(), ..self.right.len()]).assign(&back);
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
        let excess = self.excess(&pairs, coefficients, squares[self.components]);
        let vectors = product(pairs.vectors.view(), self.right.view().slice(s![..q, ..]));
        let pairs = Pairs { vectors, ..pairs };
        let rounding = super::zero(self.f.dim()).powi(2) * self.energy;
        let converged = excess <= rounding || excess <= EXCESS * self.left_over(&pairs);
        Ok((pairs, converged))
    }

    /// By how much the energy of pairs, whose vectors are given as w, can be short of the best.
    fn excess(&self, pairs: &Pairs, coefficients: ArrayView2<f64>, next: f64) -> f64 {
        let images = product(pairs.vectors.view(), coefficients.as_standard_layout().view());
        let back = self.back.slice(s![..self.left.len(), ..self.right.len()]);
        let mut residuals = product(images.view(), back.as_standard_layout().view());
        let short = |(i, &square): (usize, &f64)| {
            let mut residual = residuals.row_mut(i);
            let w = pairs.vectors.row(i);
            residual.slice_mut(s![..w.len()]).scaled_add(-square, &w);
            shortfall(norm(residual.view()), square - next)
        };
        pairs.squares.iter().enumerate().map(short).sum()
    }

    /// ‖F − F VᵀV‖².
    fn left_over(&self, pairs: &Pairs) -> f64 {
        let difference = self.energy - pairs.squares.iter().sum::<f64>();
        if difference > 1e-6 * self.energy {
            return difference;
        }
        let images = product_transposed(self.f, pairs.vectors.view());
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
