//! What one setting cost, and what a figure can have across.

use super::setting::{Curve, Setting};
use super::stage::Subject;
use crate::machine::Machine;
use crate::number;
use crate::row::Row;
use crate::table::aligned;

/// The measurement of a setting.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Place of its curve.
    pub curve: usize,
    /// What was measured.
    pub setting: Setting,
    /// What came out.
    pub row: Row,
    /// Σ T², which turns the relative squared error into the paper's SE.
    pub square: f64,
}

/// A quantity that a figure has across.
pub struct Cost {
    /// Column of the CSV.
    pub name: &'static str,
    /// Quantity and unit.
    pub title: &'static str,
    /// The figure of an outcome.
    pub of: fn(&Outcome) -> Option<f64>,
}

/// The paper's count of what is stored.
pub const NUMBERS: Cost = Cost {
    name: "numbers",
    title: "numbers stored: m_p n' + m_c (n' + 1) n",
    of: |o| Some(o.setting.numbers(o.row.samples, o.row.responses * o.row.lights) as f64),
};
/// What relighting holds.
pub const MEMORY: Cost = Cost {
    name: "resident_mb",
    title: "resident storage, MB",
    of: |o| o.row.resident_bytes.map(|bytes| bytes as f64 / 1e6),
};
/// Relighting; the settings of a subject take turns.
pub const RELIGHT: Cost = Cost {
    name: "relight_1_ms",
    title: "relighting one channel on one thread, ms (median)",
    of: |o| o.row.relight_1_ms,
};
/// Encoding.
pub const ENCODE: Cost = Cost { name: "encode_s", title: "encoding on all threads, s", of: |o| o.row.encode_s };
/// n'
pub const COMPONENTS: Cost = Cost {
    name: "components",
    title: "components of each cluster, n'",
    of: |o| o.setting.size.map(|size| size.components as f64),
};

impl Outcome {
    /// The paper's SE: the squared error over all samples.
    pub fn squared_error(&self) -> Option<f64> {
        Some(self.row.error? * self.square)
    }
}

/// One line for each outcome, with the machine in every line.
pub fn csv(curves: &[Curve], outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "curve",
        "method",
        "clusters",
        "components",
        "status",
        "reason",
        "scene",
        "samples",
        "responses",
        "lights",
        "numbers",
        "resident_bytes",
        "file_bytes",
        "error",
        "squared_error",
        "encode_s",
        "relight_1_ms",
        "relight_rgb_all_ms",
        "machine",
    ])?;
    let count = |n: Option<usize>| n.map_or(String::new(), |n| n.to_string());
    let bytes = |n: Option<u64>| n.map_or(String::new(), |n| n.to_string());
    let text = |figure: Option<f64>| figure.map_or(String::new(), |f| f.to_string());
    for o in outcomes {
        let Row { method, reason, scene, samples, responses, lights, .. } = &o.row;
        let status = if o.row.is_ok() { "ok" } else { "failed" };
        writer.write_record([
            curves[o.curve].name.clone(),
            method.clone(),
            count(o.setting.size.map(|s| s.clusters)),
            count(o.setting.size.map(|s| s.components)),
            status.into(),
            reason.clone(),
            scene.clone(),
            samples.to_string(),
            responses.to_string(),
            lights.to_string(),
            text((NUMBERS.of)(o)),
            bytes(o.row.resident_bytes),
            bytes(o.row.file_bytes),
            text(o.row.error),
            text(o.squared_error()),
            text(o.row.encode_s),
            text(o.row.relight_1_ms),
            text(o.row.relight_rgb_all_ms),
            machine.line(),
        ])?;
    }
    Ok(writer.into_inner()?)
}

/// Title, subject, a line for each outcome, and the reasons of those that failed.
pub fn table(title: &str, subject: &Subject, outcomes: &[Outcome]) -> String {
    let titles = ["method", "numbers", "memory", "relight ms", "encode s", "error", "SE"];
    let lines = outcomes.iter().map(|o| {
        let short = |figure: Option<f64>| figure.map_or_else(|| "-".into(), number::short);
        let error = if o.row.is_ok() { short(o.row.error) } else { "failed".into() };
        vec![
            o.row.method.clone(),
            (NUMBERS.of)(o).map_or_else(|| "-".into(), |n| number::count(n as u64)),
            o.row.resident_bytes.map_or_else(|| "-".into(), number::bytes),
            short(o.row.relight_1_ms),
            short(o.row.encode_s),
            error,
            short(o.squared_error()),
        ]
    });
    let lines: Vec<Vec<String>> = lines.collect();
    let failed = outcomes.iter().filter(|o| !o.row.is_ok()).map(|o| format!("{}: {}", o.row.method, o.row.reason));
    let parts = [format!("\n{title}\n{}", subject.title()), aligned(&titles, lines.into_iter())];
    parts.into_iter().chain(failed).collect::<Vec<_>>().join("\n")
}
