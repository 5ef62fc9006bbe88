//! The innermost work of clustering: how far a point lies from an affine subspace.

use pulp::{Arch, Simd, WithSimd};

/// Squares of the distance from a mean and of its parts along vectors, in single precision.
pub(crate) struct Parts {
    /// `|x - mean|²`
    pub(crate) square: f32,
    /// `Σ_j ((x - mean) · v_j)²`
    pub(crate) explained: f32,
}

/// Vectors that are multiplied with a residual at once.
const TOGETHER: usize = 4;

/// The processor's vectors, chosen when the program runs.
#[derive(Clone, Copy)]
pub(crate) struct Residual(Arch);

impl Residual {
    pub(crate) fn new() -> Residual {
        Residual(Arch::new())
    }

    /// `|x - mean|²` and its part along `vectors` (rows of x.len()). `scratch` is overwritten.
    pub(crate) fn parts(&self, x: &[f32], mean: &[f32], vectors: &[f32], scratch: &mut Vec<f32>) -> Parts {
        scratch.resize(x.len(), 0.0);
        self.0.dispatch(Work { x, mean, vectors, scratch })
    }

    /// How much [`Parts::square`] - [`Parts::explained`] may be off, as a part of `square`: sums of `dimension` products in
    /// `LANES` strands, each product with a relative error of 2⁻²⁴ as each sum, for unit vectors that are orthogonal to 1e-6.
    pub(crate) fn uncertainty(dimension: usize, vectors: usize) -> f32 {
        let strand = (dimension / LEAST_LANES + LEAST_LANES + 2) as f32 * f32::EPSILON;
        (strand + 1e-6) * (1.0 + 2.0 * (vectors as f32).sqrt())
    }
}

/// Strands that any processor sums in.
const LEAST_LANES: usize = 4;

struct Work<'a> {
    x: &'a [f32],
    mean: &'a [f32],
    vectors: &'a [f32],
    scratch: &'a mut [f32],
}

impl WithSimd for Work<'_> {
    type Output = Parts;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Parts {
        let n = self.x.len();
        let square = subtract(simd, self.x, &self.mean[..n], self.scratch);
        let mut explained = 0.0;
        let mut groups = self.vectors.chunks_exact(TOGETHER * n.max(1));
        for group in groups.by_ref() {
            explained += products::<S, TOGETHER>(simd, self.scratch, group).iter().map(|a| a * a).sum::<f32>();
        }
        for vector in groups.remainder().chunks_exact(n.max(1)) {
            let [a] = products::<S, 1>(simd, self.scratch, vector);
            explained += a * a;
        }
        Parts { square, explained }
    }
}

/// `out` = `x` - `mean`, and its square.
#[inline(always)]
fn subtract<S: Simd>(simd: S, x: &[f32], mean: &[f32], out: &mut [f32]) -> f32 {
    let ((x, x_rest), (mean, mean_rest)) = (S::as_simd_f32s(x), S::as_simd_f32s(mean));
    let (out, out_rest) = S::as_mut_simd_f32s(out);
    let mut sum = simd.splat_f32s(0.0);
    for ((x, mean), out) in x.iter().zip(mean).zip(out) {
        *out = simd.sub_f32s(*x, *mean);
        sum = simd.mul_add_e_f32s(*out, *out, sum);
    }
    let mut square = simd.reduce_sum_f32s(sum);
    for ((x, mean), out) in x_rest.iter().zip(mean_rest).zip(out_rest) {
        *out = x - mean;
        square += *out * *out;
    }
    square
}

/// `r` times each of `V` vectors.
#[inline(always)]
fn products<S: Simd, const V: usize>(simd: S, r: &[f32], vectors: &[f32]) -> [f32; V] {
    let n = r.len();
    let (r, r_rest) = S::as_simd_f32s(r);
    let split: [_; V] = std::array::from_fn(|j| S::as_simd_f32s(&vectors[j * n..][..n]));
    let mut sums = [simd.splat_f32s(0.0); V];
    for (i, r) in r.iter().enumerate() {
        for (sum, (vector, _)) in sums.iter_mut().zip(&split) {
            *sum = simd.mul_add_e_f32s(*r, vector[i], *sum);
        }
    }
    std::array::from_fn(|j| {
        let rest = r_rest.iter().zip(split[j].1).map(|(a, b)| a * b).sum::<f32>();
        simd.reduce_sum_f32s(sums[j]) + rest
    })
}

/// `|r - Σ_j (r · v_j) v_j|²` with r = x - mean, residual by residual in double precision: no cancellation.
pub(crate) fn explicit(x: &[f32], mean: &[f32], vectors: &[f32]) -> f64 {
    Arch::new().dispatch(Deflated { x, mean, vectors })
}

struct Deflated<'a> {
    x: &'a [f32],
    mean: &'a [f32],
    vectors: &'a [f32],
}

impl WithSimd for Deflated<'_> {
    type Output = f64;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        deflated(self.x, self.mean, self.vectors)
    }
}

#[inline(always)]
fn deflated(x: &[f32], mean: &[f32], vectors: &[f32]) -> f64 {
    let n = x.len();
    let mut r = vec![0f64; n];
    for ((r, x), m) in r.iter_mut().zip(x).zip(mean) {
        *r = f64::from(*x) - f64::from(*m);
    }
    for vector in vectors.chunks_exact(n.max(1)) {
        let a = summed(&r, |i| r[i] * f64::from(vector[i]));
        for (r, v) in r.iter_mut().zip(vector) {
            *r -= a * f64::from(*v);
        }
    }
    summed(&r, |i| r[i] * r[i])
}

/// The sum of a term for each place in `of`, in strands that become vectors.
#[inline(always)]
fn summed(of: &[f64], term: impl Fn(usize) -> f64) -> f64 {
    const STRANDS: usize = 8;
    let mut sums = [0f64; STRANDS];
    let whole = of.len() / STRANDS * STRANDS;
    for first in (0..whole).step_by(STRANDS) {
        for (strand, sum) in sums.iter_mut().enumerate() {
            *sum += term(first + strand);
        }
    }
    sums.iter().sum::<f64>() + (whole..of.len()).map(term).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use prt_transfer::linalg;
    use prt_transfer::random::Random;

    #[test]
    fn parts_are_the_sums_within_the_uncertainty_that_is_told() {
        let (mut random, mut scratch) = (Random(2), Vec::new());
        for n in [1, 2, 7, 16, 33, 100, 1001] {
            for k in [0, 1, 3, 4, 5, 8, 9, 12, 19].into_iter().filter(|k| *k <= n) {
                let v = linalg::orthonormal_columns(Array2::from_shape_simple_fn((n, k), || random.normal()).view());
                let vectors: Vec<f32> = v.t().iter().map(|v| *v as f32).collect();
                let mut draw = |size: f64| (0..n).map(|_| (size * random.normal()) as f32).collect::<Vec<f32>>();
                let (x, mean) = (draw(1.0), draw(3.0));
                let r: Vec<f64> = x.iter().zip(&mean).map(|(x, m)| f64::from(*x) - f64::from(*m)).collect();
                let square: f64 = r.iter().map(|r| r * r).sum();
                let along = |vector: &[f32]| vector.iter().zip(&r).map(|(v, r)| f64::from(*v) * r).sum::<f64>();
                let explained: f64 = vectors.chunks(n).map(|vector| along(vector).powi(2)).sum();

                let parts = Residual::new().parts(&x, &mean, &vectors, &mut scratch);
                let tolerance = f64::from(Residual::uncertainty(n, k)) * square;
                assert!((f64::from(parts.square) - square).abs() <= tolerance, "{n}, {k}: {} {square}", parts.square);
                assert!((f64::from(parts.explained) - explained).abs() <= tolerance, "{n}, {k}: {}", parts.explained);
                let left = explicit(&x, &mean, &vectors);
                assert!((left - (square - explained)).abs() <= 1e-6 * square, "{n}, {k}: {left}");
                assert!((f64::from(parts.square - parts.explained) - left).abs() <= tolerance, "{n}, {k}: {left}");
            }
        }
    }

    #[test]
    fn the_uncertainty_is_that_of_sums_in_four_strands() {
        for (n, k) in [(1, 0), (16, 4), (6144, 64)] {
            // Half an epsilon for each product and each sum, of the square and, twice, of the products with k vectors.
            let strand = (n / 4 + 6) as f64 * 2f64.powi(-23) + 1e-6;
            let expected = strand * (1.0 + 2.0 * f64::from(k).sqrt());
            let told = f64::from(Residual::uncertainty(n, k as usize));
            assert!((told - expected).abs() <= 1e-6 * expected, "{told} {expected}");
        }
    }
}
