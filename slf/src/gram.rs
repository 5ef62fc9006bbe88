//! Residuals of a cluster, and the eigenpairs of their Gram matrix where they are more than directions.

use ndarray::{Array2, s};
use prt_cpca::solver::leading_of_gram;
use prt_transfer::random::Random;
use prt_transfer::samples::square;
use prt_transfer::{Result, linalg};
use std::ops::Range;

/// Parts of some samples: rows of G_i.
pub(crate) struct Rows<'a> {
    /// Of all samples, `stride` each.
    pub(crate) values: &'a [f32],
    /// Which samples.
    pub(crate) group: &'a [u32],
    pub(crate) stride: usize,
    /// Which part of them.
    pub(crate) first: usize,
    pub(crate) length: usize,
}

/// Directions for each vector of a block above which iterating on a Gram matrix is faster than all of its eigenpairs.
const COLUMNS: usize = 24;
/// Vectors that are iterated beside those that are wanted, and steps.
const BEYOND: usize = 4;
const STEPS: usize = 8;
const SEED: u64 = 0x0073_6c66;

impl Rows<'_> {
    /// Rows that are taken to double precision at a time.
    pub(crate) const BLOCK: usize = 256;

    /// The `at`th of them.
    pub(crate) fn row(&self, at: usize) -> &[f32] {
        &self.values[self.group[at] as usize * self.stride + self.first..][..self.length]
    }

    /// Some of them in double precision.
    pub(crate) fn gathered(&self, range: Range<usize>) -> Array2<f64> {
        let mut rows = Array2::zeros((range.len(), self.length));
        for (mut out, at) in rows.outer_iter_mut().zip(range) {
            out.iter_mut().zip(self.row(at)).for_each(|(out, x)| *out = f64::from(*x));
        }
        rows
    }

    /// All of them, a block after the other.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Range<usize>> {
        let count = self.group.len();
        (0..count).step_by(Self::BLOCK).map(move |first| first..(first + Self::BLOCK).min(count))
    }

    /// Σ G².
    pub(crate) fn square(&self) -> f64 {
        (0..self.group.len()).map(|at| square(self.row(at))).sum()
    }

    /// The smaller of GᵀG and G Gᵀ.
    pub(crate) fn gram(&self) -> Array2<f64> {
        let (m, n) = (self.group.len(), self.length);
        let mut gram = Array2::zeros((m.min(n), m.min(n)));
        if m > n {
            self.blocks().for_each(|range| linalg::add_gram(self.gathered(range).view(), gram.view_mut()));
        } else {
            linalg::add_half_gram_of_rows(self.gathered(0..m).view(), gram.view_mut());
        }
        gram
    }
}

/// Leading right singular vectors of more rows than directions: eigenvectors of GᵀG, never with all rows in double precision at once.
pub(crate) fn tall_leading(rows: &Rows, components: usize) -> Result<Array2<f64>> {
    let gram = rows.gram();
    let start = if rows.length > COLUMNS * (components + BEYOND) { Some(guess(&gram, components)) } else { None };
    Ok(leading_of_gram(gram.view(), components, start.as_ref().map(|start| start.view()))?.vectors)
}

/// Steps of subspace iteration from random vectors: what the solver improves and proves.
fn guess(gram: &Array2<f64>, components: usize) -> Array2<f64> {
    let mut random = Random(SEED);
    let n = gram.ncols();
    let mut basis = Array2::from_shape_simple_fn((components + BEYOND, n), || random.normal());
    for _ in 0..STEPS {
        let mut next = Array2::zeros(basis.dim());
        linalg::times(basis.view(), gram.view(), next.view_mut());
        basis = linalg::orthonormal_columns(next.t()).t().as_standard_layout().into_owned();
    }
    basis.slice(s![..components, ..]).to_owned()
}
