//! Table 1, each of the paper's columns as a line with ours below it.

use super::encoding::Figures;
use super::table1::{Line as Model, Measured, Ours, SETTINGS};
use crate::number::{bytes, short};
use crate::tables::beside::{Beside, Cell, Column, Line};
use prt_transfer::params::Value;

/// The paper's line, then a line for each of our labels.
pub(super) fn beside(lines: &[Measured]) -> Beside {
    let block = |measured: &Measured| {
        let ours = match &measured.ours {
            None => vec![missing(measured.line, "no mesh stands in for it")],
            Some(Err(reason)) => vec![missing(measured.line, reason)],
            Some(Ok(ours)) => (0..SETTINGS.len()).map(|setting| of(ours, setting)).collect(),
        };
        std::iter::once(of_paper(measured.line)).chain(ours)
    };
    Beside {
        addition: "",
        title: "Table 1: transfer in lobes and clustered tensors (Tsai and Shih 2006)".into(),
        subjects: lines.iter().filter_map(|line| line.ours.as_ref()?.as_ref().ok()).map(subject).collect(),
        head: "model",
        columns: vec![
            Column::whole("vertices", "vertices"),
            Column::whole("clusters", "clusters"),
            Column::bytes("raw_bytes", ""),
            Column::bytes("lobe_bytes", ""),
            Column::bytes("resident_bytes", "in memory"),
            Column::bytes("file_bytes", "file"),
            Column::new("ratio", "T / file"),
            Column::new("error_srbf", "SRBF"),
            Column::new("error", "+ CTA"),
            Column::new("precompute_s", ""),
            Column::new("encode_s", "encode s"),
            Column::bytes("peak_encode_bytes", "peak"),
            Column::new("relight_rgb_all_ms", "relight ms"),
        ],
        lines: lines.iter().flat_map(block).collect(),
        why: "Meshes and the roughness of the BRDF were not published. view=8 loses more here than in the paper: our \
              terms are weighted as a picture shows them, and the best eight directions hold some 85 % of their square; \
              all 16 are worth their bytes. The paper's GB and MB are powers of two, its times those of an Athlon 64 \
              FX-55. Its frames per second (view moves / light moves) were 75/16, 51/13 and 49/10.",
    }
}

fn subject(ours: &Ours) -> String {
    let [raw, lobes] = ours.bytes.map(bytes);
    let Ours { scene, samples, precompute_s, .. } = ours;
    let seconds = short(*precompute_s);
    format!("{scene}: {samples} vertices, T {raw}, in lobes at 16 bits {lobes}, precomputed in {seconds} s")
}

fn of_paper(model: &Model) -> Line {
    let [raw, lobes, file] = model.bytes;
    let [srbf, cta] = model.errors.map(Cell::Printed);
    let [precompute, encode] = model.seconds.map(Cell::Printed);
    let sizes = [Cell::from(1000 * model.vertices), model.clusters.into(), raw.into(), lobes.into(), Cell::Nothing];
    let figures = [file.into(), (raw / file).into(), srbf, cta, precompute, encode];
    Line::printed(model.model, sizes.into_iter().chain(figures).collect())
}

fn missing(model: &Model, reason: &str) -> Line {
    Line::ours(model.model, (model.model, ""), Err(reason.into()))
}

fn of(ours: &Ours, setting: usize) -> Line {
    let (encoding, (view, numbers)) = (&ours.encodings[setting], SETTINGS[setting]);
    let [raw, lobes] = ours.bytes;
    let cells = |f: &Figures| {
        vec![
            ours.samples.into(),
            ours.clusters.into(),
            raw.into(),
            lobes.into(),
            f.resident_bytes.into(),
            f.file_bytes.into(),
            (raw as f64 / f.file_bytes as f64).into(),
            ours.lost.into(),
            f.error.into(),
            ours.precompute_s.into(),
            f.encode_s.into(),
            f.peak_bytes.into(),
            f.relight_ms.into(),
        ]
    };
    let name = format!("{}, view={view}, {}", ours.scene, numbers.show());
    Line::ours(name, (&ours.scene, &encoding.label), encoding.figures.as_ref().map(cells).map_err(Clone::clone))
}
