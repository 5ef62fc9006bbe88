//! Numbers come back within their bounds.

use super::*;
use ndarray::Array2;
use proptest::prelude::*;

const WIDTHS: [Width; 3] = [Width::F32, Width::F16, Width::I16];
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
        for width in WIDTHS {
            let numbers = stored(&values, width);
            prop_assert_eq!((numbers.len(), numbers.is_empty()), (values.len(), values.is_empty()));
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
            let scales = if width == Width::F32 { 0 } else { 4 };
            prop_assert_eq!(sink.resident_bytes(), width.bytes() * values.len() + scales);
            let mut source = Source::new(sink.into_sections()).unwrap();
            let count = [values.len(), 1];
            let read = Numbers::read(&mut source, SECTIONS, width, count, std::iter::repeat(0));
            prop_assert_eq!(read.unwrap(), numbers);
        }
    }

    #[test]
    fn a_range_is_unpacked_with_finite_numbers_behind_it(values in vector(), cut in (0f64..1.0, 0f64..1.0), spare in 0usize..9) {
        let place = |part: f64| (part * (values.len() + 1) as f64) as usize;
        let (from, to) = (place(cut.0.min(cut.1)), place(cut.0.max(cut.1)));
        for width in WIDTHS {
            let (numbers, mut buffer) = (stored(&values, width), vec![f32::NAN; 5]);
            let unpacked = numbers.unpack(from..to, spare, &mut buffer);
            prop_assert_eq!(unpacked.len(), to - from + spare);
            prop_assert!(unpacked.iter().all(|v| v.is_finite()));
            prop_assert!(unpacked.iter().zip(from..to).all(|(&v, at)| v == numbers.stored(at)));
        }
    }

    #[test]
    fn products_are_those_of_what_is_stored(values in prop::collection::vec(-9f32..9.0, 0..40), skipped in 0f64..1.0, channels in 1usize..6) {
        // Rows of two numbers each, from any row on.
        let rows = values.len() / 2;
        let skipped = (skipped * (rows + 1) as f64) as usize;
        for (width, unit) in WIDTHS.into_iter().zip([1.0, UNIT, UNIT]) {
            let (numbers, shape) = (stored(&values, width), Shape::new(rows - skipped, 1, 2).unwrap());
            prop_assert_eq!(numbers.unit(), unit);
            let lights = Array2::from_shape_fn((2, channels), |(k, c)| 1.0 + (3 * k + c) as f32 / 8.0);
            let mut out = Array2::from_elem((shape.rows(), channels), f32::NAN);
            numbers.apply_stored(2 * skipped, shape, lights.view(), out.view_mut()).unwrap();
            for ((row, c), &y) in out.indexed_iter() {
                let term = |k: usize| f64::from(numbers.stored(2 * (skipped + row) + k) * unit * lights[[k, c]]);
                let (sum, size) = (term(0) + term(1), term(0).abs() + term(1).abs());
                prop_assert!((f64::from(y) - sum).abs() <= 1e-6 * size, "{width:?}: {y} for {sum}");
            }
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
        // Nor is it finer than rounding to nine bits makes it.
        let coarse = |(vector, step): (usize, &f64)| f64::from(numbers.scale(vector)) >= step * (1.0 - 2f64.powi(-8));
        prop_assert!(steps.iter().enumerate().all(coarse));
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
fn widths_have_the_codes_of_the_format() {
    for (code, width) in WIDTHS.into_iter().enumerate() {
        assert_eq!(Width::of_code(code as u32, "header").unwrap(), width);
    }
    assert!(Width::of_code(3, "header").is_err());
}

#[test]
fn steps_that_are_none_are_as_fine_as_sixteen_bits_allow() {
    let finest = stored(&[3.0, -1.0], Width::I16);
    // From a sixteen-thousandth of the largest number on, no file could hold them.
    let large = [f32::MAX * UNIT, f32::MAX / 2.0, f32::MAX].map(f64::from);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY].into_iter().chain(large) {
        assert_eq!(Numbers::store_coarse(&[3.0, -1.0], &[step], std::iter::repeat(0)), finest, "{step}");
    }
}

#[test]
fn coarse_steps_at_either_end_of_single_precision_are_kept() {
    // The nearest step of the largest number there is can lie beyond it.
    for part in 0..256 {
        let step = 2f64.powi(113) * (1.0 + f64::from(part) / 256.0);
        let numbers = Numbers::store_coarse(&[f32::MAX, -f32::MAX], &[step], std::iter::repeat(0));
        let [upper, lower] = numbers.decode(std::iter::repeat(0))[..] else { panic!("two numbers") };
        assert!(upper.is_finite() && f64::from(f32::MAX) - f64::from(upper) < step && lower == -upper, "{step:e}");
    }
    // 3.7 of the least number there is.
    let numbers = Numbers::store_coarse(&[2f32.powi(-145)], &[3.7 * 2f64.powi(-149)], std::iter::repeat(0));
    assert_eq!((numbers.scale(0), numbers.stored(0)), (f32::from_bits(3), 5.0));
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
