//! Sums of light over intervals of columns, from its prefix sums.

use super::{BLOCK_ROWS, Column};

/// For each of at most [`BLOCK_ROWS`] groups, Σ `prefix[start + length] - prefix[start]` over its intervals: group `i` has the intervals
/// `ends[i - 1]..ends[i]` (the first group from 0). The vector kernel reads four intervals at a time, and is left to calls
/// that have four more behind the last group's.
///
/// # Safety
/// `ends` must ascend strictly from 1 or more up to at most `starts.len()`, `starts` and `lengths` be of one length, and `start + length` of every
/// interval, also of those after the last group, be below `prefix.len()`.
pub(crate) unsafe fn interval_sums<const N: usize, I: Column, L: Column>(
    ends: &[u32],
    starts: &[I],
    lengths: &[L],
    prefix: &[[f64; N]],
    sums: &mut [[f64; N]],
) {
    assert!(ends.len() == sums.len() && ends.len() <= BLOCK_ROWS, "{} groups into {}", ends.len(), sums.len());
    assert!(starts.len() == lengths.len(), "{} starts, {} lengths", starts.len(), lengths.len());
    #[cfg(target_arch = "x86_64")]
    if ends.last().is_some_and(|&end| end as usize + 4 <= starts.len()) && super::x86::available() {
        let (prefix, out) = (prefix.as_flattened(), sums.as_flattened_mut());
        // SAFETY: the processor has the features, four intervals follow every end, and the caller promises the rest.
        match N {
            1 => return unsafe { super::x86::intervals_one(ends, starts, lengths, prefix, out) },
            4 => return unsafe { super::x86::intervals_four(ends, starts, lengths, prefix, out) },
            _ => {}
        }
    }
    // SAFETY: the caller promises it.
    unsafe { portable(ends, starts, lengths, prefix, sums) }
}

/// [`interval_sums`] without vector instructions of a processor.
///
/// # Safety
/// As for [`interval_sums`].
pub(super) unsafe fn portable<const N: usize, I: Column, L: Column>(
    ends: &[u32],
    starts: &[I],
    lengths: &[L],
    prefix: &[[f64; N]],
    sums: &mut [[f64; N]],
) {
    let mut first = 0;
    for (sum, &end) in sums.iter_mut().zip(ends) {
        let end = end as usize;
        *sum = [0.0; N];
        for (start, length) in starts[first..end].iter().zip(&lengths[first..end]) {
            let (start, length) = (start.at(), length.at());
            // SAFETY: the caller promises the interval.
            let (below, above) = unsafe { (prefix.get_unchecked(start), prefix.get_unchecked(start + length)) };
            sum.iter_mut().zip(above).zip(below).for_each(|((sum, above), below)| *sum += above - below);
        }
        first = end;
    }
}
