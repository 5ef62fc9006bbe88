//! Values as they are stored, and how a kernel gets `f32` back: as they are, halves, integers or entries of a table.

use super::Column;
use half::f16;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// A run of stored values, decoded where they are used.
pub(crate) trait Stored: Copy + Send + Sync {
    /// How many.
    fn len(self) -> usize;

    /// The values from `first` on.
    fn from(self, first: usize) -> Self;

    /// Value `i`.
    ///
    /// # Safety
    /// `i` must be below [`Stored::len`].
    unsafe fn at(self, i: usize) -> f32;

    /// Values `i..i + 8`.
    ///
    /// # Safety
    /// `i + 8` must not exceed [`Stored::len`], and the processor must have AVX2 and F16C.
    #[cfg(target_arch = "x86_64")]
    unsafe fn eight(self, i: usize) -> __m256;

    /// Where value `i` lies, for prefetching; `i` may be past the end.
    fn address(self, i: usize) -> *const i8;
}

/// Every value as it is.
#[derive(Clone, Copy)]
pub(crate) struct Plain<'a>(pub(crate) &'a [f32]);

/// Half precision times `scale`.
#[derive(Clone, Copy)]
pub(crate) struct Half<'a> {
    pub(crate) halves: &'a [f16],
    pub(crate) scale: f32,
}

/// Integers times `scale`.
#[derive(Clone, Copy)]
pub(crate) struct Integer<'a, T> {
    pub(crate) codes: &'a [T],
    pub(crate) scale: f32,
}

/// Entries of a table. Every code must be below its length.
#[derive(Clone, Copy)]
pub(crate) struct Dictionary<'a, T> {
    pub(crate) codes: &'a [T],
    pub(crate) table: &'a [f32],
}

/// An integer that `f32` holds exactly.
pub(crate) trait Code: Copy + Send + Sync + 'static {
    /// As a number.
    fn number(self) -> f32;

    /// Eight of them as 32-bit lanes.
    ///
    /// # Safety
    /// `first` must point to eight readable codes, and the processor must have AVX2.
    #[cfg(target_arch = "x86_64")]
    unsafe fn lanes(first: *const Self) -> __m256i;
}

macro_rules! code {
    ($($type:ty, $load:ident, $widen:ident;)*) => {$(
        impl Code for $type {
            #[inline(always)]
            fn number(self) -> f32 {
                self.into()
            }
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            unsafe fn lanes(first: *const $type) -> __m256i {
                // SAFETY: eight codes and AVX2, as the caller promises.
                unsafe { $widen($load(first.cast())) }
            }
        }
    )*};
}
code! {
    u8, _mm_loadl_epi64, _mm256_cvtepu8_epi32;
    i8, _mm_loadl_epi64, _mm256_cvtepi8_epi32;
    u16, _mm_loadu_si128, _mm256_cvtepu16_epi32;
    i16, _mm_loadu_si128, _mm256_cvtepi16_epi32;
}

impl Stored for Plain<'_> {
    #[inline(always)]
    fn len(self) -> usize {
        self.0.len()
    }
    #[inline(always)]
    fn from(self, first: usize) -> Self {
        Plain(&self.0[first..])
    }
    #[inline(always)]
    unsafe fn at(self, i: usize) -> f32 {
        // SAFETY: i < len, as the caller promises.
        unsafe { *self.0.get_unchecked(i) }
    }
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn eight(self, i: usize) -> __m256 {
        // SAFETY: i + 8 ≤ len, as the caller promises.
        unsafe { _mm256_loadu_ps(self.0.as_ptr().add(i)) }
    }
    #[inline(always)]
    fn address(self, i: usize) -> *const i8 {
        self.0.as_ptr().wrapping_add(i).cast()
    }
}

impl Stored for Half<'_> {
    #[inline(always)]
    fn len(self) -> usize {
        self.halves.len()
    }
    #[inline(always)]
    fn from(self, first: usize) -> Self {
        Half { halves: &self.halves[first..], ..self }
    }
    #[inline(always)]
    unsafe fn at(self, i: usize) -> f32 {
        // SAFETY: i < len, as the caller promises.
        unsafe { self.halves.get_unchecked(i) }.to_f32() * self.scale
    }
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn eight(self, i: usize) -> __m256 {
        // SAFETY: i + 8 ≤ len and F16C, as the caller promises.
        unsafe {
            let halves = _mm_loadu_si128(self.halves.as_ptr().add(i).cast());
            _mm256_mul_ps(_mm256_cvtph_ps(halves), _mm256_set1_ps(self.scale))
        }
    }
    #[inline(always)]
    fn address(self, i: usize) -> *const i8 {
        self.halves.as_ptr().wrapping_add(i).cast()
    }
}

impl<T: Code> Stored for Integer<'_, T> {
    #[inline(always)]
    fn len(self) -> usize {
        self.codes.len()
    }
    #[inline(always)]
    fn from(self, first: usize) -> Self {
        Integer { codes: &self.codes[first..], ..self }
    }
    #[inline(always)]
    unsafe fn at(self, i: usize) -> f32 {
        // SAFETY: i < len, as the caller promises.
        unsafe { self.codes.get_unchecked(i) }.number() * self.scale
    }
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn eight(self, i: usize) -> __m256 {
        // SAFETY: i + 8 ≤ len and AVX2, as the caller promises.
        unsafe {
            let numbers = _mm256_cvtepi32_ps(T::lanes(self.codes.as_ptr().add(i)));
            _mm256_mul_ps(numbers, _mm256_set1_ps(self.scale))
        }
    }
    #[inline(always)]
    fn address(self, i: usize) -> *const i8 {
        self.codes.as_ptr().wrapping_add(i).cast()
    }
}

impl<T: Column> Stored for Dictionary<'_, T> {
    #[inline(always)]
    fn len(self) -> usize {
        self.codes.len()
    }
    #[inline(always)]
    fn from(self, first: usize) -> Self {
        Dictionary { codes: &self.codes[first..], ..self }
    }
    #[inline(always)]
    unsafe fn at(self, i: usize) -> f32 {
        // SAFETY: i < len, as the caller promises; the lookup is checked.
        self.table[unsafe { self.codes.get_unchecked(i) }.at()]
    }
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn eight(self, i: usize) -> __m256 {
        // SAFETY: i + 8 ≤ len, as the caller promises; the lookups are checked.
        unsafe {
            let codes = T::eight(self.codes.as_ptr().add(i));
            let v: [f32; 8] = std::array::from_fn(|lane| self.table[codes[lane]]);
            _mm256_setr_ps(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7])
        }
    }
    #[inline(always)]
    fn address(self, i: usize) -> *const i8 {
        self.codes.as_ptr().wrapping_add(i).cast()
    }
}
