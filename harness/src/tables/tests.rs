//! What the tables promise.

use super::quantity::{OF_MATRIX, OF_METHOD};

use super::*;
use crate::row::{Row, Status};

fn every_scene() -> impl Iterator<Item = &'static PaperScene> {
    PAPERS.iter().flat_map(|paper| paper.tables).flat_map(|table| table.scenes)
}

#[test]
fn whatever_a_paper_prints_is_a_quantity_that_is_measured() {
    for scene in every_scene() {
        for (name, _) in scene.printed {
            assert!(OF_MATRIX.iter().chain(&OF_METHOD).any(|q| q.name == *name), "{} prints {name}", scene.name);
        }
    }
}

/// A slip of the eye while copying a table would show here.
#[test]
fn the_printed_figures_agree_with_each_other_within_their_digits() {
    let close = |a: f64, b: f64| (a - b).abs() <= 0.04 * b;
    for scene in every_scene().filter(|scene| !scene.printed.is_empty()) {
        let of = |name| scene.printed(name).unwrap();
        let name = scene.name;
        assert!(close(of("mflops"), 2.0 * of("nnz_millions")), "{name}");
        assert!(close(of("computation_percent"), 100.0 * of("reduced_mflops") / of("mflops")), "{name}");
        assert!(close(of("data_u8_percent"), 100.0 * of("resident_mb") / of("dense_u8_mb")), "{name}");
        let directions = if name == "armor" { 144.0 } else { 64.0 };
        // Table I gives the bunny 1,400 MB where 3,286 vertices have 1,292.
        let bytes = of("vertices") * directions * 6144.0 / 1e6;
        assert!((of("dense_u8_mb") - bytes).abs() < 0.09 * bytes, "{name}: {bytes}");
    }
}

/// A scene with two finished methods and a failed one.
fn survey(scene: &'static PaperScene) -> Survey {
    let row = |method: &str, size: u64| Row {
        method: method.into(),
        status: Status::Ok,
        samples: 10,
        responses: 64,
        lights: 6144,
        non_zeros: 1_000_000,
        resident_bytes: Some(size),
        multiplications: Some(size / 8),
        additions: Some(size / 8),
        relight_1_ms: Some(size as f64 / 1e6),
        error: Some(0.0),
        ..Row::default()
    };
    let failed = Row { method: "f16".into(), samples: 10, ..Row::default() }.failed("out of memory");
    Survey {
        scene,
        subject: Some("blob-10".into()),
        rows: vec![row("csr", 2_000_000), row("compact", 4_000_000), failed],
    }
}

#[test]
fn percentages_stand_beside_the_paper_s_and_a_failure_gives_its_reason() {
    let bunny = every_scene().find(|scene| scene.name == "bunny").unwrap();
    let armor = every_scene().find(|scene| scene.name == "armor").unwrap();
    let nowhere = Survey { scene: armor, subject: None, rows: vec![Row::default().failed("not published")] };
    let (surveys, methods) = ([survey(bunny), nowhere], ["csr", "compact", "f16"].map(String::from));
    let layout = Layout::new("Table I", &surveys, &methods);

    let text = layout.terminal();
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    let line = |start: &str| {
        let found =
            text.lines().filter(|line| line.starts_with(start)).map(|line| line[start.len()..].split_whitespace());
        found.map(|cells| cells.collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    assert_eq!(line("computation, %")[0], ["25.0", "27.4", "33.9"]);
    assert_eq!(line("data, % of dense at 1 B")[0], ["50.9", "1.70", "0.620"]);
    assert_eq!(line("data, % of compact")[0], ["50.0", "-", "-"]);
    assert_eq!(line("times as fast as compact")[0], ["2.00", "-", "-"]);
    assert_eq!(line("computation, %")[2], ["-", "27.4", "33.9"]);
    assert!(text.ends_with("blob-10, f16: out of memory\narmor: not published"), "{text}");

    let markdown = layout.markdown();
    let widths = markdown.lines().filter(|line| line.starts_with('|')).map(|line| line.matches('|').count());
    assert!(widths.collect::<Vec<_>>().iter().all(|&bars| bars == 5), "{markdown}");

    let csv = String::from_utf8(layout.csv(&Machine::here(2)).unwrap()).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let column = |name: &str| csv.lines().next().unwrap().split(',').position(|c| c == name).unwrap();
    let (ours, papers, reason) = (column("computation_percent"), column("paper_computation_percent"), column("reason"));
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.unwrap()).collect();
    assert_eq!((rows.len(), &rows[0][ours], &rows[0][papers]), (4, "25", "27.4"));
    assert_eq!((&rows[2][reason], &rows[3][reason], &rows[3][papers]), ("out of memory", "not published", "33.9"));
}
