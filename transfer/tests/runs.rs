//! What `runs` promises beyond what every exact codec does (`exact.rs`).

use ndarray::Array2;
use proptest::prelude::*;
use prt_transfer::compact::Compact;
use prt_transfer::runs::{EncodedRuns, Runs};
use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, Restore, Section, Sink, Source, TransferMatrix};

fn encoded(matrix: &TransferMatrix) -> EncodedRuns {
    Runs::new(Default::default()).unwrap().encode(matrix, &Quiet).unwrap()
}

fn sections(encoded: &dyn Encoded) -> Vec<Section> {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.into_sections()
}

fn bytes(encoded: &dyn Encoded) -> usize {
    sections(encoded).iter().map(|s| s.bytes.len()).sum()
}

fn dense(values: Vec<f32>, lights: usize) -> TransferMatrix {
    let rows = values.len() / lights;
    TransferMatrix::from_dense(values, rows, 1, LightBasis::Plain { lights }).unwrap()
}

/// Rows of runs: lengths from 1 to `longest`, a quarter of them of zeros, values from -2 to 2 in quarters.
fn matrix(longest: usize) -> impl Strategy<Value = TransferMatrix> {
    let value = prop_oneof![1 => Just(0i8), 3 => -8i8..=8];
    let row = move |lights: usize| prop::collection::vec((value.clone(), 1..=longest), lights);
    (1usize..300, 0usize..100).prop_flat_map(move |(lights, rows)| {
        prop::collection::vec(row(lights), rows).prop_map(move |rows| {
            let repeat = |&(v, n): &(i8, usize)| std::iter::repeat_n(f32::from(v) / 4.0, n);
            dense(rows.iter().flat_map(|row| row.iter().flat_map(repeat).take(lights)).collect(), lights)
        })
    })
}

/// Runs of a matrix by their value, in each row: independent of the codec's own search.
fn runs_of(matrix: &TransferMatrix) -> Vec<Vec<(f32, usize)>> {
    let mut row = vec![0f32; matrix.lights()];
    let mut runs = |r| {
        matrix.gather(r, &mut row);
        row.chunk_by(|a, b| a == b).filter(|run| run[0] != 0.0).map(|run| (run[0], run.len())).collect()
    };
    (0..matrix.rows()).map(&mut runs).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_fixed_point_light_relights_to_the_bits_of_an_exact_sum(
        matrix in matrix(30), channels in 1usize..=4, seed in any::<u32>(),
    ) {
        // Ten bits of light, four of a value, nine of a row: sums stay below 2²⁴ steps.
        let coefficient = |k: usize, c: usize| (k as u32 * 5 + c as u32 + 1).wrapping_mul(seed | 1) >> 22;
        let lights = Array2::from_shape_fn((matrix.lights(), channels), |(k, c)| coefficient(k, c) as f32 / 256.0);
        let mut out = Array2::zeros((matrix.rows(), channels));
        encoded(&matrix).apply_into(lights.view(), out.view_mut()).unwrap();
        for ((r, c), &y) in out.indexed_iter() {
            let product = |(k, v): (usize, f32)| i64::from(coefficient(k, c)) * (4.0 * v) as i64;
            let exact: i64 = matrix.row(r).non_zeros().map(product).sum();
            prop_assert_eq!(y, (exact as f64 / 1024.0) as f32, "row {}, channel {}", r, c);
        }
    }

    #[test]
    fn flops_are_the_closed_formula_and_the_bytes_never_more_than_those_of_compact(matrix in matrix(8)) {
        let encoded = encoded(&matrix);
        let compact = Compact::new(Default::default()).unwrap().encode(&matrix, &Quiet).unwrap();
        prop_assert!(bytes(&encoded) <= bytes(&compact) + 20, "{} > {}", bytes(&encoded), bytes(&compact));
        let flops = encoded.flops(&vec![1.0; matrix.lights()]);
        if sections(&encoded).iter().all(|s| s.name != "header/runs") {
            prop_assert_eq!(flops, compact.flops(&vec![1.0; matrix.lights()]));
            return Ok(());
        }
        let (mut products, mut ones, mut long) = (0, 0, 0);
        for row in runs_of(&matrix) {
            let (singles, runs): (Vec<_>, Vec<_>) = row.into_iter().partition(|run| run.1 == 1);
            let mut values: Vec<f32> = runs.iter().map(|run| run.0).collect();
            values.sort_by(f32::total_cmp);
            values.dedup();
            long += runs.len() as u64;
            values.extend(singles.iter().map(|run| run.0));
            products += values.len() as u64;
            ones += values.iter().filter(|v| v.abs() == 1.0).count() as u64;
        }
        prop_assert_eq!(flops.multiplications, products);
        prop_assert_eq!(flops.additions, products + 2 * long + matrix.lights() as u64);
        prop_assert_eq!(flops.by_one, ones);
    }

    #[test]
    fn an_infinite_coefficient_reaches_only_the_rows_that_have_its_column(matrix in matrix(12), at in any::<prop::sample::Index>()) {
        let (at, encoded) = (at.index(matrix.lights()), encoded(&matrix));
        // A matrix that is smaller in full is multiplied in full, as by `dense`.
        prop_assume!(sections(&encoded).iter().any(|s| s.name.starts_with("index/")));
        for channels in [1, 3] {
            let lights = Array2::from_shape_fn((matrix.lights(), channels), |(k, _)| if k == at { f32::INFINITY } else { 1.0 });
            let mut out = Array2::zeros((matrix.rows(), channels));
            encoded.apply_into(lights.view(), out.view_mut()).unwrap();
            for r in 0..matrix.rows() {
                let value = matrix.row(r).non_zeros().find(|e| e.0 == at).map_or(0.0, |e| e.1);
                let sum: f32 = matrix.row(r).non_zeros().map(|e| e.1).sum();
                // Quarters add up without rounding.
                let expected = if value == 0.0 { sum } else { value * f32::INFINITY };
                prop_assert!(out.row(r).iter().all(|&y| y == expected), "row {}: {} for {}", r, out.row(r), expected);
            }
        }
    }
}

#[test]
fn a_run_costs_the_same_however_long_it_is() {
    for (lights, length) in [(300, 3), (300, 299), (70_000, 69_999)] {
        let row = |r: usize| (0..lights).map(move |k| if (r % 2..r % 2 + length).contains(&k) { 0.7 } else { 0.0 });
        let encoded = encoded(&dense((0..20).flat_map(row).collect(), lights));
        let flops = encoded.flops(&vec![1.0; lights]);
        assert_eq!((flops.multiplications, flops.additions), (20, 20 + 40 + lights as u64));
        assert!(bytes(&encoded) < 20 * 12 + 80, "{} bytes", bytes(&encoded));
    }
}

#[test]
fn runs_that_share_a_column_or_leave_the_lights_are_refused() {
    // Columns 2 … 5 twice a row, and 9 alone.
    let row = |r: usize| {
        (0..20).map(move |k| if (2..6).contains(&k) || k == 9 || (12..15).contains(&k) { 1.0 + r as f32 } else { 0.0 })
    };
    let matrix = dense((0..100).flat_map(row).collect(), 20);
    let good = sections(&encoded(&matrix));
    let refusal = |name: &str, at: usize, byte: u8| {
        let mut sections = good.clone();
        sections.iter_mut().find(|s| s.name == name).unwrap().bytes[at] = byte;
        EncodedRuns::read(matrix.shape(), &mut Source::new(sections).unwrap()).err().map(|e| e.to_string())
    };
    assert!(refusal("index/run_starts", 1, 12).is_none(), "what was there");
    for (name, at, byte) in [
        ("index/run_starts", 1, 5),
        ("index/run_starts", 1, 9),
        ("index/run_starts", 1, 18),
        ("index/run_lengths", 0, 0),
        ("index/run_lengths", 0, 8),
        ("index/run_counts", 0, 0),
        ("index/run_counts", 0, 255),
        ("index/run_rows", 0, 1),
        ("index/run_rows", 99, 36),
        ("index/run_blocks", 0, 1),
        ("index/run_blocks", 16, 101),
        ("index/run_blocks", 24, 127),
    ] {
        let message = refusal(name, at, byte).unwrap_or_else(|| panic!("{name} {at} = {byte} passed"));
        assert!(message.contains("index/run_"), "{message}");
    }
}
