//! Figure 5: the bunny by several ranks of lights and samples. The paper shows pictures and sizes; errors can be measured.

use super::coefficients::Coefficients;
use super::encoding::{Encoding, Figures};
use super::{clusters, label, subject};
use crate::figures::stage::{Mesh, Stage};
use crate::figures::{Drawing, Figure};
use crate::tables::beside::{Beside, Cell, Column, Line};
use prt_tensor::CtaParams;

pub(super) const FIGURE: Figure =
    Figure { name: "figure5", table: Some("Figure 5: the bunny by ranks of lights and samples"), draw };

const BUNNY: Mesh = Mesh { file: Some("bunny_35k.ply"), built_in: "blob", vertices: 61_000 };

/// Ranks of lights and samples, MB of 2^20 bytes, frames per second as the view and as the light moves.
const PRINTED: [(usize, usize, f64, [f64; 2]); 4] = [
    (48, 24, 15.89, [48.65, 10.42]),
    (24, 24, 9.40, [49.21, 16.45]),
    (48, 12, 13.00, [53.47, 11.13]),
    (24, 12, 7.26, [53.96, 16.84]),
];
const MB: f64 = (1 << 20) as f64;

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let coefficients = Coefficients::of(stage, &BUNNY)?;
    stage.steps.more(PRINTED.len());
    let labels = labels(clusters(stage, coefficients.samples()));
    let encodings: Vec<Encoding> = labels.iter().map(|label| Encoding::of(stage, &coefficients, label)).collect();
    Ok(Drawing { beside: vec![beside(&coefficients, &encodings)], ..Drawing::default() })
}

pub(super) fn labels(clusters: usize) -> [String; 4] {
    PRINTED.map(|(light, sample, ..)| label(&CtaParams { clusters, light, sample, ..CtaParams::default() }))
}

fn beside(coefficients: &Coefficients, encodings: &[Encoding]) -> Beside {
    let scene = super::title(&coefficients.scene);
    let first = encodings[0].figures.as_ref().map_or(f64::NAN, |f| f.file_bytes as f64);
    let lines = PRINTED.iter().zip(encodings).flat_map(|(&(light, sample, mb, [view_hz, light_hz]), encoding)| {
        let [view_hz, light_hz] = [view_hz, light_hz].map(Cell::Printed);
        let size = [(mb * MB).into(), (mb / PRINTED[0].2).into()];
        let cells = size.into_iter().chain([Cell::Nothing, Cell::Nothing, view_hz, light_hz]).collect();
        let ours = |f: &Figures| {
            let size = [f.file_bytes.into(), (f.file_bytes as f64 / first).into()];
            let [none, hz] = [Cell::Nothing, Cell::Nothing];
            size.into_iter().chain([f.error.into(), f.relight_ms.into(), none, hz, f.encode_s.into()]).collect()
        };
        let figures = encoding.figures.as_ref().map(ours).map_err(Clone::clone);
        [
            Line::printed(format!("R_light = {light}, R_vert = {sample}"), cells),
            Line::ours(scene.clone(), (scene.clone(), encoding.label.clone()), figures),
        ]
    });
    Beside {
        addition: "",
        title: "Figure 5: ranks of lights and samples (Tsai and Shih 2006)".into(),
        subjects: vec![subject(coefficients)],
        head: "ranks",
        columns: vec![
            Column::bytes("file_bytes", "file"),
            Column::new("of_first", "of the first"),
            Column::new("error", "error"),
            Column::new("relight_rgb_all_ms", "relight ms"),
            Column::new("paper_view_hz", "Hz, view"),
            Column::new("paper_light_hz", "Hz, light"),
            Column::new("encode_s", "encode s"),
        ],
        lines: lines.collect(),
        why: "The paper shows pictures of each, whose errors it does not print. Ours is a smaller mesh with as many \
              samples a cluster, so that parts of the first size compare. It counts frames of a graphics card; \
              relighting here is the product alone, for a light that moves.",
    }
}
