//! Each cluster's subspace from its members, from sweep to sweep.
//!
//! A sweep need not know the best subspace, only a better one than before: steps of subspace iteration from the old components
//! never lose energy of the members, so that every sweep lowers the error. The components that are stored in the end are computed anew
//! ([`crate::solver`]).

use crate::subspaces::{Subspace, Subspaces};
use ndarray::{Array2, ArrayView2, s};
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Result, linalg};
use rayon::prelude::*;

/// Up to so many dimensions, of the space or of the members, all eigenpairs of the Gram matrix are computed.
const SMALL: usize = 48;
/// Vectors that are iterated beside those that are wanted, so that these converge.
const SPARE: usize = 4;

/// The mean of samples, in double precision.
pub(crate) fn mean(samples: &Samples, group: &[u32]) -> Vec<f64> {
    let mut sum = vec![0f64; samples.dimension()];
    pulp::Arch::new().dispatch(Sum { samples, group, sum: &mut sum });
    let count = group.len().max(1) as f64;
    sum.iter_mut().for_each(|s| *s /= count);
    sum
}

struct Sum<'a> {
    samples: &'a Samples<'a>,
    group: &'a [u32],
    sum: &'a mut [f64],
}

impl pulp::WithSimd for Sum<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for &sample in self.group {
            for (sum, x) in self.sum.iter_mut().zip(self.samples.row(sample as usize)) {
                *sum += f64::from(*x);
            }
        }
    }
}

/// Subspaces of `components` each around the means of their members. A cluster whose members are those of `before`, with as
/// many components, stays as it is, and so does an empty one.
pub(crate) fn refit(
    samples: &Samples,
    groups: &Groups,
    changed: &[bool],
    components: &[usize],
    before: &Subspaces,
) -> Result<Subspaces> {
    let fit = |cluster: usize| {
        let group = groups.of_cluster(cluster);
        let same =
            !changed[cluster] && before.components(cluster) == components[cluster].min(group.len().saturating_sub(1));
        if group.is_empty() || same {
            return Ok(before.of(cluster).clone());
        }
        fit(samples, group, components[cluster], &before.of(cluster).components)
    };
    let subspaces = (0..groups.len()).into_par_iter().map(fit).collect::<Result<_>>()?;
    Ok(Subspaces::new(samples.dimension(), subspaces))
}

/// A subspace of so many components, or as many as the members span, around their mean.
pub(crate) fn fit(samples: &Samples, group: &[u32], components: usize, guess: &[f32]) -> Result<Subspace> {
    let mean: Vec<f32> = mean(samples, group).iter().map(|m| *m as f32).collect();
    let wanted = components.min(group.len().saturating_sub(1));
    if wanted == 0 {
        return Ok(Subspace { mean, components: Vec::new() });
    }
    let rows = centred(samples, group, &mean);
    Ok(Subspace { components: leading(&rows, wanted, guess)?, mean })
}

/// Samples less a mean, a row each.
pub(crate) fn centred(samples: &Samples, group: &[u32], mean: &[f32]) -> Array2<f32> {
    let mut rows = Vec::with_capacity(group.len() * mean.len());
    for &sample in group {
        rows.extend(samples.row(sample as usize).iter().zip(mean).map(|(x, m)| x - m));
    }
    Array2::from_shape_vec((group.len(), mean.len()), rows).expect("a row for each member")
}

/// Leading directions of `rows`, the better the nearer `guess` was.
fn leading(rows: &Array2<f32>, wanted: usize, guess: &[f32]) -> Result<Vec<f32>> {
    let (m, n) = rows.dim();
    if m.min(n) <= SMALL.max(2 * wanted) {
        return exact(rows, wanted);
    }
    let known = guess.len() / n;
    let size = (wanted + SPARE).min(m);
    let mut basis = Array2::<f64>::zeros((size, n));
    basis.iter_mut().zip(guess).for_each(|(b, g)| *b = f64::from(*g));
    // Members far apart from each other in their order stand in for what is not known.
    for (i, mut row) in basis.outer_iter_mut().enumerate().skip(known.min(size)) {
        row.assign(&rows.row((i - known) * m / (size - known.min(size - 1))).mapv(f64::from));
    }
    let mut basis = orthonormal(basis.view())?;
    for _ in 0..if known < wanted { 3 } else { 1 } {
        basis = step(rows, &basis)?;
    }
    ritz(rows, &basis, wanted)
}

/// The span of F V Fᵀ for the span of V.
fn step(rows: &Array2<f32>, basis: &Array2<f32>) -> Result<Array2<f32>> {
    let products = times_transposed(rows, basis).t().as_standard_layout().into_owned();
    let mut next = Array2::zeros(basis.dim());
    linalg::times_single(products.view(), rows.view(), next.view_mut());
    orthonormal(next.mapv(f64::from).view())
}

/// The directions of most energy within a span.
fn ritz(rows: &Array2<f32>, basis: &Array2<f32>, wanted: usize) -> Result<Vec<f32>> {
    let products = times_transposed(rows, basis).mapv(f64::from);
    let mut gram = Array2::zeros((basis.nrows(), basis.nrows()));
    linalg::add_gram(products.view(), gram.view_mut());
    let spectrum = linalg::eigen(gram.view())?;
    let count = rank(&spectrum.values, wanted);
    let mut turned = Array2::zeros((count, basis.ncols()));
    linalg::times(spectrum.vectors.slice(s![..count, ..]), basis.mapv(f64::from).view(), turned.view_mut());
    Ok(turned.iter().map(|v| *v as f32).collect())
}

fn times_transposed(rows: &Array2<f32>, basis: &Array2<f32>) -> Array2<f32> {
    let mut products = Array2::zeros((rows.nrows(), basis.nrows()));
    linalg::times_transposed(rows.view(), basis.view(), products.view_mut());
    products
}

/// An orthonormal basis of the span of rows.
fn orthonormal(rows: ArrayView2<f64>) -> Result<Array2<f32>> {
    let mut gram = Array2::zeros((rows.nrows(), rows.nrows()));
    linalg::times_transposed_f64(rows, rows, gram.view_mut());
    let spectrum = linalg::eigen(gram.view())?;
    Ok(from_gram(spectrum, rows, rows.nrows()).mapv(|v| v as f32))
}

fn exact(rows: &Array2<f32>, wanted: usize) -> Result<Vec<f32>> {
    let (m, n) = rows.dim();
    let rows = rows.mapv(f64::from);
    if n <= m {
        let mut gram = Array2::zeros((n, n));
        linalg::add_gram(rows.view(), gram.view_mut());
        let spectrum = linalg::eigen(gram.view())?;
        let count = rank(&spectrum.values, wanted);
        return Ok(spectrum.vectors.slice(s![..count, ..]).iter().map(|v| *v as f32).collect());
    }
    let mut gram = Array2::zeros((m, m));
    linalg::times_transposed_f64(rows.view(), rows.view(), gram.view_mut());
    Ok(from_gram(linalg::eigen(gram.view())?, rows.view(), wanted).iter().map(|v| *v as f32).collect())
}

/// Right singular vectors of rows from the eigenpairs of their Gram matrix: `V = D⁻¹ Uᵀ F` (paper §4.1, in the order that holds).
fn from_gram(spectrum: linalg::Spectrum, rows: ArrayView2<f64>, wanted: usize) -> Array2<f64> {
    let count = rank(&spectrum.values, wanted);
    let mut vectors = Array2::zeros((count, rows.ncols()));
    linalg::times(spectrum.vectors.slice(s![..count, ..]), rows, vectors.view_mut());
    for (mut row, value) in vectors.outer_iter_mut().zip(&spectrum.values) {
        row /= value.sqrt();
    }
    vectors
}

/// How many of the leading eigenvalues are more than rounding.
fn rank(values: &[f64], most: usize) -> usize {
    let floor = values.first().map_or(0.0, |v| v.max(0.0)) * 1e-12;
    values.iter().take(most).take_while(|v| **v > floor).count()
}
