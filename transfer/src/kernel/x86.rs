//! Kernels for processors with AVX2, FMA and F16C, chosen at run time.
//!
//! Rows of a few dozen elements end at unpredictable places: a loop per row loses more to the mispredicted exit than to its
//! arithmetic. The sparse kernels therefore run through a block of rows in groups of eight elements without a branch at the
//! row's end: the last group of a row is masked, its sum is stored like every other group's, and only then does the place to
//! store to move on.

use super::{BLOCK_ROWS, Column, Stored};
use std::arch::x86_64::*;

/// Elements ahead that are asked for, into the second-level cache: the first one belongs to the light.
const AHEAD: usize = 1024;

/// Eight lanes of ones and eight of zeros: eight lanes from `8 - n` on select the first `n`.
static SELECT: [i32; 16] = [-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0];

/// As [`SELECT`], four lanes of 64 bits each.
static SELECT_PAIRS: [i64; 8] = [-1, -1, -1, -1, 0, 0, 0, 0];

/// Whether this processor has what the kernels here need.
#[inline]
pub(super) fn available() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") && is_x86_feature_detected!("f16c")
}

/// Walks over the groups of a block of rows.
struct Walk {
    at: u32,
    row: usize,
}

/// One group: its first element, the lanes that belong to the row, and all lanes unless the row ends here.
struct Group {
    at: usize,
    row: usize,
    mine: __m256,
    keep: __m256,
}

impl Walk {
    /// # Safety
    /// The processor must have AVX2, `self.row` be below `ends.len()`, and `ends` ascend.
    #[inline(always)]
    unsafe fn next(&mut self, ends: &[u32]) -> Group {
        // SAFETY: as the caller promises; `taken` is at most 8.
        unsafe {
            let left = ends.get_unchecked(self.row) - self.at;
            let (taken, last) = (left.min(8), left <= 8);
            let mine = _mm256_loadu_ps(SELECT.as_ptr().add(8 - taken as usize).cast());
            let keep = _mm256_castsi256_ps(_mm256_set1_epi32(i32::from(last) - 1));
            let group = Group { at: self.at as usize, row: self.row, mine, keep };
            self.at += taken;
            self.row += usize::from(last);
            group
        }
    }
}

#[inline(always)]
unsafe fn prefetch<I: Column, V: Stored>(columns: &[I], values: V, at: usize) {
    // SAFETY: a prefetch may name any address.
    unsafe {
        _mm_prefetch::<_MM_HINT_T1>(columns.as_ptr().wrapping_add(at + AHEAD).cast());
        _mm_prefetch::<_MM_HINT_T1>(values.address(at + AHEAD));
    }
}

#[inline(always)]
unsafe fn prefetch_intervals<I: Column, L: Column>(starts: &[I], lengths: &[L], at: usize) {
    // SAFETY: a prefetch may name any address.
    unsafe {
        _mm_prefetch::<_MM_HINT_T1>(starts.as_ptr().wrapping_add(at + AHEAD).cast());
        _mm_prefetch::<_MM_HINT_T1>(lengths.as_ptr().wrapping_add(at + AHEAD).cast());
    }
}

/// [`super::sparse_rows`] for one channel.
///
/// # Safety
/// As for [`super::sparse_rows`]; eight elements must follow the last row's end, and [`available`] hold.
#[target_feature(enable = "avx2,fma,f16c")]
pub(super) unsafe fn sparse_one<I: Column, V: Stored>(
    ends: &[u32],
    columns: &[I],
    values: V,
    x: &[f32],
    out: &mut [f32],
) {
    let mut sums = [_mm256_setzero_ps(); BLOCK_ROWS];
    let mut sum = _mm256_setzero_ps();
    let mut walk = Walk { at: 0, row: 0 };
    while walk.row < ends.len() {
        // SAFETY: row < ends.len() ≤ BLOCK_ROWS; at ≤ the last end, so that eight elements follow; columns are below x.len().
        unsafe {
            let group = walk.next(ends);
            prefetch(columns, values, group.at);
            let c = I::eight(columns.as_ptr().add(group.at));
            let x = |lane: usize| *x.get_unchecked(c[lane]);
            let x = _mm256_set_m128(_mm_setr_ps(x(4), x(5), x(6), x(7)), _mm_setr_ps(x(0), x(1), x(2), x(3)));
            sum = _mm256_fmadd_ps(x, _mm256_and_ps(values.eight(group.at), group.mine), sum);
            *sums.get_unchecked_mut(group.row) = sum;
            sum = _mm256_and_ps(sum, group.keep);
        }
    }
    // Four rows at a time, since one store is cheaper than a copy of unknown length.
    let (fours, rest) = out.as_chunks_mut::<4>();
    let (sums, last) = sums.split_at(4 * fours.len());
    for (y, sums) in fours.iter_mut().zip(sums.as_chunks::<4>().0) {
        let half = |i: usize| _mm_add_ps(_mm256_castps256_ps128(sums[i]), _mm256_extractf128_ps::<1>(sums[i]));
        let four = _mm_hadd_ps(_mm_hadd_ps(half(0), half(1)), _mm_hadd_ps(half(2), half(3)));
        // SAFETY: y is four floats.
        unsafe { _mm_storeu_ps(y.as_mut_ptr(), four) };
    }
    for (y, &sum) in rest.iter_mut().zip(last) {
        *y = total(sum);
    }
}

/// [`super::sparse_rows`] for four packed channels: `x` and `out` are lights x 4 and rows x 4.
///
/// # Safety
/// As for [`sparse_one`], `x.len()` being four times what the columns stay below.
#[target_feature(enable = "avx2,fma,f16c")]
pub(super) unsafe fn sparse_four<I: Column, V: Stored>(
    ends: &[u32],
    columns: &[I],
    values: V,
    x: &[f32],
    out: &mut [f32],
) {
    // Two elements to a register: lanes 0 to 3 and 4 to 7 take the value of one each.
    let pairs: [__m256i; 4] = std::array::from_fn(|p| {
        let (a, b) = (2 * p as i32, 2 * p as i32 + 1);
        _mm256_setr_epi32(a, a, a, a, b, b, b, b)
    });
    let mut sums = [_mm256_setzero_ps(); 2];
    let mut walk = Walk { at: 0, row: 0 };
    while walk.row < ends.len() {
        // SAFETY: row < ends.len() = out.len() / 4; eight elements follow `at`; four floats of x lie at every column.
        unsafe {
            let group = walk.next(ends);
            prefetch(columns, values, group.at);
            let c = I::eight(columns.as_ptr().add(group.at));
            let v = _mm256_and_ps(values.eight(group.at), group.mine);
            let x = |lane: usize| _mm_loadu_ps(x.as_ptr().add(4 * c[lane]));
            for p in 0..4 {
                let v = _mm256_permutevar8x32_ps(v, pairs[p]);
                sums[p % 2] = _mm256_fmadd_ps(_mm256_set_m128(x(2 * p + 1), x(2 * p)), v, sums[p % 2]);
            }
            let both = _mm256_add_ps(sums[0], sums[1]);
            let y = _mm_add_ps(_mm256_castps256_ps128(both), _mm256_extractf128_ps::<1>(both));
            _mm_storeu_ps(out.as_mut_ptr().add(4 * group.row), y);
            sums = sums.map(|s| _mm256_and_ps(s, group.keep));
        }
    }
}

/// [`super::interval_sums`] for one channel, four intervals at a time, without a branch at the end of a sum.
///
/// # Safety
/// As for [`super::interval_sums`]; four intervals must follow the last end, and [`available`] hold.
#[target_feature(enable = "avx2,fma,f16c")]
pub(super) unsafe fn intervals_one<I: Column, L: Column>(
    ends: &[u32],
    starts: &[I],
    lengths: &[L],
    prefix: &[f64],
    out: &mut [f64],
) {
    let mut sums = [_mm256_setzero_pd(); BLOCK_ROWS];
    let mut sum = _mm256_setzero_pd();
    let (mut at, mut group) = (0u32, 0);
    while group < ends.len() {
        // SAFETY: group < ends.len() ≤ BLOCK_ROWS; at ≤ the last end, so that four intervals follow; prefix holds their ends.
        unsafe {
            let left = ends.get_unchecked(group) - at;
            let (taken, last) = (left.min(4), left <= 4);
            let first = at as usize;
            prefetch_intervals(starts, lengths, first);
            let (start, length) = (I::four(starts.as_ptr().add(first)), L::four(lengths.as_ptr().add(first)));
            let p = |at: usize| *prefix.get_unchecked(at);
            let below = _mm256_setr_pd(p(start[0]), p(start[1]), p(start[2]), p(start[3]));
            let end = |lane: usize| start[lane] + length[lane];
            let above = _mm256_setr_pd(p(end(0)), p(end(1)), p(end(2)), p(end(3)));
            let mine = _mm256_loadu_pd(SELECT_PAIRS.as_ptr().add(4 - taken as usize).cast());
            sum = _mm256_add_pd(sum, _mm256_and_pd(_mm256_sub_pd(above, below), mine));
            *sums.get_unchecked_mut(group) = sum;
            sum = _mm256_and_pd(sum, _mm256_castsi256_pd(_mm256_set1_epi64x(i64::from(last) - 1)));
            at += taken;
            group += usize::from(last);
        }
    }
    for (y, &sum) in out.iter_mut().zip(&sums) {
        let two = _mm_add_pd(_mm256_castpd256_pd128(sum), _mm256_extractf128_pd::<1>(sum));
        *y = _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
    }
}

/// [`super::interval_sums`] for four packed channels, two intervals at a time: `prefix` and `sums` are lights + 1 and groups
/// times 4.
///
/// # Safety
/// As for [`intervals_one`].
#[target_feature(enable = "avx2,fma,f16c")]
pub(super) unsafe fn intervals_four<I: Column, L: Column>(
    ends: &[u32],
    starts: &[I],
    lengths: &[L],
    prefix: &[f64],
    sums: &mut [f64],
) {
    let mut sum = _mm256_setzero_pd();
    let (mut at, mut group) = (0u32, 0);
    while group < ends.len() {
        // SAFETY: group < ends.len() = sums.len() / 4; at ≤ the last end, so that four intervals follow; prefix holds four
        // floats at their ends.
        unsafe {
            let left = ends.get_unchecked(group) - at;
            let (taken, last) = (left.min(2), left <= 2);
            let first = at as usize;
            prefetch_intervals(starts, lengths, first);
            let p = |at: usize| _mm256_loadu_pd(prefix.as_ptr().add(4 * at));
            let difference = |i: usize| {
                let start = starts.get_unchecked(i).at();
                _mm256_sub_pd(p(start + lengths.get_unchecked(i).at()), p(start))
            };
            let second = _mm256_castsi256_pd(_mm256_set1_epi64x(i64::from(taken < 2) - 1));
            let pair = _mm256_add_pd(difference(first), _mm256_and_pd(difference(first + 1), second));
            sum = _mm256_add_pd(sum, pair);
            _mm256_storeu_pd(sums.as_mut_ptr().add(4 * group), sum);
            sum = _mm256_and_pd(sum, _mm256_castsi256_pd(_mm256_set1_epi64x(i64::from(last) - 1)));
            at += taken;
            group += usize::from(last);
        }
    }
}

/// Products of `R` dense rows with `C` channels. `x` is channels x lights; `values` starts at the first row.
///
/// # Safety
/// `values` must hold `R` rows of `lights`, `x` hold `C` times `lights`, and [`available`] hold.
#[target_feature(enable = "avx2,fma,f16c")]
pub(super) unsafe fn dense<const R: usize, const C: usize, V: Stored>(
    values: V,
    lights: usize,
    x: &[f32],
) -> [[f32; C]; R] {
    let mut sums = [[_mm256_setzero_ps(); C]; R];
    let whole = lights / 8 * 8;
    for k in (0..whole).step_by(8) {
        // SAFETY: k + 8 ≤ lights, of which there are C in x and R in values.
        unsafe {
            let x: [__m256; C] = std::array::from_fn(|c| _mm256_loadu_ps(x.as_ptr().add(c * lights + k)));
            for (r, sums) in sums.iter_mut().enumerate() {
                let v = values.eight(r * lights + k);
                for c in 0..C {
                    sums[c] = _mm256_fmadd_ps(v, x[c], sums[c]);
                }
            }
        }
    }
    // Loops: a closure would not be inlined, and its vectors would go through memory.
    let mut products = [[0f32; C]; R];
    for (products, sums) in products.iter_mut().zip(&sums) {
        for (y, &sum) in products.iter_mut().zip(sums) {
            *y = total(sum);
        }
    }
    for k in whole..lights {
        for (r, products) in products.iter_mut().enumerate() {
            // SAFETY: k < lights.
            let v = unsafe { values.at(r * lights + k) };
            for (c, y) in products.iter_mut().enumerate() {
                *y += v * x[c * lights + k];
            }
        }
    }
    products
}

#[target_feature(enable = "avx2")]
#[inline]
fn total(sum: __m256) -> f32 {
    let four = _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps::<1>(sum));
    let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two)))
}
