//! What a user of the codec may rely on, on matrices of every kind.

mod common;

use common::{encode, identity, reloaded};
use ndarray::Array2;
use proptest::prelude::*;
use prt_bicluster::{Bicluster, BiclusterParams, Levels, Objective, Seeds};
use prt_transfer::compact::{Compact, CompactParams};
use prt_transfer::{Compressed, Configure, LightBasis, Method, Quiet, TransferMatrix};

fn rows(compressed: &Compressed) -> Vec<Vec<f32>> {
    let shape = compressed.shape();
    let mut out = vec![0.0; shape.lights];
    let row = |row| {
        compressed.row_into(row, &mut out);
        out.clone()
    };
    (0..shape.rows()).map(row).collect()
}

fn sparse(rows: &[Vec<f32>], responses: usize) -> TransferMatrix {
    let lights = rows.first().map_or(1, Vec::len);
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in rows {
        for (column, &value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            columns.push(column as u32);
            values.push(value);
        }
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, responses, LightBasis::Plain { lights }).unwrap()
}

/// Values that codecs stumble over: dyadic visibility, decimals, extremes, signs.
const VALUES: [f32; 12] = [1.0, 1.0, 1.0, 0.25, 0.5, 0.75, 0.1, -1.0, 1e30, -1e-30, f32::MIN_POSITIVE / 8.0, 3.0];

/// Random, block, banded and repeated rows in one strategy: a row starts as a window of a few patterns and is disturbed.
fn matrices() -> impl Strategy<Value = (Vec<Vec<f32>>, usize)> {
    let row = (0..6usize, 0..40usize, 0..20usize, prop::collection::vec((0..40usize, 0..VALUES.len()), 0..6));
    (prop::collection::vec(row, 0..24), 1..40usize, 1..3usize).prop_map(|(rows, lights, responses)| {
        let rows = rows.into_iter().map(|(kind, start, length, changes)| {
            let mut row = vec![0.0; lights];
            for k in start..start + length {
                let value = match kind {
                    0 => 0.0,
                    1 => VALUES[k % VALUES.len()],
                    2 => k as f32 + 0.1,
                    5 => [16_777_216.0, 16_777_218.0, 1.0][(k + length) % 3],
                    4 => 0.001 * (k % 5 + 1) as f32,
                    _ => 1.0,
                };
                row[k % lights] = value;
            }
            let changes = if kind == 3 { &[] } else { &changes[..] };
            changes.iter().for_each(|&(at, value)| row[at % lights] = VALUES[value]);
            row
        });
        let mut rows: Vec<Vec<f32>> = rows.collect();
        rows.truncate(rows.len() / responses * responses);
        (rows, responses)
    })
}

fn params() -> impl Strategy<Value = BiclusterParams> {
    let levels = prop_oneof![
        Just((Levels::All, None)),
        Just((Levels::One, None)),
        Just((Levels::One, Some(Seeds::Random))),
        Just((Levels::One, Some(Seeds::Longest))),
        Just((Levels::Two, Some(Seeds::Best))),
    ];
    (levels, any::<bool>()).prop_map(|((levels, seeds), bytes)| BiclusterParams {
        levels,
        seeds,
        objective: if bytes { Objective::Bytes } else { Objective::Flops },
        ..Default::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn every_element_comes_back_bit_for_bit((rows_in, responses) in matrices(), params in params()) {
        let matrix = sparse(&rows_in, responses);
        let compressed = encode(params, &matrix);
        prop_assert_eq!(&rows(&compressed), &rows_in);
        let reloaded = reloaded(&compressed);
        prop_assert_eq!(&rows(&reloaded), &rows_in);
        prop_assert!(reloaded.held().into_sections() == compressed.held().into_sections());
    }

    #[test]
    fn memory_never_exceeds_that_of_compact((rows_in, responses) in matrices(), params in params()) {
        let matrix = sparse(&rows_in, responses);
        let compact = Method::new(identity(), Compact::new(CompactParams::default()).unwrap());
        let limit = compact.encode(&matrix, &Quiet).unwrap();
        let compressed = encode(params, &matrix);
        prop_assert!(compressed.resident_bytes() <= limit.resident_bytes());
        let light = vec![1.0; matrix.lights()];
        prop_assert!(compressed.flops(&light).unwrap().total() <= limit.flops(&light).unwrap().total());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn an_error_bound_is_kept((rows_in, responses) in matrices(), bound in 0.0..0.3f64) {
        let matrix = sparse(&rows_in, responses);
        let decoded = rows(&reloaded(&encode(BiclusterParams { max_error: Some(bound), ..Default::default() }, &matrix)));
        let square = |x: f64| x * x;
        let error: f64 = decoded.iter().flatten().zip(rows_in.iter().flatten()).map(|(a, b)| square(f64::from(*a) - f64::from(*b))).sum();
        let energy: f64 = rows_in.iter().flatten().map(|v| square((*v).into())).sum();
        prop_assert!(error <= bound * energy, "{error} of {energy}, bound {bound}");
    }
}

/// Visibility as a curved surface sees it: a window that moves from row to row, a part of it half seen.
fn visibility(rows: usize, lights: usize) -> TransferMatrix {
    let row = |r: usize| -> Vec<f32> {
        let start = (r * 7) % (lights - 12);
        (0..lights)
            .map(|k| {
                if k < start || k > start + 11 {
                    0.0
                } else if k == start {
                    0.25
                } else {
                    1.0
                }
            })
            .collect()
    };
    sparse(&(0..rows).map(row).collect::<Vec<_>>(), 4)
}

#[test]
fn light_in_fixed_point_gives_the_same_bits_as_the_exact_sum() {
    let matrix = visibility(4000, 200);
    for levels in [Levels::One, Levels::Two, Levels::All] {
        let compressed = reloaded(&encode(BiclusterParams { levels, ..Default::default() }, &matrix));
        for channels in [1, 2, 3, 4, 5, 7] {
            // Multiples of 2^-8 below 2^6: sums of a row are exact in f32.
            let light = Array2::from_shape_fn((200, channels), |(k, c)| ((k * 37 + c * 1001) % 16384) as f32 / 256.0);
            let (mut y, mut expected) = (Array2::zeros((4000, channels)), Array2::zeros((4000, channels)));
            compressed.apply_into(light.view(), y.view_mut()).unwrap();
            matrix.apply_into(light.view(), expected.view_mut()).unwrap();
            assert_eq!(y, expected, "{channels} channels, levels={levels:?}");
        }
    }
}

#[test]
fn repeated_rows_cost_a_place_and_no_operation() {
    let once = visibility(200, 200);
    let rows: Vec<Vec<f32>> = (0..800)
        .map(|r| {
            let mut row = vec![0.0; 200];
            once.gather(r % 200, &mut row);
            row
        })
        .collect();
    let [once, repeated] = [once, sparse(&rows, 4)].map(|m| encode(BiclusterParams::default(), &m));
    let light = vec![1.0; 200];
    assert_eq!(once.flops(&light).unwrap(), repeated.flops(&light).unwrap());
    assert!(repeated.resident_bytes() <= once.resident_bytes() + 600 * 4 + 64);
}

/// What relighting holds and does is the same before and after a file, also where only some blocks have sums to share.
#[test]
fn a_file_gives_back_the_same_arrays() {
    let mut rng = 1u64;
    let mut noise = || {
        rng = rng.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (rng >> 40) as f32 + 0.5
    };
    // Windows on the first lights, all values different on the last.
    let row = |r: usize, noise: &mut dyn FnMut() -> f32| -> Vec<f32> {
        let start = r * 7 % 88;
        let inside = |k: usize| if r.is_multiple_of(3) { k >= 100 } else { (start..start + 12).contains(&k) };
        (0..120)
            .map(|k| {
                if !inside(k) {
                    0.0
                } else if r.is_multiple_of(3) {
                    noise()
                } else {
                    1.0
                }
            })
            .collect()
    };
    let matrix = sparse(&(0..12_000).map(|r| row(r, &mut noise)).collect::<Vec<_>>(), 1);
    let compressed = encode(BiclusterParams::default(), &matrix);
    let names: Vec<String> = compressed.held().sizes().map(|(name, _)| name.to_string()).collect();
    assert!(names.iter().any(|n| n == "index/rest-columns") && names.iter().any(|n| n == "index/terms"), "{names:?}");
    assert_eq!(reloaded(&compressed).held().into_sections(), compressed.held().into_sections());
}

/// Rows so long that pairs are counted strip by strip, and too random to be left with few terms.
#[test]
fn long_rows_come_back_and_give_the_same_arrays_again() {
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state >> 33
    };
    let rows: Vec<Vec<f32>> =
        (0..300).map(|_| (0..3000).map(|_| if random().is_multiple_of(2) { 1.0 } else { 0.0 }).collect()).collect();
    let compressed = encode(BiclusterParams::default(), &sparse(&rows, 1));
    assert!(compressed.held().sizes().any(|(name, _)| name == "index/slots"), "sums are shared");
    let reloaded = reloaded(&compressed);
    assert!(self::rows(&reloaded) == rows);
    assert!(reloaded.held().into_sections() == compressed.held().into_sections());
}

/// An infinite coefficient reaches the rows that contain it and no others, as IEEE arithmetic has it.
#[test]
fn infinite_light_reaches_only_the_rows_that_see_it() {
    let matrix = visibility(2000, 200);
    let mut light = Array2::ones((200, 1));
    light[[77, 0]] = f32::INFINITY;
    let mut expected = Array2::zeros((2000, 1));
    matrix.apply_into(light.view(), expected.view_mut()).unwrap();
    for levels in [Levels::One, Levels::Two, Levels::All] {
        let compressed = reloaded(&encode(BiclusterParams { levels, ..Default::default() }, &matrix));
        let mut y = Array2::zeros((2000, 1));
        compressed.apply_into(light.view(), y.view_mut()).unwrap();
        assert_eq!(y, expected, "levels={levels:?}");
    }
}

#[test]
fn a_matrix_without_repetition_is_left_to_compact() {
    let rows: Vec<Vec<f32>> = (0..50).map(|r| (0..40).map(|k| (r * 40 + k) as f32 + 0.5).collect()).collect();
    let compressed = encode(BiclusterParams::default(), &sparse(&rows, 1));
    let names: Vec<String> = compressed.sections().sizes().map(|(name, _)| name.to_string()).collect();
    assert!(!names.contains(&"index/pairs".to_string()) && !names.contains(&"index/slots".to_string()), "{names:?}");
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let refused = |params| Bicluster::new(params).err().unwrap().to_string();
    assert!(refused(BiclusterParams { max_error: Some(1.5), ..Default::default() }).contains("max_error=1.5"));
    let seeds = BiclusterParams { seeds: Some(Seeds::Random), ..Default::default() };
    assert!(refused(seeds).contains("seeds=random"));
    assert!(refused(BiclusterParams { seed: 3, ..Default::default() }).contains("seed=3"));
}
