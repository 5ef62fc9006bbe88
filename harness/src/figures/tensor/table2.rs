//! Table 2: all-frequency CPCA beside SRBF and CTA at about equal bytes.

use super::segments::{LENGTH, Segmented, Segments};
use super::{available, label, own_clusters, spec};
use crate::figures::setting::{Curve, Setting};
use crate::figures::stage::{Mesh, Stage, Subject};
use crate::figures::{Drawing, Figure};
use crate::machine::Machine;
use crate::number;
use crate::scenes::{self, LIGHTS};
use crate::signal::Spec;
use crate::table::aligned;
use prt_cpca::{Clusters, CpcaParams, Mode};
use prt_tensor::CtaParams;
use prt_transfer::numbers::Width;
use prt_transfer::{Params, Shape};

pub(super) const FIGURE: Figure = Figure { name: "table2", draw };

const MESH: Mesh = Mesh { file: Some("bunny_3k.ply"), built_in: "blob", vertices: 3000 };
/// Orthonormal over the sphere.
const HAAR: &str = "haar:scale=sphere";
/// Lobes of `srbf`.
const LOBES: usize = 642;
/// Small, middle and large: multiples of the least that CPCA of whole samples can use.
const SIZES: [usize; 3] = [1, 2, 4];
/// Representatives of whole samples in the small size, for 3000 vertices.
const REPRESENTATIVES: f64 = 4.0;
/// Clusters of CPCA that are tried.
const CLUSTERS: [usize; 4] = [1, 2, 4, 8];
/// A file of CTA may differ so much from its size before its rank is chosen once more.
const NEAR: f64 = 0.05;

/// A way to compress at a size.
pub(super) struct Line {
    /// Multiple of the least.
    size: usize,
    kind: &'static str,
    method: String,
    figures: Result<Segmented, String>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    drawing(stage, &spec(), &SIZES)
}

/// The table of a signal at these sizes.
pub(super) fn drawing(stage: &Stage, spec: &Spec, sizes: &[usize]) -> anyhow::Result<Drawing> {
    let subject = stage.subject(&available(stage, &MESH), spec)?;
    let matrix = subject.matrix();
    let shape = matrix.shape();
    let (segments, light) = (Segments::of(stage, matrix, HAAR)?, scenes::light(LIGHTS[0], matrix.basis())?);
    let mut lines = Vec::new();
    for &size in sizes {
        let numbers = numbers(shape, size);
        let rival = |segments: usize| cpca(shape, numbers, segments);
        for codec in rival(1) {
            lines.push(whole(stage, &subject, size, "CPCA of whole samples", format!("{HAAR}+{codec}"))?);
        }
        stage.steps.more(CLUSTERS.len());
        for codec in rival(segments.count()) {
            let figures = segments.measure(stage, &codec, &light).map_err(|error| format!("{error:#}"));
            let (kind, method) = ("CPCA of segments", format!("{HAAR}+{}x{codec}", segments.count()));
            lines.push(Line { size, kind, method, figures });
        }
        stage.steps.done(CLUSTERS.len());
        lines.push(of_cta(stage, &subject, size, 2 * numbers)?);
    }
    Ok(Drawing {
        text: table(&subject, &lines),
        tables: vec![("", csv(&subject, &lines, &stage.machine)?)],
        chart: None,
        measured: lines.iter().any(|line| line.figures.is_ok()),
    })
}

/// What a size may store: so many representatives of whole samples, and weights for all but the mean.
pub(super) fn numbers(shape: Shape, size: usize) -> usize {
    let share = REPRESENTATIVES * shape.samples as f64 / MESH.vertices as f64;
    let vectors = size * (share.round() as usize).max(1);
    vectors * shape.responses * shape.lights + (vectors - 1) * shape.samples
}

/// CPCA of no more than so many numbers in all segments: as many components as there is room for, for each number of clusters.
pub(super) fn cpca(shape: Shape, numbers: usize, segments: usize) -> Vec<String> {
    let of_representatives = shape.responses * shape.lights;
    let components = |clusters: usize| {
        let left = numbers.checked_sub(clusters * of_representatives)?;
        Some((clusters, left / (clusters * of_representatives + segments * shape.samples)))
    };
    let fitting = CLUSTERS.into_iter().filter(|clusters| *clusters <= shape.samples).filter_map(components);
    fitting
        .map(|(clusters, components)| {
            let (clusters, mode) = (Clusters::Number(clusters), Mode::Iterative);
            let (weights, representatives) = (Width::I16, Width::I16);
            let params = CpcaParams { clusters, components, mode, weights, representatives, ..CpcaParams::default() };
            params.to_stage().to_string()
        })
        .collect()
}

/// CTA of about so many bytes in a file.
fn of_cta(stage: &Stage, subject: &Subject, size: usize, bytes: usize) -> anyhow::Result<Line> {
    let shape = subject.matrix().shape();
    let measured = |bytes: f64| whole(stage, subject, size, "SRBF and CTA", label(&cta(shape, size, bytes / 2.0)));
    let line = measured(bytes as f64)?;
    let Ok(Segmented { file_bytes, .. }) = line.figures else { return Ok(line) };
    let factor = bytes as f64 / file_bytes as f64;
    if (factor - 1.0).abs() < NEAR { Ok(line) } else { measured(bytes as f64 * factor) }
}

/// The paper's members of a cluster, less in larger sizes, and its ranks of views and lights; the rank of samples is what there is room for:
/// Σ_c light (lobes + sample view) + samples · sample numbers.
pub(super) fn cta(shape: Shape, size: usize, numbers: f64) -> CtaParams {
    let (clusters, base) = ((own_clusters(shape.samples) * size).min(shape.samples), CtaParams::default());
    let view = base.view.min(shape.responses);
    let left = numbers - (clusters * base.light * LOBES) as f64;
    let of_a_rank = clusters * base.light * view + shape.samples;
    let sample = (left / of_a_rank as f64).round().clamp(1.0, 4096.0) as usize;
    CtaParams { clusters, sample, ..base }
}

/// As the bench measures.
fn whole(stage: &Stage, subject: &Subject, size: usize, kind: &'static str, method: String) -> anyhow::Result<Line> {
    let curves = [Curve::new(kind, [Setting::whole(&method)])];
    let mut outcomes = stage.measure(subject, &curves)?;
    let row = outcomes.remove(0).row;
    let figures = || {
        Some(Segmented {
            file_bytes: row.file_bytes?,
            resident_bytes: row.resident_bytes?,
            error: row.error_sphere?,
            encode_s: row.encode_s?,
            relight_ms: row.relight_rgb_all_ms?,
        })
    };
    let figures = figures().filter(|_| row.is_ok()).ok_or_else(|| row.reason.clone());
    Ok(Line { size, kind, method, figures })
}

fn table(subject: &Subject, lines: &[Line]) -> String {
    let titles = ["method", "size", "file", "in memory", "error", "encode s", "relight ms"];
    let rows = lines.iter().map(|line| {
        let cells = match &line.figures {
            Err(_) => ["-", "-", "failed", "-", "-"].map(String::from),
            Ok(f) => [
                number::bytes(f.file_bytes),
                number::bytes(f.resident_bytes),
                number::short(f.error),
                number::short(f.encode_s),
                number::short(f.relight_ms),
            ],
        };
        [line.method.clone(), line.size.to_string()].into_iter().chain(cells).collect()
    });
    let failed = lines.iter().filter_map(|line| Some(format!("{}: {}", line.method, line.figures.as_ref().err()?)));
    let head = format!("\nTable 2: all-frequency CPCA, and SRBF with CTA, at about equal bytes\n{}", subject.title());
    let segments = format!("24xcpca: each of 24 segments of {LENGTH} Haar coefficients by itself");
    [head, aligned(&titles, rows), segments].into_iter().chain(failed).collect::<Vec<_>>().join("\n")
}

fn csv(subject: &Subject, lines: &[Line], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "subject",
        "size",
        "kind",
        "method",
        "status",
        "reason",
        "file_bytes",
        "resident_bytes",
        "error_sphere",
        "encode_s",
        "relight_rgb_all_ms",
        "machine",
    ])?;
    for line in lines {
        let head = [subject.title(), line.size.to_string(), line.kind.into(), line.method.clone()];
        let figures = match &line.figures {
            Err(reason) => ["failed", reason, "", "", "", "", ""].map(String::from),
            Ok(f) => [
                "ok".into(),
                String::new(),
                f.file_bytes.to_string(),
                f.resident_bytes.to_string(),
                f.error.to_string(),
                f.encode_s.to_string(),
                f.relight_ms.to_string(),
            ],
        };
        writer.write_record(head.into_iter().chain(figures).chain([machine.line()]))?;
    }
    Ok(writer.into_inner()?)
}
