//! Products of dense rows: a matrix-vector product that reads the matrix once for up to four channels.

use super::{Half, Integer, Plain, Stored, by_channels};
use crate::error::{Error, Result};
use crate::matrix::{Shape, check_apply};
use half::f16;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use rayon::prelude::*;

/// Elements given to a thread at a time, about; a task is a multiple of [`ROWS`] rows.
const ELEMENTS_PER_TASK: usize = 1 << 17;

/// Rows that a kernel multiplies together, so that a light coefficient is loaded once for all of them.
const ROWS: usize = 4;

/// `out` (rows x channels) = `values` (row-major, rows x lights) · `lights` (lights x channels), after checking sizes.
pub fn apply(values: &[f32], shape: Shape, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
    apply_stored(Plain(values), shape, lights, out)
}

/// [`apply`] to half-precision values times `scale`.
pub fn apply_halves(
    halves: &[f16],
    scale: f32,
    shape: Shape,
    lights: ArrayView2<f32>,
    out: ArrayViewMut2<f32>,
) -> Result<()> {
    apply_stored(Half { halves, scale }, shape, lights, out)
}

/// [`apply`] to integers times `scale`.
pub fn apply_integers(
    integers: &[i16],
    scale: f32,
    shape: Shape,
    lights: ArrayView2<f32>,
    out: ArrayViewMut2<f32>,
) -> Result<()> {
    apply_stored(Integer { codes: integers, scale }, shape, lights, out)
}

/// [`apply`] over stored values.
pub(crate) fn apply_stored<V: Stored>(
    values: V,
    shape: Shape,
    lights: ArrayView2<f32>,
    out: ArrayViewMut2<f32>,
) -> Result<()> {
    check_apply(shape, &lights, &out)?;
    Error::expect_size("elements of the dense matrix", shape.rows() * shape.lights, values.len())?;
    by_channels(lights, out, |lights, out| match lights.ncols() {
        1 => apply_planes::<1, V>(values, lights, out),
        2 | 3 => apply_planes::<3, V>(values, lights, out),
        _ => apply_planes::<4, V>(values, lights, out),
    });
    Ok(())
}

/// Channels lie one after the other, so that eight coefficients of one are a vector. `values.len()` has been checked.
fn apply_planes<const C: usize, V: Stored>(values: V, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
    let n = lights.nrows();
    let mut planes = vec![0f32; C * n];
    for (plane, channel) in planes.chunks_exact_mut(n.max(1)).zip(lights.columns()) {
        plane.iter_mut().zip(channel).for_each(|(x, &c)| *x = c);
    }
    let rows_per_task = (ELEMENTS_PER_TASK / n.max(1)).next_multiple_of(ROWS).clamp(ROWS, 4096);
    out.axis_chunks_iter_mut(Axis(0), rows_per_task).into_par_iter().enumerate().for_each(|(task, mut out)| {
        for (group, mut out) in out.axis_chunks_iter_mut(Axis(0), ROWS).enumerate() {
            let first = task * rows_per_task + group * ROWS;
            let products: [[f32; C]; ROWS] = match out.nrows() {
                ROWS => product(values.from(first * n), n, &planes),
                rows => {
                    let mut products = [[0.0; C]; ROWS];
                    for (r, y) in products[..rows].iter_mut().enumerate() {
                        [*y] = product(values.from((first + r) * n), n, &planes);
                    }
                    products
                }
            };
            super::store(&products[..out.nrows()], out.view_mut());
        }
    });
}

/// `R` rows times `C` channels; `values` starts at the first of the rows and holds them all.
pub(super) fn product<const R: usize, const C: usize, V: Stored>(values: V, lights: usize, x: &[f32]) -> [[f32; C]; R] {
    assert!(values.len() >= R * lights && x.len() == C * lights, "{R} rows of {lights}, {C} channels");
    #[cfg(target_arch = "x86_64")]
    if super::x86::available() {
        // SAFETY: the processor has the features, and the sizes have just been checked.
        return unsafe { super::x86::dense(values, lights, x) };
    }
    portable(values, lights, x)
}

/// [`product`] without vector instructions of a processor. Sizes have been checked.
pub(super) fn portable<const R: usize, const C: usize, V: Stored>(
    values: V,
    lights: usize,
    x: &[f32],
) -> [[f32; C]; R] {
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            // Eight sums, which a compiler turns into vectors.
            let (mut sums, plane) = ([0f32; 8], &x[c * lights..(c + 1) * lights]);
            for (i, eight) in plane.chunks(8).enumerate() {
                for (lane, (sum, x)) in sums.iter_mut().zip(eight).enumerate() {
                    // SAFETY: the element belongs to row r, which `values` holds.
                    *sum += unsafe { values.at(r * lights + 8 * i + lane) } * x;
                }
            }
            sums.iter().sum()
        })
    })
}
