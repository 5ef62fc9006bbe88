//! What a chart must show, whatever it looks like.

use super::*;
use crate::family::in_order;
use crate::row::Status;

fn row(method: &str, error: f64, cost: f64) -> Row {
    Row {
        method: method.into(),
        family: crate::family::family(&method.parse().unwrap()),
        status: Status::Ok,
        error: Some(error),
        relight_1_ms: Some(cost),
        resident_bytes: Some((cost * 1e6) as u64),
        encode_s: Some(cost / 10.0),
        ..Row::default()
    }
}

fn group() -> Group {
    let mut rows = vec![row("dense", 0.0, 12.0), row("csr", 0.0, 1.9), row("compact", 0.0, 1.6), row("f16", 3e-8, 1.7)];
    for (terms, error, cost) in
        [(16, 0.21, 0.11), (32, 0.12, 0.2), (64, 0.055, 0.37), (128, 0.021, 0.7), (256, 0.007, 1.4)]
    {
        rows.push(row(&format!("haar+truncate:terms={terms}"), error, cost));
    }
    for (order, error, cost) in [(3, 0.7, 0.02), (5, 0.5, 0.06), (8, 0.35, 0.15)] {
        rows.push(row(&format!("sh:order={order}+dense"), error, cost));
    }
    rows.push(row("truncate:terms=64", 0.6, 0.4));
    rows.push(Row { method: "broken".into(), ..Row::default() }.failed("because"));
    Group { title: "teapot · biscale · cubemap:32".into(), file_name: "teapot".into(), rows, ..Group::default() }
}

fn families(group: &Group) -> Vec<String> {
    in_order(group.rows.iter().map(|row| row.family.as_str()))
}

fn charts(group: &Group) -> Vec<Chart> {
    of(group, &families(group))
}

#[test]
fn every_finished_method_is_drawn_with_its_label_and_exact_ones_stand_apart() {
    let charts = charts(&group());
    assert_eq!(charts.len(), 3);
    for chart in &charts {
        let svg = chart.svg(None);
        assert_eq!(chart.points.len(), 13);
        for text in ["exact", "haar+truncate", "256", "Pareto frontier", "csr, exact", chart.cost.title] {
            assert!(svg.contains(&format!(">{text}</text>")), "{text} is missing");
        }
    }
}

#[test]
fn the_frontier_keeps_the_perfect_point() {
    let speed = &charts(&group())[0];
    let kept: Vec<&str> = speed.points.iter().filter(|p| p.on_frontier).map(|p| p.method.as_str()).collect();
    assert_eq!(kept[0], "compact");
    assert!(!kept.contains(&"csr") && !kept.contains(&"truncate:terms=64") && !kept.contains(&"f16"), "{kept:?}");
    assert!(kept.contains(&"sh:order=3+dense"));
}

#[test]
fn a_chart_of_exact_methods_only_or_of_one_method_is_drawn_too() {
    for rows in
        [vec![row("csr", 0.0, 1.0)], vec![row("csr", 0.5, 1.0)], vec![row("csr", 0.0, 1.0), row("dense", 0.0, 1.0)]]
    {
        let group = Group { rows, ..group() };
        for chart in charts(&group) {
            let svg = chart.svg(Some(&Machine::here(2)));
            assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
    assert!(charts(&Group { rows: Vec::new(), ..group() }).is_empty());
}

#[test]
fn every_chart_has_its_picture_and_its_raw_data() {
    let folder = tempfile::tempdir().unwrap();
    draw(&group(), &families(&group()), folder.path(), &Machine::here(2)).unwrap();
    for name in ["speed", "storage", "encode"] {
        let file = |extension| std::fs::read(folder.path().join(format!("teapot-{name}.{extension}"))).unwrap();
        assert_eq!(&file("png")[1..4], b"PNG");
        assert!(file("svg").starts_with(b"<svg"));
        assert_eq!(file("csv").split(|&b| b == b'\n').filter(|l| !l.is_empty()).count(), 1 + 13);
    }
    if let Ok(keep) = std::env::var("PRT_KEEP_CHARTS") {
        draw(&group(), &families(&group()), Path::new(&keep), &Machine::here(2)).unwrap();
    }
}
