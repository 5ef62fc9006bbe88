//! Table 1: storage, error and time of each of the paper's models.

use super::coefficients::Coefficients;
use super::encoding::Encoding;
use super::table1_layout::beside;
use super::{clusters, label};
use crate::figures::stage::{Mesh, Stage};
use crate::figures::{Drawing, Figure};
use prt_tensor::{CtaParams, Storage};

pub(super) const FIGURE: Figure =
    Figure { name: "table1", table: Some("Table 1: storage, error and time of each model"), draw };

/// A column of the paper's table.
pub(super) struct Line {
    pub(super) model: &'static str,
    /// In thousands, as it is printed.
    pub(super) vertices: usize,
    pub(super) clusters: usize,
    /// Bytes of T, of T in lobes, and of the compressed data.
    pub(super) bytes: [f64; 3],
    /// SE ratio of SRBF, and of SRBF and CTA.
    pub(super) errors: [f64; 2],
    /// Precomputation and compression, s.
    pub(super) seconds: [f64; 2],
    /// What stands in for it here, if anything.
    pub(super) mesh: Option<Mesh>,
}

const MB: f64 = (1 << 20) as f64;
const GB: f64 = (1 << 30) as f64;
const TEAPOT: Mesh = Mesh { file: Some("teapot_40k.ply"), built_in: "teapot", vertices: 41_000 };
const BUNNY: Mesh = Mesh { file: Some("bunny_35k.ply"), built_in: "blob", vertices: 61_000 };

pub(super) static LINES: [Line; 3] = [
    Line {
        model: "Teapot",
        vertices: 41,
        clusters: 110,
        bytes: [15.11 * GB, 0.79 * GB, 10.37 * MB],
        errors: [0.0123, 0.0391],
        seconds: [minutes(1, 53), minutes(16, 6)],
        mesh: Some(TEAPOT),
    },
    Line {
        model: "Buddha",
        vertices: 52,
        clusters: 140,
        bytes: [19.12 * GB, 1.00 * GB, 13.18 * MB],
        errors: [0.0141, 0.0375],
        seconds: [minutes(2, 19), minutes(24, 16)],
        mesh: None,
    },
    Line {
        model: "Bunny",
        vertices: 61,
        clusters: 170,
        bytes: [22.35 * GB, 1.17 * GB, 15.89 * MB],
        errors: [0.0128, 0.0364],
        seconds: [minutes(2, 47), minutes(29, 2)],
        mesh: Some(BUNNY),
    },
];

const fn minutes(hours: u32, minutes: u32) -> f64 {
    (3600 * hours + 60 * minutes) as f64
}

/// A line with what was measured for it.
pub(super) struct Measured {
    pub(super) line: &'static Line,
    /// Nothing where no mesh stands in; the reason where there should be one.
    pub(super) ours: Option<Result<Ours, String>>,
}

/// A mesh and every label on it.
pub(super) struct Ours {
    pub(super) scene: String,
    pub(super) samples: usize,
    /// Of T, and of T in lobes at 16 bits.
    pub(super) bytes: [u64; 2],
    pub(super) clusters: usize,
    /// Of SRBF alone.
    pub(super) lost: f64,
    pub(super) precompute_s: f64,
    pub(super) encodings: Vec<Encoding>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let lines: Vec<Measured> = LINES.iter().map(|line| measured(stage, line)).collect();
    Ok(Drawing { beside: vec![beside(&lines)], ..Drawing::default() })
}

fn measured(stage: &Stage, line: &'static Line) -> Measured {
    let of = |mesh| ours(stage, mesh).map_err(|error| format!("{error:#}"));
    Measured { line, ours: line.mesh.as_ref().map(of) }
}

fn ours(stage: &Stage, mesh: &Mesh) -> anyhow::Result<Ours> {
    stage.steps.more(5);
    let coefficients = Coefficients::of(stage, mesh)?;
    stage.steps.done(1);
    let samples = coefficients.samples();
    let clusters = clusters(stage, samples);
    let rows = coefficients.matrix.rows() as u64;
    Ok(Ours {
        scene: super::title(&coefficients.scene),
        samples,
        bytes: [4 * rows * coefficients.basis.lights() as u64, 2 * rows * coefficients.matrix.lights() as u64],
        clusters,
        lost: coefficients.lost(),
        precompute_s: coefficients.seconds,
        encodings: labels(clusters).iter().map(|label| Encoding::of(stage, &coefficients, label)).collect(),
    })
}

/// View rank and storage: the paper's ranks (light 48, sample 24), then every BRDF term; numbers of 16 bits, then coded ones.
pub(super) static SETTINGS: [(usize, Storage); 4] =
    [(8, Storage::I16), (8, Storage::Coded), (16, Storage::I16), (16, Storage::Coded)];

/// The label of each of [`SETTINGS`].
pub(super) fn labels(clusters: usize) -> Vec<String> {
    let params = SETTINGS.iter().map(|&(view, numbers)| CtaParams { clusters, view, numbers, ..CtaParams::default() });
    params.map(|params| label(&params)).collect()
}
