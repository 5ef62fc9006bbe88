//! What every figure promises, whatever its methods.

use super::outcome::{self, COMPONENTS, MEMORY, NUMBERS, Outcome, RELIGHT};
use super::plot::plot;
use super::setting::{Curve, Setting, Size};
use super::stage::{Mesh, Meshes};
use super::*;
use crate::signal::{Signal, Spec};
use prt_transfer::LightBasis;

const BLOB: Mesh = Mesh { file: Some("absent.ply"), built_in: "blob", vertices: 1000 };

fn stage<T>(meshes: Meshes, work: impl FnOnce(&Stage) -> T) -> T {
    let (registry, pools) = (registry::registry(), Pools::new(2).unwrap());
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
    work(&Stage::new(bench, Machine::here(2), meshes))
}

/// Two curves of methods that every registry has, one of them with a setting that fails.
fn curves() -> Vec<Curve> {
    let setting = |method: &str, clusters, components| Setting {
        method: method.into(),
        size: Some(Size { clusters, components }),
    };
    let harmonics = (1..4).map(|order| setting(&format!("sh:order={order}+dense"), 1, order * order));
    let haar = [4, 8].map(|terms| setting(&format!("haar+truncate:terms={terms}"), 1, terms));
    let fails = setting("haar+visibility", 1, 1);
    vec![
        Curve::new("harmonics", harmonics),
        Curve::new("haar", haar.into_iter().chain([fails])),
        Curve::new("uncompressed", [Setting::whole("dense")]),
    ]
}

#[test]
fn every_setting_is_a_line_of_the_table_and_of_the_csv_and_what_is_measured_is_drawn() {
    stage(Meshes::BuiltIn(60), |stage| {
        let spec = Spec::new(Signal::Diffuse, LightBasis::Cubemap { resolution: 4 });
        let subject = stage.subject(&BLOB, &spec).unwrap();
        let curves = curves();
        let outcomes = stage.measure(&subject, &curves).unwrap();
        assert_eq!(outcomes.iter().map(|o| o.curve).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1, 2]);
        assert!(outcomes.iter().all(|o| o.row.is_ok() == (o.row.method != "haar+visibility")));

        // SE is the error times Σ T²: of nothing at all it would be Σ T² itself.
        let matrix = subject.matrix();
        let of_row = |r| matrix.row(r).non_zeros().map(|(_, v)| f64::from(v).powi(2)).sum::<f64>();
        let square: f64 = (0..matrix.rows()).map(of_row).sum();
        for o in outcomes.iter().filter(|o| o.row.is_ok()) {
            assert!((o.squared_error().unwrap() - square * o.row.error.unwrap()).abs() <= 1e-9 * square);
        }

        let chart = plot(
            ("t", subject.title(), Some("a remark")),
            &curves,
            &outcomes,
            &[NUMBERS, MEMORY, RELIGHT, COMPONENTS],
            |s| s.size.map_or(String::new(), |size| format!("at {}", size.components)),
        );
        assert_eq!(chart.names, ["harmonics", "haar"], "the legend has what is drawn");
        let svg = chart.svg(None).replace("&apos;", "'").replace("&#39;", "'");
        for text in
            ["at 1", "at 9", "at 8", "harmonics", "haar", "dense, exact", "a remark", NUMBERS.title, RELIGHT.title]
        {
            assert!(svg.contains(&format!(">{text}</text>")), "{text}: {svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 4 * 3 + 1, "a marker for each setting and panel, one in the legend");

        let text = outcome::table("t", &subject, &outcomes);
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
        assert!(text.lines().last().unwrap().starts_with("haar+visibility: "), "{text}");
        let csv = String::from_utf8(outcome::csv(&curves, &outcomes, &Machine::here(2)).unwrap()).unwrap();
        assert_eq!(csv.lines().count(), 1 + outcomes.len(), "{csv}");
    });
}

#[test]
fn a_subject_is_computed_once_and_a_mesh_that_is_missing_says_so() {
    stage(Meshes::BuiltIn(60), |stage| {
        let spec = Spec::new(Signal::Diffuse, LightBasis::SphericalHarmonics { order: 3 });
        let twice = [0, 1].map(|_| stage.subject(&BLOB, &spec).unwrap());
        assert!(std::rc::Rc::ptr_eq(&twice[0], &twice[1]));
        let other = stage.subject(&BLOB, &Spec::new(Signal::Diffuse, LightBasis::SphericalHarmonics { order: 2 }));
        assert_eq!((twice[0].dimension(), other.unwrap().dimension()), (9, 4));
    });
    let folder = tempfile::tempdir().unwrap();
    stage(Meshes::Files(folder.path().into()), |stage| {
        let spec = Spec::new(Signal::Diffuse, LightBasis::SphericalHarmonics { order: 2 });
        let message = stage.subject(&BLOB, &spec).err().map(|e| format!("{e:#}")).unwrap_or_default();
        assert!(message.contains("absent.ply"), "{message}");
    });
}

#[test]
fn a_smaller_scene_has_fewer_clusters_of_about_as_many_samples() {
    stage(Meshes::BuiltIn(60), |stage| {
        for samples in [1, 20, 500, 1000, 4000] {
            let clusters = stage.clusters(256, &BLOB, samples);
            assert!(clusters.is_power_of_two() && clusters <= 256, "{clusters}");
            let share = (samples as f64 / clusters as f64) / (1000.0 / 256.0);
            assert!((0.70..1.42).contains(&share) || clusters == 1 || clusters == 256, "{samples}: {clusters}");
        }
    });
    stage(Meshes::Files(".".into()), |stage| assert_eq!(stage.clusters(256, &BLOB, 20), 256));
}

#[test]
fn what_is_written_is_the_chart_and_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let figure = Figure { name: "figure0", table: None, draw: |_| anyhow::bail!("not drawn here") };
    let outcomes: Vec<Outcome> = Vec::new();
    let chart = Some(plot(("t", "s".into(), None), &[], &outcomes, &[MEMORY], |_| String::new()));
    let tables = vec![("", b"a\n".to_vec()), ("-paper", b"b\n".to_vec())];
    let drawing = Drawing { tables, chart, ..Drawing::default() };
    write(&figure, &drawing, folder.path(), &Machine::here(2)).unwrap();
    let file = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!((file("figure0.csv"), file("figure0-paper.csv")), (b"a\n".to_vec(), b"b\n".to_vec()));
    assert!(file("figure0.svg").starts_with(b"<svg") && &file("figure0.png")[1..4] == b"PNG");
}

#[test]
fn names_are_those_of_the_paper_and_an_unknown_one_lists_them() {
    let paper = find("clustered-pca").unwrap();
    let all: Vec<&str> = chosen(paper.figures.iter(), &[]).unwrap().iter().map(|f| f.name).collect();
    assert_eq!(all, ["figure2", "figure3", "figure10", "table1"]);
    let message = chosen(paper.figures.iter(), &["figure7".into()]).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("'figure7'") && message.contains("figure2, figure3"), "{message}");
}
