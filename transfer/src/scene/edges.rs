//! Edge functions of eight triangles at once, with a bound on what rounding does to them.
//!
//! With corners relative to the origin, an edge `(a, b)` of a triangle is the function `F(d) = (a × b)·d` of the direction.
//! It is computed as `p × (b − a)·d`, with `p` the nearer end of the edge: its error is then small beside `|p|∞·|b − a|∞`,
//! hence beside `F` itself a fraction of the edge's length away, also for small triangles far off.

use super::bvh::WIDTH;
use super::visibility_kernel::Lanes;

/// Bound on the rounding error of an edge function over `|p|∞·|b − a|∞`, and of its window coordinates: 2⁻¹⁷. The sum of all
/// steps in units of 2⁻²⁴ is below 110: cross product 18, product with the direction 30, the direction itself 12, the
/// division that turns a row into a column 48.
pub(crate) const ROUNDING: f32 = 1.0 / 131_072.0;

/// Added to each bound, so that it holds where products underflow: far above 2⁻¹⁴⁹, far below any square of a unit scene.
pub(crate) const UNDERFLOW: f32 = 1e-35;

/// `|x|∞` of eight vectors.
#[inline(always)]
pub(crate) fn largest<L: Lanes>(x: [L; 3]) -> L {
    x[0].abs().max(x[1].abs()).max(x[2].abs())
}

/// `a·b` of eight pairs.
#[inline(always)]
pub(crate) fn dot<L: Lanes>(a: [L; 3], b: [L; 3]) -> L {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// `a × b` of eight edges and the bound on its products with directions, see the head of the file.
#[inline(always)]
pub(crate) fn edge<L: Lanes>(a: [L; 3], b: [L; 3]) -> ([L; 3], L) {
    let along = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let (size_a, size_b) = (largest(a), largest(b));
    let a_nearer = size_b.gt(size_a);
    let mut p = a;
    for k in 0..3 {
        p[k] = a_nearer.select(a[k], b[k]);
    }
    let n = [p[1] * along[2] - p[2] * along[1], p[2] * along[0] - p[0] * along[2], p[0] * along[1] - p[1] * along[0]];
    (n, size_a.min(size_b) * largest(along) * L::splat(ROUNDING))
}

/// Per edge and lane, `F = constant + per_column·column + per_row·row`, known to within `bound`.
#[derive(Default)]
pub(crate) struct Edges {
    pub(crate) constant: [[f32; WIDTH]; 3],
    pub(crate) per_column: [[f32; WIDTH]; 3],
    pub(crate) per_row: [[f32; WIDTH]; 3],
    pub(crate) bound: [[f32; WIDTH]; 3],
}
