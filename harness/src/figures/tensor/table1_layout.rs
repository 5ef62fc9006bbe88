//! Table 1 as people and as programs read it.

use super::encoding::{Encoding, Figures};
use super::table1::{Line, Measured, Ours, SETTINGS};
use crate::machine::Machine;
use crate::number;
use crate::table::aligned;
use prt_transfer::params::Value;

const TITLE: &str = "Table 1: transfer in lobes and clustered tensors (Tsai and Shih 2006)";

/// The paper's line, then a line for each of our labels; then what failed.
pub(super) fn text(lines: &[Measured]) -> String {
    let titles = [
        "model",
        "vertices",
        "clusters",
        "in memory",
        "file",
        "T / file",
        "SRBF",
        "+ CTA",
        "encode s",
        "peak",
        "relight ms",
    ];
    let rows = lines.iter().flat_map(|measured| {
        let ours = measured.ours.iter().flatten();
        std::iter::once(of_paper(measured.line)).chain(ours.flat_map(|ours| (0..SETTINGS.len()).map(|i| of(ours, i))))
    });
    let table = aligned(&titles, rows);
    let subjects = lines.iter().filter_map(|line| line.ours.as_ref()?.as_ref().ok()).map(subject);
    let parts = std::iter::once(format!("\n{TITLE}")).chain(subjects).chain([table]);
    parts.chain(lines.iter().flat_map(failures)).collect::<Vec<_>>().join("\n")
}

fn subject(ours: &Ours) -> String {
    let [raw, lobes] = ours.bytes.map(number::bytes);
    let Ours { scene, samples, precompute_s, .. } = ours;
    let seconds = number::short(*precompute_s);
    format!("{scene}: {samples} vertices, T {raw}, in lobes at 16 bits {lobes}, precomputed in {seconds} s")
}

fn of_paper(line: &Line) -> Vec<String> {
    let Line { model, vertices, clusters, bytes: [raw, _, file], errors, seconds, .. } = line;
    let (file_bytes, ratio) = (number::bytes(*file as u64), number::short(raw / file));
    let [srbf, cta] = errors.map(number::short);
    let name = format!("{model}, the paper's");
    let (vertices, seconds, none) = (format!("{vertices}k"), format!("{}", seconds[1]), || "-".to_string());
    vec![name, vertices, clusters.to_string(), none(), file_bytes, ratio, srbf, cta, seconds, none(), none()]
}

fn of(ours: &Ours, setting: usize) -> Vec<String> {
    let (encoding, (view, numbers)) = (&ours.encodings[setting], SETTINGS[setting]);
    let figure = |show: &dyn Fn(&Figures) -> Option<String>| {
        encoding.figures.as_ref().ok().and_then(show).unwrap_or_else(|| "-".into())
    };
    vec![
        format!("  view={view}, {}", numbers.show()),
        ours.samples.to_string(),
        ours.clusters.to_string(),
        figure(&|f| Some(number::bytes(f.resident_bytes))),
        figure(&|f| Some(number::bytes(f.file_bytes))),
        figure(&|f| Some(number::short(ours.bytes[0] as f64 / f.file_bytes as f64))),
        number::short(ours.lost),
        figure(&|f| Some(number::short(f.error))),
        figure(&|f| Some(number::short(f.encode_s))),
        figure(&|f| f.peak_bytes.map(number::bytes)),
        figure(&|f| Some(number::short(f.relight_ms))),
    ]
}

fn failures(measured: &Measured) -> Vec<String> {
    let model = measured.line.model;
    match &measured.ours {
        None => vec![format!("{model}: no mesh stands in for it")],
        Some(Err(reason)) => vec![format!("{model}: {reason}")],
        Some(Ok(ours)) => {
            let failed = ours.encodings.iter().filter_map(|e| Some((e, e.figures.as_ref().err()?)));
            failed.map(|(e, reason)| format!("{}, {}: {reason}", ours.scene, e.label)).collect()
        }
    }
}

/// A line for each of the text's, and for each failure; ours with the machine in every line.
pub(super) fn csv(lines: &[Measured], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "source",
        "mesh",
        "vertices",
        "clusters",
        "method",
        "status",
        "reason",
        "raw_bytes",
        "lobe_bytes",
        "resident_bytes",
        "file_bytes",
        "ratio",
        "error_srbf",
        "error",
        "precompute_s",
        "encode_s",
        "peak_encode_bytes",
        "relight_rgb_all_ms",
        "machine",
    ])?;
    for measured in lines {
        writer.write_record(paper_record(measured.line))?;
        match &measured.ours {
            None => {}
            Some(Err(reason)) => writer.write_record(missing_record(measured.line, reason, machine))?,
            Some(Ok(ours)) => {
                ours.encodings.iter().try_for_each(|e| writer.write_record(record(ours, e, machine)))?;
            }
        }
    }
    Ok(writer.into_inner()?)
}

fn paper_record(line: &Line) -> [String; 19] {
    let [raw, lobes, file] = line.bytes;
    [
        "paper".into(),
        line.model.into(),
        (1000 * line.vertices).to_string(),
        line.clusters.to_string(),
        "SRBF+CTA, ranks 8 x 48 x 24".into(),
        "ok".into(),
        String::new(),
        raw.round().to_string(),
        lobes.round().to_string(),
        String::new(),
        file.round().to_string(),
        (raw / file).to_string(),
        line.errors[0].to_string(),
        line.errors[1].to_string(),
        line.seconds[0].to_string(),
        line.seconds[1].to_string(),
        String::new(),
        String::new(),
        "AMD Athlon 64 FX-55, NVIDIA GeForce 6800".into(),
    ]
}

fn missing_record(line: &Line, reason: &str, machine: &Machine) -> [String; 19] {
    let mut cells = [const { String::new() }; 19];
    (cells[0], cells[1], cells[5]) = ("measured".into(), line.model.into(), "failed".into());
    (cells[6], cells[18]) = (reason.into(), machine.line());
    cells
}

fn record(ours: &Ours, encoding: &Encoding, machine: &Machine) -> [String; 19] {
    let figures = encoding.figures.as_ref().ok();
    let figure = |show: &dyn Fn(&Figures) -> String| figures.map_or(String::new(), show);
    [
        "measured".into(),
        ours.scene.clone(),
        ours.samples.to_string(),
        ours.clusters.to_string(),
        encoding.label.clone(),
        if figures.is_some() { "ok" } else { "failed" }.into(),
        encoding.figures.as_ref().err().cloned().unwrap_or_default(),
        ours.bytes[0].to_string(),
        ours.bytes[1].to_string(),
        figure(&|f| f.resident_bytes.to_string()),
        figure(&|f| f.file_bytes.to_string()),
        figure(&|f| (ours.bytes[0] as f64 / f.file_bytes as f64).to_string()),
        ours.lost.to_string(),
        figure(&|f| f.error.to_string()),
        ours.precompute_s.to_string(),
        figure(&|f| f.encode_s.to_string()),
        figure(&|f| f.peak_bytes.map_or(String::new(), |bytes| bytes.to_string())),
        figure(&|f| f.relight_ms.to_string()),
        machine.line(),
    ]
}
