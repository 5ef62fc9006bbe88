//! Error against bytes: components and clusters on a matte, a textured and a glossy shape, poles weighted or not.

use super::{WORLD, field, world};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::error_sums::relative;
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::light_field::{Compression, compressed};
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;
use prt_transfer::responses::Directions;
use prt_transfer::scene::light_field::{FieldParams, Horizon};
use prt_transfer::{Metric, TransferMatrix};

pub(super) const FIGURE: Figure = Figure { name: "bytes", table: None, draw };

/// A panel.
struct Subject {
    shape: &'static str,
    title: &'static str,
    params: FieldParams,
}

/// A curve: k, and what else the label says.
struct Family {
    name: &'static str,
    components: usize,
    rest: &'static str,
}

const FAMILIES: [Family; 7] = [
    Family { name: "k = 1", components: 1, rest: ":norm=radiance" },
    Family { name: "k = 2", components: 2, rest: ":norm=radiance" },
    Family { name: "k = 4", components: 4, rest: ":norm=radiance" },
    Family { name: "k = 8", components: 8, rest: ":norm=radiance" },
    Family { name: "k = 16", components: 16, rest: ":norm=radiance" },
    Family { name: "k = 8, poles not weighted", components: 8, rest: ":norm=coefficients" },
    Family { name: "k = 8, Haar", components: 8, rest: ":norm=radiance:maps=haar" },
];

/// η of Table 1's reach, in steps of four where fewer are wanted.
const CLUSTERS: [usize; 10] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512];

struct Outcome {
    subject: usize,
    family: usize,
    clusters: usize,
    made: Result<Compression, String>,
}

fn subjects(stage: &Stage) -> [Subject; 4] {
    let side = if stage.is_paper_sized() { 128 } else { 48 };
    let (around, down) = if stage.is_paper_sized() { (64, 32) } else { (32, 16) };
    let base = FieldParams { width: side, height: side, around, down, ..FieldParams::default() };
    let matte = FieldParams { horizon: Horizon::Dark, ..base.clone() };
    [
        Subject { shape: "torus", title: "torus, matte", params: matte.clone() },
        Subject { shape: "left-wall", title: "left-wall, textured", params: matte },
        Subject { shape: "blue-sphere", title: "blue-sphere, glossy", params: base.clone() },
        Subject {
            shape: "blue-sphere",
            title: "the same, reflected",
            params: FieldParams { frame: Directions::Reflected, ..base },
        },
    ]
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let (world, subjects, folder) = (world()?, subjects(stage), tempfile::tempdir()?);
    let (mut outcomes, mut noises) = (Vec::new(), Vec::new());
    stage.steps.more(subjects.len() * (2 + FAMILIES.len() * CLUSTERS.len()));
    for (subject, of) in subjects.iter().enumerate() {
        let matrix = field(stage, &world, of.shape, &of.params, 0)?;
        noises.push(noise(&matrix, &field(stage, &world, of.shape, &of.params, 1)?)?);
        for (family, Family { components, rest, .. }) in FAMILIES.iter().enumerate() {
            for clusters in CLUSTERS {
                let label = format!("slf:clusters={clusters}:components={components}{rest}");
                stage.steps.show(&format!("{} {label}", of.shape));
                let path = folder.path().join("field.prt");
                let registry = stage.bench.registry;
                let encode = || compressed(&matrix, &label.parse()?, registry, &path, &Unseen);
                let made = stage.bench.pools.everywhere(encode).map_err(|e| format!("{e:#}"));
                outcomes.push(Outcome { subject, family, clusters, made });
                stage.steps.done(1);
            }
        }
    }
    Ok(Drawing {
        text: table(&subjects, &outcomes, &noises),
        tables: vec![("", csv(&subjects, &outcomes, &noises, &stage.machine)?)],
        chart: Some(chart(&subjects, &outcomes)),
        measured: outcomes.iter().any(|o| o.made.is_ok()),
        ..Drawing::default()
    })
}

/// The variance of tracing, half the squared difference of two seeds, as a part of the square; over the sphere.
fn noise(a: &TransferMatrix, b: &TransferMatrix) -> anyhow::Result<f64> {
    let (metric, lights) = (Metric::of(a)?, a.lights());
    let (mut differences, mut whole) = (0.0, 0.0);
    let [mut one, mut other] = [vec![0f32; lights], vec![0f32; lights]];
    for row in 0..a.rows() {
        a.gather(row, &mut one);
        b.gather(row, &mut other);
        let mut difference: Vec<f64> = one.iter().zip(&other).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect();
        differences += metric.square_of(&mut difference, lights);
        whole += metric.square_of(&mut one.iter().map(|a| f64::from(*a)).collect::<Vec<_>>(), lights);
    }
    Ok(relative(0.5 * differences, whole))
}

fn chart(subjects: &[Subject], outcomes: &[Outcome]) -> Curves {
    let dot = |o: &Outcome| {
        let made = o.made.as_ref().ok();
        Dot {
            x: made.map_or(f64::NAN, |s| s.file_bytes as f64),
            y: made.map_or(f64::NAN, |s| s.error_sphere),
            label: String::new(),
        }
    };
    let curve = |subject: usize, family: usize| {
        outcomes.iter().filter(|o| (o.subject, o.family) == (subject, family)).map(dot).collect()
    };
    let plane = |(subject, of): (usize, &Subject)| Plane {
        upwards: format!("{}: relative squared error", of.title),
        across: "bytes of the file".into(),
        curves: (0..FAMILIES.len()).map(|family| curve(subject, family)).collect(),
        references: Vec::new(),
    };
    let FieldParams { width, height, around, down, .. } = subjects[0].params;
    Curves {
        title: "Surface light fields: error against bytes".into(),
        subject: format!(
            "{WORLD} · {width} x {height} texels · {around} x {down} directions · η from 1 to 512 along each curve"
        ),
        remark: None,
        names: FAMILIES.iter().map(|f| f.name.into()).collect(),
        apart: true,
        planes: subjects.iter().enumerate().map(plane).collect(),
    }
}

fn table(subjects: &[Subject], outcomes: &[Outcome], noises: &[f64]) -> String {
    let titles = ["shape", "curve", "η", "Eq. 5", "memory", "file", "error", "encode s"];
    let shown = |o: &&Outcome| [1, 16, 256].contains(&o.clusters);
    let lines = outcomes.iter().filter(shown).map(|o| {
        let head = [subjects[o.subject].title.to_string(), FAMILIES[o.family].name.into(), o.clusters.to_string()];
        let figures = match &o.made {
            Err(_) => ["failed", "-", "-", "-", "-"].map(String::from),
            Ok(s) => [
                s.counts.as_ref().map_or("-".into(), |c| number::short(c.ratio)),
                number::bytes(s.resident_bytes),
                number::bytes(s.file_bytes),
                number::short(s.error_sphere),
                number::short(s.encode_s),
            ],
        };
        head.into_iter().chain(figures).collect()
    });
    let failed = outcomes.iter().filter_map(|o| {
        let reason = o.made.as_ref().err()?;
        Some(format!("{}, {}, η = {}: {reason}", subjects[o.subject].title, FAMILIES[o.family].name, o.clusters))
    });
    let table = format!("\nError against bytes\n{}", aligned(&titles, lines));
    let noises = subjects
        .iter()
        .zip(noises)
        .map(|(of, noise)| format!("{}: tracing has a variance of {} of the square", of.title, number::short(*noise)));
    std::iter::once(table).chain(noises).chain(failed).collect::<Vec<_>>().join("\n")
}

fn csv(subjects: &[Subject], outcomes: &[Outcome], noises: &[f64], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "shape",
        "method",
        "clusters",
        "ratio_eq5",
        "resident_bytes",
        "file_bytes",
        "error_sphere",
        "error",
        "encode_s",
        "reason",
        "tracing_noise",
        "machine",
    ])?;
    for o in outcomes {
        let Family { components, rest, .. } = &FAMILIES[o.family];
        let method = format!("slf:clusters={}:components={components}{rest}", o.clusters);
        let head = [subjects[o.subject].title.to_string(), method, o.clusters.to_string()];
        let figures = match &o.made {
            Ok(s) => [
                s.counts.as_ref().map(|c| c.ratio.to_string()).unwrap_or_default(),
                s.resident_bytes.to_string(),
                s.file_bytes.to_string(),
                s.error_sphere.to_string(),
                s.error.to_string(),
                s.encode_s.to_string(),
                String::new(),
            ],
            Err(reason) => std::array::from_fn(|i| if i == 6 { reason.clone() } else { String::new() }),
        };
        writer.write_record(head.into_iter().chain(figures).chain([noises[o.subject].to_string(), machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
