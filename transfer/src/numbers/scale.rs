//! Scales of vectors, and numbers in steps of them.

use super::UNIT;
use half::f16;

/// The exponent of the highest bit of a positive number: ⌊log2⌋.
fn magnitude(value: f64) -> i32 {
    // f64 holds every f32 and its parts as normal numbers.
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

pub(super) fn scale_of_halves(largest: f32) -> f32 {
    // Below 2^-126 halves are finer than f32.
    let exponent = if largest == 0.0 { 0 } else { (magnitude(largest.into()) - 14).max(-126) };
    2f64.powi(exponent) as f32
}

pub(super) fn halve(value: f32, scale: f32) -> f16 {
    let half = f16::from_f32((f64::from(value) / f64::from(scale)) as f32);
    // Only beside f32::MAX can rounding up leave f32's range.
    if (half.to_f32() * scale).is_finite() { half } else { f16::from_bits(half.to_bits() - 1) }
}

pub(super) fn scale_of_codes(largest: f32) -> f32 {
    if largest == 0.0 {
        return 0.0;
    }
    let scale = f64::from(largest) / f64::from(i16::MAX);
    // Nine bits times the fifteen of a code are the 24 of an f32; nothing is below 2^-149.
    let last_bit = 2f64.powi((magnitude(scale) - 8).max(-149));
    ((scale / last_bit).ceil() * last_bit) as f32
}

/// At most `step`, in nine bits; 0 where it is none.
pub(super) fn scale_of_step(step: f64) -> f32 {
    if !(step > 0.0 && step < f64::from(f32::MAX * UNIT)) {
        return 0.0;
    }
    let last_bit = 2f64.powi((magnitude(step) - 8).max(-149));
    ((step / last_bit).floor() * last_bit) as f32
}

/// The nearest of 32,767 steps of a scale in either direction; 0 where the scale is.
pub fn code(value: f64, scale: f64) -> i16 {
    if scale == 0.0 {
        return 0;
    }
    let code = (value / scale).round().clamp(-f64::from(i16::MAX), f64::from(i16::MAX)) as i16;
    // As in `halve`.
    if (f32::from(code) * scale as f32).is_finite() { code } else { code - code.signum() }
}
