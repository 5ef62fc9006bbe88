//! The two-dimensional Haar transform of one square face: the kernel.
//!
//! Non-standard construction: one level splits every 2x2 block of the face into a mean and three differences, and the next
//! level does the same to the face of means. With the block's texels `a b` above `c d`, the orthonormal step is
//!
//! ```text
//! mean       (a + b + c + d) / 2      becomes a texel of the next, half as wide, face
//! horizontal (a - b + c - d) / 2      left minus right
//! vertical   (a + b - c - d) / 2      upper minus lower
//! diagonal   (a - b - c + d) / 2
//! ```
//!
//! Order of the `resolution²` coefficients, coarse to fine: coefficient 0 is the face's mean (times its resolution); the level
//! whose differences form an n x n grid (n = 1, 2, 4, …, resolution/2) has its horizontal ones at `n²..2n²`, the vertical ones
//! at `2n²..3n²` and the diagonal ones at `3n²..4n²`, each grid in rows from the top. The first n² coefficients are
//! thus, for every n, the transform of the face averaged down to n x n.

use prt_transfer::Count;

/// Texels along the edge of the support of coefficient `index` on a face of this resolution.
pub(crate) fn support_edge(resolution: usize, index: usize) -> usize {
    // The level of n x n grids is n²..4n²; coefficient 0 spans the face like those of n = 1.
    resolution >> (index.max(1).ilog2() / 2)
}

/// Numbers that [`forward`] and [`inverse`] need as scratch.
pub(crate) fn scratch(resolution: usize) -> usize {
    // Means travel between two buffers, each as large as those of the finest level.
    2 * (resolution / 2).pow(2)
}

/// `out` = coefficients of `face`, both `resolution²` long, the resolution a power of two.
pub(crate) fn forward<C: Count>(face: &[f32], out: &mut [f32], resolution: usize, scratch: &mut [f32], count: &mut C) {
    if resolution == 1 {
        return out.copy_from_slice(face);
    }
    // The differences of each level are in place at once; only the means travel.
    let mut n = resolution / 2;
    let (mut means, mut next) = scratch.split_at_mut(n * n);
    split(face, n, &mut means[..n * n], &mut out[n * n..4 * n * n], count);
    while n > 1 {
        n /= 2;
        split(&means[..4 * n * n], n, &mut next[..n * n], &mut out[n * n..4 * n * n], count);
        (means, next) = (next, means);
    }
    out[0] = means[0];
}

/// `face` = texels of the coefficients `from`, both `resolution²` long: [`forward`] backward.
pub(crate) fn inverse(from: &[f32], face: &mut [f32], resolution: usize, scratch: &mut [f32]) {
    if resolution == 1 {
        return face.copy_from_slice(from);
    }
    let half = resolution / 2;
    let (mut means, mut next) = scratch.split_at_mut(half * half);
    means[0] = from[0];
    let mut n = 1;
    while n < half {
        join(&means[..n * n], &from[n * n..4 * n * n], n, &mut next[..4 * n * n]);
        (means, next) = (next, means);
        n *= 2;
    }
    join(&means[..n * n], &from[n * n..4 * n * n], n, face);
}

/// One level down: `from` (2n x 2n) into `means` (n x n) and `details` (three grids of n x n).
#[inline]
fn split<C: Count>(from: &[f32], n: usize, means: &mut [f32], details: &mut [f32], count: &mut C) {
    let (horizontal, rest) = details.split_at_mut(n * n);
    let (vertical, diagonal) = rest.split_at_mut(n * n);
    let grids = means.chunks_exact_mut(n).zip(horizontal.chunks_exact_mut(n));
    let grids = grids.zip(vertical.chunks_exact_mut(n).zip(diagonal.chunks_exact_mut(n)));
    for (rows, ((m, h), (v, d))) in from.chunks_exact(4 * n).zip(grids) {
        let (upper, lower) = rows.split_at(2 * n);
        split_row(upper.as_chunks().0, lower.as_chunks().0, m, h, v, d);
    }
    count.multiply(4 * n * n);
    count.add(8 * n * n);
}

/// A row of 2x2 blocks. Slices of one known length let the compiler fill vector registers.
#[inline]
fn split_row(upper: &[[f32; 2]], lower: &[[f32; 2]], m: &mut [f32], h: &mut [f32], v: &mut [f32], d: &mut [f32]) {
    let n = upper.len();
    let (lower, m, h, v, d) = (&lower[..n], &mut m[..n], &mut h[..n], &mut v[..n], &mut d[..n]);
    for j in 0..n {
        let ([a, b], [c, e]) = (upper[j], lower[j]);
        let (upper_sum, upper_difference) = (a + b, a - b);
        let (lower_sum, lower_difference) = (c + e, c - e);
        m[j] = 0.5 * (upper_sum + lower_sum);
        h[j] = 0.5 * (upper_difference + lower_difference);
        v[j] = 0.5 * (upper_sum - lower_sum);
        d[j] = 0.5 * (upper_difference - lower_difference);
    }
}

/// One level up: `means` (n x n) and `details` (three grids of n x n) into `to` (2n x 2n).
#[inline]
fn join(means: &[f32], details: &[f32], n: usize, to: &mut [f32]) {
    let (horizontal, rest) = details.split_at(n * n);
    let (vertical, diagonal) = rest.split_at(n * n);
    let grids = means.chunks_exact(n).zip(horizontal.chunks_exact(n));
    let grids = grids.zip(vertical.chunks_exact(n).zip(diagonal.chunks_exact(n)));
    for (rows, ((m, h), (v, d))) in to.chunks_exact_mut(4 * n).zip(grids) {
        let (upper, lower) = rows.split_at_mut(2 * n);
        join_row(m, h, v, d, upper.as_chunks_mut().0, lower.as_chunks_mut().0);
    }
}

#[inline]
fn join_row(m: &[f32], h: &[f32], v: &[f32], d: &[f32], upper: &mut [[f32; 2]], lower: &mut [[f32; 2]]) {
    let n = m.len();
    let (h, v, d, upper, lower) = (&h[..n], &v[..n], &d[..n], &mut upper[..n], &mut lower[..n]);
    for j in 0..n {
        let (left, right) = (m[j] + h[j], m[j] - h[j]);
        let (left_difference, right_difference) = (v[j] + d[j], v[j] - d[j]);
        upper[j] = [0.5 * (left + left_difference), 0.5 * (right + right_difference)];
        lower[j] = [0.5 * (left - left_difference), 0.5 * (right - right_difference)];
    }
}
