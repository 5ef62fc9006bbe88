//! Products of sparse rows.

use super::{BLOCK_ROWS, Column, Plain, Stored};

/// Σ value · x\[column\] over one sparse row.
///
/// # Safety
/// `columns` and `values` must be of one length, and every column below `x.len()`.
#[inline]
pub unsafe fn sparse_dot<const N: usize, I: Column>(columns: &[I], values: &[f32], x: &[[f32; N]]) -> [f32; N] {
    // SAFETY: the caller's promise is the same.
    unsafe { dot(columns, Plain(values), x) }
}

/// Products of `ends.len()` consecutive sparse rows, at most [`BLOCK_ROWS`], with a finite light. Row `i` has the elements
/// `ends[i - 1]..ends[i]` (the first row from 0) of `columns` and `values`. These may go on beyond the last row, and should:
/// the vector kernel reads eight elements at a time, and is left to the blocks that have eight more.
///
/// # Safety
/// `ends` must ascend up to at most `columns.len()`, `columns` and `values` be of one length, and every column, also those
/// after the last row, be below `x.len()`.
pub unsafe fn sparse_rows<const N: usize, I: Column>(
    ends: &[u32],
    columns: &[I],
    values: &[f32],
    x: &[[f32; N]],
    out: &mut [[f32; N]],
) {
    // SAFETY: the caller's promise is the same.
    unsafe { rows_of(ends, columns, Plain(values), x, out) }
}

/// [`sparse_dot`] over stored values.
///
/// # Safety
/// As for [`sparse_dot`].
#[inline]
pub(crate) unsafe fn dot<const N: usize, I: Column, V: Stored>(columns: &[I], values: V, x: &[[f32; N]]) -> [f32; N] {
    debug_assert!(columns.len() <= values.len());
    // Four sums, since one would make every addition wait for the one before.
    let mut sums = [[0f32; N]; 4];
    let quads = columns.len() / 4 * 4;
    let step = |sum: &mut [f32; N], i: usize| {
        // SAFETY: i < columns.len() = values.len(), and the caller promises the column.
        let (value, x) = unsafe { (values.at(i), x.get_unchecked(columns.get_unchecked(i).at())) };
        sum.iter_mut().zip(x).for_each(|(s, x)| *s += value * x);
    };
    for i in (0..quads).step_by(4) {
        sums.iter_mut().enumerate().for_each(|(lane, sum)| step(sum, i + lane));
    }
    for i in quads..columns.len() {
        step(&mut sums[0], i);
    }
    std::array::from_fn(|c| (sums[0][c] + sums[1][c]) + (sums[2][c] + sums[3][c]))
}

/// [`sparse_rows`] over stored values.
///
/// # Safety
/// As for [`sparse_rows`].
pub(crate) unsafe fn rows_of<const N: usize, I: Column, V: Stored>(
    ends: &[u32],
    columns: &[I],
    values: V,
    x: &[[f32; N]],
    out: &mut [[f32; N]],
) {
    assert!(ends.len() == out.len() && ends.len() <= BLOCK_ROWS, "{} rows into {}", ends.len(), out.len());
    #[cfg(target_arch = "x86_64")]
    if ends.last().is_some_and(|&end| end as usize + 8 <= columns.len()) && super::x86::available() {
        // SAFETY: the processor has the features, eight elements follow every row's end, and the caller promises the rest.
        match N {
            1 => {
                return unsafe {
                    super::x86::sparse_one(ends, columns, values, x.as_flattened(), out.as_flattened_mut())
                };
            }
            4 => {
                return unsafe {
                    super::x86::sparse_four(ends, columns, values, x.as_flattened(), out.as_flattened_mut())
                };
            }
            _ => {}
        }
    }
    // SAFETY: the caller promises it.
    unsafe { portable(ends, columns, values, x, out) }
}

/// [`rows_of`] without vector instructions of a processor.
///
/// # Safety
/// As for [`sparse_rows`].
pub(super) unsafe fn portable<const N: usize, I: Column, V: Stored>(
    ends: &[u32],
    columns: &[I],
    values: V,
    x: &[[f32; N]],
    out: &mut [[f32; N]],
) {
    let mut start = 0;
    for (y, &end) in out.iter_mut().zip(ends) {
        let end = end as usize;
        // SAFETY: the caller promises the columns.
        *y = unsafe { dot(&columns[start..end], values.from(start), x) };
        start = end;
    }
}
