//! The promises of truncation: the least possible error, bounds that hold after decoding, one result on any number of threads.

use ndarray::Array2;
use proptest::prelude::*;
use prt_transfer::method::transform_rows;
use prt_transfer::transform::Identity;
use prt_transfer::{Compressed, Configure, Error, Flops, LightBasis, Quiet, Registry, TransferMatrix, Transform};
use prt_wavelet::{Haar, HaarParams, Truncate};

fn registry() -> Registry {
    Registry::new().transform::<Identity>().transform::<Haar>().codec::<Truncate>()
}

fn encode(label: &str, matrix: &TransferMatrix) -> Result<Compressed, Error> {
    registry().method(&label.parse()?)?.encode(matrix, &Quiet)
}

fn dense(values: &[f32], rows: usize) -> TransferMatrix {
    let lights = values.len() / rows.max(1);
    TransferMatrix::from_dense(values.to_vec(), rows, 1, LightBasis::Plain { lights }).unwrap()
}

fn decode(compressed: &Compressed) -> Vec<f32> {
    let shape = compressed.shape();
    let mut values = vec![f32::NAN; shape.rows() * shape.lights];
    (0..shape.rows()).for_each(|row| compressed.row_into(row, &mut values[row * shape.lights..][..shape.lights]));
    values
}

fn energy(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v).powi(2)).sum()
}

fn squared_error(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
}

/// Squares, largest first.
fn squares(values: &[f32]) -> Vec<f64> {
    let mut squares: Vec<f64> = values.iter().map(|&v| f64::from(v).powi(2)).collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    squares
}

fn kept(values: &[f32]) -> usize {
    values.iter().filter(|v| **v != 0.0).count()
}

/// A smooth row, a checkered one, a bright texel and so on, over a cubemap.
fn cubemap_rows(rows: usize, resolution: usize) -> TransferMatrix {
    let lights = 6 * resolution * resolution;
    let value = |i: usize| {
        let (row, k) = (i / lights, i % lights);
        let smooth = ((k as f32 * 0.01 + row as f32).sin() + 1.0) * 0.3;
        let edge = if (k / (row + 3)) % 5 < 2 { 0.0 } else { 1.0 };
        smooth * edge + if k == 7 * row { 20.0 } else { 0.0 }
    };
    TransferMatrix::from_dense((0..rows * lights).map(value).collect(), rows, 1, LightBasis::Cubemap { resolution })
        .unwrap()
}

/// A small matrix with many equal magnitudes and zeros, as visibility has, or of any numbers.
fn matrices() -> impl Strategy<Value = (usize, Vec<f32>)> {
    let steps = (-4i8..=4).prop_map(|v| f32::from(v) / 4.0).boxed();
    let numbers = prop_oneof![Just(0f32), -1e3f32..1e3, -1e-3f32..1e-3].boxed();
    (1usize..7, 1usize..30, prop_oneof![Just(steps), Just(numbers)])
        .prop_flat_map(|(rows, lights, value)| (Just(rows), prop::collection::vec(value, rows * lights)))
}

#[test]
fn dropped_energy_is_the_error_and_no_choice_of_so_many_terms_has_less() {
    let matrix = cubemap_rows(5, 16);
    let lights = matrix.lights();
    let coefficients = decode(&encode("haar+truncate:terms=0", &matrix).unwrap());
    assert!(squared_error(&coefficients, matrix.as_dense().unwrap()) < 1e-9 * energy(&coefficients));
    let haar = Haar::new(HaarParams::default()).unwrap().bind(matrix.basis()).unwrap();
    let haar = transform_rows(&matrix, &haar, &Quiet).unwrap();
    for terms in [1, 64, 300] {
        let compressed = encode(&format!("haar+truncate:terms={terms}"), &matrix).unwrap();
        let error = squared_error(&decode(&compressed), matrix.as_dense().unwrap());
        let rows = haar.as_dense().unwrap().chunks(lights);
        let least: f64 = rows.map(|row| squares(row)[terms..].iter().sum::<f64>()).sum();
        assert!((error - least).abs() < 1e-5 * least, "{terms}: {error} {least}");
    }
}

#[test]
fn no_subset_of_a_row_is_better() {
    let row = [3.0f32, -1.0, 0.5, 2.0, -2.5, 0.25, 1.5, -0.75];
    for terms in 1..=8u32 {
        let error = squared_error(&row, &decode(&encode(&format!("truncate:terms={terms}"), &dense(&row, 1)).unwrap()));
        let dropped = |set: u32| (0..8).filter(|i| set >> i & 1 == 0).map(|i| f64::from(row[i]).powi(2)).sum::<f64>();
        let best = (0..256u32).filter(|set| set.count_ones() == terms).map(dropped).fold(f64::MAX, f64::min);
        assert_eq!(error, best);
    }
}

proptest! {
    #[test]
    fn an_error_bound_holds_and_is_met_with_the_fewest_coefficients((rows, values) in matrices(), bound in 0f64..0.7) {
        let matrix = dense(&values, rows);
        let decoded = decode(&encode(&format!("truncate:max_error={bound}"), &matrix).unwrap());
        let limit = bound * energy(&values);
        prop_assert!(squared_error(&values, &decoded) <= limit);
        let squares = squares(&values);
        // The last millionth of the bound is left unused.
        let rest = |kept: usize| squares[kept..].iter().sum::<f64>();
        let fewest = (0..=squares.len()).find(|&k| rest(k) <= limit * (1.0 - 2e-6)).unwrap();
        prop_assert!(kept(&decoded) <= fewest, "{} {}", kept(&decoded), fewest);
    }

    #[test]
    fn an_error_bound_holds_with_rounded_values_or_is_refused((rows, values) in matrices(), bound in -9f64..0.0, bits in prop_oneof![Just(8), Just(16)]) {
        let bound = 10f64.powf(bound);
        match encode(&format!("truncate:max_error={bound}:bits={bits}"), &dense(&values, rows)) {
            Ok(compressed) => {
                prop_assert!(squared_error(&values, &decode(&compressed)) <= bound * energy(&values));
            }
            Err(Error::Parameter { .. }) => {
                let all = decode(&encode(&format!("truncate:terms=0:bits={bits}"), &dense(&values, rows)).unwrap());
                prop_assert!(squared_error(&values, &all) > 0.99 * bound * energy(&values));
            }
            Err(e) => prop_assert!(false, "{}", e),
        }
    }

    #[test]
    fn each_row_keeps_its_share_of_energy_with_the_fewest_coefficients((rows, values) in matrices(), share in 0.01f64..=1.0, most in 1usize..40) {
        let decoded = decode(&encode(&format!("truncate:energy={share}:terms={most}"), &dense(&values, rows)).unwrap());
        let lights = values.len() / rows;
        for (row, decoded) in values.chunks(lights).zip(decoded.chunks(lights)) {
            let (squares, total) = (squares(row), energy(row));
            let rest = |kept: usize| squares[kept..].iter().sum::<f64>();
            let within = |slack: f64| (0..=lights).find(|&k| rest(k) <= (1.0 - share) * total + slack * total).unwrap();
            let range = within(1e-12).min(most)..=within(-1e-12 * (1.0 - share)).min(most);
            prop_assert!(range.contains(&kept(decoded)), "{:?} {}", range, kept(decoded));
        }
    }

    #[test]
    fn kept_values_are_exact_or_within_half_a_step((rows, values) in matrices(), bits in prop_oneof![Just(8), Just(16), Just(32)]) {
        let decoded = decode(&encode(&format!("truncate:terms=0:bits={bits}"), &dense(&values, rows)).unwrap());
        let lights = values.len() / rows;
        for (row, decoded) in values.chunks(lights).zip(decoded.chunks(lights)) {
            let largest = row.iter().fold(0f32, |m, v| m.max(v.abs()));
            let step = if bits == 32 { 0.0 } else { largest / ((1 << (bits - 1)) - 1) as f32 };
            for (a, b) in row.iter().zip(decoded) {
                // A step times a whole number is rounded to f32, which of 16 bits is a visible part of a step.
                prop_assert!((a - b).abs() <= 0.5 * step + 2.0 * f32::EPSILON * a.abs(), "{} {} {}", a, b, step);
            }
        }
    }
}

/// Magnitudes of 0.01 to 1, most of them small, some of the smallest equal, none of which 8 bits round to zero.
fn many_rows() -> Vec<f32> {
    let signs = [1.0, -1.0, -1.0];
    (0..1100 * 7).map(|i| signs[i % 3] * (0.01 + 0.99 * (((i * 3571) % 7700) as f32 / 7700.0).powi(3))).collect()
}

#[test]
fn the_fewest_of_many_rows_keep_a_bound_with_what_rounding_costs() {
    let values = many_rows();
    let matrix = dense(&values, 1100);
    for bits in [8, 16, 32] {
        let all = decode(&encode(&format!("truncate:terms=0:bits={bits}"), &matrix).unwrap());
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[b].abs().total_cmp(&values[a].abs()));
        // errors[k]: of keeping the k largest.
        let mut errors = vec![energy(&values)];
        for i in order {
            let (square, rounded) = (f64::from(values[i]).powi(2), (f64::from(all[i]) - f64::from(values[i])).powi(2));
            errors.push(errors.last().unwrap() - square + rounded);
        }
        for bound in [1e-3, 0.1, 0.5] {
            let limit = bound * energy(&values);
            let decoded = decode(&encode(&format!("truncate:max_error={bound}:bits={bits}"), &matrix).unwrap());
            let fewest = |limit: f64| errors.iter().position(|&error| error <= limit).unwrap();
            let range = fewest(limit)..=fewest(limit * (1.0 - 2e-6));
            assert!(range.contains(&kept(&decoded)), "{bits} bits, {bound}: {} of {range:?}", kept(&decoded));
            assert!(squared_error(&values, &decoded) <= limit);
        }
    }
}

#[test]
fn the_least_bound_that_is_told_is_one_that_can_be_kept() {
    let matrix = dense(&many_rows(), 1100);
    let refusal = |bound: f64| {
        encode(&format!("truncate:max_error={bound}:bits=8"), &matrix).map(|_| ()).map_err(|e| e.to_string())
    };
    let told = refusal(1e-9).unwrap_err();
    let least: f64 = told.split("at least ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    assert_eq!(refusal(least * (1.0 + 1e-9)), Ok(()), "{told}");
    assert!(refusal(least * (1.0 - 1e-9)).is_err(), "{told}");
}

#[test]
fn three_million_equal_elements_do_not_exceed_a_bound_by_one() {
    let decoded = decode(&encode("truncate:max_error=0.5", &dense(&vec![1.0; 3_000_000], 2000)).unwrap());
    assert!((1_500_000..=1_500_002).contains(&kept(&decoded)), "{}", kept(&decoded));
}

#[test]
fn ties_are_dropped_evenly_over_the_rows() {
    let decoded = decode(&encode("truncate:max_error=0.501", &dense(&[1.0; 400], 20)).unwrap());
    assert_eq!(kept(&decoded), 200);
    assert!(decoded.chunks(20).all(|row| kept(row) == 10));
}

#[test]
fn relighting_is_decoded_rows_times_light_in_every_layout() {
    // 2,500 rows are more than two blocks of columns, and no multiple of a task's rows.
    let values: Vec<f32> = (0..2500 * 40u64).map(|i| (i * i % 251) as f32 / 125.0 - 1.0).collect();
    let matrix = dense(&values, 2500);
    for layout in ["", ":order=columns", ":bits=16", ":bits=16:order=columns", ":bits=8", ":bits=8:order=columns"] {
        let compressed = encode(&format!("truncate:terms=11{layout}"), &matrix).unwrap();
        let decoded = dense(&decode(&compressed), 2500);
        assert!(kept(decoded.as_dense().unwrap()) > 2400 * 10);
        for channels in [0, 1, 2, 3, 5, 9] {
            let light = Array2::from_shape_fn((40, channels), |(k, c)| ((k * 7 + c) % 5) as f32 - 1.0);
            let (mut y, mut expected) = (Array2::zeros((2500, channels)), Array2::zeros((2500, channels)));
            compressed.apply_into(light.view(), y.view_mut()).unwrap();
            decoded.apply_into(light.view(), expected.view_mut()).unwrap();
            y.iter().zip(&expected).for_each(|(a, b)| assert!((a - b).abs() < 2e-5, "{layout}: {a} {b}"));
        }
        let (light, mut y) = (Array2::zeros((41, 1)), Array2::zeros((2500, 1)));
        assert!(matches!(compressed.apply_into(light.view(), y.view_mut()), Err(Error::Shape { .. })));
    }
}

#[test]
fn operations_equal_the_closed_formula_and_columns_skip_dark_lights() {
    let matrix = cubemap_rows(1500, 4);
    let lights = matrix.lights();
    let light: Vec<f32> = (0..lights).map(|k| if k % 3 == 0 { 0.5 } else { 0.0 }).collect();
    for (bits, scales) in [(32, 0), (16, 1500)] {
        let label = |order| format!("truncate:terms=20:bits={bits}:order={order}");
        let (rows, columns) = (encode(&label("rows"), &matrix).unwrap(), encode(&label("columns"), &matrix).unwrap());
        let decoded = decode(&rows);
        assert_eq!(decoded, decode(&columns));
        let stored = decoded.iter().filter(|v| **v != 0.0).count() as u64;
        let lit =
            decoded.iter().enumerate().filter(|(i, v)| **v != 0.0 && (i % lights).is_multiple_of(3)).count() as u64;
        let expected = |n: u64, flops: Flops| Flops { multiplications: n + scales, additions: n, ..flops };
        let (a, b) = (rows.flops(&light).unwrap(), columns.flops(&light).unwrap());
        assert_eq!((a, b), (expected(stored, a), expected(lit, b)));
        assert!(lit < stored / 2);
    }
}

#[test]
fn threads_do_not_change_bytes() {
    let matrix = cubemap_rows(600, 8);
    for label in ["haar+truncate:terms=9", "haar+truncate:max_error=1e-2:order=columns", "truncate:energy=0.9:bits=8"] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| encode(label, &matrix).unwrap().sections().into_sections())
        };
        assert_eq!(on(1), on(4), "{label}");
    }
}

#[test]
fn sparse_and_dense_matrices_encode_alike() {
    let values: Vec<f32> = (0..90).map(|i| if i % 4 == 0 { (i % 11) as f32 - 5.0 } else { 0.0 }).collect();
    let matrix = dense(&values, 9);
    let (mut offsets, mut columns, mut elements) = (vec![0], Vec::new(), Vec::new());
    for row in 0..9 {
        matrix.row(row).non_zeros().for_each(|(c, v)| {
            columns.push(c as u32);
            elements.push(v);
        });
        offsets.push(columns.len());
    }
    let sparse = TransferMatrix::from_csr(offsets, columns, elements, 1, matrix.basis().clone()).unwrap();
    for label in ["truncate:terms=2", "truncate:energy=0.8", "truncate:max_error=0.1:order=columns"] {
        let sections = |m: &TransferMatrix| encode(label, m).unwrap().sections().into_sections();
        assert_eq!(sections(&matrix), sections(&sparse), "{label}");
    }
}

#[test]
fn parameters_that_contradict_each_other_are_refused_and_labels_read_back() {
    for label in
        ["truncate", "truncate:terms=64", "truncate:terms=0", "truncate:terms=5:energy=0.5", "truncate:max_error=0"]
    {
        let method = registry().method(&label.parse().unwrap()).unwrap();
        assert_eq!(method.label().to_string(), label);
    }
    let none = registry().method(&"truncate:terms=none:bits=32:order=rows".parse().unwrap()).unwrap();
    assert_eq!(none.label().to_string(), "truncate");
    for params in [
        "energy=0",
        "energy=1.1",
        "max_error=-1",
        "max_error=2",
        "bits=7",
        "max_error=0.1:terms=3",
        "max_error=0.1:energy=1",
    ] {
        let result = registry().method(&format!("truncate:{params}").parse().unwrap());
        assert!(matches!(result, Err(Error::Parameter { .. })), "{params}");
    }
}

#[test]
fn the_default_is_64_terms_and_a_bound_replaces_it() {
    let matrix = dense(&[1.0; 200], 1);
    assert_eq!(kept(&decode(&encode("truncate", &matrix).unwrap())), 64);
    assert_eq!(kept(&decode(&encode("truncate:energy=0.75", &matrix).unwrap())), 150);
    assert_eq!(kept(&decode(&encode("truncate:max_error=0", &matrix).unwrap())), 200);
}
