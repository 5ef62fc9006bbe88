//! Stored numbers: columns of the narrowest exact width, values of 32, 16 or 8 bits.

use prt_transfer::kernel::Column;
use prt_transfer::sections::Pod;

/// A column index of the narrowest width that holds a matrix's columns.
pub(crate) trait Index: Column + Pod {
    /// The index of a column that is known to fit.
    fn narrow(column: u32) -> Self;
}

macro_rules! index {
    ($($type:ty)*) => {$(
        impl Index for $type {
            fn narrow(column: u32) -> Self {
                column as $type
            }
        }
    )*};
}
index! { u8 u16 u32 }

/// A value as it is stored: itself, or a whole multiple of its row's step.
pub(crate) trait Value: Pod + Send + Sync {
    /// The largest multiple, or `None` where values are stored as they are.
    const LARGEST: Option<f32>;
    /// Values that [`Value::numbers`] takes at a time.
    const CHUNK: usize;
    /// `value` as a multiple of `step`, or itself.
    fn store(value: f32, step: f32) -> Self;
    /// The stored number, to be multiplied by the row's step if there is one.
    fn number(self) -> f32;
    /// Up to [`Value::CHUNK`] stored numbers as `f32`, in `buffer` unless they are that already.
    fn numbers<'a>(stored: &'a [Self], buffer: &'a mut [f32; 64]) -> &'a [f32];
}

impl Value for f32 {
    const LARGEST: Option<f32> = None;
    const CHUNK: usize = usize::MAX;
    fn store(value: f32, _: f32) -> f32 {
        value
    }
    #[inline(always)]
    fn number(self) -> f32 {
        self
    }
    #[inline(always)]
    fn numbers<'a>(stored: &'a [f32], _: &'a mut [f32; 64]) -> &'a [f32] {
        stored
    }
}

macro_rules! multiples {
    ($($type:ty)*) => {$(
        impl Value for $type {
            const LARGEST: Option<f32> = Some(<$type>::MAX as f32);
            const CHUNK: usize = 64;
            fn store(value: f32, step: f32) -> $type {
                // Saturates; a step of 0 belongs to a row of zeros.
                (value / step).round() as $type
            }
            #[inline(always)]
            fn number(self) -> f32 {
                self.into()
            }
            #[inline(always)]
            fn numbers<'a>(stored: &'a [$type], buffer: &'a mut [f32; 64]) -> &'a [f32] {
                buffer.iter_mut().zip(stored).for_each(|(number, &q)| *number = q.into());
                &buffer[..stored.len()]
            }
        }
    )*};
}
multiples! { i16 i8 }

/// What storing does to values.
#[derive(Clone, Copy)]
pub(crate) struct Rounding {
    /// The largest multiple of the step, where there is one.
    largest: Option<f32>,
    decode: fn(f32, f32) -> f32,
}

impl Rounding {
    /// Of values of so many bits: 8, 16, and 32 otherwise.
    pub(crate) fn of_bits(bits: u32) -> Rounding {
        fn of<V: Value>() -> Rounding {
            Rounding {
                largest: V::LARGEST,
                decode: |value, step| {
                    let number = V::store(value, step).number();
                    if V::LARGEST.is_some() { number * step } else { number }
                },
            }
        }
        match bits {
            8 => of::<i8>(),
            16 => of::<i16>(),
            _ => of::<f32>(),
        }
    }
    /// Whether values come back as they were.
    pub(crate) fn is_exact(self) -> bool {
        self.largest.is_none()
    }
    /// The step of a row of these values: their largest magnitude is the largest multiple. 0 where all of them are.
    pub(crate) fn step(self, values: impl Iterator<Item = f32>) -> f32 {
        let Some(largest) = self.largest else { return 1.0 };
        let most = values.fold(0f32, |m, v| m.max(v.abs()));
        let step = most / largest;
        // Below 2^-126 steps are as coarse as they are small: rounded down, the largest magnitude would be more of them than there are.
        if most / step > largest + 0.5 { step.next_up() } else { step }
    }
    /// A value after storing and decoding.
    pub(crate) fn decoded(self, value: f32, step: f32) -> f32 {
        if self.is_exact() { value } else { (self.decode)(value, step) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_magnitude_is_further_than_half_a_step_from_what_is_stored(most in 1u32..0x7f00_0000, small in 1u32..0x0100_0000, part in -1f32..=1.0, bits in prop_oneof![Just(8), Just(16)]) {
            // Small ones are below 2^-126 or not much above, where steps are coarse.
            for most in [most, small].map(f32::from_bits) {
                let rounding = Rounding::of_bits(bits);
                let step = rounding.step([most, part * most].into_iter());
                for value in [most, -most, part * most] {
                    let error = f64::from(rounding.decoded(value, step)) - f64::from(value);
                    // Division and product round once each where the step is a normal number.
                    prop_assert!(error.abs() <= f64::from(step) * 0.51, "{value:e} in steps of {step:e}: {error:e}");
                }
            }
        }
    }
}
