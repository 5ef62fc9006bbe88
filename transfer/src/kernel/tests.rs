use super::*;
use half::f16;
use proptest::prelude::*;
use proptest::sample::SizeRange;

/// Ends of rows, and for each element a column below 256 and a code of a value.
fn rows(rows: impl Into<SizeRange>) -> impl Strategy<Value = (Vec<u32>, Vec<u8>, Vec<u8>)> {
    let row = prop::collection::vec((any::<u8>(), any::<u8>()), 0..40);
    prop::collection::vec(row, rows).prop_map(|rows| {
        let mut end = 0;
        let ends = rows.iter().map(|r| {
            end += r.len() as u32;
            end
        });
        (ends.collect(), rows.iter().flatten().map(|e| e.0).collect(), rows.iter().flatten().map(|e| e.1).collect())
    })
}

fn light<const N: usize>() -> Vec<[f32; N]> {
    (0..256).map(|k| std::array::from_fn(|c| ((k * 37 + c * 11) % 101) as f32 / 50.0 - 1.0)).collect()
}

/// Every value of the rows' elements, once more behind them so that the vector kernel reaches the last row.
fn check<const N: usize, I: Column, V: Stored>(ends: &[u32], columns: &[I], values: V) {
    let x = light::<N>();
    let (mut fast, mut plain) = (vec![[9.0; N]; ends.len()], vec![[9.0; N]; ends.len()]);
    // SAFETY: columns are below 256 = x.len(), ends ascend to columns.len() or less.
    unsafe {
        rows_of(ends, columns, values, &x, &mut fast);
        sparse::portable(ends, columns, values, &x, &mut plain);
    }
    let mut start = 0;
    for ((fast, plain), &end) in fast.iter().zip(&plain).zip(ends) {
        for c in 0..N {
            let terms =
                (start..end as usize).map(|i| unsafe { values.at(i) } as f64 * f64::from(x[columns[i].at()][c]));
            let (sum, size) = terms.fold((0.0, 0.0), |(s, a), t| (s + t, a + t.abs()));
            assert!((f64::from(fast[c]) - sum).abs() <= 3e-6 * size, "{} for {sum}", fast[c]);
            assert!((f64::from(plain[c]) - sum).abs() <= 3e-6 * size, "{} for {sum}", plain[c]);
        }
        start = end as usize;
    }
}

fn check_widths<const N: usize, V: Stored>(ends: &[u32], columns: &[u8], values: V) {
    check::<N, u8, V>(ends, columns, values);
    check::<N, u16, V>(ends, &columns.iter().map(|&c| c.into()).collect::<Vec<u16>>(), values);
    check::<N, u32, V>(ends, &columns.iter().map(|&c| c.into()).collect::<Vec<u32>>(), values);
}

fn check_forms<const N: usize>(ends: &[u32], columns: &[u8], codes: &[u8]) {
    let numbers: Vec<f32> = codes.iter().map(|&c| f32::from(c) * 0.37 - 20.0).collect();
    check_widths::<N, _>(ends, columns, Plain(&numbers));
    let halves: Vec<f16> = numbers.iter().map(|&v| f16::from_f32(v)).collect();
    check_widths::<N, _>(ends, columns, Half { halves: &halves, scale: 0.5 });
    check_widths::<N, _>(ends, columns, Integer { codes, scale: 0.25 });
    let signed: Vec<i8> = codes.iter().map(|&c| c as i8).collect();
    check_widths::<N, _>(ends, columns, Integer { codes: &signed, scale: 2.0 });
    let words: Vec<u16> = codes.iter().map(|&c| u16::from(c) * 257).collect();
    check_widths::<N, _>(ends, columns, Integer { codes: &words, scale: 1.0 });
    let signed: Vec<i16> = words.iter().map(|&c| c as i16).collect();
    check_widths::<N, _>(ends, columns, Integer { codes: &signed, scale: 0.125 });
    let table: Vec<f32> = (0..256).map(|i| (i as f32).sin()).collect();
    check_widths::<N, _>(ends, columns, Dictionary { codes, table: &table });
    let words: Vec<u16> = codes.iter().map(|&c| c.into()).collect();
    check_widths::<N, _>(ends, columns, Dictionary { codes: &words, table: &table });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn vector_and_portable_sparse_products_are_the_sums_in_every_form((ends, columns, codes) in rows(0..=BLOCK_ROWS)) {
        check_forms::<1>(&ends, &columns, &codes);
        check_forms::<4>(&ends, &columns, &codes);
        // With elements behind the last row the vector kernel takes the whole block.
        let more = |v: &[u8]| [v, &[255; 8]].concat();
        check_forms::<1>(&ends, &more(&columns), &more(&codes));
        check_forms::<4>(&ends, &more(&columns), &more(&codes));
    }

    #[test]
    fn vector_and_portable_dense_products_agree(values in prop::collection::vec(-1f32..1., 4 * 41), lights in 0usize..=41) {
        let x: Vec<f32> = (0..4 * lights).map(|k| (k as f32).cos()).collect();
        let v = Plain(&values);
        let (fast, plain) = (dense::product::<4, 4, _>(v, lights, &x), dense::portable::<4, 4, _>(v, lights, &x));
        let difference = fast.iter().zip(&plain).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs());
        prop_assert!(difference.fold(0.0, f32::max) <= 1e-5);
    }
}

/// Intervals from the columns and codes of [`rows`], the vector kernel beside the portable one and the sums themselves.
fn check_intervals<const N: usize>(ends: &[u32], columns: &[u8], codes: &[u8]) {
    // Every kind of width; the lengths of groups are at least 1.
    let starts: Vec<u16> = columns.iter().map(|&c| c.into()).collect();
    let lengths: Vec<u32> = codes.iter().map(|&c| c.into()).collect();
    let prefix: Vec<[f64; N]> = (0..512).map(|k| std::array::from_fn(|c| f64::from(k * k + c as i32))).collect();
    let (mut fast, mut plain) = (vec![[9.0; N]; ends.len()], vec![[9.0; N]; ends.len()]);
    // SAFETY: columns and codes are below 256, their sum below 512.
    unsafe {
        interval_sums(ends, &starts, &lengths, &prefix, &mut fast);
        intervals::portable(ends, columns, codes, &prefix, &mut plain);
    }
    assert_eq!(fast, plain);
    let mut start = 0;
    for (sum, &end) in plain.iter().zip(ends) {
        let term = |i: usize| i64::from(codes[i]) * (2 * i64::from(columns[i]) + i64::from(codes[i]));
        assert_eq!(*sum, [(start..end as usize).map(term).sum::<i64>() as f64; N]);
        start = end as usize;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn vector_and_portable_sums_of_intervals_are_the_sums((mut ends, columns, codes) in rows(0..=BLOCK_ROWS)) {
        ends.dedup();
        ends.retain(|&end| end > 0);
        check_intervals::<1>(&ends, &columns, &codes);
        check_intervals::<4>(&ends, &columns, &codes);
        let more = |v: &[u8]| [v, &[255; 4]].concat();
        check_intervals::<1>(&ends, &more(&columns), &more(&codes));
        check_intervals::<4>(&ends, &more(&columns), &more(&codes));
    }
}

#[test]
fn an_infinite_coefficient_reaches_only_the_rows_that_have_its_column() {
    struct Rows(Vec<u32>, Vec<u16>, Vec<f32>);
    impl RowKernel for Rows {
        fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], _: &mut C) -> [f32; N] {
            let range = if row == 0 { 0 } else { self.0[row - 1] as usize }..self.0[row] as usize;
            // SAFETY: columns are below 2 = x.len().
            unsafe { sparse_dot(&self.1[range.clone()], &self.2[range], x) }
        }
        fn block<const N: usize>(&self, _: usize, x: &[[f32; N]], out: &mut [[f32; N]]) {
            // SAFETY: columns are below 2 = x.len().
            unsafe { sparse_rows(&self.0, &self.1, &self.2, x, out) }
        }
    }
    // Eight elements more than the rows have, so that the vector kernel takes them.
    let rows = Rows((1..=20).collect(), (0..28).map(|r| r % 2).collect(), vec![1.0; 28]);
    let shape = Shape::new(20, 1, 2).unwrap();
    for channels in [1, 3] {
        let lights = ndarray::Array2::from_shape_fn((2, channels), |(k, _)| [3.0, f32::INFINITY][k]);
        let mut out = ndarray::Array2::zeros((20, channels));
        apply(&rows, shape, lights.view(), out.view_mut()).unwrap();
        assert!(out.indexed_iter().all(|((r, _), &y)| y == lights[[r % 2, 0]]), "{out}");
    }
}

#[test]
fn every_row_and_channel_is_multiplied_once_however_many_there_are() {
    /// Row r has one element, r + 1, in column r mod 5.
    struct Diagonal;
    impl RowKernel for Diagonal {
        fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], _: &mut C) -> [f32; N] {
            x[row % 5].map(|x| (row + 1) as f32 * x)
        }
    }
    for (rows, channels) in [(0, 1), (1, 2), (64, 3), (513, 4), (1300, 1), (1300, 9)] {
        let lights = ndarray::Array2::from_shape_fn((5, channels), |(k, c)| (k * 10 + c) as f32);
        let mut out = ndarray::Array2::from_elem((rows, channels), f32::NAN);
        apply(&Diagonal, Shape::new(rows, 1, 5).unwrap(), lights.view(), out.view_mut()).unwrap();
        assert!(out.indexed_iter().all(|((r, c), &y)| y == ((r + 1) * (r % 5 * 10 + c)) as f32), "{rows} x {channels}");
    }
}

#[test]
fn dense_products_of_many_rows_are_the_sums_in_every_form() {
    // One task, several of one group of rows each, several of many with a rest; few and many lights.
    for (rows, lights, channels) in [(3, 0, 1), (7, 5, 2), (9, 70_000, 3), (301, 1000, 4), (9001, 3, 6)] {
        let value = |i: usize| f64::from((i * 37 + i / 91 * 11) as u16 % 101) / 4.0 - 12.0;
        let codes: Vec<i16> = (0..rows * lights).map(|i| (4.0 * value(i)) as i16).collect();
        let halves: Vec<f16> = codes.iter().map(|&c| f16::from_f32(c.into())).collect();
        let values: Vec<f32> = codes.iter().map(|&c| f32::from(c) / 4.0).collect();
        let light = ndarray::Array2::from_shape_fn((lights, channels), |(k, c)| ((k * 13 + c) % 29) as f32 - 14.0);
        let shape = Shape::new(rows, 1, lights).unwrap();
        let apply = |form: usize| {
            let mut out = ndarray::Array2::from_elem((rows, channels), f32::NAN);
            match form {
                0 => dense::apply(&values, shape, light.view(), out.view_mut()),
                1 => dense::apply_halves(&halves, 0.25, shape, light.view(), out.view_mut()),
                _ => dense::apply_integers(&codes, 0.25, shape, light.view(), out.view_mut()),
            }
            .unwrap();
            out
        };
        let wide = ndarray::Array2::from_shape_fn((rows, lights), |(r, k)| f64::from(values[r * lights + k]));
        let (sums, sizes) =
            (wide.dot(&light.mapv(f64::from)), wide.mapv(f64::abs).dot(&light.mapv(|x| f64::from(x.abs()))));
        for (form, out) in (0..3).map(|form| (form, apply(form))) {
            let within = out
                .iter()
                .zip(sums.iter().zip(&sizes))
                .all(|(&y, (sum, size))| (f64::from(y) - sum).abs() <= 1e-6 * size);
            assert!(within, "form {form}: {rows} x {lights} x {channels}");
        }
    }
}
