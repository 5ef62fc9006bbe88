//! Eight floats at a time: the arithmetic of the visibility sweep, once in AVX2 and once in portable Rust.
//!
//! The sweep is written once, over [`Lanes`]; [`dispatch`] picks the instruction set. Products and sums may differ in the last
//! bit between the two (AVX2 fuses multiply and add), and nothing depends on it: every decision closer than the error bound is
//! handed to exact arithmetic, so both give the same masks.
//!
//! All `unsafe` of the scene lives in this file.

use std::ops::{Add, Div, Mul, Sub};

/// Eight `f32`. A comparison gives lanes of all ones (true) or all zeros; [`Lanes::select`] and [`Lanes::signs`] look at the
/// sign bit only.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; 8]) -> Self;
    fn store(self) -> [f32; 8];
    /// `self · b + c`, fused or not.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The smaller; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    fn gt(self, other: Self) -> Self;
    fn le(self, other: Self) -> Self;
    fn ne(self, other: Self) -> Self;
    fn and(self, other: Self) -> Self;
    fn or(self, other: Self) -> Self;
    /// Per lane `a` where the sign bit of `self` is set, else `b`.
    fn select(self, a: Self, b: Self) -> Self;
    /// The eight sign bits, lane 0 lowest.
    fn signs(self) -> u32;
    /// Integer-valued lanes in 0..=255 packed as bytes: lane k of `[a, b, c, d]` gives `a | b<<8 | c<<16 | d<<24`.
    fn bytes(parts: [Self; 4]) -> [u32; 8];
    /// Per lane the bits `first..=last`, for integer-valued `first` ≥ 0 and `last` ≤ 63; none where `first > last`.
    fn spans(first: Self, last: Self) -> [u64; 8];
}

/// Something to be computed with whichever [`Lanes`] this processor has.
pub(crate) trait Task {
    type Output;
    /// Must be `#[inline(always)]`, so that it is compiled for the instruction set of its caller.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs the task with AVX2 and FMA where the processor has them.
#[inline]
pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    use std::arch::is_x86_feature_detected as has;
    #[cfg(target_arch = "x86_64")]
    if has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt") {
        // SAFETY: all features that `x86::run` enables were just found.
        return unsafe { x86::run(task) };
    }
    task.run::<Portable>()
}

/// Plain arrays.
#[derive(Clone, Copy)]
pub(crate) struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Portable {
        Portable(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Portable, f: impl Fn(f32, f32) -> f32) -> Portable {
        Portable(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }

    #[inline(always)]
    fn test(self, other: Portable, f: impl Fn(f32, f32) -> bool) -> Portable {
        self.zip(other, |a, b| f32::from_bits(if f(a, b) { !0 } else { 0 }))
    }
}

macro_rules! portable_operator {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Portable {
            type Output = Portable;
            #[inline(always)]
            fn $method(self, other: Portable) -> Portable {
                self.zip(other, |a, b| a.$method(b))
            }
        }
    )*};
}
portable_operator!(Add add, Sub sub, Mul mul, Div div);

impl Lanes for Portable {
    #[inline(always)]
    fn splat(x: f32) -> Portable {
        Portable([x; 8])
    }
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Portable {
        Portable(*x)
    }
    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0
    }
    #[inline(always)]
    fn mul_add(self, b: Portable, c: Portable) -> Portable {
        self * b + c
    }
    #[inline(always)]
    fn min(self, other: Portable) -> Portable {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Portable) -> Portable {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Portable {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn floor(self) -> Portable {
        self.map(f32::floor)
    }
    #[inline(always)]
    fn ceil(self) -> Portable {
        self.map(f32::ceil)
    }
    #[inline(always)]
    fn gt(self, other: Portable) -> Portable {
        self.test(other, |a, b| a > b)
    }
    #[inline(always)]
    fn le(self, other: Portable) -> Portable {
        self.test(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn ne(self, other: Portable) -> Portable {
        self.test(other, |a, b| a != b)
    }
    #[inline(always)]
    fn and(self, other: Portable) -> Portable {
        self.zip(other, |a, b| f32::from_bits(a.to_bits() & b.to_bits()))
    }
    #[inline(always)]
    fn or(self, other: Portable) -> Portable {
        self.zip(other, |a, b| f32::from_bits(a.to_bits() | b.to_bits()))
    }
    #[inline(always)]
    fn select(self, a: Portable, b: Portable) -> Portable {
        Portable(std::array::from_fn(|k| if self.0[k].is_sign_negative() { a.0[k] } else { b.0[k] }))
    }
    #[inline(always)]
    fn signs(self) -> u32 {
        (0..8).fold(0, |bits, k| bits | u32::from(self.0[k].is_sign_negative()) << k)
    }
    #[inline(always)]
    fn bytes(parts: [Portable; 4]) -> [u32; 8] {
        std::array::from_fn(|k| u32::from_le_bytes(parts.map(|part| part.0[k] as u8)))
    }
    #[inline(always)]
    fn spans(first: Portable, last: Portable) -> [u64; 8] {
        // Casts saturate, so that anything past the row is a shift by 64 or more.
        let from = |x: f32| (!0u64).checked_shl(x as u32).unwrap_or(0);
        let upto = |x: f32| (!0u64).checked_shr((63.0 - x) as u32).unwrap_or(0);
        std::array::from_fn(|k| from(first.0[k]) & upto(last.0[k]))
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Lanes, Task};
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Sub};

    /// One AVX register. Private to this module, and made only inside [`run`]: that is why its methods may use AVX2 and FMA.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256);

    /// Runs the task compiled for AVX2 and FMA.
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(crate) fn run<T: Task>(task: T) -> T::Output {
        task.run::<Avx2>()
    }

    macro_rules! avx2_operator {
        ($($operator:ident $method:ident $intrinsic:ident),*) => {$(
            impl $operator for Avx2 {
                type Output = Avx2;
                #[inline(always)]
                fn $method(self, other: Avx2) -> Avx2 {
                    // SAFETY: an Avx2 exists only where AVX2 was detected.
                    Avx2(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        )*};
    }
    avx2_operator!(Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);

    /// Methods that are one expression over intrinsics.
    macro_rules! avx2_methods {
        ($($name:ident($($argument:ident: $type:ty),*) -> $output:ty { $body:expr })*) => {$(
            #[inline(always)]
            fn $name($($argument: $type),*) -> $output {
                // SAFETY: called only from `run`, where AVX2 and FMA were detected; loads and stores go through references of
                // exactly the size they touch.
                unsafe { $body }
            }
        )*};
    }

    impl Lanes for Avx2 {
        avx2_methods! {
            splat(x: f32) -> Avx2 { Avx2(_mm256_set1_ps(x)) }
            load(x: &[f32; 8]) -> Avx2 { Avx2(_mm256_loadu_ps(x.as_ptr())) }
            spans(first: Avx2, last: Avx2) -> [u64; 8] {{
                // A shift by 64 or more gives 0, and a conversion out of range gives 2^31.
                let left = _mm256_cvttps_epi32(first.0);
                let right = _mm256_cvttps_epi32(_mm256_sub_ps(_mm256_set1_ps(63.0), last.0));
                let ones = _mm256_set1_epi64x(-1);
                let half = |left: __m128i, right: __m128i| _mm256_and_si256(
                    _mm256_sllv_epi64(ones, _mm256_cvtepu32_epi64(left)),
                    _mm256_srlv_epi64(ones, _mm256_cvtepu32_epi64(right)),
                );
                let low = half(_mm256_castsi256_si128(left), _mm256_castsi256_si128(right));
                let high = half(_mm256_extracti128_si256(left, 1), _mm256_extracti128_si256(right, 1));
                std::mem::transmute::<[__m256i; 2], [u64; 8]>([low, high])
            }}
            bytes(parts: [Avx2; 4]) -> [u32; 8] {{
                let [a, b, c, d] = [
                    _mm256_cvttps_epi32(parts[0].0), _mm256_cvttps_epi32(parts[1].0),
                    _mm256_cvttps_epi32(parts[2].0), _mm256_cvttps_epi32(parts[3].0),
                ];
                let low = _mm256_or_si256(a, _mm256_slli_epi32(b, 8));
                let high = _mm256_or_si256(_mm256_slli_epi32(c, 16), _mm256_slli_epi32(d, 24));
                std::mem::transmute::<__m256i, [u32; 8]>(_mm256_or_si256(low, high))
            }}
        }
        #[inline(always)]
        fn store(self) -> [f32; 8] {
            // SAFETY: both are 32 bytes of plain floats.
            unsafe { std::mem::transmute(self.0) }
        }
        #[inline(always)]
        fn mul_add(self, b: Avx2, c: Avx2) -> Avx2 {
            // SAFETY: FMA was detected, see `run`.
            Avx2(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn min(self, other: Avx2) -> Avx2 {
            // SAFETY: AVX2 was detected, see `run`; so below.
            Avx2(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn abs(self) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn floor(self) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_floor_ps(self.0) })
        }
        #[inline(always)]
        fn ceil(self) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_ceil_ps(self.0) })
        }
        #[inline(always)]
        fn gt(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_cmp_ps(self.0, other.0, _CMP_GT_OQ) })
        }
        #[inline(always)]
        fn le(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_cmp_ps(self.0, other.0, _CMP_LE_OQ) })
        }
        #[inline(always)]
        fn ne(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_cmp_ps(self.0, other.0, _CMP_NEQ_UQ) })
        }
        #[inline(always)]
        fn and(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_and_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn or(self, other: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_or_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn select(self, a: Avx2, b: Avx2) -> Avx2 {
            // SAFETY: as above.
            Avx2(unsafe { _mm256_blendv_ps(b.0, a.0, self.0) })
        }
        #[inline(always)]
        fn signs(self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(self.0) as u32 }
        }
    }
}
