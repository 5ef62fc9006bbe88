//! The loops that relighting spends its time in.
//!
//! A codec whose rows can be multiplied one by one implements [`RowKernel`]; [`apply`] then packs the light, spreads rows over
//! rayon's current pool and takes care of channels, and [`count`] runs the same products with a tally. Sparse rows have a
//! vector kernel for whole blocks of rows, [`sparse_rows`]; dense matrices have their own [`dense`](mod@dense) loop.

mod column;
pub mod dense;
mod intervals;
mod sparse;
mod stored;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use column::Column;
pub(crate) use intervals::interval_sums;
pub(crate) use sparse::{dot, rows_of};
pub use sparse::{sparse_dot, sparse_rows};
pub(crate) use stored::{Dictionary, Half, Integer, Plain, Stored};

use crate::error::Result;
use crate::flops::{Count, Flops, NoCount, Tally};
use crate::matrix::{Shape, check_apply};
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use rayon::prelude::*;

/// Rows that a kernel multiplies in one call, at most.
pub const BLOCK_ROWS: usize = 64;

/// Rows given to a thread at a time, a multiple of [`BLOCK_ROWS`]: enough to hide the cost of handing them out, few enough
/// to balance uneven rows.
const ROWS_PER_TASK: usize = 8 * BLOCK_ROWS;

/// A matrix whose products with a light are independent row by row.
pub trait RowKernel: Sync {
    /// The product of one row with `N` packed channels (`x[k]` = the channels of light coefficient k), telling `count` of
    /// the operations that one channel takes. `x.len()` = lights has been checked.
    fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], count: &mut C) -> [f32; N];

    /// The products of rows `first..first + out.len()` with a finite light. `first` is a multiple of [`BLOCK_ROWS`], which
    /// `out.len()` does not exceed. A kernel overrides it where many rows together are faster than one after the other.
    fn block<const N: usize>(&self, first: usize, x: &[[f32; N]], out: &mut [[f32; N]]) {
        each_row(self, first, x, out);
    }
}

/// [`RowKernel::block`], row by row.
pub(crate) fn each_row<const N: usize, K: RowKernel + ?Sized>(
    kernel: &K,
    first: usize,
    x: &[[f32; N]],
    out: &mut [[f32; N]],
) {
    out.iter_mut().enumerate().for_each(|(i, y)| *y = kernel.product(first + i, x, &mut NoCount));
}

/// `out` (rows x channels) = kernel · `lights` (lights x channels), after checking sizes.
pub fn apply<K: RowKernel>(kernel: &K, shape: Shape, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
    check_apply(shape, &lights, &out)?;
    by_channels(lights, out, |lights, out| match lights.ncols() {
        1 => apply_packed::<1, K>(kernel, lights, out),
        // Three channels travel as four: one vector register, the last lane idle.
        _ => apply_packed::<4, K>(kernel, lights, out),
    });
    Ok(())
}

/// Hands over channels in groups of at most four.
pub(crate) fn by_channels(
    lights: ArrayView2<f32>,
    mut out: ArrayViewMut2<f32>,
    mut group: impl FnMut(ArrayView2<f32>, ArrayViewMut2<f32>),
) {
    let channels = lights.ncols();
    for first in (0..channels).step_by(4) {
        let end = channels.min(first + 4);
        group(lights.slice(s![.., first..end]), out.slice_mut(s![.., first..end]));
    }
}

fn apply_packed<const N: usize, K: RowKernel>(kernel: &K, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) {
    let packed = pack::<N>(lights);
    // Vector kernels multiply lanes that they do not want by 0, which an infinite coefficient would turn into a NaN.
    let finite = all_finite(&packed);
    by_blocks(out, |first, products| match finite {
        true => kernel.block(first, &packed, products),
        false => each_row(kernel, first, &packed, products),
    });
}

/// Whether every coefficient is a number.
pub(crate) fn all_finite<const N: usize>(packed: &[[f32; N]]) -> bool {
    packed.as_flattened().iter().all(|x| x.is_finite())
}

/// Fills the output in blocks of at most [`BLOCK_ROWS`] rows, each from a multiple of it: `products(first, out)` gives the first
/// rows' products.
pub(crate) fn by_blocks<const N: usize>(mut out: ArrayViewMut2<f32>, products: impl Fn(usize, &mut [[f32; N]]) + Sync) {
    out.axis_chunks_iter_mut(Axis(0), ROWS_PER_TASK).into_par_iter().enumerate().for_each(|(task, mut rows)| {
        let mut lanes = [[0.0; N]; BLOCK_ROWS];
        for (block, rows) in rows.axis_chunks_iter_mut(Axis(0), BLOCK_ROWS).enumerate() {
            let lanes = &mut lanes[..rows.nrows()];
            products(task * ROWS_PER_TASK + block * BLOCK_ROWS, lanes);
            store(lanes, rows);
        }
    });
}

/// The channels of each light coefficient side by side, up to `N` = 1 or 4 of them; further lanes are 0.
pub fn pack<const N: usize>(lights: ArrayView2<f32>) -> Vec<[f32; N]> {
    let mut packed = vec![[0f32; N]; lights.nrows()];
    let lights = lights.as_standard_layout();
    let coefficients = lights.as_slice().expect("standard layout");
    match lights.ncols() {
        1 => copy_lanes(coefficients.as_chunks::<1>().0, &mut packed),
        2 => copy_lanes(coefficients.as_chunks::<2>().0, &mut packed),
        3 => copy_lanes(coefficients.as_chunks::<3>().0, &mut packed),
        _ => copy_lanes(coefficients.as_chunks::<4>().0, &mut packed),
    }
    packed
}

/// Copies the first channels of `products` to the rows of the output.
fn store<const N: usize>(products: &[[f32; N]], mut rows: ArrayViewMut2<f32>) {
    let width = rows.ncols();
    match (rows.as_slice_mut(), width) {
        (Some(slice), 1) => copy_lanes(products, slice.as_chunks_mut::<1>().0),
        (Some(slice), 2) => copy_lanes(products, slice.as_chunks_mut::<2>().0),
        (Some(slice), 3) => copy_lanes(products, slice.as_chunks_mut::<3>().0),
        (Some(slice), 4) => copy_lanes(products, slice.as_chunks_mut::<4>().0),
        _ => rows.outer_iter_mut().zip(products).for_each(|(mut row, p)| {
            row.iter_mut().zip(p).for_each(|(y, p)| *y = *p);
        }),
    }
}

/// Copies the lanes that both sides have. Their numbers are constants, since a copy of a length known only at run time is a
/// call, which for a few floats costs more than their arithmetic.
fn copy_lanes<const A: usize, const B: usize>(from: &[[f32; A]], to: &mut [[f32; B]]) {
    for (to, from) in to.iter_mut().zip(from) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
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

#[cfg(test)]
mod tests;
