//! What the figures of this paper promise.

use super::coefficients::Coefficients;
use super::*;
use crate::compute;
use crate::error_sums::{of_difference, of_matrix};
use crate::figures::Drawing;
use crate::figures::stage::{Mesh, Meshes};
use crate::machine::Machine;
use crate::measure::{Bench, Pools};
use crate::registry::{method, registry};
use crate::timing::Budget;
use prt_cpca::CpcaParams;
use prt_transfer::io::prt;
use prt_transfer::scene::separable::Terms;
use prt_transfer::{Label, Metric, Quiet, Shape};
use std::time::Duration;

const BLOB: Mesh = Mesh { file: None, built_in: "blob", vertices: 1000 };

fn stage<T>(vertices: usize, work: impl FnOnce(&Stage) -> T) -> T {
    let (registry, pools) = (registry(), Pools::new(2).unwrap());
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
    work(&Stage::new(bench, Machine::here(2), Meshes::BuiltIn(vertices)))
}

/// The records of a figure's only table, and its columns by name.
fn records(drawing: &Drawing) -> Vec<std::collections::HashMap<String, String>> {
    let table = drawing.beside.first().map(|beside| beside.csv(&Machine::here(2)).unwrap());
    let csv = table.unwrap_or_else(|| drawing.tables[0].1.clone());
    csv::Reader::from_reader(csv.as_slice()).deserialize().collect::<Result<_, _>>().unwrap()
}

fn is_shortest(label: &str) -> bool {
    let parsed: Label = label.parse().unwrap();
    registry().method(&parsed).unwrap().label().to_string() == label
}

#[test]
fn the_error_by_pythagoras_is_that_of_the_restored_rows() {
    stage(70, |stage| {
        let coefficients = Coefficients::of(stage, &BLOB).unwrap();
        let whole = compute::precompute("blob", Some(70), &spec(), &Quiet).unwrap().matrix;
        let metric = Metric::of(&whole).unwrap();
        let square = of_matrix(&whole, &metric).weighted;
        // The metric's weights 1/dω have a mean of 1.
        let angles = whole.basis().solid_angles().unwrap();
        let mean = angles.iter().map(|a| 1.0 / a).sum::<f64>() / angles.len() as f64;
        assert!((coefficients.square / (mean * square) - 1.0).abs() < 1e-6, "{} {square}", coefficients.square);
        for label in ["srbf+dense", "srbf+cta:clusters=2:light=24:sample=8", "srbf+cta:clusters=1:numbers=coded"] {
            let encode = method(&registry(), label).unwrap();
            let compressed = encode.encode_coefficients(&coefficients.matrix, &coefficients.basis, &Quiet).unwrap();
            let compressed = prt::from_bytes(&prt::to_bytes(&compressed, &Quiet).unwrap(), &registry()).unwrap();
            let explicit = of_difference(&whole, &compressed, &metric).weighted / square;
            let found = encoding::error(&coefficients, &compressed);
            assert!((found / explicit - 1.0).abs() < 1e-4, "{label}: {found} {explicit}");
            assert!(found >= coefficients.lost() * (1.0 - 1e-9), "{label}");
        }
    });
}

#[test]
fn table_1_has_the_paper_s_lines_and_every_label_of_every_mesh() {
    stage(60, |stage| {
        let drawing = (table1::FIGURE.draw)(stage).unwrap();
        let records = records(&drawing);
        let of = |source: &str| records.iter().filter(|r| r["source"] == source).collect::<Vec<_>>();
        assert_eq!((of("paper").len(), of("measured").len()), (3, 2 * 4 + 1));
        let number = |record: &std::collections::HashMap<String, String>, column: &str| {
            record[column].parse::<f64>().unwrap_or_else(|_| panic!("{column}: {record:?}"))
        };
        let (ok, failed): (Vec<_>, Vec<_>) = of("measured").into_iter().partition(|record| record["status"] == "ok");
        assert_eq!((failed.len(), failed[0]["reason"].as_str()), (1, "no mesh stands in for it"));
        for record in ok {
            assert_eq!(number(record, "raw_bytes"), 4.0 * 16.0 * 6144.0 * number(record, "vertices"));
            let errors = ["error_srbf", "error"].map(|column| number(record, column));
            assert!(0.0 < errors[0] && errors[0] <= errors[1] && errors[1] < 1.0, "{record:?}");
            for column in ["file_bytes", "resident_bytes", "encode_s", "precompute_s", "relight_rgb_all_ms"] {
                assert!(number(record, column) > 0.0, "{column}: {record:?}");
            }
        }
        // 94.7 % saved by lobes of 16 bits, 1,440:1 in all (§7.1).
        for record in of("paper") {
            assert!((number(record, "lobe_bytes") / number(record, "raw_bytes") - 0.053).abs() < 1e-3, "{record:?}");
        }
        assert!((number(of("paper")[2], "ratio") - 1440.0).abs() < 1.0);
        let text = drawing.beside[0].terminal();
        assert!(text.contains("\nBuddha: no mesh stands in for it\n"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    });
}

#[test]
fn labels_are_in_their_shortest_form_and_clusters_grow_with_the_mesh() {
    for clusters in [1, 64, 110] {
        let labels = table1::labels(clusters);
        assert!(labels.iter().all(|label| is_shortest(label)), "{labels:?}");
        assert!((1..labels.len()).all(|i| !labels[..i].contains(&labels[i])), "{labels:?}");
    }
    assert_eq!([1, 380, 4000, 41_000].map(own_clusters), [1, 1, 11, 110]);
}

#[test]
fn every_decomposition_of_every_array_is_a_line_and_hooi_is_never_worse_than_where_it_starts() {
    stage(60, |stage| {
        let drawing = decompositions::drawing(stage, [24, 6, 18], &[3, 6]).unwrap();
        let records = records(&drawing);
        assert!(drawing.measured && records.len() == 3 * 2 * 4 && records.iter().all(|r| r["status"] == "ok"));
        for four in records.chunks(4) {
            let errors: Vec<f64> = four.iter().map(|r| r["error"].parse().unwrap()).collect();
            assert!(errors[2] <= errors[1] * (1.0 + 1e-9) && errors.iter().all(|e| *e < 1.0), "{four:?}");
        }
        let chart = drawing.chart.unwrap();
        assert_eq!((chart.planes.len(), chart.names.len()), (3, 4));
        assert!(chart.planes.iter().all(|plane| plane.curves.iter().all(|curve| curve.len() == 2)));
        assert!(drawing.text.lines().all(|line| line.chars().count() <= 120), "{}", drawing.text);
    });
}

#[test]
fn every_setting_of_every_curve_is_measured_and_drawn() {
    let settings = bytes::settings(12_100, &bytes::SWEEPS);
    let clusters: Vec<usize> = settings.iter().filter(|s| s.0 == 0).map(|s| s.1).collect();
    assert_eq!(clusters, [8, 8, 16, 16, 32, 32, 64, 64, 128, 128]);
    assert!(settings.iter().all(|(.., label)| is_shortest(label)), "{settings:?}");
    stage(60, |stage| {
        let drawing = (bytes::FIGURE.draw)(stage).unwrap();
        let records = records(&drawing);
        let expected = bytes::settings(records[0]["vertices"].parse().unwrap(), &bytes::SWEEPS);
        assert_eq!(records.len(), expected.len());
        for (record, (.., label)) in records.iter().zip(&expected) {
            assert!(record["status"] == "ok" && record["method"] == *label, "{record:?}");
        }
        // A label on several curves is one measurement.
        let times =
            |label: &str| records.iter().filter(|r| r["method"] == label).map(|r| &r["encode_s"]).collect::<Vec<_>>();
        let same = times("srbf+cta:clusters=1");
        assert!(same.len() == 4 && same.iter().all(|t| t == &same[0]), "{same:?}");
        let chart = drawing.chart.unwrap();
        let dots: usize = chart.planes[..2].iter().flat_map(|plane| &plane.curves).map(Vec::len).sum();
        assert_eq!((dots, chart.names.len(), chart.planes.len()), (expected.len(), 6, 3));
        assert!(drawing.text.lines().skip(3).all(|line| line.chars().count() <= 120), "{}", drawing.text);
    });
}

#[test]
fn rivals_of_a_size_store_about_as_many_numbers() {
    for (samples, size) in [(3000, 1), (3000, 2), (2600, 4)] {
        let shape = Shape::new(samples, 16, 6144).unwrap();
        let numbers = table2::numbers(shape, size);
        for (segments, clusters) in [(1, 1), (1, 2), (24, 1), (24, 2), (24, 4)] {
            let params = table2::cpca(shape, numbers as f64, segments, clusters).unwrap();
            assert!(is_shortest(&params.to_stage().to_string()));
            let more = CpcaParams { components: params.components + 1, ..params.clone() };
            let [found, above] = [&params, &more].map(|params| table2::numbers_of_cpca(shape, params, segments));
            assert!(found <= numbers && numbers < above, "{params:?}");
        }
        assert!(table2::cpca(shape, 98_303.0, 1, 1).is_none(), "no room for a mean");
        let params = table2::cta(shape, size, 8, numbers as f64);
        let stored = table2::numbers_of_cta(shape, &params);
        assert!((stored as f64 / numbers as f64 - 1.0).abs() < 0.03, "{params:?}: {stored} {numbers}");
    }
}

#[test]
fn table_2_has_every_rival_of_every_size() {
    stage(60, |stage| {
        let few = Spec { terms: Terms::Count(4), ..spec() };
        let drawing = table2::drawing(stage, &few, &[1, 2]).unwrap();
        let records = records(&drawing);
        let kinds = ["CPCA of whole samples", "CPCA of segments", "SRBF and CTA", "SRBF and CTA, all views"];
        for (size, kind) in ["1", "2"].into_iter().flat_map(|size| kinds.map(|kind| (size, kind))) {
            let mut of = records.iter().filter(|r| r["size"] == size && r["subject"] == kind).peekable();
            assert!(of.peek().is_some() && of.all(|r| r["status"] == "ok"), "{size} {kind}: {records:?}");
        }
        let printed = records.iter().filter(|r| r["source"] == "paper").map(|r| r["error_sphere"].as_str());
        assert_eq!(printed.collect::<Vec<_>>(), ["0.0309", "0.0375"]);
        let text = drawing.beside[0].terminal();
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    });
}

#[test]
fn figure_5_has_every_pair_of_ranks_and_the_paper_s_second_table_agrees_with_the_first() {
    assert!(figure5::labels(110).iter().all(|label| is_shortest(label)));
    stage(60, |stage| {
        let drawing = (figure5::FIGURE.draw)(stage).unwrap();
        let records = records(&drawing);
        let number = |r: &std::collections::HashMap<String, String>, column: &str| r[column].parse::<f64>().unwrap();
        let [printed, ours]: [Vec<_>; 2] =
            ["paper", "measured"].map(|source| records.iter().filter(|r| r["source"] == source).collect());
        assert_eq!((printed.len(), ours.len()), (4, 4));
        assert!((number(printed[0], "file_bytes") - table1::LINES[2].bytes[2]).abs() < 1.0, "the bunny of Table 1");
        assert!(ours.iter().all(|r| r["status"] == "ok" && number(r, "error") < 1.0), "{ours:?}");
        // Fewer ranks take no more bytes and leave no less error.
        for fewer in [1, 2] {
            assert!(number(ours[fewer], "file_bytes") <= number(ours[0], "file_bytes"), "{ours:?}");
            assert!(number(ours[fewer], "error") >= number(ours[0], "error") * 0.999, "{ours:?}");
        }
    });
}
