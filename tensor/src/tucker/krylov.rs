//! Leading eigenvectors of a large symmetric matrix G, none of whose eigenvalues is below 0, from products with it: block Krylov
//! iteration with Rayleigh-Ritz and a residual test (Golub, Luk and Overton 1981; Musco and Musco 2015).
//!
//! A basis of rows Q (d x n), orthonormal to working precision, grows by what G makes of its last block. The eigenpairs (θ, w) of
//! Q G Qᵀ give the best vectors w Q of its span. The block holds more vectors than are wanted where that number is known, so
//! that an eigenvalue repeated as often cannot hide.

use super::leading::{Leading, Want};
use super::unfold::{standard, times};
use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use prt_transfer::random::Random;
use prt_transfer::{Result, linalg};

/// Excess energy, of what is left over, at which the iteration ends.
const EXCESS: f64 = 1e-6;
/// The same, of all energy: rounding.
const ROUNDING: f64 = 1e-14;

/// G, n x n.
pub(super) struct Operator<'a> {
    pub(super) size: usize,
    /// Its trace: all energy.
    pub(super) energy: f64,
    /// G Q (n x k) for Q (n x k), or an error that ends the iteration.
    pub(super) apply: &'a dyn Fn(ArrayView2<f64>) -> Result<Array2<f64>>,
}

/// The vectors wanted (columns), from blocks of so many until the basis has `most` rows.
pub(super) fn leading(g: &Operator, want: Want, block: usize, most: usize, seed: u64) -> Result<Leading> {
    let mut random = Random(seed);
    let mut next = Array2::from_shape_simple_fn((g.size, block), || random.normal());
    let (mut q, mut images) = (Array2::zeros((0, g.size)), Array2::zeros((0, g.size)));
    let mut tested = 0;
    loop {
        let new = beyond(&q, next);
        next = (g.apply)(new.view())?;
        q = stacked(&q, &new);
        images = stacked(&images, &next);
        let last = q.nrows() + block > most;
        // What a test costs grows with Q: one every eighth of it.
        if last || 8 * q.nrows() >= 9 * tested {
            tested = q.nrows();
            let leading = ritz(&q, &images, want, g.energy)?;
            if last || leading.converged {
                return Ok(leading);
            }
        }
    }
}

/// Orthonormal columns, orthogonal to the rows of Q, that span those of `block` outside of Q. Done twice, after which what the
/// first pass left to rounding is gone (Giraud et al. 2005).
fn beyond(q: &Array2<f64>, mut block: Array2<f64>) -> Array2<f64> {
    for _ in 0..2 {
        let inside = times(q.view(), block.view());
        block -= &times(q.t(), inside.view());
        block = linalg::orthonormal_columns(block.view());
    }
    block
}

/// The best vectors of the span of Q, and whether they are good enough.
fn ritz(q: &Array2<f64>, images: &Array2<f64>, want: Want, energy: f64) -> Result<Leading> {
    let spectrum = linalg::eigen(times(images.view(), q.t()).view())?;
    let left = (energy - spectrum.values.iter().sum::<f64>()).max(0.0);
    let keep = Want { tail: want.tail - left, ..want }.keep(&spectrum.values);
    let w = spectrum.vectors.slice(s![..keep, ..]);
    let (vectors, images) = (times(w, q.view()), times(w, images.view()));
    let excess = excess(&vectors, &images, &spectrum.values);
    let rest = energy - spectrum.values[..keep].iter().sum::<f64>();
    let enough = left <= want.tail || !want.is_open();
    let converged = enough && (excess <= EXCESS * rest || excess <= ROUNDING * energy);
    Ok(Leading { vectors: standard(linalg::orthonormal_columns(vectors.t()).view()), converged })
}

/// By how much the energy of the first vectors v can be short of the best: θ is short of an eigenvalue by ρ = ‖G v - θ v‖ at most,
/// and by ρ²/(θ - t) where the next value t is further below (Parlett 1980, §11.7).
fn excess(vectors: &Array2<f64>, images: &Array2<f64>, values: &[f64]) -> f64 {
    let next = values.get(vectors.nrows()).copied().unwrap_or(0.0);
    let short = |i: usize| {
        let difference = &images.row(i) - &(&vectors.row(i) * values[i]);
        let (residual, gap) = (difference.dot(&difference).sqrt(), values[i] - next);
        if gap > residual { residual * residual / gap } else { residual }
    };
    (0..vectors.nrows()).map(short).sum()
}

/// Rows, and columns as rows below.
fn stacked(rows: &Array2<f64>, columns: &Array2<f64>) -> Array2<f64> {
    concatenate(Axis(0), &[rows.view(), columns.t()]).map(|all| standard(all.view())).expect("rows of one length")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vᵀ diag(values) V and V, orthonormal rows.
    fn symmetric(values: &[f64]) -> (Array2<f64>, Array2<f64>) {
        let (n, mut random) = (values.len(), Random(3));
        let v = linalg::orthonormal_columns(Array2::from_shape_simple_fn((n, n), || random.normal()).view());
        let scaled = Array2::from_shape_fn((n, n), |(i, j)| values[i] * v[[i, j]]);
        (times(v.t(), scaled.view()), v)
    }

    fn run(values: &[f64], want: Want, block: usize, most: usize) -> (Leading, f64) {
        let (g, v) = symmetric(values);
        let apply = |q: ArrayView2<f64>| Ok(times(g.view(), q));
        let operator = Operator { size: values.len(), energy: values.iter().sum(), apply: &apply };
        let leading = leading(&operator, want, block, most, 1).unwrap();
        let eye = Array2::<f64>::eye(leading.vectors.ncols());
        assert!((leading.vectors.t().dot(&leading.vectors) - eye).iter().all(|d| d.abs() <= 1e-13));
        let held = times(v.view(), leading.vectors.view());
        let energy = held.indexed_iter().map(|((i, _), h)| values[i] * h * h).sum();
        (leading, energy)
    }

    #[test]
    fn energy_is_that_of_the_leading_eigenvectors_however_often_they_repeat() {
        let decay: Vec<f64> = (0..120).map(|i| 0.8f64.powi(i)).collect();
        let repeated: Vec<f64> = (0..120).map(|i| if i < 6 { 2.0 } else { 1.0 / f64::from(i + 1) }).collect();
        let few: Vec<f64> = (0..120).map(|i| if i < 4 { 1.0 + f64::from(i) } else { 0.0 }).rev().collect();
        for mut values in [decay, repeated, few, vec![1.0; 120]] {
            let (leading, energy) = run(&values, Want { rank: 6, tail: 1e-9 }, 10, 60);
            values.sort_by(|a, b| b.total_cmp(a));
            let (best, all): (f64, f64) = (values[..6].iter().sum(), values.iter().sum());
            assert!(leading.converged && best - energy <= 1e-6 * (all - best) + 1e-12, "{energy} of {best}");
            assert_eq!(leading.vectors.ncols(), values.iter().take(6).filter(|v| **v > 1e-9).count());
        }
    }

    #[test]
    fn a_tail_is_kept_and_one_that_asks_for_too_much_is_reported() {
        let values: Vec<f64> = (0..120).map(|i| 0.8f64.powi(i)).collect();
        let all: f64 = values.iter().sum();
        for tail in [1.0, 0.1, 1e-3] {
            let (leading, energy) = run(&values, Want { rank: usize::MAX, tail }, 8, 100);
            let keep = (1..).find(|keep| values[*keep..].iter().sum::<f64>() <= tail).unwrap();
            assert!(leading.converged && all - energy <= tail + 1e-12 && leading.vectors.ncols() == keep, "{tail}");
        }
        assert!(!run(&values, Want { rank: usize::MAX, tail: 1e-6 }, 8, 30).0.converged);
        assert!(!run(&[1.0; 40], Want { rank: usize::MAX, tail: 1.0 }, 8, 30).0.converged);
    }
}
