//! Error against file bytes: what clusters and each rank are worth.

use super::coefficients::Coefficients;
use super::encoding::{Encoding, Figures};
use super::{available, label, title};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::{Mesh, Stage};
use crate::figures::{Drawing, Figure};
use crate::frontier::frontier;
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;
use prt_tensor::{CtaParams, Storage};
use prt_transfer::params::Value;

pub(super) const FIGURE: Figure = Figure { name: "bytes", table: None, draw };

const MESH: Mesh = Mesh { file: Some("bunny_12k.ply"), built_in: "blob", vertices: 12_000 };
/// Clusters while ranks differ: of as many members as the paper's.
const CLUSTERS: usize = 32;

/// A parameter whose values differ while the others stay at the paper's.
pub(super) struct Sweep {
    name: &'static str,
    values: &'static [usize],
    set: fn(&mut CtaParams, usize),
}

pub(super) static SWEEPS: [Sweep; 4] = [
    Sweep { name: "clusters", values: &[8, 16, 32, 64, 128], set: |p, n| p.clusters = n },
    Sweep { name: "view", values: &[4, 6, 8, 12, 16], set: |p, n| p.view = n },
    Sweep { name: "light", values: &[16, 24, 32, 48, 64, 96], set: |p, n| p.light = n },
    Sweep { name: "sample", values: &[8, 12, 16, 24, 32, 48, 64], set: |p, n| p.sample = n },
];

/// How numbers are stored.
const STORAGES: [Storage; 2] = [Storage::I16, Storage::Coded];

/// A point of a curve.
pub(super) struct Outcome {
    /// Place in [`SWEEPS`].
    sweep: usize,
    value: usize,
    /// Place in [`STORAGES`].
    storage: usize,
    encoding: Encoding,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let coefficients = Coefficients::of(stage, &available(stage, &MESH))?;
    let outcomes = outcomes(stage, &coefficients, &SWEEPS);
    Ok(Drawing {
        text: table(&coefficients, &outcomes),
        tables: vec![("", csv(&coefficients, &outcomes, &stage.machine)?)],
        chart: Some(chart(&coefficients, &outcomes)),
        measured: outcomes.iter().any(|o| o.encoding.figures.is_ok()),
        ..Drawing::default()
    })
}

/// Every setting; one on several curves is measured once.
pub(super) fn outcomes(stage: &Stage, coefficients: &Coefficients, sweeps: &[Sweep]) -> Vec<Outcome> {
    let settings = settings(coefficients.samples(), sweeps);
    let mut outcomes: Vec<Outcome> = Vec::with_capacity(settings.len());
    stage.steps.more(settings.len());
    for (sweep, value, storage, label) in settings {
        let known = outcomes.iter().find(|o| o.encoding.label == label).map(|o| o.encoding.clone());
        let encoding = known.unwrap_or_else(|| Encoding::of(stage, coefficients, &label));
        outcomes.push(Outcome { sweep, value, storage, encoding });
    }
    outcomes
}

/// Sweep, value, storage and label of each; clusters as many as suit a mesh of so many samples.
pub(super) fn settings(samples: usize, sweeps: &[Sweep]) -> Vec<(usize, usize, usize, String)> {
    let scaled = |n: usize| ((n * samples) as f64 / MESH.vertices as f64).round().max(1.0) as usize;
    // A mesh of about the size has the numbers themselves.
    let of_mesh = |n: usize| if samples.abs_diff(MESH.vertices) * 10 <= MESH.vertices { n } else { scaled(n) };
    let base = CtaParams { clusters: of_mesh(CLUSTERS), ..CtaParams::default() };
    let mut settings = Vec::new();
    for (at, sweep) in sweeps.iter().enumerate() {
        let number = |&n: &usize| if sweep.name == "clusters" { of_mesh(n) } else { n };
        let mut values: Vec<usize> = sweep.values.iter().map(number).collect();
        values.dedup();
        for (value, storage) in values.into_iter().flat_map(|value| (0..STORAGES.len()).map(move |s| (value, s))) {
            let mut params = CtaParams { numbers: STORAGES[storage], ..base.clone() };
            (sweep.set)(&mut params, value);
            settings.push((at, value, storage, label(&params)));
        }
    }
    settings
}

impl Outcome {
    fn point(&self) -> Option<(f64, f64)> {
        let Figures { file_bytes, error, .. } = self.encoding.figures.as_ref().ok()?;
        Some((*file_bytes as f64 / 1e6, *error))
    }
}

/// A panel for each storage with a curve for each parameter, and one with what is best of each storage.
fn chart(coefficients: &Coefficients, outcomes: &[Outcome]) -> Curves {
    let of = |storage: usize| outcomes.iter().filter(move |o| o.storage == storage);
    let curve = |storage: usize, sweep: usize| {
        let dot = |o: &Outcome| o.point().map(|(x, y)| Dot { x, y, label: o.value.to_string() });
        let mut dots: Vec<Dot> = of(storage).filter(|o| o.sweep == sweep).filter_map(dot).collect();
        // All curves meet at the paper's ranks, where there is no room.
        let last = dots.len().saturating_sub(1);
        dots.iter_mut().take(last).skip(1).for_each(|dot| dot.label.clear());
        dots
    };
    let best = |storage: usize| {
        let points: Vec<(f64, f64)> = of(storage).filter_map(Outcome::point).map(|(x, y)| (y, x)).collect();
        frontier(&points).into_iter().map(|i| Dot { x: points[i].1, y: points[i].0, label: String::new() }).collect()
    };
    let plane = |upwards: String, curves| Plane { upwards, across: "file, MB".into(), curves, references: Vec::new() };
    let panels = (0..STORAGES.len()).map(|s| {
        let curves = (0..SWEEPS.len()).map(|sweep| curve(s, sweep)).collect();
        plane(format!("numbers={}: relative squared error", STORAGES[s].show()), curves)
    });
    let fronts = std::iter::repeat_n(Vec::new(), SWEEPS.len()).chain((0..STORAGES.len()).map(best)).collect();
    let names = SWEEPS.iter().map(|sweep| sweep.name.to_string());
    Curves {
        title: "SRBF and CTA: what clusters and ranks are worth".into(),
        subject: subject(coefficients),
        names: names.chain(STORAGES.map(|s| format!("best of {}", s.show()))).collect(),
        remark: Some("numbers: the ends of a curve".into()),
        apart: false,
        planes: panels.chain([plane("the best of all: relative squared error".into(), fronts)]).collect(),
    }
}

fn subject(coefficients: &Coefficients) -> String {
    let base = settings(coefficients.samples(), &SWEEPS[1..2]).into_iter().find(|(_, value, ..)| *value == 8);
    let base = base.map_or(String::new(), |(.., label)| label);
    format!("{} · around {base}", super::subject(coefficients))
}

fn table(coefficients: &Coefficients, outcomes: &[Outcome]) -> String {
    let titles = ["method", "file", "in memory", "error", "encode s", "relight ms"];
    let is_first = |i: usize| outcomes[..i].iter().all(|o| o.encoding.label != outcomes[i].encoding.label);
    let distinct: Vec<&Outcome> = (0..outcomes.len()).filter(|&i| is_first(i)).map(|i| &outcomes[i]).collect();
    let rows = distinct.iter().map(|o| {
        let cells = match &o.encoding.figures {
            Err(_) => ["-", "-", "failed", "-", "-"].map(String::from),
            Ok(f) => [
                number::bytes(f.file_bytes),
                number::bytes(f.resident_bytes),
                number::short(f.error),
                number::short(f.encode_s),
                number::short(f.relight_ms),
            ],
        };
        std::iter::once(o.encoding.label.clone()).chain(cells).collect()
    });
    let failed =
        distinct.iter().filter_map(|o| Some(format!("{}: {}", o.encoding.label, o.encoding.figures.as_ref().err()?)));
    let head = format!("\nError against bytes\n{}", subject(coefficients));
    [head, aligned(&titles, rows)].into_iter().chain(failed).collect::<Vec<_>>().join("\n")
}

fn csv(coefficients: &Coefficients, outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "mesh",
        "vertices",
        "curve",
        "value",
        "numbers",
        "method",
        "status",
        "reason",
        "file_bytes",
        "resident_bytes",
        "error_srbf",
        "error",
        "encode_s",
        "relight_rgb_all_ms",
        "machine",
    ])?;
    let (mesh, vertices) = (title(&coefficients.scene), coefficients.samples().to_string());
    for o in outcomes {
        let head = [mesh.clone(), vertices.clone(), SWEEPS[o.sweep].name.into(), o.value.to_string()];
        let method = [STORAGES[o.storage].show(), o.encoding.label.clone()];
        let figures = match &o.encoding.figures {
            Err(reason) => ["failed", reason, "", "", "", "", "", ""].map(String::from),
            Ok(f) => [
                "ok".into(),
                String::new(),
                f.file_bytes.to_string(),
                f.resident_bytes.to_string(),
                coefficients.lost().to_string(),
                f.error.to_string(),
                f.encode_s.to_string(),
                f.relight_ms.to_string(),
            ],
        };
        writer.write_record(head.into_iter().chain(method).chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
