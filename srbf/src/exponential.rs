//! e^x of many numbers at once.

use pulp::{Arch, Simd, WithSimd};

/// ln 2 in two parts, the first of which has 32 trailing zeros: its multiples by exponents are exact.
const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Adding it leaves the nearest whole number in the last bits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// 1/n!, n = 0 to 12: the remainder is below 2e-16 where |x| ≤ ½ ln 2.
const TAYLOR: [f64; 13] = {
    let mut factors = [1.0; 13];
    let mut n = 1;
    while n < 13 {
        factors[n] = factors[n - 1] / n as f64;
        n += 1;
    }
    factors
};

/// Where e^x is no more a normal number: 0 takes its place.
const UNDERFLOW: f64 = -708.0;

/// Replaces every μ by e^(`bandwidth` (μ - 1)), to within 1e-15 of it while that is at least 1e-307, and 0 below; μ ≤ 1 up to rounding.
pub(crate) fn gaussian(cosines: &mut [f64], bandwidth: f64) {
    Arch::new().dispatch(Gaussian { cosines, bandwidth });
}

struct Gaussian<'a> {
    cosines: &'a mut [f64],
    bandwidth: f64,
}

impl WithSimd for Gaussian<'_> {
    type Output = ();

    // Plain code: inlined where the vector instructions of the machine are allowed, the compiler takes them. It makes no fused
    // operations of its own, so results are the same with any of them.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let bandwidth = self.bandwidth;
        for value in self.cosines.iter_mut() {
            *value = exponential(bandwidth * (*value - 1.0));
        }
    }
}

/// e^x = 2^n e^r with x = n ln 2 + r.
#[inline(always)]
fn exponential(x: f64) -> f64 {
    let clamped = x.max(UNDERFLOW);
    let shifted = clamped * std::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (clamped - n * LN2[0]) - n * LN2[1];
    let mut sum = TAYLOR[12];
    let mut i = 12;
    while i > 0 {
        i -= 1;
        sum = sum * r + TAYLOR[i];
    }
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    if x < UNDERFLOW { 0.0 } else { sum * power }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exponentials_are_those_of_the_standard_library(x in -700f64..1.0, tiny in -1e-6f64..1e-6) {
            for x in [x, tiny] {
                prop_assert!((exponential(x) / x.exp() - 1.0).abs() < 1e-15, "{x}: {:e} {:e}", exponential(x), x.exp());
            }
        }
    }

    #[test]
    fn what_is_below_normal_numbers_is_zero() {
        assert!((exponential(UNDERFLOW) / UNDERFLOW.exp() - 1.0).abs() < 1e-13);
        for x in [UNDERFLOW * (1.0 + f64::EPSILON), -746.0, -1e5, f64::MIN, f64::NEG_INFINITY] {
            assert_eq!(exponential(x), 0.0, "{x}");
        }
    }

    #[test]
    fn every_number_of_a_row_is_replaced() {
        let cosines: Vec<f64> = (0..37).map(|i| 1.0 - i as f64 / 18.0).collect();
        for bandwidth in [0.01, 3.0, 1e5] {
            let mut row = cosines.clone();
            gaussian(&mut row, bandwidth);
            for (value, mu) in row.iter().zip(&cosines) {
                let expected = (bandwidth * (mu - 1.0)).exp();
                assert!((value - expected).abs() <= 1e-14 * expected + 1e-306, "{value:e} {expected:e}");
            }
        }
    }
}
