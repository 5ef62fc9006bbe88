//! What the data of the paper's figures promise.

use super::matched::at_cost;
use super::table1::{LINES, curve};
use super::*;
use crate::charts::curves::Curves;
use crate::figures::outcome::{MEMORY, Outcome};
use crate::row::{Row, Status};
use prt_transfer::{Label, Params};

/// Every label of every figure, by the curves of a scene of that many samples.
fn labels(samples: usize) -> Vec<Vec<Setting>> {
    let of = |curves: Vec<Curve>| curves.into_iter().flat_map(|curve| curve.settings).collect();
    let mut all = vec![
        of(figure2::curves(samples, 25, 2)),
        of(figure3::curves(256, &[1, 2, 3, 4, 6, 8, 12, 16])),
        of(figure10::curves(samples, 256)),
    ];
    all.extend(LINES.iter().map(|line| curve(line.clusters, line.components).settings));
    all
}

#[test]
fn every_label_is_in_its_shortest_form_and_once_in_its_figure() {
    for settings in labels(34_835) {
        for (i, setting) in settings.iter().enumerate() {
            let label: Label = setting.method.parse().unwrap();
            assert_eq!(label.to_string(), setting.method);
            let shortest = match label.codec.name.as_str() {
                "vq" => VqParams::from_stage(&label.codec).unwrap().to_stage(),
                "pca" => PcaParams::from_stage(&label.codec).unwrap().to_stage(),
                "cpca" => CpcaParams::from_stage(&label.codec).unwrap().to_stage(),
                _ => label.codec.clone(),
            };
            assert_eq!(shortest.to_string(), setting.method);
            assert!(settings[..i].iter().all(|other| other.method != setting.method), "{}", setting.method);
        }
    }
}

#[test]
fn figure_2_ends_where_the_paper_s_does_and_never_stores_more_than_the_matrix() {
    let curves = figure2::curves(48_668, 25, 2);
    let clusters =
        |n: usize| curves[n].settings.iter().filter_map(|s| s.size).map(|size| size.clusters).collect::<Vec<_>>();
    assert_eq!(clusters(0), (0..=14).map(|power| 1 << power).collect::<Vec<usize>>(), "1, 2, 4, ..., 16k");
    for (samples, step) in [(48_668, 2), (300, 4), (3, 4)] {
        for setting in figure2::curves(samples, 25, step).iter().flat_map(|curve| &curve.settings) {
            assert!(setting.numbers(samples, 25) <= samples * 25 && !setting.method.is_empty());
        }
    }
    // By hand: 10 samples of 25 numbers in 2 clusters of a mean and 3 components.
    assert_eq!(cpca(Mode::Static, 2, 3).numbers(10, 25), 10 * 3 + 2 * 4 * 25);
}

/// A slip of the eye while copying would show here: the same measurement is printed in three places.
#[test]
fn the_printed_figures_agree_with_each_other() {
    let rows = matched::beside(&[], &[]);
    let errors = rows.iter().filter(|b| b.setting().ends_with("n' = 8")).map(matched::Beside::error);
    let bird = LINES.iter().find(|line| line.model == "bird" && line.brdf == "gloss-anis").unwrap();
    let errors: Vec<f64> = errors.chain([bird.printed[1].error]).collect();
    assert!(errors.len() == 3 && errors.iter().all(|e| (e - 294.4).abs() < 0.5), "{errors:?}");
    assert!(LINES.iter().all(|line| line.printed[1].error < line.printed[0].error), "iterative is better");
    assert!(LINES.iter().all(|line| line.printed[1].seconds > line.printed[0].seconds), "and slower");
    // 6m7s, 3h43m, 3m26s
    assert_eq!(
        (LINES[1].printed[0].seconds, bird.printed[1].seconds, LINES[6].printed[1].seconds),
        (367.0, 13_380.0, 206.0)
    );
}

fn outcome(curve: usize, components: usize, bytes: u64, error: f64) -> Outcome {
    let row = Row {
        status: Status::Ok,
        error: Some(error),
        resident_bytes: Some(bytes),
        relight_1_ms: Some(bytes as f64 / 1e6),
        encode_s: Some(1.5),
        samples: 34_835,
        ..Row::default()
    };
    Outcome { curve, setting: cpca(Mode::Iterative, 256, components), row, square: 1e6 }
}

#[test]
fn between_two_points_error_follows_the_power_law_through_them_and_beyond_the_curve_there_is_none() {
    let law = |bytes: u64| 3.0 / (bytes as f64).powf(1.7);
    // Not in the order of their cost.
    let curve = [1_000, 16_000, 4_000].map(|bytes| outcome(0, 8, bytes, law(bytes)));
    let curve: Vec<&Outcome> = curve.iter().collect();
    for bytes in [1_000, 2_000, 4_000, 5_000, 16_000] {
        let found = at_cost(&curve, &MEMORY, bytes as f64 / 1e6).unwrap();
        assert!((found / (1e6 * law(bytes)) - 1.0).abs() < 1e-9, "{bytes}: {found}");
    }
    assert_eq!([999, 16_001].map(|bytes| at_cost(&curve, &MEMORY, bytes as f64 / 1e6)), [None, None]);
    let exact = [outcome(0, 8, 1_000, 0.0), outcome(0, 8, 4_000, 0.0)];
    assert_eq!(at_cost(&exact.iter().collect::<Vec<_>>(), &MEMORY, 2e-3), None, "no logarithm");
}

#[test]
fn figures_10_and_11_stand_beside_the_paper_s_in_120_columns() {
    let curves = ["PCA", "VQ", "CPCA", "uncompressed"].map(|name| Curve::new(name, []));
    let cpca = [(2, 2e-4), (4, 1e-4), (8, 1e-5), (12, 2e-6)];
    let cpca = cpca.map(|(n, error)| outcome(2, n, 1_000_000 * n as u64, error));
    let pca = [(1, 0.2), (64, 0.02)].map(|(n, error)| outcome(0, n, 500_000 * n as u64, error));
    let outcomes: Vec<Outcome> = cpca.into_iter().chain(pca).collect();
    let beside = matched::beside(&curves, &outcomes);
    let text = matched::table(&beside);
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    // SE of n' = 2, as a multiple of n' = 8: 9510.75 / 294.421 in print, 2e-4 / 1e-5 here.
    let line = text.lines().rfind(|line| line.contains("n' = 2 ")).unwrap();
    assert_eq!(line.split_whitespace().rev().take(4).collect::<Vec<_>>(), ["20.0", "200", "32.3", "9510.75"], "{text}");
    // VQ was not measured here.
    let line = text.lines().find(|line| line.starts_with("VQ")).unwrap();
    assert!(line.split_whitespace().rev().take(4).all(|cell| cell == "-"), "{line}");
    let csv = String::from_utf8(matched::csv(&beside, &crate::machine::Machine::here(2)).unwrap()).unwrap();
    assert_eq!(csv.lines().count(), 1 + 8, "{csv}");
}

#[test]
fn table_1_has_the_paper_s_line_and_ours_and_why_there_is_none() {
    let lines: Vec<table1::Measured> = LINES
        .iter()
        .enumerate()
        .map(|(i, line)| table1::Measured {
            line,
            subject: if i == 0 { Err("there is no such mesh".into()) } else { Ok("bunny_35k · glossy".into()) },
            clusters: line.clusters,
            outcomes: if i == 0 { Vec::new() } else { vec![outcome(0, 8, 1, 4e-4), outcome(0, 8, 1, 1e-4)] },
        })
        .collect();
    let text = table1_layout::text(&lines);
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    assert_eq!(
        text.lines().filter(|line| line.starts_with("  ours: bunny_35k") && line.ends_with("0.250")).count(),
        6,
        "{text}"
    );
    assert!(text.ends_with("Buddha gloss-iso: there is no such mesh"), "{text}");
    let csv = String::from_utf8(table1_layout::csv(&lines, &crate::machine::Machine::here(2)).unwrap()).unwrap();
    assert_eq!(csv.lines().count(), 1 + 7, "{csv}");
}

/// Outcomes that fall with storage as a smooth signal's do, so that charts can be looked at without measuring.
fn lawful(curves: &[Curve], samples: usize, dimension: usize) -> Vec<Outcome> {
    let of = |(curve, setting): (usize, &Setting)| {
        let numbers = setting.numbers(samples, dimension) as f64;
        let error = setting.size.map_or(0.0, |size| {
            0.3 * (1.0 + size.components as f64).powf(-1.5)
                * (size.clusters as f64).powf(-0.2 * (1.0 + size.components as f64).sqrt())
        });
        let row = Row {
            method: setting.method.clone(),
            responses: 1,
            lights: dimension,
            encode_s: Some(1e-7 * numbers),
            relight_1_ms: Some(0.05 + 1e-6 * numbers),
            ..outcome(curve, 0, 4 * numbers as u64, error).row
        };
        Outcome { curve, setting: setting.clone(), row, square: 1e4 }
    };
    let settings = curves.iter().enumerate().flat_map(|(i, curve)| curve.settings.iter().map(move |s| (i, s)));
    settings.map(of).collect()
}

#[test]
fn every_chart_has_every_setting_in_every_panel_and_every_curve_in_its_legend() {
    let of = |curves: Vec<Curve>, dimension, chart: fn(String, &[Curve], &[Outcome]) -> Curves| {
        let outcomes = lawful(&curves, 34_835, dimension);
        let chart = chart("bunny_35k · diffuse · sh:5".into(), &curves, &outcomes);
        (curves, chart)
    };
    let charts = [
        ("figure2", of(figure2::curves(34_835, 25, 2), 25, figure2::chart)),
        ("figure3", of(figure3::curves(256, &[1, 2, 3, 4, 6, 8, 12, 16]), 25, figure3::chart)),
        ("figure10", of(figure10::curves(34_835, 256), 600, figure10::chart)),
    ];
    for (name, (curves, chart)) in charts {
        let svg = chart.svg(None);
        let settings = curves.iter().flat_map(|curve| &curve.settings).filter(|s| s.size.is_some()).count();
        let drawn = curves.len() - 1;
        // Circles, polygons; lines are not filled.
        let markers =
            svg.matches("<circle").count() + svg.matches("<path").count() - svg.matches("fill=\"none\"").count();
        assert_eq!(markers, 3 * settings + drawn, "{name}");
        assert_eq!((chart.names.len(), svg.matches(">dense, exact</text>").count() > 0), (drawn, true), "{name}");
        if let Ok(keep) = std::env::var("PRT_KEEP_CHARTS") {
            let png = chart.png(&crate::machine::Machine::here(2)).unwrap();
            std::fs::write(std::path::Path::new(&keep).join(format!("{name}.png")), png).unwrap();
        }
    }
}
