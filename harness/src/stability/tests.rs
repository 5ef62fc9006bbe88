//! What the matrices of the sweeps and their outcomes promise.

use super::columns::spread_lights;
use super::scatter::scattered;
use super::values::quantised;
use super::vertices::first_samples;
use super::*;
use crate::compute;
use crate::fingerprint;
use crate::signal::{Signal, Spec};
use prt_transfer::LightBasis;
use prt_transfer::Quiet;

fn base() -> TransferMatrix {
    let spec = Spec { local_directions: 4, ..Spec::new(Signal::Biscale, LightBasis::Cubemap { resolution: 16 }) };
    compute::precompute("blob", Some(60), &spec, &Quiet).unwrap().matrix
}

fn row(matrix: &TransferMatrix, row: usize) -> Vec<(usize, f32)> {
    matrix.row(row).non_zeros().collect()
}

fn columns_of(matrix: &TransferMatrix, of: usize) -> Vec<usize> {
    row(matrix, of).into_iter().map(|(col, _)| col).collect()
}

fn values_of(matrix: &TransferMatrix, of: usize) -> Vec<f32> {
    let mut values: Vec<f32> = row(matrix, of).into_iter().map(|(_, value)| value).collect();
    values.sort_by(f32::total_cmp);
    values
}

#[test]
fn a_quantised_field_has_its_levels_on_the_same_pattern_and_changes_slowly() {
    let base = base();
    for levels in [2usize, 4, 64, 4096] {
        let matrix = quantised(&base, levels).unwrap();
        assert!((0..base.rows()).all(|r| columns_of(&matrix, r) == columns_of(&base, r)));
        // All levels where there are few, most of them where there are about as many as elements.
        let found = distinct(&matrix);
        assert!(found <= levels && found >= if levels <= 64 { levels } else { levels / 2 }, "{found} of {levels}");
        // Neighbours in a row differ by at most the slope of the field, 3π/2 a row, and a level.
        let most = 4.72 / base.lights() as f32 + 1.01 / levels as f32;
        for r in 0..base.rows() {
            let steps = row(&matrix, r);
            let near = steps.windows(2).filter(|w| w[1].0 == w[0].0 + 1);
            assert!(near.clone().all(|w| (w[1].1 - w[0].1).abs() <= most), "{levels}");
        }
    }
}

#[test]
fn scattering_keeps_every_row_s_values_and_moves_what_it_says() {
    let base = base();
    let moved = |fraction: f64| {
        let matrix = scattered(&base, fraction).unwrap();
        let stayed = |r: usize| columns_of(&matrix, r).iter().filter(|c| columns_of(&base, r).contains(c)).count();
        assert!((0..base.rows()).all(|r| values_of(&matrix, r) == values_of(&base, r)));
        1.0 - (0..base.rows()).map(stayed).sum::<usize>() as f64 / base.non_zeros() as f64
    };
    assert_eq!(moved(0.0), 0.0);
    // Some land where there was an element before.
    assert!((0.15..0.21).contains(&moved(0.2)) && moved(1.0) > 0.8, "{} {}", moved(0.2), moved(1.0));
    let twice = [0, 1].map(|_| fingerprint::matrix(&scattered(&base, 0.5).unwrap()));
    assert_eq!(twice[0], twice[1]);
    // A full row has nowhere to go.
    let full = TransferMatrix::from_dense(vec![1.0, 2.0, 3.0], 1, 1, LightBasis::Plain { lights: 3 }).unwrap();
    assert_eq!(row(&scattered(&full, 1.0).unwrap(), 0), row(&full, 0));
}

#[test]
fn fewer_vertices_and_fewer_columns_are_parts_of_the_matrix() {
    let base = base();
    let part = first_samples(&base, 3).unwrap();
    assert_eq!((part.shape().samples, part.shape().responses), (3, 16));
    assert!((0..part.rows()).all(|r| row(&part, r) == row(&base, r)));
    let (mut whole, mut kept) = (vec![0f32; base.lights()], vec![0f32; 8]);
    let part = spread_lights(&base, 8).unwrap();
    let step = base.lights() / 8;
    for r in 0..base.rows() {
        base.gather(r, &mut whole);
        part.gather(r, &mut kept);
        assert!(kept.iter().enumerate().all(|(k, value)| *value == whole[k * step + step / 2]));
    }
    for all in [first_samples(&base, 1 << 20).unwrap(), spread_lights(&base, base.lights()).unwrap()] {
        assert_eq!(fingerprint::matrix(&all), fingerprint::matrix(&base));
    }
}

#[test]
fn every_sweep_is_measured_at_every_value_by_every_method_and_the_plain_product_is_the_measure_of_work() {
    let (base, registry, pools) = (base(), registry::registry(), Pools::new(2).unwrap());
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
    let methods = labels::with_baseline(&registry, &["csr".into()], &[], BASELINE).unwrap();
    for sweep in STUDIES.iter().flat_map(|study| study.sweeps) {
        // One level, no pattern, one vertex, one column.
        let ends = Sweep { values: |_| vec![1.0], ..*sweep };
        let outcomes = outcomes(&bench, &ends, &base, &methods, &Steps::new(0)).unwrap();
        assert_eq!(outcomes.iter().map(|o| o.row.method.as_str()).collect::<Vec<_>>(), ["csr", "compact"]);
        for outcome in &outcomes {
            assert!(outcome.row.is_ok(), "{} {}: {}", sweep.name, outcome.row.method, outcome.row.reason);
            let figure = |name| {
                let all = outcome::DRAWN.iter().chain(&outcome::TOLD);
                all.filter(|f| f.name == name).find_map(|f| (f.of)(outcome)).unwrap()
            };
            let work = figure("flops_percent");
            assert!(figure("error") == 0.0 && (work == 100.0 || outcome.row.method != "csr"), "{}: {work}", sweep.name);
            assert!(figure("flops_value_aware_percent") <= work && figure("relight_of_compact") > 0.0);
        }
        let text = outcome::table(&ends, &outcomes);
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
        let csv = String::from_utf8(outcome::csv(&ends, &outcomes, &Machine::here(2)).unwrap()).unwrap();
        assert_eq!(csv.lines().count(), 1 + methods.len(), "{csv}");
        let svg = outcome::panels(&ends, "blob", &outcomes, &methods).svg(None);
        assert!(outcome::DRAWN.iter().all(|figure| svg.contains(figure.title)), "{svg}");
    }
}

#[test]
fn a_failure_is_a_line_with_its_reason_and_no_figure() {
    let row = Row { method: "csr".into(), samples: 1, non_zeros: 5, ..Row::default() }.failed("because");
    let outcomes = [Outcome { value: 2.0, distinct: 1, row, baseline_ms: None }];
    let sweep = &STUDIES[0].sweeps[0];
    assert!(outcome::table(sweep, &outcomes).ends_with("csr at 2: because"));
    let chart = outcome::panels(sweep, "blob", &outcomes, &["csr".into()]);
    assert!(chart.panels.iter().all(|panel| panel.values == [[None]]));
}
