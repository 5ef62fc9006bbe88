//! Numbers come back within their bounds.

use super::*;
use proptest::prelude::*;

const SECTIONS: Sections = Sections { numbers: "weights/numbers", scales: "weights/scales" };

/// Finite numbers of every size, many of them near each other, some at the ends of `f32`.
fn vector() -> impl Strategy<Value = Vec<f32>> {
    let any = (any::<bool>(), -149f64..=127.99).prop_map(|(n, e)| if n { -1.0 } else { 1.0 } * e.exp2() as f32);
    let end = prop::sample::select(vec![0.0, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, f32::from_bits(1), -0.0]);
    let near = (-149f64..=127.0).prop_flat_map(|e| prop::collection::vec(-e.exp2() as f32..=e.exp2() as f32, 0..40));
    prop_oneof![prop::collection::vec(prop_oneof![any, end], 0..40), near]
}

fn stored(values: &[f32], width: Width) -> Numbers {
    Numbers::store(values, width, 1, std::iter::repeat(0))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn errors_keep_their_bounds_and_what_is_decoded_is_finite_and_read_again(values in vector()) {
        let largest = values.iter().fold(0f32, |m, v| m.max(v.abs()));
        for width in [Width::F32, Width::F16, Width::I16] {
            let numbers = stored(&values, width);
            let scale = f64::from(numbers.scale(0));
            for (&v, d) in values.iter().zip(numbers.decode(std::iter::repeat(0))) {
                prop_assert!(d.is_finite());
                // Beside f32::MAX numbers are rounded towards 0: a whole step.
                let whole = if largest > 0.99 * f32::MAX { 2.0 } else { 1.0 };
                let bound = match width {
                    Width::F32 => 0.0,
                    Width::F16 => {
                        let of_largest = f64::from(largest) * 2f64.powi(-39);
                        (f64::from(v.abs()) * 2f64.powi(-11)).max(of_largest) * whole
                    }
                    Width::I16 => scale / 2.0 * whole,
                };
                let error = (f64::from(v) - f64::from(d)).abs();
                prop_assert!(error <= bound * (1.0 + 1e-9), "{width:?}: {v:e} {d:e} of {largest:e}");
            }
            if width == Width::I16 {
                prop_assert!(scale <= f64::from(largest) / 32767.0 * (1.0 + 2f64.powi(-8)) + 2f64.powi(-149));
            }
            let mut sink = Sink::new();
            numbers.write(&mut sink, SECTIONS);
            let mut source = Source::new(sink.into_sections()).unwrap();
            let count = [values.len(), 1];
            let read = Numbers::read(&mut source, SECTIONS, width, count, std::iter::repeat(0));
            prop_assert_eq!(read.unwrap(), numbers);
        }
    }

    #[test]
    fn coarse_numbers_keep_their_steps_and_come_back_from_sorted_sections(
        values in prop::collection::vec(-1e3f32..=1e3, 0..60), exponents in prop::collection::vec(-20i32..10, 3),
    ) {
        let steps: Vec<f64> = exponents.iter().map(|e| 1.1 * f64::from(*e).exp2()).collect();
        let vector_of = (0..values.len()).map(|i| i * i % 3);
        let numbers = Numbers::store_coarse(&values, &steps, vector_of.clone());
        for ((value, decoded), vector) in values.iter().zip(numbers.decode(vector_of.clone())).zip(vector_of.clone()) {
            // A step is never coarser than asked for, unless 16 bits do not reach so far.
            let finest = 1e3 / 32767.0 * (1.0 + 2f64.powi(-8));
            let error = (f64::from(*value) - f64::from(decoded)).abs();
            prop_assert!(error <= steps[vector].max(finest) / 2.0 * (1.0 + 1e-6), "{value} {decoded} {vector}");
        }
        for numbers in [numbers, Numbers::store(&values, Width::F16, 3, vector_of.clone())] {
            let mut sink = Sink::new();
            numbers.write_sorted(&mut sink, SECTIONS, vector_of.clone());
            let mut source = Source::new(sink.into_sections()).unwrap();
            let (width, count) = (numbers.width(), [values.len(), 3]);
            let read = Numbers::read_sorted(&mut source, SECTIONS, width, count, vector_of.clone());
            prop_assert_eq!(read.unwrap(), numbers);
        }
    }
}

#[test]
fn numbers_of_zero_and_of_one_size_come_back_exactly() {
    for values in [vec![0.0; 5], vec![3.0, -3.0, 3.0], vec![f32::from_bits(1), f32::from_bits(7)]] {
        for width in [Width::F16, Width::I16] {
            let decoded = stored(&values, width).decode(std::iter::repeat(0));
            let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-4 * a.abs();
            assert!(decoded.iter().zip(&values).all(close), "{width:?}: {decoded:?} for {values:?}");
            assert!(values[0] != 0.0 || decoded == values);
        }
    }
}

#[test]
fn products_that_overflow_are_refused() {
    let read = |codes: &[i16], scale: f32| {
        let mut sink = Sink::new();
        sink.put(SECTIONS.numbers, codes);
        sink.put(SECTIONS.scales, &[scale]);
        let mut source = Source::new(sink.into_sections()).unwrap();
        Numbers::read(&mut source, SECTIONS, Width::I16, [codes.len(), 1], std::iter::repeat_n(0, codes.len()))
    };
    assert!(read(&[1, -32768], 1e34).is_ok());
    let refused = [read(&[1, 32767], 1.1e34), read(&[0], -1.0), read(&[0], f32::NAN), read(&[0], 3e34)];
    assert!(refused.iter().all(Result::is_err));
}
