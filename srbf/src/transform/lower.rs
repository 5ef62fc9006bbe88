//! The Cholesky factor of the Gram matrix.

use ndarray::{Array2, ArrayViewMut2};
use prt_transfer::Count;
use prt_transfer::linalg::Cholesky;

/// L with G = L Lᵀ, held without the zeros above its diagonal.
pub(super) struct Lower {
    n: usize,
    /// Row after row, row i of i + 1 numbers.
    values: Vec<f64>,
}

impl Lower {
    pub(super) fn new(cholesky: &Cholesky) -> Lower {
        let rows = cholesky.lower();
        let n = rows.nrows();
        let mut values = Vec::with_capacity(n * (n + 1) / 2);
        rows.outer_iter().enumerate().for_each(|(i, row)| values.extend(row.iter().take(i + 1)));
        Lower { n, values }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.values[i * (i + 1) / 2..][..=i]
    }

    /// Memory of the values.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }

    /// `x` becomes L⁻¹ x. A division counts as a multiplication.
    pub(super) fn forward<C: Count>(&self, x: &mut [f64], count: &mut C) {
        for i in 0..self.n {
            let row = self.row(i);
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
            count.multiply_add(i);
            count.multiply(1);
        }
    }

    /// `x` becomes L⁻ᵀ x.
    pub(super) fn backward(&self, x: &mut [f64]) {
        for i in (0..self.n).rev() {
            let row = self.row(i);
            x[i] /= row[i];
            let known = x[i];
            x[..i].iter_mut().zip(row).for_each(|(x, l)| *x -= l * known);
        }
    }

    /// As [`Lower::forward`] for every column of `x` (n x columns), contiguous.
    pub(super) fn forward_columns(&self, x: ArrayViewMut2<f64>) {
        self.whole().solve_lower(x);
    }

    /// As [`Lower::backward`] for every column of `x` (n x columns), contiguous.
    pub(super) fn backward_columns(&self, x: ArrayViewMut2<f64>) {
        self.whole().solve_upper(x);
    }

    /// [`Lower::forward`], then [`Lower::backward`], for every column of `x` (n x columns), contiguous.
    pub(super) fn solve_columns(&self, x: ArrayViewMut2<f64>) {
        self.whole().solve(x);
    }

    /// With the zeros: what a solve for many columns wants costs less to make than to use.
    fn whole(&self) -> Cholesky {
        let mut lower = Array2::zeros((self.n, self.n));
        for (i, mut row) in lower.outer_iter_mut().enumerate() {
            row.iter_mut().zip(self.row(i)).for_each(|(to, l)| *to = *l);
        }
        Cholesky::from_lower(lower)
    }
}

/// Eight sums side by side: one alone would wait for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0f64; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(s, (a, b))| *s += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::{NoCount, Tally};

    fn lower(n: usize) -> Lower {
        let element = |(i, j): (usize, usize)| if i == j { 2.0 + i as f64 } else { ((i * 7 + j * 3) % 5) as f64 - 2.0 };
        Lower::new(&Cholesky::from_lower(Array2::from_shape_fn((n, n), |p| if p.1 > p.0 { 0.0 } else { element(p) })))
    }

    #[test]
    fn one_column_is_solved_as_many_are() {
        for n in [1, 2, 9, 40] {
            let lower = lower(n);
            let columns = Array2::from_shape_fn((n, 3), |(i, c)| ((i * 5 + c * 2) % 7) as f64 - 3.0);
            let [mut forward, mut backward, mut solved] = [columns.clone(), columns.clone(), columns.clone()];
            lower.forward_columns(forward.view_mut());
            lower.backward_columns(backward.view_mut());
            lower.solve_columns(solved.view_mut());
            for c in 0..3 {
                let mut x = columns.column(c).to_vec();
                lower.forward(&mut x, &mut NoCount);
                assert!(x.iter().zip(forward.column(c)).all(|(a, b)| (a - b).abs() < 1e-12), "{n}");
                lower.backward(&mut x);
                let mut y = columns.column(c).to_vec();
                lower.backward(&mut y);
                assert!(y.iter().zip(backward.column(c)).all(|(a, b)| (a - b).abs() < 1e-12), "{n}");
                assert!(x.iter().zip(solved.column(c)).all(|(a, b)| (a - b).abs() < 1e-12), "{n}");
            }
        }
    }

    #[test]
    fn a_solve_multiplies_once_for_each_number_and_adds_for_those_below_the_diagonal() {
        let (lower, mut tally) = (lower(9), Tally::default());
        lower.forward(&mut [1.0; 9], &mut tally);
        assert_eq!((tally.0.multiplications, tally.0.additions), (45, 36));
        assert_eq!(lower.bytes(), 45 * size_of::<f64>());
    }
}
