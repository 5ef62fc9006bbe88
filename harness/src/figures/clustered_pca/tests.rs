//! What the data of the paper's figures promise.

use super::claims::{components_for, crossing};
use super::matched::{FIGURE_10, FIGURE_11, at_cost};
use super::table1::{LINES, curve};
use super::*;
use crate::charts::curves::Curves;
use crate::figures::outcome::{MEMORY, Outcome};
use crate::row::{Row, Status};
use crate::tables::beside::Beside;
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
    let of = |model: &str| LINES.iter().find(|l| l.model == model && l.brdf == "gloss-anis").unwrap();
    let (bird, [of_buddha, of_bird]) = (of("bird"), FIGURE_11[2].1);
    let errors = [FIGURE_10[2].2, of_bird.0, bird.printed[1].error];
    assert!(errors.iter().all(|e| (e - 294.4).abs() < 0.5), "{errors:?}");
    assert!((of_buddha.0 - of("Buddha").printed[1].error).abs() < 0.5 && FIGURE_10[2].3 == of_bird.1);
    for model in [0, 1] {
        assert!(FIGURE_11.is_sorted_by(|a, b| a.1[model].0 > b.1[model].0 && a.1[model].1 > b.1[model].1));
    }
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

fn records(beside: &Beside) -> Vec<std::collections::HashMap<String, String>> {
    let csv = beside.csv(&crate::machine::Machine::here(2)).unwrap();
    csv::Reader::from_reader(csv.as_slice()).deserialize().map(Result::unwrap).collect()
}

/// SE of four numbers of components, and of PCA at half and eight times the bytes of n' = 2.
fn measured() -> (Vec<Curve>, Vec<Outcome>) {
    let curves = ["PCA", "VQ", "CPCA", "uncompressed"].map(|name| Curve::new(name, []));
    let cpca = [(2, 2e-4), (4, 1e-4), (8, 1e-5), (12, 2e-6)];
    let cpca = cpca.map(|(n, error)| outcome(2, n, 1_000_000 * n as u64, error));
    let pca = [(1, 0.2), (64, 0.02)].map(|(n, error)| outcome(0, n, 500_000 * n as u64, error));
    (curves.into(), cpca.into_iter().chain(pca).collect())
}

#[test]
fn figure_10_is_read_at_the_cost_of_cpca_and_says_what_reaches_no_such_cost() {
    let (curves, outcomes) = measured();
    let beside = matched::figure10("a blob".into(), &curves, &outcomes);
    assert!(beside.terminal().lines().all(|line| line.chars().count() <= 120), "{}", beside.terminal());
    let records = records(&beside);
    let of = |subject: &str| records.iter().filter(|r| r["subject"].starts_with(subject)).collect::<Vec<_>>();
    let number = |text: &str| text.parse::<f64>().unwrap();
    let [printed, time, bytes] = of("CPCA")[..] else { panic!("{records:?}") };
    assert_eq!(
        (printed["source"].as_str(), number(&printed["squared_error"]), number(&printed["of_base"])),
        ("paper", 294.4, 1.0)
    );
    for ours in [time, bytes] {
        assert!(
            (number(&ours["squared_error"]) - 10.0).abs() < 1e-9 && (number(&ours["of_base"]) - 1.0).abs() < 1e-9,
            "{ours:?}"
        );
    }
    // PCA through 0.2 at 0.5 MB and 0.02 at 32 MB, at the 8 MB of n' = 8: ln 16 / ln 64 of the way down.
    let [_, time, bytes] = of("PCA")[..] else { panic!("{records:?}") };
    let expected = 1e6 * 0.2 * 0.1_f64.powf(16_f64.ln() / 64_f64.ln());
    assert!((number(&bytes["squared_error"]) / expected - 1.0).abs() < 1e-9, "{bytes:?}");
    assert_eq!((bytes["resident_bytes"].as_str(), time["relight_1_ms"].as_str()), ("8000000", "8"));
    let [_, time, bytes] = of("VQ")[..] else { panic!("{records:?}") };
    assert!(time["status"] == "failed" && bytes["reason"] == "VQ does not reach the cost of CPCA", "{time:?}");
}

#[test]
fn figure_11_has_both_models_and_a_model_that_is_missing_its_reason() {
    let (curves, outcomes) = measured();
    let models = [Err("there is no dragon".to_string()), Ok(("a blob".to_string(), curves, outcomes))];
    let records = records(&matched::figure11(&models));
    let ours = |model: &str| {
        records.iter().filter(|r| r["source"] == "measured" && r["subject"].starts_with(model)).collect::<Vec<_>>()
    };
    assert!(
        ours("Buddha").len() == 4 && ours("Buddha").iter().all(|r| r["reason"] == "there is no dragon"),
        "{records:?}"
    );
    // SE as a multiple of that of n' = 8: 2e-4 / 1e-5 here, 9510.75 / 294.421 in print.
    let ratios: Vec<f64> = ours("bird").iter().map(|r| r["of_base"].parse().unwrap()).collect();
    assert!(ratios.iter().zip([20.0, 10.0, 1.0, 0.2]).all(|(a, b)| (a - b).abs() < 1e-9), "{ratios:?}");
    let printed = records.iter().find(|r| r["subject"] == "bird, n' = 2").unwrap();
    assert!((printed["of_base"].parse::<f64>().unwrap() - 9510.75 / 294.421).abs() < 1e-9);
}

#[test]
fn curves_cross_where_the_next_is_lower_at_equal_cost_and_fewer_components_are_told_in_components() {
    // Before: SE 100/x; after: 1000/x². They meet at x = 10.
    let of = |law: fn(f64) -> f64| [2, 4, 8, 16, 32].map(|n| outcome(0, n, 1_000_000 * n as u64, 1e-6 * law(n as f64)));
    let (before, after) = (of(|x| 100.0 / x), of(|x| 1000.0 / (x * x)));
    let [before, after]: [Vec<&Outcome>; 2] = [before.iter().collect(), after.iter().collect()];
    assert_eq!(crossing(&before, &after, &MEMORY), Some(16.0));
    assert_eq!(crossing(&before, &before, &MEMORY), None);
    // 100/n = 1000/16² at n = 25.6, between 16 and 32 on the line of logarithms.
    let found = components_for(&before, after[3].squared_error().unwrap()).unwrap();
    assert!((found - (16.0 + 16.0 * (1.6_f64.ln() / 2_f64.ln()))).abs() < 1e-6, "{found}");
    assert_eq!(components_for(&before, 1e3), None);
}

#[test]
fn what_the_paper_says_of_figures_2_and_3_has_ours_below_it() {
    let curves = figure3::curves(256, &[1, 2, 4, 8]);
    let three = claims::figure3("a blob".into(), &curves, &lawful(&curves, 34_835, 25));
    let lines = records(&three);
    assert_eq!(lines.iter().filter(|r| r["source"] == "paper").count(), 2);
    // All ways of encoding have the same law here: none is worth a component.
    let more: Vec<f64> =
        lines.iter().filter(|r| r["source"] == "measured").map(|r| r["more_components"].parse().unwrap()).collect();
    assert!(more.len() == 8 && more.iter().all(|more| more.abs() < 1e-9), "{more:?}");
    let curves = figure2::curves(34_835, 25, 2);
    let two = claims::figure2("a blob".into(), &curves, &lawful(&curves, 34_835, 25));
    assert_eq!(records(&two).len(), 2 * 5, "five curves above that of VQ");
    for beside in [two, three] {
        assert!(beside.terminal().lines().all(|line| line.chars().count() <= 120), "{}", beside.terminal());
    }
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
    let beside = table1_layout::beside(&lines);
    let text = beside.terminal();
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    assert_eq!(
        text.lines().filter(|line| line.starts_with("  bunny_35k") && line.ends_with("0.250")).count(),
        6,
        "{text}"
    );
    assert!(text.contains("\nBuddha gloss-iso: there is no such mesh\n"), "{text}");
    // 1h51m and 451 keep their digits.
    let line = text.lines().find(|line| line.starts_with("Buddha gloss-iso 16x25, the paper's")).unwrap();
    assert_eq!(line.split_whitespace().rev().skip(2).take(2).collect::<Vec<_>>(), ["451", "6660"], "{text}");
    assert_eq!(records(&beside).len(), 2 * 7);
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
