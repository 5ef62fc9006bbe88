//! Table 2: all-frequency CPCA beside SRBF and CTA at about equal bytes.

use super::segments::{Segmented, Segments};
use super::{available, label, own_clusters, spec, table2_layout};
use crate::figures::setting::{Curve, Setting};
use crate::figures::stage::{Mesh, Stage, Subject};
use crate::figures::{Drawing, Figure};
use crate::lights::{self, LIGHTS};
use crate::signal::Spec;
use ndarray::Array2;
use prt_cpca::{Clusters, CpcaParams, Mode};
use prt_tensor::CtaParams;
use prt_transfer::numbers::Width;
use prt_transfer::{Params, Shape};

pub(super) const FIGURE: Figure =
    Figure { name: "table2", table: Some("Table 2: beside all-frequency clustered PCA, at about equal bytes"), draw };

const MESH: Mesh = Mesh { file: Some("bunny_3k.ply"), built_in: "blob", vertices: 3000 };
/// Orthonormal over the sphere.
pub(super) const HAAR: &str = "haar:scale=sphere";
/// Lobes of `srbf`.
const LOBES: usize = 642;
/// Small, middle and large: multiples of the least that CPCA of whole samples can use.
const SIZES: [usize; 3] = [1, 2, 4];
/// Representatives of whole samples in the small size, for 3000 vertices.
const REPRESENTATIVES: f64 = 4.0;
/// Clusters of CPCA that are tried.
const CLUSTERS: [usize; 3] = [1, 2, 4];
/// A file of CTA may differ so much from its size before its rank is chosen once more.
const NEAR: f64 = 0.05;

/// What is compared.
pub(super) const KINDS: [&str; 4] =
    ["CPCA of whole samples", "CPCA of segments", "SRBF and CTA", "SRBF and CTA, all views"];

/// A way to compress at a size.
pub(super) struct Line {
    /// Multiple of the least.
    pub(super) size: usize,
    pub(super) kind: &'static str,
    pub(super) method: String,
    pub(super) figures: Result<Segmented, String>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    drawing(stage, &spec(), &SIZES)
}

/// The table of a signal at these sizes.
pub(super) fn drawing(stage: &Stage, spec: &Spec, sizes: &[usize]) -> anyhow::Result<Drawing> {
    let subject = stage.subject(&available(stage, &MESH), spec)?;
    let segments = Segments::of(stage, subject.matrix(), HAAR)?;
    let light = lights::light(LIGHTS[0], subject.matrix().basis())?;
    let mut rivals = Rivals { stage, subject: &subject, segments: &segments, light: &light, stored: [1.0; 4] };
    let mut lines = Vec::new();
    for &size in sizes {
        lines.extend(rivals.of_size(size)?);
    }
    Ok(Drawing { beside: vec![table2_layout::beside(subject.title(), &lines)], ..Drawing::default() })
}

/// What is compared, on what.
struct Rivals<'a> {
    stage: &'a Stage<'a>,
    subject: &'a Subject,
    segments: &'a Segments,
    light: &'a Array2<f32>,
    /// What files of each of [`KINDS`] take of the bytes of their numbers, as far as is known.
    stored: [f64; 4],
}

impl Rivals<'_> {
    /// CPCA of as many clusters as are tried, then CTA.
    fn of_size(&mut self, size: usize) -> anyhow::Result<Vec<Line>> {
        let shape = self.subject.matrix().shape();
        let (bytes, count, mut stored) = (2 * numbers(shape, size), self.segments.count(), self.stored);
        let mut lines = Vec::new();
        for (kind, parts) in [(0, 1), (1, count)] {
            for clusters in CLUSTERS {
                let choose = |numbers| cpca(shape, numbers, parts, clusters);
                let numbers_of = |params: &CpcaParams| numbers_of_cpca(shape, params, parts);
                let measure = |params: &CpcaParams| self.cpca(size, kind, &params.to_stage().to_string());
                lines.extend(near((bytes, &mut stored[kind]), choose, numbers_of, measure)?);
            }
        }
        for (kind, view) in [(2, CtaParams::default().view), (3, shape.responses)] {
            let choose = |numbers| Some(cta(shape, size, view, numbers));
            let measure = |params: &CtaParams| self.whole(size, kind, label(params));
            lines.extend(near((bytes, &mut stored[kind]), choose, |params| numbers_of_cta(shape, params), measure)?);
        }
        self.stored = stored;
        Ok(lines)
    }

    /// Of whole samples or of segments.
    fn cpca(&self, size: usize, kind: usize, codec: &str) -> anyhow::Result<Line> {
        if kind == 0 {
            return self.whole(size, kind, format!("{HAAR}+{codec}"));
        }
        let method = format!("{HAAR}+{}x{codec}", self.segments.count());
        self.stage.steps.show(&method);
        let figures = self.segments.measure(self.stage, codec, self.light).map_err(|error| format!("{error:#}"));
        Ok(Line { size, kind: KINDS[kind], method, figures })
    }

    /// As the bench measures.
    fn whole(&self, size: usize, kind: usize, method: String) -> anyhow::Result<Line> {
        let curves = [Curve::new(KINDS[kind], [Setting::whole(&method)])];
        let row = self.stage.measure(self.subject, &curves)?.remove(0).row;
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
        Ok(Line { size, kind: KINDS[kind], method, figures })
    }
}

/// What a size may store: so many representatives of whole samples, and weights for all but the mean.
pub(super) fn numbers(shape: Shape, size: usize) -> usize {
    let share = REPRESENTATIVES * shape.samples as f64 / MESH.vertices as f64;
    let vectors = size * (share.round() as usize).max(1);
    vectors * shape.responses * shape.lights + (vectors - 1) * shape.samples
}

/// A method whose file has about so many bytes; none where there is no room for any. Of what is to be stored in 16 bits the file takes the
/// part `stored`: known from the line before, and if that was wrong measured again.
fn near<P: PartialEq>(
    (bytes, stored): (usize, &mut f64),
    choose: impl Fn(f64) -> Option<P>,
    numbers_of: impl Fn(&P) -> usize,
    measure: impl Fn(&P) -> anyhow::Result<Line>,
) -> anyhow::Result<Option<Line>> {
    let numbers = |stored: f64| bytes as f64 / (2.0 * stored);
    let Some(first) = choose(numbers(*stored)) else { return Ok(None) };
    let line = measure(&first)?;
    let Ok(Segmented { file_bytes, .. }) = line.figures else { return Ok(Some(line)) };
    *stored = file_bytes as f64 / (2 * numbers_of(&first)) as f64;
    let is_near = (file_bytes as f64 / bytes as f64 - 1.0).abs() < NEAR;
    match choose(numbers(*stored)).filter(|again| !is_near && *again != first) {
        Some(again) => measure(&again).map(Some),
        None => Ok(Some(line)),
    }
}

/// CPCA of no more than so many numbers in all segments: as many components as there is room for.
pub(super) fn cpca(shape: Shape, numbers: f64, segments: usize, clusters: usize) -> Option<CpcaParams> {
    let (mode, weights, representatives) = (Mode::Iterative, Width::I16, Width::I16);
    let of = |components| {
        let clusters = Clusters::Number(clusters);
        CpcaParams { clusters, components, mode, weights, representatives, ..CpcaParams::default() }
    };
    let [none, one] = [0, 1].map(|components| numbers_of_cpca(shape, &of(components), segments) as f64);
    (none <= numbers).then(|| of(((numbers - none) / (one - none)) as usize))
}

/// Means, components and weights of all segments.
pub(super) fn numbers_of_cpca(shape: Shape, params: &CpcaParams, segments: usize) -> usize {
    let Clusters::Number(clusters) = params.clusters else { return 0 };
    clusters * (params.components + 1) * shape.responses * shape.lights + params.components * segments * shape.samples
}

/// The paper's members of a cluster, less in larger sizes, and its rank of lights; the rank of samples is what there is room for.
pub(super) fn cta(shape: Shape, size: usize, view: usize, numbers: f64) -> CtaParams {
    let (clusters, base) = ((own_clusters(shape.samples) * size).min(shape.samples), CtaParams::default());
    let of = |sample| CtaParams { clusters, view, sample, ..base.clone() };
    let [one, two] = [1, 2].map(|sample| numbers_of_cta(shape, &of(sample)) as f64);
    of(((numbers - one) / (two - one)).round().clamp(0.0, 4095.0) as usize + 1)
}

/// Bases of the lights, dual bases and weights.
pub(super) fn numbers_of_cta(shape: Shape, params: &CtaParams) -> usize {
    let CtaParams { clusters, light, sample, .. } = *params;
    clusters * light * (LOBES + sample * params.view.min(shape.responses)) + shape.samples * sample
}
