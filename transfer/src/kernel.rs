//! The loops that relighting spends its time in.
//!
//! A codec whose rows can be multiplied one by one implements [`RowKernel`]; [`apply`] then packs the light, spreads rows over
//! rayon's current pool and takes care of channels, and [`count`] runs the same products with a tally.

use crate::error::Result;
use crate::flops::{Count, Flops, NoCount, Tally};
use crate::matrix::{Shape, check_apply};
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use rayon::prelude::*;

/// A matrix whose products with a light are independent row by row.
pub trait RowKernel: Sync {
    /// The product of one row with `N` packed channels (`x[k]` = the channels of light coefficient k), telling `count` of
    /// the operations that one channel takes. `x.len()` = lights has been checked.
    fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], count: &mut C) -> [f32; N];
}

/// Rows given to a thread at a time: enough to hide the cost of handing them out, few enough to balance uneven rows.
const ROWS_PER_TASK: usize = 512;

/// `out` (rows x channels) = kernel · `lights` (lights x channels), after checking sizes.
pub fn apply<K: RowKernel>(
    kernel: &K,
    shape: Shape,
    lights: ArrayView2<f32>,
    mut out: ArrayViewMut2<f32>,
) -> Result<()> {
    check_apply(shape, &lights, &out)?;
    let channels = lights.ncols();
    let mut first = 0;
    while first < channels {
        // Three channels travel as four: one vector register, the last lane idle.
        let width = if channels - first == 1 { 1 } else { (channels - first).min(4) };
        let lights = lights.slice(s![.., first..first + width]);
        let out = out.slice_mut(s![.., first..first + width]);
        if width == 1 {
            apply_packed::<1, K>(kernel, lights, out)
        } else {
            apply_packed::<4, K>(kernel, lights, out)
        }
        first += width;
    }
    Ok(())
}

fn apply_packed<const N: usize, K: RowKernel>(kernel: &K, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
    let packed: Vec<[f32; N]> = lights
        .outer_iter()
        .map(|coefficient| {
            let mut x = [0.0; N];
            x.iter_mut().zip(coefficient).for_each(|(x, &c)| *x = c);
            x
        })
        .collect();
    out.axis_chunks_iter_mut(Axis(0), ROWS_PER_TASK).into_par_iter().enumerate().for_each(|(task, mut rows)| {
        for (i, mut y) in rows.outer_iter_mut().enumerate() {
            let product = kernel.product(task * ROWS_PER_TASK + i, &packed, &mut NoCount);
            y.iter_mut().zip(product).for_each(|(y, p)| *y = p);
        }
    });
}

/// Operations of one relighting with one channel, told by the products themselves.
pub fn count<K: RowKernel>(kernel: &K, shape: Shape, light: &[f32]) -> Flops {
    let packed: Vec<[f32; 1]> = light.iter().map(|&x| [x]).collect();
    let mut tally = Tally::default();
    for row in 0..shape.rows() {
        kernel.product(row, &packed, &mut tally);
    }
    tally.0
}

/// A stored column index.
pub trait Column: Copy + Send + Sync {
    /// As an index.
    fn at(self) -> usize;
}

impl Column for u8 {
    #[inline(always)]
    fn at(self) -> usize {
        self.into()
    }
}

impl Column for u16 {
    #[inline(always)]
    fn at(self) -> usize {
        self.into()
    }
}

impl Column for u32 {
    #[inline(always)]
    fn at(self) -> usize {
        self as usize
    }
}

/// Σ value · x\[column\] over one sparse row.
///
/// # Safety
/// Every column must be below `x.len()`.
#[inline]
pub unsafe fn sparse_dot<const N: usize, I: Column>(columns: &[I], values: &[f32], x: &[[f32; N]]) -> [f32; N] {
    // Four sums, since one would make every addition wait for the one before.
    let mut sums = [[0f32; N]; 4];
    let quads = columns.len() / 4 * 4;
    let step = |sum: &mut [f32; N], i: usize| {
        // SAFETY: i < columns.len() = values.len(), and the caller promises the column.
        let (value, x) = unsafe { (*values.get_unchecked(i), x.get_unchecked(columns.get_unchecked(i).at())) };
        sum.iter_mut().zip(x).for_each(|(s, x)| *s += value * x);
    };
    debug_assert_eq!(columns.len(), values.len());
    for i in (0..quads).step_by(4) {
        sums.iter_mut().enumerate().for_each(|(lane, sum)| step(sum, i + lane));
    }
    for i in quads..columns.len() {
        step(&mut sums[0], i);
    }
    std::array::from_fn(|c| (sums[0][c] + sums[1][c]) + (sums[2][c] + sums[3][c]))
}
